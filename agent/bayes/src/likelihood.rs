//! The likelihood of a factor: (3)-(7) of Tisdale et al. 2008.
//!
//! For a target at ground point x, a frame that was taken from the reported pose (T̂, q̂) shows it at image
//! point z. To first order in the errors of the pose, z is normal with mean U_T(x, T̂, q̂) and covariance
//! Σ(x) = Σ_i σ_i² ∂U/∂e_i ∂U/∂e_iᵀ, e = (along track, across track, height, yaw, pitch, roll).
//!
//! - **Detection at z**: p(D, z | x) = N(z; U(x), Σ(x)) p(D | V, r(z)) + P_false / image area (3).
//! - **No detection**: 1 − p(D, V | x) − P_false, with p(D, V | x) = p(D | V, r) P(z in the image) (5), (7). The
//!   probability that z is in the image is the product, over rows and columns, of differences of normal
//!   distribution functions, which a logistic curve replaces (error below 2·10⁻⁴).
//!
//! p(D | V, r) is the mean over the errors of the pose as well: the resolution r has a relative error, most of it
//! from the height.
//!
//! The paper multiplies the normal density of (3) by p(D, V | x) of (7), edges included. That counts the edges
//! twice: the image point z of a detection is known, and in the image, whatever x is. Here they are counted
//! once, as Bayes' rule has it.
//!
//! A likelihood differs from a constant only near the footprint. What is added to a belief is therefore
//! ln p(z | x) less its constant elsewhere, and exactly 0 outside a rectangle.

use csat_proto::camera::{CameraModel, CameraView, Pose};
use csat_proto::detector::DetectorModel;
use csat_proto::model::Ground;
use nalgebra::Vector3;

use crate::config::AgentConfig;
use crate::factor::Factor;
use crate::mutant::{Mutant, is_on};

pub mod many;

/// What likelihoods depend on besides the factor.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// The camera.
    pub camera: CameraModel,
    /// The detector.
    pub detector: DetectorModel,
    /// σ of the reported pose: along, across, height, metres; yaw, pitch, roll, radians.
    pub sigma: [f64; 6],
    /// The region.
    pub ground: Ground,
}

impl Sensor {
    /// The sensor of an agent's mission.
    pub fn new(config: &AgentConfig) -> Self {
        let mut sigma = config.pose_sigma;
        if is_on(Mutant::AttitudeExact) {
            sigma[3..].fill(0.0);
        }
        Self { camera: config.camera, detector: config.detector, sigma, ground: config.ground }
    }
}

/// An axis-aligned rectangle of ground, `world`, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// West and south.
    pub min: [f64; 2],
    /// East and north.
    pub max: [f64; 2],
}

impl Rect {
    /// Whether it contains a point, borders included.
    pub fn contains(&self, x: [f64; 2]) -> bool {
        (0..2).all(|axis| self.min[axis] <= x[axis] && x[axis] <= self.max[axis])
    }

    /// Whether it meets another one.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }
}

/// Beyond this many standard deviations from the image a target is taken to be out of sight.
const EDGE_SIGMAS: f64 = 4.5;
/// Beyond this many standard deviations from a detection a target is taken not to be its cause.
const DETECTION_SIGMAS: f64 = 6.0;
/// Room for a covariance that is larger elsewhere in the image than where it was asked.
const ROOM: f64 = 1.25;
/// A target closer than this to the plane of the camera is not in the image, metres.
const MIN_DEPTH_M: f64 = 1.0;
/// No likelihood is less than this share of its constant.
const LEAST: f64 = 1e-12;

/// The likelihood of a factor.
#[derive(Debug, Clone)]
pub struct Likelihood {
    optics: Optics,
    /// p(D | V, r).
    detected: DetectionTable,
    p_false: f64,
    footprint: Option<Rect>,
    bounds: Option<Rect>,
    kind: Kind,
}

#[derive(Debug, Clone)]
enum Kind {
    /// ln[(1 − p(D, V | x) − P_false) / (1 − P_false)].
    NoDetection,
    /// ln[1 + N(z; U(x), Σ(x)) `gain`], `gain` = p(D | V, r(z)) image area / P_false.
    Detection { z: [f64; 2], gain: f64 },
}

impl Likelihood {
    /// The likelihood of a factor.
    pub fn new(sensor: &Sensor, factor: &Factor) -> Self {
        Self::of_frame(sensor, &factor.pose.into(), factor.sighting.map(|z| z.map(f64::from)))
    }

