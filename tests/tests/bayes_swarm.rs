//! The swarm of the Bayesian search: fixed seeds, those that once failed, and a few new ones.
//!
//! `CSAT_SEEDS=1000` flies that many instead, `CSAT_SEEDS=500..700` those; `CSAT_SEED=7` flies one.

use csat_tests::bayes::swarm::{self, Exercise};
use csat_tests::replay::Seeds;

/// Seeds that are flown every time, and new ones.
const SEEDS: Seeds = Seeds {
    fixed: 40,
    fresh: 4,
    regressions: concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/bayes_swarm_regressions.txt"),
};

#[test]
fn whatever_the_links_do_beliefs_are_products_and_healed_agents_agree() {
    if let Some(exercise) = SEEDS.fly("bayes_swarm", swarm::fly, Exercise::with) {
        let Exercise { corrupted, duplicated, late, crashes, old, missed, ahead, .. } = exercise;
        let Exercise { repeated, relayed, sightings, products, equal, identical, .. } = exercise;
        let Exercise { stale, converged, tight, stationed, moving, .. } = exercise;
        let many = [corrupted, duplicated, late, crashes, old, missed, ahead, repeated, relayed];
        let more = [sightings, products, equal, identical];
        assert!(many.iter().chain(&more).min() > Some(&10), "{exercise:?}");
        assert!(
            [stale, converged, tight, stationed, moving].iter().min() > Some(&2),
            "{exercise:?}"
        );
    }
}
