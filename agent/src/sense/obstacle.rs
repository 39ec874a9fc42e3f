//! What Obstacle pixels prove: ground too near to an obstacle for any target, and occupied cells.

use std::collections::BTreeSet;

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label};
use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::Grid;
use csat_proto::region::{Region, Ring};
use nalgebra::Vector3;

use super::exclusion::{centre_of_bounds, disc_intersection, disc_intersection_of_moved};
use super::foot;
use super::pixel_bounds::{LANES, PixelBounder, PixelBounds, differ};
use super::pose_box::{Extent, PoseBox, Tilt};
use super::pyramid::{self, ground_corners, top_m};
use crate::config::AgentConfig;
use crate::mutant::{Mutant, is_on};
use crate::region::Inner;

/// Number of grades of the quality of a margin: a margin of grade g is an intersection of discs that
/// contains a disc of g / `GRADES` of their radius.
const GRADES: f64 = 8.0;

/// Margins below this grade are dropped: such small discs, one per cell, do not overlap.
const LEAST_GRADE: f64 = 4.0;

/// The same where poses are not exact: then there are no better ones.
const LEAST_GRADE_IN_BOX: f64 = 2.0;

/// With inexact poses every so many rows and columns of pixels are asked for their margins: neighbours prove the same.
const LATTICE: u16 = 4;

/// Which pixels are asked for their margins, given how well the pose is known.
#[derive(Debug, Clone, Copy)]
struct Asked {
    /// Whether any can have one.
    may_prove: bool,
    /// Every so many rows and columns.
    lattice: u16,
    /// The grades that all lose to the errors of the position, at least.
    lost: f32,
    least_grade: f64,
}

impl Asked {
    fn from(poses: &PoseBox, radius_m: f64) -> Self {
        if poses.is_exact() {
            return Self { may_prove: true, lattice: 1, lost: 0.0, least_grade: LEAST_GRADE };
        }
        let lost = |shift_m: f64| shift_m / radius_m * GRADES;
        Self {
            may_prove: GRADES - lost(poses.most_shift_m()) >= LEAST_GRADE_IN_BOX,
            lattice: LATTICE,
            lost: lost(poses.least_shift_m()) as f32,
            least_grade: LEAST_GRADE_IN_BOX,
        }
    }

    fn has(&self, pixel: &BoundedPixel) -> bool {
        self.may_prove
            && pixel.column.is_multiple_of(self.lattice)
            && pixel.row.is_multiple_of(self.lattice)
    }
}

/// What the Obstacle pixels of one frame prove.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObstacleFindings {
    /// S° (4.12), inner, without parts that were measured as well before.
    pub margin: Inner,
    /// Occupied cells (4.39) that are new or higher than before, each once, by increasing index.
    pub occupied: Vec<OemDelta>,
}

/// Measures S° and heights, and keeps grids of the quality of what was measured. Any subset of the
/// pixels is sound. So it skips pixels whose disc is no better than the best one of their cell, and
/// pixels that are no higher than their cell.
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
    /// The interval of its distance, metres.
    depth_m: [f64; 2],
    /// Unit vector of its centre ray, `world`.
    ray: Vector3<f64>,
}

/// An Obstacle pixel and its bounds: see [`PixelBounds`].
#[derive(Debug, Clone, Copy)]
struct BoundedPixel {
    column: u16,
    row: u16,
    grade: f32,
    middle: i32,
    far_end: i32,
    top_dm: f32,
    reach_squared: f32,
}

impl Pixel {
    fn at(view: &CameraView, frame: &Frame, column: u16, row: u16) -> Self {
        let model = view.model();
        let first = view.ray_world(0.5, f64::from(row) + 0.5);
        let ray = first + view.ray_matrix().column(0) * f64::from(column);
        let index = usize::from(row) * usize::from(model.columns) + usize::from(column);
        let depth_m = model.depth_interval_m(frame.depth[index]);
        Self { column, row, depth_m, ray: ray / ray.norm() }
    }

