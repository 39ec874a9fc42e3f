//! The footprint of a camera whose pose is only known to a box, by interval analysis.

use super::interval::Interval;
use super::sivia::{Cell, Paving, Proof};
use csat_proto::camera::{CameraModel, Pose, PoseError};

/// A pose by its components, each an interval: x, y, z, yaw, pitch, roll.
type Poses = [Interval; 6];

/// The poses of a box: all of them, and its corners and middle one by one.
pub struct Footprint {
    camera: CameraModel,
    /// Columns and rows, from and to.
    window: [[u16; 2]; 2],
    all: Poses,
    some: Vec<Poses>,
}

impl Footprint {
    /// The footprint of the whole image of `camera` within `error` of `pose`, without regard to d_max, as in §6.6.1.
    pub fn new(camera: &CameraModel, pose: &Pose, error: &PoseError) -> Self {
        Self::of_window(camera, [[0, camera.columns], [0, camera.rows]], pose, error)
    }

    /// The same of a part of the image: its columns and rows, from and to, the last ones not included.
    pub fn of_window(
        camera: &CameraModel,
        window: [[u16; 2]; 2],
        pose: &Pose,
        error: &PoseError,
    ) -> Self {
        let [x, y, z] = pose.p_world;
        let middle = [x, y, z, pose.yaw_rad, pose.pitch_rad, pose.roll_rad];
        let half = error.half_widths();
        let wide =
            |axis: usize| Interval::new(middle[axis] - half[axis], middle[axis] + half[axis]);
        let corner = |number: u32| -> Poses {
            std::array::from_fn(|axis| {
                let side = if number >> axis & 1 == 1 { 1.0 } else { -1.0 };
                Interval::point(middle[axis] + side * half[axis])
            })
        };
        let some = (0..64).map(corner).chain([middle.map(Interval::point)]).collect();
        Self { camera: *camera, window, all: std::array::from_fn(wide), some }
    }

    /// Paves a square of ground, from `south_west`, metres.
    pub fn pave(&self, south_west: [f64; 2], side_m: f64, least_m: f64) -> Paving {
        let start = south_west.map(|from| Interval::new(from, from + side_m));
        Paving::of(start, least_m, |cell| self.prove(cell))
    }

    /// What is proved of a box of ground. A single pose from which all of it is in the image, or none, proves that it
    /// is in X^∃, or not in X^∀.
    pub fn prove(&self, ground: &Cell) -> Proof {
        match self.is_in_image(ground, &self.all) {
            Some(true) => return Proof::Inside,
            Some(false) => return Proof::Outside,
            None => {}
        }
        let mut found = [false; 2];
        for is_seen in self.some.iter().filter_map(|pose| self.is_in_image(ground, pose)) {
            found[usize::from(is_seen)] = true;
            if found == [true; 2] {
                return Proof::Penumbra;
            }
        }
        Proof::Nothing
    }

    /// Whether all of a box of ground is in the image from all `poses`, or nothing of it from any; `None` if neither
    /// is proved.
    fn is_in_image(&self, [x, y]: &Cell, poses: &Poses) -> Option<bool> {
        let [px, py, pz, yaw, pitch, roll] = *poses;
        let (dx, dy, dz) = (*x - px, *y - py, -pz);
        let turned = |angle: Interval, a: Interval, b: Interval| {
            let [sin, cos] = angle.sin_cos();
            [cos * a + sin * b, cos * b - sin * a]
        };
        // From the world to the body: the transposes of yaw, pitch and roll.
        let [ahead, left] = turned(yaw, dx, dy);
        let [up, ahead] = turned(pitch, dz, ahead);
        let [left, up] = turned(roll, left, up);
        let tilt = Interval::point(self.camera.tilt_deg.to_radians());
        // z along the axis, which the camera's tilt turns down; y down.
        let [sin, cos] = tilt.sin_cos();
        let (right, depth, down) = (-left, cos * ahead - sin * up, -(sin * ahead) - cos * up);
        if depth.high <= 0.0 {
            return Some(false);
        }
        if depth.low <= 0.0 {
            return None;
        }
        let (columns, rows) = (f64::from(self.camera.columns), f64::from(self.camera.rows));
        let focal = Interval::point(self.camera.focal_px());
        let c = Interval::point(columns / 2.0) - focal * right / depth;
        let r = Interval::point(rows / 2.0) - focal * down / depth;
        let image = self.window.map(|[from, to]| Interval::new(f64::from(from), f64::from(to)));
        if c.is_in(image[0]) && r.is_in(image[1]) {
            return Some(true);
        }
        (c.misses(image[0]) || r.misses(image[1])).then_some(false)
    }
}
