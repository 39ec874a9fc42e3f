//! Measures of road clearing, from reports.

use std::collections::BTreeMap;

use csat_mission::measures::{Measures, Values};
use csat_proto::ids::{AgentId, Incarnation};

use super::report::{Counts, Report};

/// Measures a run.
pub struct ClearingMeasures {
    /// The side of a pixel on the ground, metres.
    pixel_m: f64,
    /// What each life counted, up to its last report.
    counts: BTreeMap<(AgentId, Incarnation), Counts>,
    /// The same up to the report before.
    before: BTreeMap<(AgentId, Incarnation), Counts>,
}

impl ClearingMeasures {
    /// Before the first step.
    pub fn new(pixel_m: f64) -> Self {
        Self { pixel_m, counts: BTreeMap::new(), before: BTreeMap::new() }
    }

    fn sum(&self, count: impl Fn(&Counts) -> u64) -> Option<f64> {
        Some(self.counts.values().map(count).sum::<u64>() as f64)
    }
}

impl Measures<Report> for ClearingMeasures {
    fn fleet(&mut self, uavs: &[&Report], _: &[[f64; 2]]) -> Values {
        self.before = self.counts.clone();
        self.counts.extend(uavs.iter().map(|report| ((report.agent, report.incarnation), report.counts)));
        let any = |says: fn(&Report) -> bool| Some(f64::from(u8::from(uavs.iter().any(|report| says(report)))));
        vec![
            ("splits", self.sum(|counts| counts.splits)),
            ("encounters", self.sum(|counts| counts.encounters)),
            ("merges", self.sum(|counts| counts.merges)),
            ("stalled", any(|report| report.is_stalled)),
            ("lost", any(|report| report.is_lost)),
        ]
    }

    fn agent(&self, report: &Report, _: &[[f64; 2]]) -> Values {
        let before = self.before.get(&(report.agent, report.incarnation)).copied().unwrap_or_default();
        let since = |now: u64, before: u64| Some(now.saturating_sub(before) as f64);
        vec![
            ("role", Some(f64::from(report.role as u8))),
            ("frontier_m", Some(self.pixel_m * f64::from(report.frontier_px))),
            ("path_m", Some(report.path_m)),
            ("hbsr_bytes", since(report.counts.hbsr_bytes, before.hbsr_bytes)),
            ("lblr_bytes", since(report.counts.lblr_bytes, before.lblr_bytes)),
        ]
    }
}