    /// How far its points are from the camera.
    fn extent(&self, view: &CameraView) -> Extent {
        pyramid::extent(view, self.column, self.row, self.depth_m)
    }

    /// The square of the distance, over the ground, from the camera to its far end, m².
    fn reach_squared(&self) -> f64 {
        (self.ray.x * self.ray.x + self.ray.y * self.ray.y) * self.depth_m[1].powi(2)
    }
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

    /// What the Obstacle pixels of `frame` prove that was not known before.
    pub fn measure(
        &mut self,
        view: &CameraView,
        poses: &PoseBox,
        frame: &Frame,
        ground: &Region,
    ) -> ObstacleFindings {
        let mut rings: Vec<Ring> = Vec::new();
        let mut raised: BTreeSet<usize> = BTreeSet::new();
        let mut walls = WallPixels::new(view, frame);
        let bounder = PixelBounder::new(view, self.radius_m, GRADES, [&self.grid, &self.oem_grid]);
        let asked = Asked::from(poses, self.radius_m);
        for_each_obstacle_pixel(view, frame, &bounder, |bounded| {
            let pixel = || Pixel::at(view, frame, bounded.column, bounded.row);
            if asked.has(bounded) && self.may_improve(bounded, &asked) {
                rings.extend(self.margin_of(view, poses, &pixel()));
            }
            if self.may_raise(bounded) {
                raised.extend(self.raise_cell(view, &pixel()));
            }
            walls.visit(bounded);
        });
        let of_walls = walls.found().filter(|_| asked.may_prove);
        rings.extend(of_walls.filter_map(|pixel| self.margin_at_foot(view, poses, frame, &pixel)));
        let margin =
            if rings.is_empty() { Inner::default() } else { Inner::from_rings(&rings, ground) };
        let delta = |cell: usize| {
            let state = OemCell::Occupied { height_dm: self.height_dm[cell] };
            OemDelta { cell: cell as u32, state }
        };
        ObstacleFindings { margin, occupied: raised.into_iter().map(delta).collect() }
    }

    /// Whether [`Self::margin_of`] a pixel may be better than the margin of its cell.
    fn may_improve(&self, bounded: &BoundedPixel, asked: &Asked) -> bool {
        let best = || usize::try_from(bounded.middle).map_or(0, |cell| self.best_grade[cell]);
        let grade = bounded.grade - asked.lost;
        grade >= asked.least_grade as f32 && grade >= f32::from(best()) + 1.0
    }

    /// Whether [`Self::raise_cell`] may raise the cell of a pixel.
    fn may_raise(&self, bounded: &BoundedPixel) -> bool {
        let height_dm = |cell: usize| f32::from(self.height_dm[cell]);
        usize::try_from(bounded.far_end).map_or(true, |cell| bounded.top_dm > height_dm(cell))
    }

    /// S°(pixel) (4.7): the points within r_s^to of every point that may have lit the pixel. `None`
    /// when it is empty or the margin of its cell is as good.
    fn margin_of(&mut self, view: &CameraView, poses: &PoseBox, pixel: &Pixel) -> Option<Ring> {
        let Pixel { column, row, depth_m: [near, far], ray } = *pixel;
        if !poses.is_exact() {
            let corners = ground_corners(view, column, row, pixel.depth_m);
            let tilt = poses.tilt(pixel.extent(view));
            return self.margin_about(poses, &corners, Some(&tilt));
        }
        let half_span_m = (far - near) / 2.0 * (ray.x * ray.x + ray.y * ray.y).sqrt();
        let centre = view.centre_world() + ray * ((near + far) / 2.0);
        self.improve([centre.x, centre.y], half_span_m, LEAST_GRADE)?;
        let corners = ground_corners(view, column, row, pixel.depth_m);
        disc_intersection(&corners, self.radius_m, self.vertices)
    }

