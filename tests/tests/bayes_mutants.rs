//! Every known mistake of the Bayesian search is noticed: by a scripted mission, by the swarm, or because too few
//! targets are where they are believed to be. Likelihoods that are wrong are wrong for judge and swarm as well, so
//! scripted missions compute them another way.

use std::panic::{AssertUnwindSafe, catch_unwind};

use csat_bayes::config::Fusion;
use csat_bayes::mutant::{Mutant, switch};
use csat_tests::bayes::calibration::{Coverage, Setting, fly};
use csat_tests::bayes::{equations, liar, swarm};
use rayon::prelude::*;

/// Seeds after which the swarm has not noticed a mistake: those that its test flies.
const SEEDS: u64 = 40;
/// Seeds flown at once.
const BATCH: u64 = 4;
/// Missions after which a belief counts as calibrated.
const MISSIONS: u64 = 24;

type Check = fn() -> Result<(), String>;

/// The scripted missions, by name: those that take no time.
const QUICK: [(&str, Check); 4] = [
    ("sightings", || equations::check_sightings().map(drop)),
    ("walk", equations::check_walk),
    ("late", equations::check_late),
    ("liar", liar::check),
];

/// The others.
const SLOW: [(&str, Check); 2] = [
    ("equations", || equations::check_posterior().map(drop)),
    ("P(D)", equations::check_detection),
];

/// What notices the mistake that is switched on.
fn noticed() -> Option<String> {
    let slow = || scripted(&SLOW);
    scripted(&QUICK).or_else(swarm_notices).or_else(slow).or_else(too_sure)
}

fn scripted(checks: &[(&str, Check)]) -> Option<String> {
    checks.iter().find_map(|(name, check)| {
        let result = catch_unwind(AssertUnwindSafe(check));
        let error = result.unwrap_or_else(|_| Err("panicked".into())).err()?;
        Some(format!("{name}: {error}"))
    })
}

fn swarm_notices() -> Option<String> {
    (0..SEEDS).step_by(BATCH as usize).find_map(|start| {
        let batch = (start..start + BATCH).into_par_iter();
        let found: Vec<_> =
            batch.filter_map(|seed| Some((seed, swarm::fly(seed).err()?))).collect();
        found.into_iter().next().map(|(seed, law)| format!("swarm, seed {seed}: {law}"))
    })
}

fn too_sure() -> Option<String> {
    let setting = Setting { looks_s: vec![40.0], ..Setting::of_beliefs(Fusion::Chernoff) };
    let coverage = Coverage::of(&fly(&setting, 0..MISSIONS)[0]);
    coverage.is_too_low().then(|| format!("calibration: {coverage:?}"))
}

#[test]
fn every_known_mistake_is_noticed() {
    assert_eq!(scripted(&QUICK).or_else(|| scripted(&SLOW)), None, "this is no mistake");
    assert_eq!(too_sure(), None, "this is no mistake");
    // Panics of mutated agents are expected and caught.
    std::panic::set_hook(Box::new(|_| {}));
    let mut alive = Vec::new();
    for mutant in Mutant::ALL {
        switch(Some(mutant));
        match noticed() {
            Some(law) => println!("{mutant:?}: {law}"),
            None => alive.push(mutant),
        }
    }
    switch(None);
    let _ = std::panic::take_hook();
    assert!(alive.is_empty(), "not noticed: {alive:?}");
}
