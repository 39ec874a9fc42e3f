//! What the stages of a run's agent-steps took, summed up.

use csat_mission::timing::StageTimes;
use serde::{Deserialize, Serialize};

/// Median, 95th percentile and maximum, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Spread {
    /// Half of the values are not above this.
    pub median: f64,
    /// 95 % of the values are not above this.
    pub p95: f64,
    /// The greatest value.
    pub max: f64,
}

/// The spread of values, by linear interpolation between the closest ranks; 0 for none.
pub fn spread(values: &[f64]) -> Spread {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    Spread {
        median: quantile(&sorted, 0.5),
        p95: quantile(&sorted, 0.95),
        max: sorted.last().copied().unwrap_or(0.0),
    }
}

/// The quantile `q` of sorted values (type 7 of Hyndman and Fan); 0 for none.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    if sorted.is_empty() {
        return 0.0;
    }
    let rank = q.clamp(0.0, 1.0) * (sorted.len() - 1) as f64;
    let (below, share) = (rank.floor() as usize, rank.fract());
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + share * (sorted[above] - sorted[below])
}

/// Every time of a run by stage.
#[derive(Debug, Clone, Default)]
pub struct Timing {
    stages: [Vec<f64>; 5],
}

/// `timing_ms` of the summary.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct TimingSummary {
    /// See [`StageTimes::render`].
    pub render: Spread,
    /// See [`StageTimes::sense`].
    pub sense: Spread,
    /// See [`StageTimes::estimate`].
    pub estimate: Spread,
    /// See [`StageTimes::fuse`].
    pub fuse: Spread,
    /// See [`StageTimes::guidance`], per decision.
    pub guidance: Spread,
}

impl Timing {
    /// Takes note of one agent-step.
    pub fn add(&mut self, times: &StageTimes) {
        let StageTimes { render, sense, estimate, fuse, guidance } = *times;
        for (stage, time) in self.stages.iter_mut().zip([render, sense, estimate, fuse, guidance]) {
            stage.extend(time);
        }
    }

    /// The spreads.
    pub fn summary(&self) -> TimingSummary {
        let [render, sense, estimate, fuse, guidance] = self.stages.each_ref().map(|s| spread(s));
        TimingSummary { render, sense, estimate, fuse, guidance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_hand() {
        let values: Vec<f64> = (1..=5).rev().map(f64::from).collect();
        assert_eq!(spread(&values), Spread { median: 3.0, p95: 4.8, max: 5.0 });
        assert_eq!(spread(&[7.0]), Spread { median: 7.0, p95: 7.0, max: 7.0 });
        assert_eq!(spread(&[1.0, 2.0]).median, 1.5);
        assert_eq!(spread(&[]), Spread::default());
    }

    #[test]
    fn stages_that_did_not_run_do_not_count() {
        let mut timing = Timing::default();
        for guidance in [None, Some(4.0), None] {
            timing.add(&StageTimes { render: Some(1.0), guidance, ..StageTimes::default() });
        }
        let summary = timing.summary();
        assert_eq!((summary.render.median, summary.guidance.median), (1.0, 4.0));
        assert_eq!(summary.fuse, Spread::default());
    }
}
