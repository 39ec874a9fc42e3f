//! Upper bounds on what Obstacle pixels may prove, in single precision.
//!
//! In flight nearly every Obstacle pixel proves nothing new: its cells were measured as well before.
//! The exact computation takes two roots and a dozen divisions per pixel. The bounds are computed in
//! single precision for many pixels at once, in loops that compile to vector instructions. Only
//! pixels whose bounds do not decide are computed exactly, so the result is the same to the last bit.

use csat_proto::camera::CameraView;
use csat_proto::raster::Grid;
use nalgebra::Vector3;

/// Pixels of a row whose bounds are computed together.
pub(super) const LANES: usize = 16;

/// Bound of the error of a length, as a share of the greatest length: about thirty roundings.
const DOUBT: f64 = 2e-6;

/// Computes the bounds of the pixels of one frame.
#[derive(Debug)]
pub(super) struct PixelBounder {
    /// One step of depth, metres.
    step_m: f32,
    /// The least and the greatest true distance, as shares of the measured one.
    shares: [f32; 2],
    /// Grades lost per metre of depth along the ground.
    grades_per_m: f32,
    /// The greatest grade plus the bound of its error.
    grades: f32,
    /// The grids of margins and of the OEM.
    places: [GridFromCamera; 2],
    /// The camera's altitude plus the bound of its error, metres.
    z_m: f32,
    /// The width of a pixel at a distance of 1.
    pixel: f32,
}

/// A grid in coordinates of the camera.
#[derive(Debug, Clone, Copy)]
struct GridFromCamera {
    /// The position of the camera, in cells.
    eye: [f32; 2],
    cells_per_m: f32,
    columns: f32,
    rows: f32,
    /// Bound of the error of a position, in cells.
    doubt: f32,
}

/// The bounds of pixels side by side.
#[derive(Debug, Default)]
pub(super) struct PixelBounds {
    /// Upper bound of the grade of the margin.
    pub(super) grade: [f32; LANES],
    /// The index of the cell of the grid of margins under the middle of the segment that may have lit
    /// the pixel's centre; negative if the cell is uncertain or outside.
    pub(super) middle: [i32; LANES],
    /// The index of the cell of the OEM under the far end of that segment; likewise.
    pub(super) far_end: [i32; LANES],
    /// Upper bound of the height of the pixel, decimetres.
    pub(super) top_dm: [f32; LANES],
    /// Approximate square of the distance, over the ground, from the camera to the far end, m².
    pub(super) reach_squared: [f32; LANES],
}

impl PixelBounder {
    /// The bounds of a frame of `view`, for margins of `radius_m` in up to `grades` grades on the
    /// first of `grids` and heights on the second.
    pub(super) fn new(view: &CameraView, radius_m: f64, grades: f64, grids: [&Grid; 2]) -> Self {
        let model = view.model();
        let centre = view.centre_world();
        let farthest_m = model.d_max_m / (1.0 + model.depth_noise[0]);
        let doubt_m = DOUBT * (farthest_m + centre.z.abs());
        let grades_per_m = 0.5 * grades / radius_m;
        Self {
            step_m: model.depth_step_m() as f32,
            shares: model.depth_noise.map(|noise| (1.0 / (1.0 + noise)) as f32),
            grades_per_m: grades_per_m as f32,
            grades: (grades * (1.0 + DOUBT) + 2.0 * doubt_m * grades_per_m) as f32,
            places: grids.map(|grid| GridFromCamera::from(grid, &centre, doubt_m)),
            z_m: (centre.z + doubt_m) as f32,
            pixel: (1.0 / view.focal_px()) as f32,
        }
    }

    /// The bounds of pixels of depths `depth`. The ray of the first pixel is `first`, and that of
    /// each further pixel is `step` more, `world`.
    pub(super) fn bounds(
        &self,
        first: &Vector3<f64>,
        step: &Vector3<f64>,
        depth: &[u16; LANES],
    ) -> PixelBounds {
        let [first, step] = [first, step].map(|v| [v.x, v.y, v.z].map(|v| v as f32));
        let [margins, oem] = self.places;
        let mut found = PixelBounds::default();
        for (lane, steps) in depth.iter().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| first[axis] + step[axis] * lane as f32);
            let across = x * x + y * y;
            let per_length = 1.0 / (across + z * z).sqrt();
            let steps = f32::from(*steps);
            let near = (steps - 0.5).max(0.0) * self.step_m * self.shares[1];
            let far = (steps + 0.5) * self.step_m * self.shares[0];
            let lost = (far - near) * across.sqrt() * per_length * self.grades_per_m;
            let [to_near, to_far] = [near, far].map(|distance| distance * per_length);
            let to_middle = 0.5 * (to_near + to_far);
            found.grade[lane] = self.grades - lost;
            found.middle[lane] = margins.cell([x * to_middle, y * to_middle]);
            found.far_end[lane] = oem.cell([x * to_far, y * to_far]);
            let rise = (z * to_near).max(z * to_far);
            found.top_dm[lane] = (self.z_m + rise + far * self.pixel) * 10.0;
            found.reach_squared[lane] = across * to_far * to_far;
        }
        found
    }
}

impl GridFromCamera {
    fn from(grid: &Grid, centre: &Vector3<f64>, doubt_m: f64) -> Self {
        let (origin, cells) = (grid.origin(), f64::from(grid.columns.max(grid.rows)));
        Self {
            eye: [0, 1].map(|axis| ((centre[axis] - origin[axis]) / grid.cell_m) as f32),
            cells_per_m: (1.0 / grid.cell_m) as f32,
            columns: grid.columns as f32,
            rows: grid.rows as f32,
            doubt: (doubt_m / grid.cell_m + DOUBT * cells) as f32,
        }
    }