    /// The likelihood of a frame from a reported pose, with a sighting at an image point, pixels, or none.
    pub fn of_frame(sensor: &Sensor, pose: &Pose, sighting: Option<[f64; 2]>) -> Self {
        let optics = Optics::new(sensor, pose);
        let p_false = sensor.detector.p_false;
        let detected = DetectionTable::new(&optics, &sensor.detector);
        let [c, r] = optics.size_px;
        let footprint = optics.ground_box([[0.0, 0.0], [c, r]], EDGE_SIGMAS, &sensor.ground);
        let (kind, bounds) = match sighting {
            None => (Kind::NoDetection, footprint),
            Some(z) => {
                let p_false = if is_on(Mutant::FalseAlarmForgotten) { 1e-200 } else { p_false };
                let gain = detected.at(optics.inverse_depth(z)) * c * r / p_false;
                let around = optics.ground_box([z, z], DETECTION_SIGMAS, &sensor.ground);
                (Kind::Detection { z, gain }, around)
            }
        };
        Self { optics, detected, p_false, footprint, bounds, kind }
    }

    /// Where it differs from a constant; `None` if nowhere in the region.
    pub fn bounds(&self) -> Option<Rect> {
        self.bounds
    }

    /// Where a target may be in the image; `None` if nowhere in the region.
    pub fn footprint(&self) -> Option<Rect> {
        self.footprint
    }

    /// Whether the frame has a detection.
    pub fn is_detection(&self) -> bool {
        matches!(self.kind, Kind::Detection { .. })
    }

    /// ln p(z | x) less its constant outside of [`Self::bounds`], at a ground point, `world`, metres.
    pub fn ln_ratio(&self, x: [f64; 2]) -> f64 {
        if self.bounds.is_some_and(|bounds| bounds.contains(x)) { self.ln_within(x) } else { 0.0 }
    }

    /// The same for a point that is known to be within [`Self::bounds`].
    #[inline]
    pub fn ln_within(&self, x: [f64; 2]) -> f64 {
        self.excess(x).ln_1p()
    }

    /// p(z | x) over its constant outside of [`Self::bounds`], at a point that is known to be within them.
    #[inline]
    pub fn ratio_within(&self, x: [f64; 2]) -> f64 {
        1.0 + self.excess(x)
    }

    /// That ratio less 1.
    #[inline]
    fn excess(&self, x: [f64; 2]) -> f64 {
        let Some(image) = self.optics.see(x) else { return 0.0 };
        match &self.kind {
            Kind::NoDetection => (-self.p_at(&image) / (1.0 - self.p_false)).max(LEAST - 1.0),
            Kind::Detection { z, gain } => image.density(*z) * gain,
        }
    }

    /// p(D, V | x): the probability that a target at x is detected in such a frame, false alarms apart (5).
    #[inline]
    pub fn p_detection(&self, x: [f64; 2]) -> f64 {
        self.optics.see(x).map_or(0.0, |image| self.p_at(&image))
    }

    #[inline]
    fn p_at(&self, image: &ImagePoint) -> f64 {
        image.p_inside(&self.optics) * self.detected.at(image.inverse_depth)
    }
}

/// The camera at a reported pose: where a ground point is in the image, and how sure that is.
#[derive(Debug, Clone)]
pub struct Optics {
    view: CameraView,
    focal_px: f64,
    size_px: [f64; 2],
    height_m: f64,
    /// p_camera = `origin` + x `east` + y `north`.
    axes: [Vector3<f64>; 3],
    /// −∂p_camera/∂e of the three translations, times σ.
    shifts: [Vector3<f64>; 3],
    /// The axes of the three rotations in `camera`, times σ.
    turns: [Vector3<f64>; 3],
}

/// The image of a ground point.
#[derive(Debug, Clone, Copy)]
pub struct ImagePoint {
    /// U_T(x, T̂, q̂), pixels.
    pub mean: [f64; 2],
    /// Σ(x), pixels²: var(c), cov(c, r), var(r).
    pub covariance: [f64; 3],
    /// 1 / z in `camera`, 1/metres.
    pub inverse_depth: f64,
}

