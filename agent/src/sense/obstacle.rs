//! What Obstacle pixels prove: ground too near to an obstacle for any target, and occupied cells.

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label};
use csat_proto::message::{OemCell, OemDelta};
use csat_proto::raster::Grid;
use csat_proto::region::{Region, Ring};

use super::exclusion::disc_intersection;
use super::pyramid::{ground_corners, top_m};
use crate::config::AgentConfig;
use crate::region::Inner;

/// How finely the quality of a margin is graded.
const GRADES: f64 = 8.0;

/// What the Obstacle pixels of one frame prove.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObstacleFindings {
    /// S° (4.12), inner, without what was measured as well before.
    pub margin: Inner,
    /// Occupied cells (4.39), each once, by increasing index.
    pub occupied: Vec<OemDelta>,
}

/// Measures S° and remembers, on a grid, how well it did where. Any subset of the pixels is sound,
/// so a pixel that would add no better disc than the best one found in its cell is skipped: the work
/// is that of what is new.
#[derive(Debug, Clone)]
pub struct MarginSensor {
    grid: Grid,
    best_grade: Vec<u8>,
    oem_grid: Grid,
    radius_m: f64,
    vertices: u16,
}

impl MarginSensor {
    /// A sensor that has measured nothing.
    pub fn new(config: &AgentConfig) -> Self {
        let radius_m = config.targets.obstacle_distance_m;
        let grid = Grid::covering(&config.ground, (radius_m / 2.0).max(0.5));
        Self {
            best_grade: vec![0; grid.cells()],
            grid,
            oem_grid: config.oem_grid(),
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
        let columns = usize::from(view.model().columns);
        let mut rings: Vec<Ring> = Vec::new();
        let mut heights: Vec<(u32, u16)> = Vec::new();
        let obstacles =
            frame.labels.iter().enumerate().filter(|(_, label)| **label == Label::Obstacle);
        for (index, _) in obstacles {
            let (row, column) = ((index / columns) as u16, (index % columns) as u16);
            let depth_m = view.model().depth_interval_m(frame.depth[index]);
            rings.extend(self.margin_of(view, column, row, depth_m));
            heights.extend(self.occupied_cell(view, column, row, depth_m));
        }
        let margin =
            if rings.is_empty() { Inner::default() } else { Inner::from_rings(&rings, ground) };
        ObstacleFindings { margin, occupied: highest_per_cell(heights) }
    }

    /// S°(pixel) (4.7): within r_s^to of every point that may have lit the pixel. `None` when it is
    /// empty or its cell was served as well before.
    fn margin_of(
        &mut self,
        view: &CameraView,
        column: u16,
        row: u16,
        depth_m: [f64; 2],
    ) -> Option<Ring> {
        let ray = view.ray_world(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let (reach, length) = (ray.x.hypot(ray.y), ray.norm());
        let middle = (depth_m[0] + depth_m[1]) / 2.0 / length;
        let centre = view.centre_world() + ray * middle;
        let half_span = (depth_m[1] - depth_m[0]) / 2.0 / length * reach;
        let grade = ((1.0 - half_span / self.radius_m) * GRADES).floor();
        let (c, r) = self.grid.cell_of([centre.x, centre.y])?;
        let best = &mut self.best_grade[self.grid.index(c, r)];
        if grade <= f64::from(*best) {
            return None;
        }
        *best = grade as u8;
        let corners = ground_corners(view, column, row, depth_m);
        disc_intersection(&corners, self.radius_m, self.vertices)
    }

    /// The cell under the farthest point that may have lit the pixel's centre (4.38), and the
    /// greatest height of the pixel's pyramid in decimetres, rounded up.
    fn occupied_cell(
        &self,
        view: &CameraView,
        column: u16,
        row: u16,
        depth_m: [f64; 2],
    ) -> Option<(u32, u16)> {
        let ray = view.ray_world(f64::from(column) + 0.5, f64::from(row) + 0.5).normalize();
        let farthest = view.centre_world() + ray * depth_m[1];
        let (c, r) = self.oem_grid.cell_of([farthest.x, farthest.y])?;
        let height_dm = (top_m(view, column, row, depth_m) * 10.0).ceil();
        Some((self.oem_grid.index(c, r) as u32, height_dm.clamp(0.0, 65535.0) as u16))
    }
}

fn highest_per_cell(mut heights: Vec<(u32, u16)>) -> Vec<OemDelta> {
    heights.sort_unstable();
    let mut deltas: Vec<OemDelta> = Vec::new();
    for (cell, height_dm) in heights {
        let state = OemCell::Occupied { height_dm };
        match deltas.last_mut() {
            Some(last) if last.cell == cell => last.state = state,
            _ => deltas.push(OemDelta { cell, state }),
        }
    }
    deltas
}