    /// The index of the cell of a point `from_eye`, metres; negative if the cell is uncertain or
    /// outside.
    fn cell(&self, from_eye: [f32; 2]) -> i32 {
        let [u, v] = [0, 1].map(|axis| self.eye[axis] + from_eye[axis] * self.cells_per_m);
        let [(column, middle_u), (row, middle_v)] = [u, v].map(whole);
        let off_middle = (u - middle_u).abs().max((v - middle_v).abs());
        let is_inside = (u > 0.0) & (v > 0.0) & (u < self.columns) & (v < self.rows);
        let is_sure = is_inside & (off_middle < 0.5 - self.doubt);
        let index = row.wrapping_mul(self.columns as i32).wrapping_add(column);
        if is_sure { index } else { -1 }
    }
}

/// The integer part of a number up to 2²² that is neither negative nor nearly an integer, and that
/// part plus one half. It compiles to vector instructions on all targets, unlike a conversion to an
/// integer.
fn whole(x: f32) -> (i32, f32) {
    // Numbers near this one have a spacing of 1, so that their last 22 bits are the offset from it.
    const HERE: f32 = 1.5 * (1 << 23) as f32;
    let counted = x - 0.5 + HERE;
    ((counted.to_bits() & 0x3f_ffff) as i32, counted - HERE + 0.5)
}

/// Whether one of two squares of lengths is certainly less than the other.
pub(super) fn differ(a: f32, b: f32) -> bool {
    (a - b).abs() > 1e-4 * a.max(b)
}

#[cfg(test)]
mod tests {
    use csat_proto::camera::{CameraModel, Pose};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    const RADIUS_M: f64 = 3.0;
    const GRADES: f64 = 8.0;

    /// A number in [0, 1).
    fn draw(rng: &mut ChaCha8Rng) -> f64 {
        f64::from(rng.next_u32()) / 2f64.powi(32)
    }

    /// Checks a lane of `bounds` against its pixel. Returns how many of its two cells are certain,
    /// and how many exist.
    fn check(
        view: &CameraView,
        grids: [&Grid; 2],
        bounds: &PixelBounds,
        lane: usize,
        (ray, depth): (Vector3<f64>, u16),
    ) -> [usize; 2] {
        let [near, far] = view.model().depth_interval_m(depth);
        let across = ray.x.hypot(ray.y);
        let grade = (1.0 - (far - near) / 2.0 * across / RADIUS_M) * GRADES;
        let above = f64::from(bounds.grade[lane]) - grade;
        assert!((0.0..0.1).contains(&above), "{above} above {grade}");
        let rise = (ray.z * near).max(ray.z * far);
        let top_dm = 10.0 * (view.centre_world().z + rise + far / view.focal_px());
        let above = f64::from(bounds.top_dm[lane]) - top_dm;
        assert!((0.0..0.1).contains(&above), "{above} above {top_dm}");
        assert!(!differ(bounds.reach_squared[lane], (across * far).powi(2) as f32));
        let ends = [(near + far) / 2.0, far].map(|distance| view.centre_world() + ray * distance);
        let there = [0, 1].map(|i| {
            let cell = grids[i].cell_of([ends[i].x, ends[i].y]);
            cell.map(|(column, row)| grids[i].index(column, row) as i32)
        });
        let seen = [bounds.middle[lane], bounds.far_end[lane]];
        let certain = seen.iter().zip(&there).filter(|(seen, there)| {
            assert!(**seen == -1 || Some(**seen) == **there, "{seen} {there:?}");
            **seen >= 0
        });
        [certain.count(), there.iter().flatten().count()]
    }

    #[test]
    fn a_glance_is_never_wrong_and_seldom_in_doubt() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let ground = crate::config::tests::default_config([500.0; 2]).ground;
        let grids = [1.5, 5.0].map(|cell_m| Grid::covering(&ground, cell_m));
        let grids = [&grids[0], &grids[1]];
        let model = CameraModel::default();
        let mut ends = [0; 2];
        for _ in 0..300 {
            let [x, y] = [0, 0].map(|_| 700.0 * (draw(&mut rng) - 0.5));
            let pose = Pose::level([x, y, 40.0 + 30.0 * draw(&mut rng)], 7.0 * draw(&mut rng));
            let view = model.at(&pose);
            let [u, v] = [model.columns - LANES as u16, model.rows]
                .map(|end| (draw(&mut rng) * f64::from(end)).floor() + 0.5);
            let [first, step] = [view.ray_world(u, v), view.ray_matrix().column(0).into()];
            let depth = [0; LANES].map(|_: u16| rng.next_u32() as u16);
            let bounder = PixelBounder::new(&view, RADIUS_M, GRADES, grids);
            let bounds = bounder.bounds(&first, &step, &depth);
            for (lane, &depth) in depth.iter().enumerate() {
                let ray = (first + step * lane as f64).normalize();
                let found = check(&view, grids, &bounds, lane, (ray, depth));
                ends = [0, 1].map(|i| ends[i] + found[i]);
            }
        }
        let [certain, inside] = ends;
        assert!(inside > 1000 && certain * 100 > inside * 99, "{certain} of {inside}");
    }

    #[test]
    fn whole_parts_of_numbers_of_cells() {
        for x in [0.001, 0.499, 0.5, 0.501, 1.3, 2.5, 1023.75, 999_999.25] {
            let (part, middle) = whole(x);
            assert_eq!((part, middle), (x as i32, x.floor() + 0.5), "{x}");
        }
    }
}
