//! The soundness swarm: a few hundred fixed seeds, those that once failed, and a few new ones.
//!
//! `CSAT_SEEDS=10000` flies that many instead, `CSAT_SEEDS=500..700` those; `CSAT_SEED=7` flies one.

use csat_tests::replay::Seeds;
use csat_tests::swarm::{self, Exercise};
use rayon::prelude::*;

/// Seeds that are flown every time, and new ones.
const SEEDS: Seeds = Seeds {
    fixed: 300,
    fresh: 20,
    regressions: concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/swarm_regressions.txt"),
};

#[test]
fn whatever_the_links_do_the_guarantee_holds_and_a_healed_core_agrees() {
    let seeds = SEEDS.all();
    let flown: Vec<_> = seeds.par_iter().map(|&seed| (seed, swarm::fly(seed))).collect();
    let mut failures = Vec::new();
    let mut exercise = Exercise::default();
    for (seed, result) in flown {
        match result {
            Ok(more) => exercise = exercise.with(more),
            Err(law) => {
                SEEDS.keep(seed, &law);
                failures.push(format!(
                    "seed {seed}: {law}\n    replay it with CSAT_SEED={seed} cargo test -p \
                     csat-tests --test swarm -- --nocapture"
                ));
            }
        }
    }
    println!("{exercise:#?}");
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), seeds.len(), failures.join("\n"));
    if seeds.len() as u64 >= SEEDS.fixed {
        let Exercise { corrupted, duplicated, late, crashes, stale, .. } = exercise;
        let Exercise { merged, precise, missed, skewed, evasive, stationed, walled, .. } = exercise;
        let faults = [corrupted, duplicated, late, crashes, stale, missed, skewed];
        let kinds = [merged, precise, evasive, stationed, walled];
        let rare = faults.iter().chain(&kinds).min();
        assert!(rare > Some(&10), "{exercise:?}");
    }
}