    /// The same, for the points that are not above seen ground. On a wall whose foot is seen these
    /// are about half of the points, and few where the measured depth is too short.
    fn margin_at_foot(
        &mut self,
        view: &CameraView,
        poses: &PoseBox,
        frame: &Frame,
        pixel: &Pixel,
    ) -> Option<Ring> {
        let [near, far] = pixel.depth_m.map(|depth_m| view.centre_world() + pixel.ray * depth_m);
        let (column, row) = self.grid.cell_of([far.x, far.y])?;
        let best = self.best_grade[self.grid.index(column, row)];
        if f64::from(best) >= GRADES - 1.0 || !foot::is_seen(view, frame, [near.x, near.y]) {
            return None;
        }
        let mut corners = ground_corners(view, pixel.column, pixel.row, pixel.depth_m);
        if !poses.is_exact() {
            corners = poses.tilt(pixel.extent(view)).about(&corners);
            let corners = foot::unseen_part(view, poses, frame, corners);
            return self.margin_about(poses, &corners, None);
        }
        let corners = foot::unseen_part(view, poses, frame, corners);
        let (centre, half_span_m) = span(&corners)?;
        self.improve(centre, half_span_m, LEAST_GRADE)?;
        disc_intersection(&corners, self.radius_m, self.vertices)
    }

    /// The points within r_s^to of `corners`, wherever the poses of the box move them; `tilt` if it is not in the
    /// corners.
    fn margin_about(
        &mut self,
        poses: &PoseBox,
        corners: &[[f64; 2]],
        tilt: Option<&Tilt>,
    ) -> Option<Ring> {
        if is_on(Mutant::MarginFromOnePose) {
            return disc_intersection(corners, self.radius_m, self.vertices);
        }
        let turned = poses.turned(corners.iter().copied());
        let (centre, half_span_m) = span(&turned)?;
        let most_m = poses.most_shift_m() + tilt.map_or(0.0, Tilt::most_m);
        self.improve(centre, half_span_m + most_m, LEAST_GRADE_IN_BOX)?;
        let moved_m =
            |normal| poses.shift_along_m(normal) + tilt.map_or(0.0, |tilt| tilt.along_m(normal));
        disc_intersection_of_moved(&turned, self.radius_m, self.vertices, moved_m)
    }

    /// Notes an intersection of discs about points at most `half_span_m` from `centre`, if its grade
    /// is the best in its cell and at least `least`.
    fn improve(&mut self, centre: [f64; 2], half_span_m: f64, least: f64) -> Option<()> {
        let grade = (1.0 - half_span_m / self.radius_m) * GRADES;
        if grade < least {
            return None;
        }
        let (column, row) = self.grid.cell_of(centre)?;
        let best = &mut self.best_grade[self.grid.index(column, row)];
        if grade < f64::from(*best) + 1.0 {
            return None;
        }
        *best = grade as u8;
        Some(())
    }

    /// The cell under the farthest point that may have lit the pixel's centre (4.38), if the
    /// greatest height of the pixel's pyramid is greater than that of the cell.
    fn raise_cell(&mut self, view: &CameraView, pixel: &Pixel) -> Option<usize> {
        let Pixel { column, row, depth_m: [near, far], ray } = *pixel;
        let farthest = view.centre_world() + ray * far;
        let (c, r) = self.oem_grid.cell_of([farthest.x, farthest.y])?;
        let cell = self.oem_grid.index(c, r);
        let known_dm = &mut self.height_dm[cell];
        // At either end, the corners are within the width of a pixel of the centre ray.
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

/// The pixels that locate walls best: of each unbroken run of Obstacle pixels in a column of the
/// image, the one whose far end is nearest.
struct WallPixels<'a> {
    view: &'a CameraView,
    frame: &'a Frame,
    /// The current run of each column.
    runs: Vec<Option<PixelRun>>,
    /// The runs that ended, with their columns.
    ended: Vec<(u16, PixelRun)>,
}

/// An unbroken run of Obstacle pixels in a column.
#[derive(Debug, Clone, Copy)]
struct PixelRun {
    last_row: u16,
    nearest_row: u16,
    /// Of the nearest pixel, approximately.
    reach_squared: f32,
}

impl<'a> WallPixels<'a> {
    fn new(view: &'a CameraView, frame: &'a Frame) -> Self {
        let runs = vec![None; usize::from(view.model().columns)];
        Self { view, frame, runs, ended: Vec::new() }
    }

