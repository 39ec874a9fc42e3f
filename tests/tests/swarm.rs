//! The soundness swarm: a few hundred fixed seeds, those that once failed, and a few new ones.
//!
//! `CSAT_SEEDS=10000` flies that many instead, `CSAT_SEEDS=500..700` those; `CSAT_SEED=7` flies one.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::time::SystemTime;

use csat_tests::swarm::{self, Exercise};
use rayon::prelude::*;

/// Seeds that are flown every time.
const FIXED: u64 = 300;
/// New seeds, which no earlier run has flown.
const FRESH: u64 = 20;
/// Seeds that failed once; failing ones are added.
const REGRESSIONS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/swarm_regressions.txt");

fn variable(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// `CSAT_SEEDS`: how many, or from..to.
fn range() -> Option<std::ops::Range<u64>> {
    let text = std::env::var("CSAT_SEEDS").ok()?;
    let (from, to) = text.split_once("..").unwrap_or(("0", &text));
    Some(from.parse().ok()?..to.parse().ok()?)
}

fn regressions() -> Vec<u64> {
    let text = fs::read_to_string(REGRESSIONS).unwrap_or_default();
    let numbers = text.lines().filter_map(|line| line.split_whitespace().next());
    numbers.filter_map(|number| number.parse().ok()).collect()
}

#[expect(clippy::disallowed_methods, reason = "fresh seeds are to be new ones")]
fn seeds() -> Vec<u64> {
    if let Some(seed) = variable("CSAT_SEED") {
        return vec![seed];
    }
    if let Some(range) = range() {
        return range.collect();
    }
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let fresh = since_1970.map_or(0, |time| time.as_secs()) << 8;
    let mut seeds = regressions();
    seeds.extend((0..FIXED).chain(fresh..fresh + FRESH));
    seeds
}

/// Adds a seed to the regressions.
fn keep(seed: u64, law: &str) {
    if !Path::new(REGRESSIONS).exists() || regressions().contains(&seed) {
        return;
    }
    if let Ok(mut file) = fs::OpenOptions::new().append(true).open(REGRESSIONS) {
        let _ = writeln!(file, "{seed}  # {}", law.lines().next().unwrap_or_default());
    }
}

#[test]
fn whatever_the_links_do_the_guarantee_holds_and_a_healed_core_agrees() {
    let seeds = seeds();
    let flown: Vec<_> = seeds.par_iter().map(|&seed| (seed, swarm::fly(seed))).collect();
    let mut failures = Vec::new();
    let mut exercise = Exercise::default();
    for (seed, result) in flown {
        match result {
            Ok(more) => exercise = exercise.with(more),
            Err(law) => {
                keep(seed, &law);
                failures.push(format!(
                    "seed {seed}: {law}\n    replay it with CSAT_SEED={seed} cargo test -p \
                     csat-tests --test swarm -- --nocapture"
                ));
            }
        }
    }
    println!("{exercise:#?}");
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), seeds.len(), failures.join("\n"));
    if seeds.len() as u64 >= FIXED {
        let Exercise { corrupted, duplicated, late, crashes, stale, .. } = exercise;
        let Exercise { merged, precise, missed, skewed, evasive, stationed, walled, .. } = exercise;
        let faults = [corrupted, duplicated, late, crashes, stale, missed, skewed];
        let kinds = [merged, precise, evasive, stationed, walled];
        let rare = faults.iter().chain(&kinds).min();
        assert!(rare > Some(&10), "{exercise:?}");
    }
}