impl Optics {
    /// The optics of a frame.
    pub fn new(sensor: &Sensor, pose: &Pose) -> Self {
        let view = sensor.camera.at(pose);
        let to_camera = view.world_from_camera().transpose();
        let [along, across, up, yaw, pitch, roll] = sensor.sigma;
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let ahead = Vector3::new(cos, sin, 0.0);
        let left = Vector3::new(-sin, cos, 0.0);
        let without_roll = Pose { roll_rad: 0.0, ..*pose }.world_from_body();
        let turn = |axis: Vector3<f64>, sigma: f64| to_camera * axis * sigma;
        Self {
            focal_px: view.focal_px(),
            size_px: [f64::from(sensor.camera.columns), f64::from(sensor.camera.rows)],
            height_m: pose.p_world[2],
            axes: [
                to_camera * -view.centre_world(),
                to_camera * Vector3::x(),
                to_camera * Vector3::y(),
            ],
            shifts: [
                to_camera * ahead * along,
                to_camera * left * across,
                to_camera * Vector3::z() * up,
            ],
            turns: [
                turn(Vector3::z(), yaw),
                turn(left, pitch),
                turn(without_roll * Vector3::x(), roll),
            ],
            view,
        }
    }

    /// The image of a ground point, `world`, metres, whether or not it is inside the image; `None` if the point
    /// is not in front of the camera.
    #[inline(always)]
    pub fn see(&self, [x, y]: [f64; 2]) -> Option<ImagePoint> {
        let [origin, east, north] = &self.axes;
        let p = Vector3::new(
            origin.x + x * east.x + y * north.x,
            origin.y + x * east.y + y * north.y,
            origin.z + x * east.z + y * north.z,
        );
        if p.z < MIN_DEPTH_M {
            return None;
        }
        let inverse_depth = 1.0 / p.z;
        let scale = self.focal_px * inverse_depth;
        let (u, v) = (p.x * inverse_depth, p.y * inverse_depth);
        let mut covariance = [0.0; 3];
        let mut add = |d: Vector3<f64>| {
            // ∂(c, r) = −f/z (∂x − u ∂z, ∂y − v ∂z); signs do not matter in squares.
            let (dc, dr) = (d.x - u * d.z, d.y - v * d.z);
            covariance[0] += dc * dc;
            covariance[1] += dc * dr;
            covariance[2] += dr * dr;
        };
        self.shifts.iter().for_each(|shift| add(*shift));
        self.turns.iter().for_each(|axis| add(axis.cross(&p)));
        let covariance = covariance.map(|sum| sum * scale * scale);
        let mean =
            [self.size_px[0] / 2.0 - self.focal_px * u, self.size_px[1] / 2.0 - self.focal_px * v];
        Some(ImagePoint { mean, covariance, inverse_depth })
    }

