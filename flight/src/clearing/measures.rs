//! Measures of road clearing, from reports.

use std::collections::BTreeMap;

use csat_clearing::agent::{Counters, Role};
use csat_mission::measures::{Measures, Values};
use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, Incarnation};

use super::report::Report;

/// Measures a run.
pub struct ClearingMeasures {
    /// The side of a pixel on the ground, metres.
    pixel_m: f64,
    /// What each life counted, up to its last report.
    counters: BTreeMap<(AgentId, Incarnation), Counters>,
    /// The same up to the report before.
    before: BTreeMap<(AgentId, Incarnation), Counters>,
    /// Where each UAV was, and the length of its path, metres.
    paths: BTreeMap<AgentId, ([f64; 3], f64)>,
}

impl ClearingMeasures {
    /// Before the first step.
    pub fn new(pixel_m: f64) -> Self {
        Self { pixel_m, counters: BTreeMap::new(), before: BTreeMap::new(), paths: BTreeMap::new() }
    }

    fn sum(&self, count: impl Fn(&Counters) -> u32) -> Option<f64> {
        Some(self.counters.values().map(|c| u64::from(count(c))).sum::<u64>() as f64)
    }
}

impl Measures<Report> for ClearingMeasures {
    fn observe(&mut self, report: &Report, pose: &Pose, _: &[[f64; 2]]) {
        let (place, path_m) = self.paths.entry(report.agent).or_insert((pose.p_world, 0.0));
        *path_m += (pose.p_world[0] - place[0]).hypot(pose.p_world[1] - place[1]);
        *place = pose.p_world;
    }

    fn fleet(&mut self, uavs: &[&Report], _: &[[f64; 2]]) -> Values {
        self.before = self.counters.clone();
        self.counters.extend(
            uavs.iter().map(|report| ((report.agent, report.incarnation), report.counters)),
        );
        let any = |says: fn(&Report) -> bool| {
            Some(f64::from(u8::from(uavs.iter().any(|report| says(report)))))
        };
        vec![
            ("splits", self.sum(|c| c.splits)),
            ("encounters", self.sum(|c| c.encounters)),
            ("merges", self.sum(|c| c.merges)),
            ("stalled", any(|report| report.is_stalled)),
            ("lost", any(|report| report.is_lost)),
        ]
    }

    fn agent(&self, report: &Report, _: &[[f64; 2]]) -> Values {
        let before =
            self.before.get(&(report.agent, report.incarnation)).copied().unwrap_or_default();
        let since = |now: u64, before: u64| Some(now.saturating_sub(before) as f64);
        vec![
            ("duty", duty(report.role)),
            ("frontier_m", Some(self.pixel_m * f64::from(report.frontier_px))),
            ("path_m", self.paths.get(&report.agent).map(|(_, path_m)| *path_m)),
            ("hbsr_bytes", since(report.counters.hbsr_bytes, before.hbsr_bytes)),
            ("lblr_bytes", since(report.counters.lblr_bytes, before.lblr_bytes)),
        ]
    }
}

/// A role as a number; a ground station has none.
fn duty(role: Role) -> Option<f64> {
    match role {
        Role::Cleaner => Some(0.0),
        Role::LeftWing | Role::RightWing => Some(1.0),
        Role::Tail => Some(2.0),
        Role::Helper => Some(3.0),
        Role::Station => None,
    }
}
