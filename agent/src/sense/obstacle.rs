//! What Obstacle pixels prove: ground too near to an obstacle for any target, and occupied cells.

use std::collections::BTreeSet;

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label};
use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::Grid;
use csat_proto::region::{Region, Ring};
use nalgebra::Vector3;

use super::exclusion::disc_intersection;
use super::pyramid::{ground_corners, top_m};
use crate::config::AgentConfig;
use crate::region::Inner;

/// How finely the quality of a margin is graded: grade g stands for an intersection of discs that
/// contains one of g / `GRADES` of their radius.
const GRADES: f64 = 8.0;

/// Grades below this are not worth their vertices: discs this small, one per cell, do not join.
const LEAST_GRADE: f64 = 4.0;

/// What the Obstacle pixels of one frame prove.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObstacleFindings {
    /// S° (4.12), inner, without what was measured as well before.
    pub margin: Inner,
    /// Occupied cells (4.39) that are new or higher than before, each once, by increasing index.
    pub occupied: Vec<OemDelta>,
}

/// Measures S° and heights, and remembers, on grids, how well it did where. Any subset of the pixels
/// is sound, so a pixel that would add no better disc than the best one found in its cell is skipped,
/// and one that cannot be higher than its cell: the work is that of what is new.
#[derive(Debug, Clone)]
pub struct MarginSensor {
    grid: Grid,
    best_grade: Vec<u8>,
    oem_grid: Grid,
    /// Greatest height found per cell of the OEM, decimetres; 0 for none.
    height_dm: Vec<u16>,
    radius_m: f64,
    vertices: u16,
}

/// An Obstacle pixel.
#[derive(Debug, Clone, Copy)]
struct Pixel {
    column: u16,
    row: u16,
    /// Distances that may be behind it, metres.
    depth_m: [f64; 2],
    /// Unit vector of its centre ray, `world`.
    ray: Vector3<f64>,
}

impl MarginSensor {
    /// A sensor that has measured nothing.
    pub fn new(config: &AgentConfig) -> Self {
        let radius_m = config.targets.obstacle_distance_m;
        let grid = Grid::covering(&config.ground, (radius_m / 2.0).max(0.5));
        let oem_grid = config.oem_grid();
        Self {
            best_grade: vec![0; grid.cells()],
            grid,
            height_dm: vec![0; oem_grid.cells()],
            oem_grid,
            radius_m,
            vertices: config.estimator.disc_vertices,
        }
    }

    /// What `frame` adds.
    pub fn measure(
        &mut self,
        view: &CameraView,
        frame: &Frame,
        ground: &Region,
    ) -> ObstacleFindings {
        let mut rings: Vec<Ring> = Vec::new();
        let mut raised: BTreeSet<usize> = BTreeSet::new();
        for_each_obstacle_pixel(view, frame, |pixel| {
            rings.extend(self.margin_of(view, pixel));
            raised.extend(self.raise_cell(view, pixel));
        });
        let margin =
            if rings.is_empty() { Inner::default() } else { Inner::from_rings(&rings, ground) };
        let delta = |cell: usize| {
            let state = OemCell::Occupied { height_dm: self.height_dm[cell] };
            OemDelta { cell: cell as u32, state }
        };
        ObstacleFindings { margin, occupied: raised.into_iter().map(delta).collect() }
    }

    /// S°(pixel) (4.7): within r_s^to of every point that may have lit the pixel. `None` when it is
    /// empty or its cell was served as well before.
    fn margin_of(&mut self, view: &CameraView, pixel: &Pixel) -> Option<Ring> {
        let Pixel { column, row, depth_m: [near, far], ray } = *pixel;
        let half_span_m = (far - near) / 2.0 * (ray.x * ray.x + ray.y * ray.y).sqrt();
        let grade = (1.0 - half_span_m / self.radius_m) * GRADES;
        if grade < LEAST_GRADE {
            return None;
        }
        let centre = view.centre_world() + ray * ((near + far) / 2.0);
        let (c, r) = self.grid.cell_of([centre.x, centre.y])?;
        let best = &mut self.best_grade[self.grid.index(c, r)];
        if grade < f64::from(*best) + 1.0 {
            return None;
        }
        *best = grade as u8;
        let corners = ground_corners(view, column, row, pixel.depth_m);
        disc_intersection(&corners, self.radius_m, self.vertices)
    }

    /// The cell under the farthest point that may have lit the pixel's centre (4.38), if the
    /// greatest height of the pixel's pyramid is greater than what is known of it.
    fn raise_cell(&mut self, view: &CameraView, pixel: &Pixel) -> Option<usize> {
        let Pixel { column, row, depth_m: [near, far], ray } = *pixel;
        let farthest = view.centre_world() + ray * far;
        let (c, r) = self.oem_grid.cell_of([farthest.x, farthest.y])?;
        let cell = self.oem_grid.index(c, r);
        let known_dm = &mut self.height_dm[cell];
        // The corners are within a pixel's width of the centre ray, at either end.
        let ends_z = (ray.z * near).max(ray.z * far) + far / view.focal_px();
        if (view.centre_world().z + ends_z) * 10.0 <= f64::from(*known_dm) {
            return None;
        }
        let height_dm = (top_m(view, column, row, pixel.depth_m) * 10.0).ceil();
        let height_dm = height_dm.clamp(0.0, f64::from(u16::MAX)) as u16;
        (height_dm > *known_dm).then(|| {
            *known_dm = height_dm;
            cell
        })
    }
}

fn for_each_obstacle_pixel(view: &CameraView, frame: &Frame, mut visit: impl FnMut(&Pixel)) {
    let model = view.model();
    let matrix = view.ray_matrix();
    let step = matrix.column(0);
    let rows = frame.labels.chunks_exact(usize::from(model.columns));
    for (row, labels) in (0..model.rows).zip(rows) {
        let first = view.ray_world(0.5, f64::from(row) + 0.5);
        let start = usize::from(row) * usize::from(model.columns);
        for (column, label) in (0..model.columns).zip(labels) {
            if *label == Label::Obstacle {
                let ray = first + step * f64::from(column);
                let depth_m = model.depth_interval_m(frame.depth[start + usize::from(column)]);
                visit(&Pixel { column, row, depth_m, ray: ray / ray.norm() });
            }
        }
    }
}
