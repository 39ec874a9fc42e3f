//! The pinhole camera of the thesis, §3.4 and §4.7.1.
//!
//! Frames: `world` (East-North-Up), `body` (x forward, y left, z up), `camera` (x right, y down,
//! z along the optical axis). As on a physical sensor the image is upside down: by (3.16) a point
//! to the right of the axis falls on a *smaller* column and a point below it on a *smaller* row, so
//! row 0 looks at the nearest ground.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Position and attitude of a UAV. The optical centre is the body's origin.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// Position in `world`, metres.
    pub p_world: [f64; 3],
    /// Heading about the vertical, counter-clockwise from east, radians.
    pub yaw_rad: f64,
    /// Nose-down angle, radians.
    pub pitch_rad: f64,
    /// Right-side-down angle, radians.
    pub roll_rad: f64,
}

impl Pose {
    /// A level pose.
    pub fn level(p_world: [f64; 3], yaw_rad: f64) -> Self {
        Self { p_world, yaw_rad, pitch_rad: 0.0, roll_rad: 0.0 }
    }

    /// The rotation that takes `body` vectors to `world`.
    pub fn world_from_body(&self) -> Matrix3<f64> {
        let (sy, cy) = self.yaw_rad.sin_cos();
        let (sp, cp) = self.pitch_rad.sin_cos();
        let (sr, cr) = self.roll_rad.sin_cos();
        let yaw = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
        let pitch = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
        let roll = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
        yaw * pitch * roll
    }
}

/// How far each component of a true pose may be from the reported one: the half-widths of a box that contains
/// the true pose (thesis §6.1). All are 0 where the reported pose is exact.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseError {
    /// Of the position along each axis of `world`, metres.
    pub p_world: [f64; 3],
    /// Of the yaw, radians.
    pub yaw_rad: f64,
    /// Of the pitch, radians.
    pub pitch_rad: f64,
    /// Of the roll, radians.
    pub roll_rad: f64,
}

impl PoseError {
    /// No error.
    pub const NONE: Self = Self { p_world: [0.0; 3], yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 };

    /// The half-widths: x, y, z, metres; yaw, pitch, roll, radians.
    pub fn half_widths(&self) -> [f64; 6] {
        let [x, y, z] = self.p_world;
        [x, y, z, self.yaw_rad, self.pitch_rad, self.roll_rad]
    }

    /// Whether the reported pose is exact.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }
}

/// A pose as a UAV knows it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseEstimate {
    /// The reported pose, in the middle of the box.
    pub pose: Pose,
    /// The half-widths of the box.
    pub error: PoseError,
}

impl From<Pose> for PoseEstimate {
    /// A pose that is exact, or whose error nobody bounds.
    fn from(pose: Pose) -> Self {
        Self { pose, error: PoseError::NONE }
    }
}

/// How a label relates to the rays of its pixel (thesis §3.5.2). Ground always follows Assumption 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub enum Assumption {
    /// Every ray of the pixel meets the same entity.
    EveryRay,
    /// At least one ray of the pixel meets the entity, and the depth is along such a ray.
    SomeRay,
    /// The ray through the pixel's centre meets the entity, and the depth is along it.
    CentreRay,
}

impl TryFrom<u8> for Assumption {
    type Error = String;
    fn try_from(value: u8) -> Result<Self, String> {
        match value {
            4 => Ok(Self::EveryRay),
            5 => Ok(Self::SomeRay),
            6 => Ok(Self::CentreRay),
            other => Err(format!("invalid value: {other}, expected assumption 4, 5 or 6")),
        }
    }
}

impl From<Assumption> for u8 {
    fn from(value: Assumption) -> u8 {
        match value {
            Assumption::EveryRay => 4,
            Assumption::SomeRay => 5,
            Assumption::CentreRay => 6,
        }
    }
}

