//! The localisation of a target: the expected covariance after the horizon.
//!
//! A detection at z adds Hᵀ Σ_z⁻¹ H, H = ∂z/∂x, to the information on the target. A plan is expected to add
//! Σ_k p(D, V | x, pose_k) Hᵀ Σ_z⁻¹ H, averaged over five points that represent where the target may be.

use csat_proto::camera::Pose;

use super::beam::Objective;
use super::footprint::Footprints;
use super::route::distance;
use crate::search_map::Gaussian;

/// Points of a Gaussian, in standard deviations along its axes, and their weights: √3 keeps fourth moments.
const POINTS: [([f64; 2], f64); 5] = [
    ([0.0, 0.0], 1.0 / 3.0),
    ([1.732, 0.0], 1.0 / 6.0),
    ([-1.732, 0.0], 1.0 / 6.0),
    ([0.0, 1.732], 1.0 / 6.0),
    ([0.0, -1.732], 1.0 / 6.0),
];

/// The objective of an aircraft with a target.
pub struct Localisation<'a> {
    footprints: &'a Footprints,
    mean: [f64; 2],
    points: [([f64; 2], f64); 5],
    /// Of the belief and the plans of others: xx, xy, yy, 1/m².
    information: [f64; 3],
    lead_m: f64,
    attraction_m: f64,
}

impl<'a> Localisation<'a> {
    /// The objective for a target. `others` are the poses of the plans of other aircraft, which are taken to have
    /// the same camera and height.
    pub fn new(
        footprints: &'a Footprints,
        target: &Gaussian,
        others: impl Iterator<Item = &'a Pose>,
        lead_m: f64,
        attraction_m: f64,
    ) -> Self {
        let [xx, xy, yy] = target.covariance;
        // The lower triangular root of the covariance.
        let a = xx.max(1e-6).sqrt();
        let b = xy / a;
        let c = (yy - b * b).max(1e-6).sqrt();
        let [x, y] = target.mean;
        let point = |([s, t], weight): ([f64; 2], f64)| ([x + a * s, y + b * s + c * t], weight);
        let determinant = a * a * c * c;
        let information =
            [(b * b + c * c) / determinant, -a * b / determinant, a * a / determinant];
        let points = POINTS.map(point);
        let mut objective =
            Self { footprints, mean: [x, y], points, information, lead_m, attraction_m };
        for pose in others {
            objective.information = objective.with(objective.information, pose);
        }
        objective
    }

    /// Information after another second of frames from a pose.
    fn with(&self, mut information: [f64; 3], pose: &Pose) -> [f64; 3] {
        if distance(self.mean, [pose.p_world[0], pose.p_world[1]]) > 400.0 {
            return information;
        }
        let (sin, cos) = pose.yaw_rad.sin_cos();
        for (x, weight) in self.points {
            let Some(seen) = self.footprints.at(pose, x) else { continue };
            let [uu, uv, vv] = seen.information.map(|i| f64::from(i) * weight);
            // From along the heading and to the left to east and north.
            information[0] += cos * cos * uu - 2.0 * cos * sin * uv + sin * sin * vv;
            information[1] += cos * sin * (uu - vv) + (cos * cos - sin * sin) * uv;
            information[2] += sin * sin * uu + 2.0 * cos * sin * uv + cos * cos * vv;
        }
        information
    }

    /// The trace of the expected covariance, m².
    fn trace([xx, xy, yy]: [f64; 3]) -> f64 {
        (xx + yy) / (xx * yy - xy * xy).max(f64::MIN_POSITIVE)
    }
}

impl Objective for Localisation<'_> {
    type State = [f64; 3];

    fn start(&self) -> [f64; 3] {
        self.information
    }

    fn value(&mut self, state: &[f64; 3], second: usize, poses: &[Pose]) -> f64 {
        let information = self.after(state, second, poses);
        let away = poses.last().map_or(0.0, |end| {
            let (sin, cos) = end.yaw_rad.sin_cos();
            let [x, y, _] = end.p_world;
            distance(self.mean, [x + self.lead_m * cos, y + self.lead_m * sin])
        });
        // Half the logarithm of the trace is the logarithm of the standard deviation.
        -0.5 * Self::trace(information).ln() - away / self.attraction_m * PULL
    }

    fn after(&mut self, state: &[f64; 3], _: usize, poses: &[Pose]) -> [f64; 3] {
        poses.iter().fold(*state, |information, pose| self.with(information, pose))
    }
}

/// What it is worth, in nats of the standard deviation, that a plan ends one `attraction_m` nearer.
const PULL: f64 = 0.03;
