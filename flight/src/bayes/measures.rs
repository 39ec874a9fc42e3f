//! Measures of the Bayesian search, from reports and the truth.

use std::collections::BTreeMap;

use csat_bayes::likelihood::{Optics, Sensor};
use csat_mission::measures::{Measures, Values};
use csat_proto::ids::{AgentId, Incarnation};

use super::report::Report;

/// A sighting farther from where the target's image is expected is not the target, standard deviations.
const GATE_SIGMAS: f64 = 5.0;

/// Measures a run.
pub struct BayesMeasures {
    sensor: Sensor,
    /// How many factors each life stated.
    stated: BTreeMap<(AgentId, Incarnation), u64>,
    detections: u64,
}

impl BayesMeasures {
    /// Before the first step.
    pub fn new(sensor: Sensor) -> Self {
        Self { sensor, stated: BTreeMap::new(), detections: 0 }
    }

    /// Whether the last frame of an aircraft detected a target at `location`.
    fn is_detection(&self, report: &Report, location: [f64; 2]) -> bool {
        let Some(factor) = report.own.filter(|factor| factor.step == report.step) else {
            return false;
        };
        let Some(z) = factor.sighting.map(|z| z.map(f64::from)) else { return false };
        let optics = Optics::new(&self.sensor, &factor.pose.into());
        let Some(image) = optics.see(location) else { return false };
        image.distance_squared(z) <= GATE_SIGMAS * GATE_SIGMAS
    }
}

impl Measures<Report> for BayesMeasures {
    fn fleet(&mut self, uavs: &[&Report], targets: &[[f64; 2]]) -> Values {
        for factor in uavs.iter().filter_map(|report| report.own) {
            let stated = self.stated.entry((factor.id.source, factor.id.incarnation)).or_default();
            *stated = (*stated).max(u64::from(factor.id.number) + 1);
        }
        let is_detection = |report: &&&Report| {
            targets.iter().any(|location| self.is_detection(report, *location))
        };
        let now = uavs.iter().filter(is_detection).count() as u64;
        self.detections += now;
        vec![
            ("true_detections", Some(now as f64)),
            ("detections", Some(self.detections as f64)),
        ]
    }

    fn agent(&self, report: &Report, targets: &[[f64; 2]]) -> Values {
        let target = targets.first();
        let [x, y] = report.estimate.mean;
        let stated: u64 = self.stated.values().sum();
        let held_pct = (stated > 0).then(|| (100.0 * report.held as f64 / stated as f64).min(100.0));
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