/// `[camera]`: the camera and what its CVS guarantees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraModel {
    /// N_c, image width in pixels.
    pub columns: u16,
    /// N_r, image height in pixels.
    pub rows: u16,
    /// Horizontal aperture, degrees.
    pub aperture_deg: f64,
    /// θ: how far the optical axis points below the horizon, degrees.
    pub tilt_deg: f64,
    /// d_max: pixels of points that are farther are Unknown, metres.
    pub d_max_m: f64,
    /// [w_lo, w_hi]: bounds of the depth noise (3.33), relative to the distance: 0.01 is 1 %.
    pub depth_noise: [f64; 2],
    /// A target is identified when at least this many of its pixels are labelled Target. Every car in
    /// the footprint of the paper's 480 x 360 camera has at least the default, 8, from the highest of
    /// the paper's four altitudes, 61 m, at its worst heading.
    pub min_pixels: u32,
    /// The most by which a detection box may be displaced, pixels; (3.53) holds all the same.
    pub box_error_px: u16,
    /// 4, 5 or 6: which assumption Obstacle and Target labels obey.
    pub assumption: Assumption,
    /// The probability that an identified target is taken for another one, 0..1, in each frame.
    pub misidentify: f64,
}

impl Default for CameraModel {
    fn default() -> Self {
        Self {
            columns: 480,
            rows: 360,
            aperture_deg: 45.0,
            tilt_deg: 30.0,
            d_max_m: 300.0,
            depth_noise: [-0.01, 0.01],
            min_pixels: 8,
            box_error_px: 0,
            assumption: Assumption::EveryRay,
            misidentify: 0.0,
        }
    }
}

impl CameraModel {
    /// f_c = f_r, in pixels.
    pub fn focal_px(&self) -> f64 {
        f64::from(self.columns) / (2.0 * (self.aperture_deg.to_radians() / 2.0).tan())
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        usize::from(self.columns) * usize::from(self.rows)
    }

    /// The rotation that takes `body` vectors to `camera` (4.43).
    pub fn camera_from_body(&self) -> Matrix3<f64> {
        let (s, c) = self.tilt_deg.to_radians().sin_cos();
        let axes = Matrix3::new(0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0);
        axes * Matrix3::new(c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c)
    }

    /// The depth of one quantisation step, metres.
    pub fn depth_step_m(&self) -> f64 {
        self.d_max_m / 65535.0
    }

    /// Quantises a noisy depth D; `None` when it exceeds d_max.
    pub fn quantise_depth(&self, depth_m: f64) -> Option<u16> {
        let steps = (depth_m / self.depth_step_m()).round();
        (0.0..=65535.0).contains(&steps).then_some(steps as u16)
    }

    /// The interval that contains the true distance ρ behind a quantised depth (3.35): the noise
    /// interval widened by half a quantisation step.
    pub fn depth_interval_m(&self, depth: u16) -> [f64; 2] {
        let [lo, hi] = self.depth_noise;
        let step = self.depth_step_m();
        let d = f64::from(depth) * step;
        [((d - 0.5 * step) / (1.0 + hi)).max(0.0), (d + 0.5 * step) / (1.0 + lo)]
    }

    /// The camera at a pose.
    pub fn at(&self, pose: &Pose) -> CameraView {
        CameraView::new(*self, pose)
    }
}

/// A camera at a pose: rays, projection and the ground homography.
#[derive(Debug, Clone)]
pub struct CameraView {
    model: CameraModel,
    focal_px: f64,
    centre_world: Vector3<f64>,
    world_from_camera: Matrix3<f64>,
    /// Direction of the ray of image point (c, r): `ray_matrix * (c, r, 1)`, in `world`, not
    /// normalised: its component along the optical axis is 1.
    ray_matrix: Matrix3<f64>,
}

impl CameraView {
    /// The camera `model` at `pose`.
    pub fn new(model: CameraModel, pose: &Pose) -> Self {
        let f = model.focal_px();
        let (half_c, half_r) = (f64::from(model.columns) / 2.0, f64::from(model.rows) / 2.0);
        let world_from_camera = pose.world_from_body() * model.camera_from_body().transpose();
        let camera_ray =
            Matrix3::new(-1.0 / f, 0.0, half_c / f, 0.0, -1.0 / f, half_r / f, 0.0, 0.0, 1.0);
        Self {
            model,
            focal_px: f,
            centre_world: Vector3::from(pose.p_world),
            world_from_camera,
            ray_matrix: world_from_camera * camera_ray,
        }
    }