    /// The relative standard deviation of the resolution on the optical axis: r = f² h / z³.
    fn resolution_sigma(&self) -> f64 {
        let centre = self.inverse_depth(self.size_px.map(|size| size / 2.0));
        if centre <= 0.0 {
            return 0.0;
        }
        let p = Vector3::new(0.0, 0.0, 1.0 / centre);
        let shifts = self.shifts.iter().copied();
        let turns = self.turns.iter().map(|axis| axis.cross(&p));
        // ∂p = −shift; the height itself is in the numerator, too: the third shift.
        let derivative = |(index, d): (usize, Vector3<f64>)| {
            let of_height = if index == 2 { d.norm() / self.height_m } else { 0.0 };
            of_height + 3.0 * d.z * centre
        };
        let squares = shifts.chain(turns).enumerate().map(|each| derivative(each).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// 1/z of the ground at an image point, 1/metres; 0 or less at and above the horizon.
    fn inverse_depth(&self, [c, r]: [f64; 2]) -> f64 {
        -self.view.ray_world(c, r).z / self.height_m
    }

    /// The rectangle of ground around a part of the image, widened by `sigmas` standard deviations; `None` if it
    /// does not meet the region.
    fn ground_box(&self, [low, high]: [[f64; 2]; 2], sigmas: f64, ground: &Ground) -> Option<Rect> {
        let half = ground.size_m.map(|size| size / 2.0);
        let all = Rect { min: half.map(|h| -h), max: half };
        let corners = |[low, high]: [[f64; 2]; 2]| {
            [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
        };
        let on_ground = |[c, r]: [f64; 2]| self.view.ground_point(c, r);
        // The greatest deviation at the corners, in pixels, for columns and rows.
        let mut deviation = [0.0f64; 2];
        for corner in corners([low, high]) {
            let Some(image) = on_ground(corner).and_then(|x| self.see(x)) else { return Some(all) };
            let [cc, _, rr] = image.covariance;
            deviation = [deviation[0].max(cc.sqrt()), deviation[1].max(rr.sqrt())];
        }
        let margin = deviation.map(|d| sigmas * ROOM * d);
        let wide =
            [[low[0] - margin[0], low[1] - margin[1]], [high[0] + margin[0], high[1] + margin[1]]];
        let mut rect = Rect { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };
        for corner in corners(wide) {
            // At the horizon the rectangle would have no end.
            let Some(x) = on_ground(corner) else { return Some(all) };
            for (axis, x) in x.into_iter().enumerate() {
                rect.min[axis] = rect.min[axis].min(x);
                rect.max[axis] = rect.max[axis].max(x);
            }
        }
        rect.meets(&all).then_some(rect)
    }
}

impl ImagePoint {
    /// The probability that the point is inside the image.
    #[inline(always)]
    fn p_inside(&self, optics: &Optics) -> f64 {
        let [cc, _, rr] = self.covariance;
        let along = |mean: f64, variance: f64, size: f64| {
            let inverse = 1.0 / variance.sqrt().max(1e-3);
            (phi((size - mean) * inverse) - phi(-mean * inverse)).max(0.0)
        };
        let columns = along(self.mean[0], cc, optics.size_px[0]);
        if columns == 0.0 {
            return 0.0;
        }
        columns * along(self.mean[1], rr, optics.size_px[1])
    }

    /// N(z; U(x), Σ(x)), per square pixel.
    #[inline]
    fn density(&self, z: [f64; 2]) -> f64 {
        let determinant = self.determinant();
        (-0.5 * self.distance_squared(z)).exp() / (std::f64::consts::TAU * determinant.sqrt())
    }

    /// The square of the Mahalanobis distance of an image point, pixels, from the mean.
    #[inline]
    pub fn distance_squared(&self, z: [f64; 2]) -> f64 {
        let [cc, cr, rr] = self.covariance;
        let (c, r) = (z[0] - self.mean[0], z[1] - self.mean[1]);
        (rr * c * c - 2.0 * cr * c * r + cc * r * r) / self.determinant()
    }

    #[inline]
    fn determinant(&self) -> f64 {
        let [cc, cr, rr] = self.covariance;
        cc * rr - cr * cr
    }
}

/// Φ(t) by a logistic curve, error below 2·10⁻⁴ (Bowling et al. 2009).
#[inline]
fn phi(t: f64) -> f64 {
    if t > 6.0 {
        return 1.0;
    }
    if t < -6.0 {
        return 0.0;
    }
    1.0 / (1.0 + (-t * (1.5976 + 0.070_566 * t * t)).exp())
}

/// p(D | V, r) over the inverse depth, the errors of the pose averaged out.
#[derive(Debug, Clone)]
struct DetectionTable {
    /// 1/z of the first entry, 1/metres.
    first: f64,
    /// Entries per 1/metres.
    per_inverse_m: f64,
    values: [f64; TABLE],
}

/// Entries of a table.
const TABLE: usize = 64;

/// Nodes and weights of the Gauss-Hermite quadrature of a standard normal number.
const HERMITE: [(f64, f64); 5] = [
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (2.856_970_013_872_806, 0.011_257_411_327_720_69),
    (-2.856_970_013_872_806, 0.011_257_411_327_720_69),
];

impl DetectionTable {
    fn new(optics: &Optics, detector: &DetectorModel) -> Self {
        let [c, r] = optics.size_px;
        // The image and half of it around: beyond, targets are out of sight.
        let corners = [[-0.5, -0.5], [1.5, -0.5], [1.5, 1.5], [-0.5, 1.5]];
        let at = |[i, j]: [f64; 2]| optics.inverse_depth([i * c, j * r]).max(1e-6);
        let depths = corners.map(at);
        let first = depths.iter().copied().fold(f64::INFINITY, f64::min);
        let last = depths.iter().copied().fold(0.0, f64::max).max(first + 1e-9);
        let step = (last - first) / (TABLE - 1) as f64;
        let sigma = optics.resolution_sigma();
        let nodes = HERMITE.map(|(node, weight)| ((sigma * node).exp(), weight));
        let mean = |index: usize| {
            let inverse_depth = first + index as f64 * step;
            let r = optics.focal_px.powi(2) * optics.height_m * inverse_depth.powi(3);
            nodes.iter().map(|(ratio, weight)| weight * detector.p_detected(r * ratio)).sum()
        };
        Self { first, per_inverse_m: 1.0 / step, values: std::array::from_fn(mean) }
    }

    #[inline]
    fn at(&self, inverse_depth: f64) -> f64 {
        let place = ((inverse_depth - self.first) * self.per_inverse_m).max(0.0);
        let index = (place as usize).min(TABLE - 2);
        let share = (place - index as f64).min(1.0);
        self.values[index] + share * (self.values[index + 1] - self.values[index])
    }
}

#[cfg(test)]
#[path = "likelihood_tests.rs"]
pub(crate) mod tests;
