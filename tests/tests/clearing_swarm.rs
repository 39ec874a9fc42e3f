//! The swarm of road clearing: fixed seeds, those that once failed, and a few new ones.
//!
//! `CSAT_SEEDS=1000` flies that many instead, `CSAT_SEEDS=500..700` those; `CSAT_SEED=7` flies one.

use csat_tests::clearing::swarm::{self, Exercise};
use csat_tests::replay::Seeds;

/// Seeds that are flown every time, and new ones.
const SEEDS: Seeds = Seeds {
    fixed: 40,
    fresh: 4,
    regressions: concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/clearing_swarm_regressions.txt"),
};

#[test]
fn whatever_the_links_do_what_is_called_cleared_is_cleared() {
    if let Some(exercise) = SEEDS.fly("clearing_swarm", swarm::fly, Exercise::with) {
        let Exercise { cleared, splits, encounters, merges, stalled, lost, told, .. } = exercise;
        assert!([cleared, splits, merges, lost].iter().min() > Some(&2), "{exercise:?}");
        assert!([encounters, stalled, told].iter().min() > Some(&0), "{exercise:?}");
        assert!(exercise.dropped.min(exercise.checks) > 10_000, "{exercise:?}");
    }
}
