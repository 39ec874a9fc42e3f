//! Ground that is hidden or seen in a frame, cell by cell. It carries no guarantee.

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label};
use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::{Region, Ring};
use nalgebra::Vector3;

use super::label_at;
use crate::region::Inner;

/// H^CVS (4.23) and the ground seen (4.6), as the cells whose centres fall on Obstacle, Target or
/// Unknown pixels, or on Ground pixels, no farther than d_max.
pub fn hidden_and_seen(view: &CameraView, frame: &Frame, grid: Grid) -> (Raster, Raster) {
    let (mut hidden, mut seen) = (Raster::empty(grid), Raster::empty(grid));
    for_each_visible_cell(view, frame, grid, |column, row, label| match label {
        Label::Ground => seen.set(column, row),
        // A camera that segments roads is none of this mission.
        Label::Obstacle | Label::Target | Label::Unknown | Label::Road => hidden.set(column, row),
    });
    (hidden, seen)
}

/// The cells of `seen` that what sweeps `silhouettes` may hide from some poses: convex rings.
pub fn behind<'a>(silhouettes: impl Iterator<Item = &'a Ring>, seen: &Raster) -> Raster {
    let mut cells = Raster::empty(*seen.grid());
    for ring in silhouettes {
        cells.fill_region(&Region::from_shapes(vec![vec![ring.clone()]]));
    }
    cells.intersect_with(seen);
    cells
}

/// The cells whose centres lie in a set.
pub fn cells_in(set: &Inner, grid: Grid) -> Raster {
    Raster::of_region(grid, set.region())
}

/// The cells of the OEM whose centres lie in the clear ground of all poses (4.40).
pub fn empty_cells_in(clear_ground: &Inner, grid: Grid) -> Vec<OemDelta> {
    cells_in(clear_ground, grid).iter().map(|(column, row)| empty(&grid, column, row)).collect()
}

fn empty(grid: &Grid, column: u32, row: u32) -> OemDelta {
    OemDelta { cell: grid.index(column, row) as u32, state: OemCell::Empty }
}

/// The cells of the OEM whose centres lie in the clear ground (4.40).
pub fn empty_cells(view: &CameraView, frame: &Frame, grid: Grid) -> Vec<OemDelta> {
    let mut cells = Vec::new();
    for_each_visible_cell(view, frame, grid, |column, row, label| {
        if label == Label::Ground {
            cells.push(empty(&grid, column, row));
        }
    });
    cells
}

/// Calls `visit` with every cell whose centre projects into the image, within d_max.
///
/// Along a row the centres move by a constant in the frame of the camera, so a cell takes one
/// addition and one division instead of a change of frames.
fn for_each_visible_cell(
    view: &CameraView,
    frame: &Frame,
    grid: Grid,
    mut visit: impl FnMut(u32, u32, Label),
) {
    let model = view.model();
    let reach_squared = model.d_max_m * model.d_max_m;
    let camera_step = view.world_from_camera().row(0).transpose() * grid.cell_m;
    let Some((rows, columns)) = footprint_cells(view, &grid) else { return };
    for row in rows {
        let [x, y] = grid.centre(columns.start, row);
        let first = view.to_camera(&Vector3::new(x, y, 0.0));
        for column in columns.clone() {
            let p_camera = first + camera_step * f64::from(column - columns.start);
            if p_camera.z <= 1e-9 || p_camera.norm_squared() > reach_squared {
                continue;
            }
            if let Some(label) = label_at(view, frame, view.project_camera(&p_camera)) {
                visit(column, row, label);
            }
        }
    }
}

type Cells = std::ops::Range<u32>;

/// The rows and columns of the box around the footprint.
fn footprint_cells(view: &CameraView, grid: &Grid) -> Option<(Cells, Cells)> {
    let footprint = view.footprint();
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| {
        footprint.iter().map(|p| p[axis]).fold(start, pick)
    };
    // The chords of the footprint lie inside its arcs, by less than this.
    const MARGIN_M: f64 = 1.0;
    (footprint.len() >= 3).then(|| {
        let (west, east) =
            (bound(0, f64::min, f64::INFINITY), bound(0, f64::max, f64::NEG_INFINITY));
        let (south, north) =
            (bound(1, f64::min, f64::INFINITY), bound(1, f64::max, f64::NEG_INFINITY));
        (
            grid.rows_between(south - MARGIN_M, north + MARGIN_M),
            grid.columns_between(west - MARGIN_M, east + MARGIN_M),
        )
    })
}