    /// The camera.
    pub fn model(&self) -> &CameraModel {
        &self.model
    }

    /// f_c = f_r, in pixels.
    pub fn focal_px(&self) -> f64 {
        self.focal_px
    }

    /// The optical centre in `world`, metres.
    pub fn centre_world(&self) -> Vector3<f64> {
        self.centre_world
    }

    /// The rotation that takes `camera` vectors to `world`.
    pub fn world_from_camera(&self) -> &Matrix3<f64> {
        &self.world_from_camera
    }

    /// `ray_matrix() * (c, r, 1)` is [`Self::ray_world`]; c and r in pixels.
    pub fn ray_matrix(&self) -> &Matrix3<f64> {
        &self.ray_matrix
    }

    /// The direction in `world` of the ray through image point (c, r), pixels, ν·v of (3.18): its
    /// component along the optical axis is 1, so a point at distance ρ is
    /// `centre + ray * (ρ / ray.norm())`.
    pub fn ray_world(&self, c: f64, r: f64) -> Vector3<f64> {
        self.ray_matrix * Vector3::new(c, r, 1.0)
    }

    /// A `world` point in the camera frame, metres.
    pub fn to_camera(&self, p_world: &Vector3<f64>) -> Vector3<f64> {
        self.world_from_camera.tr_mul(&(p_world - self.centre_world))
    }

    /// The image point (c, r), pixels, of a `world` point (metres) in front of the camera (3.16),
    /// whether or not it falls inside the image; `None` for a point beside or behind the camera.
    pub fn project(&self, p_world: &Vector3<f64>) -> Option<[f64; 2]> {
        let p = self.to_camera(p_world);
        (p.z > 1e-9).then(|| self.project_camera(&p))
    }

    /// The image point (c, r), pixels, of a point of the `camera` frame with z > 0, metres.
    pub fn project_camera(&self, p_camera: &Vector3<f64>) -> [f64; 2] {
        [
            f64::from(self.model.columns) / 2.0 - self.focal_px * p_camera.x / p_camera.z,
            f64::from(self.model.rows) / 2.0 - self.focal_px * p_camera.y / p_camera.z,
        ]
    }

    /// Where the ray of image point (c, r) meets the ground z = 0, `world`, metres; `None` at or
    /// above the horizon.
    pub fn ground_point(&self, c: f64, r: f64) -> Option<[f64; 2]> {
        let ray = self.ray_world(c, r);
        (ray.z < -1e-12).then(|| {
            let scale = -self.centre_world.z / ray.z;
            [self.centre_world.x + scale * ray.x, self.centre_world.y + scale * ray.y]
        })
    }

    /// The number of pixels per square metre of ground at image point (c, r), px/m²: f²·h/z³ for a camera at
    /// height h that sees the point at depth z along its axis. 0 at or above the horizon.
    pub fn resolution_px_m2(&self, c: f64, r: f64) -> f64 {
        let inverse_depth = -self.ray_world(c, r).z / self.centre_world.z;
        if inverse_depth <= 0.0 {
            return 0.0;
        }
        self.focal_px.powi(2) * self.centre_world.z * inverse_depth.powi(3)
    }

