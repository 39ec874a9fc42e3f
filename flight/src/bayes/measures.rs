//! Measures of the Bayesian search, from reports and the truth.

use std::collections::BTreeMap;

use csat_mission::measures::{Measures, Values};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation};
use nalgebra::Vector3;

use super::report::Report;

/// How far from the image of the target a sighting of it may be, pixels: agents round it.
const ROUNDING_PX: f64 = 0.01;

/// Measures a run.
pub struct BayesMeasures {
    camera: CameraModel,
    /// How many factors each life stated.
    stated: BTreeMap<(AgentId, Incarnation), u64>,
    /// Frames of this step that detected the target.
    now: u64,
    detections: u64,
}

impl BayesMeasures {
    /// Before the first step.
    pub fn new(camera: CameraModel) -> Self {
        Self { camera, stated: BTreeMap::new(), now: 0, detections: 0 }
    }

    /// Whether the last frame of an aircraft at `pose`, in truth, detected the target at `location`.
    fn is_detection(&self, report: &Report, pose: &Pose, location: [f64; 2]) -> bool {
        let Some(factor) = report.own.filter(|factor| factor.step == report.step) else {
            return false;
        };
        let Some(z) = factor.sighting.map(|z| z.map(f64::from)) else { return false };
        let target = Vector3::new(location[0], location[1], 0.0);
        let image = self.camera.at(pose).project(&target);
        image.is_some_and(|image| (image[0] - z[0]).hypot(image[1] - z[1]) < ROUNDING_PX)
    }
}

impl Measures<Report> for BayesMeasures {
    fn observe(&mut self, report: &Report, pose: &Pose, targets: &[[f64; 2]]) {
        let is_true = targets.iter().any(|location| self.is_detection(report, pose, *location));
        self.now += u64::from(is_true);
    }

    fn fleet(&mut self, uavs: &[&Report], _: &[[f64; 2]]) -> Values {
        for factor in uavs.iter().filter_map(|report| report.own) {
            let stated = self.stated.entry((factor.id.source, factor.id.incarnation)).or_default();
            *stated = (*stated).max(u64::from(factor.id.number) + 1);
        }
        let now = std::mem::take(&mut self.now);
        self.detections += now;
        vec![("true_detections", Some(now as f64)), ("detections", Some(self.detections as f64))]
    }

    fn agent(&self, report: &Report, targets: &[[f64; 2]]) -> Values {
        let target = targets.first();
        let [x, y] = report.estimate.mean;
        let stated: u64 = self.stated.values().sum();
        let held_pct =
            (stated > 0).then(|| (100.0 * report.held as f64 / stated as f64).min(100.0));
        let is_in = target.map(|p| f64::from(u8::from(report.region.contains(*p))));
        let mut values = stats(report);
        values.push(("localization_error_m", target.map(|p| (p[0] - x).hypot(p[1] - y))));
        values.push(("in_95_region", is_in));
        values.push(("factors_held_pct", held_pct));
        values
    }
}

/// What an agent can tell of itself without the truth.
pub fn stats(report: &Report) -> Values {
    vec![
        ("sigma_m", Some(report.estimate.sigma_m())),
        ("cumulative_detection", Some(report.cumulative_detection)),
        ("region_m2", Some(report.region.area_m2())),
        ("left_out", Some(report.left_out as f64)),
    ]
}
