//! The soundness swarm: a few hundred fixed seeds, those that once failed, and a few new ones.
//!
//! `CSAT_SEEDS=10000` flies that many instead, `CSAT_SEEDS=500..700` those; `CSAT_SEED=7` flies one.

use csat_tests::replay::Seeds;
use csat_tests::swarm::{self, Exercise};

/// Seeds that are flown every time, and new ones.
const SEEDS: Seeds = Seeds {
    fixed: 300,
    fresh: 20,
    regressions: concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/swarm_regressions.txt"),
};

#[test]
fn whatever_the_links_do_the_guarantee_holds_and_a_healed_core_agrees() {
    if let Some(exercise) = SEEDS.fly("swarm", swarm::fly, Exercise::with) {
        let Exercise { corrupted, duplicated, late, crashes, stale, .. } = exercise;
        let Exercise { merged, precise, missed, skewed, evasive, stationed, walled, .. } = exercise;
        let Exercise { uncertain, lying, relayed, named, .. } = exercise;
        let faults = [corrupted, duplicated, late, crashes, stale, missed, skewed];
        let kinds = [merged, precise, evasive, stationed, uncertain, walled, lying, relayed, named];
        let rare = faults.iter().chain(&kinds).min();
        assert!(rare > Some(&10), "{exercise:?}");
    }
}