    /// Takes the next pixel, in the order of rows.
    fn visit(&mut self, bounded: &BoundedPixel) {
        let &BoundedPixel { column, row, reach_squared, .. } = bounded;
        match &mut self.runs[usize::from(column)] {
            Some(run) if run.last_row + 1 == row => {
                run.last_row = row;
                let is_nearer = if differ(reach_squared, run.reach_squared) {
                    reach_squared < run.reach_squared
                } else {
                    let reach = |row| Pixel::at(self.view, self.frame, column, row).reach_squared();
                    reach(row) < reach(run.nearest_row)
                };
                if is_nearer {
                    (run.nearest_row, run.reach_squared) = (row, reach_squared);
                }
            }
            run => {
                let next = PixelRun { last_row: row, nearest_row: row, reach_squared };
                self.ended.extend(run.replace(next).map(|run| (column, run)));
            }
        }
    }

    /// The pixels of all runs.
    fn found(&self) -> impl Iterator<Item = Pixel> {
        let last = (0..).zip(&self.runs).filter_map(|(column, run)| Some((column, (*run)?)));
        let all = self.ended.iter().copied().chain(last);
        all.map(|(column, run)| Pixel::at(self.view, self.frame, column, run.nearest_row))
    }
}

/// The middle of points and the greatest distance from it, metres.
fn span(points: &[[f64; 2]]) -> Option<([f64; 2], f64)> {
    let centre = centre_of_bounds(points)?;
    let gap = |p: &[f64; 2]| (p[0] - centre[0]).hypot(p[1] - centre[1]);
    Some((centre, points.iter().map(gap).fold(0.0, f64::max)))
}

/// Visits the Obstacle pixels with their bounds, row by row.
fn for_each_obstacle_pixel(
    view: &CameraView,
    frame: &Frame,
    bounder: &PixelBounder,
    mut visit: impl FnMut(&BoundedPixel),
) {
    let model = view.model();
    let columns = usize::from(model.columns);
    let step: Vector3<f64> = view.ray_matrix().column(0).into();
    let rows = frame.labels.chunks_exact(columns).zip(frame.depth.chunks_exact(columns));
    for (row, (labels, depth)) in (0..model.rows).zip(rows) {
        let parts = labels.chunks(LANES).zip(depth.chunks(LANES));
        for ((labels, depth), start) in parts.zip((0..model.columns).step_by(LANES)) {
            // Comparing all of them is faster than stopping at the first one.
            if !labels.iter().fold(false, |any, label| any | (*label == Label::Obstacle)) {
                continue;
            }
            let first = view.ray_world(f64::from(start) + 0.5, f64::from(row) + 0.5);
            let mut depths = [0; LANES];
            depths[..depth.len()].copy_from_slice(depth);
            let PixelBounds { grade, middle, far_end, top_dm, reach_squared } =
                bounder.bounds(&first, &step, &depths);
            for (lane, label) in labels.iter().enumerate() {
                if *label == Label::Obstacle {
                    visit(&BoundedPixel {
                        column: start + lane as u16,
                        row,
                        grade: grade[lane],
                        middle: middle[lane],
                        far_end: far_end[lane],
                        top_dm: top_dm[lane],
                        reach_squared: reach_squared[lane],
                    });
                }
            }
        }
    }
}