    /// The theoretical footprint F(x^u) ∩ {z = 0} as a counter-clockwise polygon (3.24), `world`,
    /// metres, cut at the ground distance where the slant range reaches d_max.
    ///
    /// The cut replaces the arc by a chord through its end points, so the polygon lies inside the
    /// true footprint; empty when the camera sees no ground.
    pub fn footprint(&self) -> Vec<[f64; 2]> {
        let (w, h) = (f64::from(self.model.columns), f64::from(self.model.rows));
        let corners = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]];
        let reach = (self.model.d_max_m.powi(2) - self.centre_world.z.powi(2)).max(0.0).sqrt();
        let mut polygon = Vec::new();
        for (index, &[c, r]) in corners.iter().enumerate() {
            let [c_next, r_next] = corners[(index + 1) % 4];
            self.append_reachable_edge([c, r], [c_next, r_next], reach, &mut polygon);
        }
        let area: f64 = (0..polygon.len())
            .map(|i| {
                let (a, b): ([f64; 2], [f64; 2]) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                a[0] * b[1] - b[0] * a[1]
            })
            .sum();
        if area < 0.0 {
            polygon.reverse();
        }
        polygon
    }

    /// Appends the part of an image edge whose ground points lie within `reach` of the nadir of the
    /// camera, end point excluded, in a few chords.
    fn append_reachable_edge(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        reach: f64,
        polygon: &mut Vec<[f64; 2]>,
    ) {
        const CHORDS: u32 = 64;
        let within = |t: f64| {
            let c = from[0] + t * (to[0] - from[0]);
            let r = from[1] + t * (to[1] - from[1]);
            self.ground_point(c, r)
                .filter(|p| (p[0] - self.centre_world.x).hypot(p[1] - self.centre_world.y) <= reach)
        };
        if let (Some(start), Some(_)) = (within(0.0), within(1.0)) {
            polygon.push(start);
            return;
        }
        for i in 0..CHORDS {
            polygon.extend(within(f64::from(i) / f64::from(CHORDS)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_inverts_rays() {
        let view = CameraModel::default().at(&Pose {
            p_world: [10.0, -20.0, 52.0],
            yaw_rad: 0.7,
            pitch_rad: 0.02,
            roll_rad: -0.01,
        });
        for (c, r) in [(0.0, 0.0), (480.0, 360.0), (123.4, 56.7)] {
            let p = view.centre_world() + view.ray_world(c, r) * 37.0;
            let [c2, r2] = view.project(&p).unwrap();
            assert!((c - c2).abs() < 1e-9 && (r - r2).abs() < 1e-9);
        }
    }

    /// The thesis: at 52 m the footprint runs from about 48 m to 230 m ahead.
    #[test]
    fn footprint_at_52_m_is_the_published_one() {
        let view = CameraModel::default().at(&Pose::level([0.0, 0.0, 52.0], 0.0));
        let xs: Vec<f64> = view.footprint().iter().map(|p| p[0]).collect();
        let near = xs.iter().copied().fold(f64::INFINITY, f64::min);
        let far = xs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((near - 48.0).abs() < 0.5, "near {near}");
        assert!((far - 230.0).abs() < 1.5, "far {far}");
        let nearest_row = view.ground_point(240.0, 0.0).unwrap();
        assert!((nearest_row[0] - near).abs() < 1e-9, "row 0 looks at the nearest ground");
    }

    #[test]
    fn resolution_is_pixels_per_area_on_the_ground() {
        let pose =
            Pose { p_world: [3.0, -7.0, 90.0], yaw_rad: 0.4, pitch_rad: -0.1, roll_rad: 0.26 };
        let view = CameraModel { tilt_deg: 90.0, ..CameraModel::default() }.at(&pose);
        for [c, r] in [[240.0, 180.0], [20.0, 350.0]] {
            let e = 1e-3;
            let corner = |dc: f64, dr: f64| view.ground_point(c + dc * e, r + dr * e).unwrap();
            let [o, a, b] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
            let area = (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
            let expected = e * e / area.abs();
            assert!((view.resolution_px_m2(c, r) / expected - 1.0).abs() < 1e-3);
        }
        assert_eq!(CameraModel::default().at(&pose).resolution_px_m2(240.0, 1e5), 0.0);
    }

    #[test]
    fn depth_interval_contains_every_noisy_depth() {
        let camera = CameraModel::default();
        for (rho, w) in [(50.0, -0.01), (123.456, 0.01), (290.0, 0.0)] {
            let depth = camera.quantise_depth(rho * (1.0 + w)).unwrap();
            let [lo, hi] = camera.depth_interval_m(depth);
            assert!(lo <= rho && rho <= hi);
        }
        assert_eq!(camera.quantise_depth(301.0), None);
    }
}
