//! The swarm detects every known mistake.
//!
//! `CSAT_MUTANTS=NoPrediction,MonitorLenient` tries those only.

use std::collections::BTreeSet;
use std::ops::Range;

use csat_agent::mutant::{Mutant, switch};
use csat_tests::swarm;
use rayon::prelude::*;

/// Seeds after which a mistake counts as undetected.
const SEEDS: u64 = 400;
/// Seeds of all kinds of missions that are tried first: boxes of poses and liars make other mistakes rarer.
const FIRST: u64 = 128;
/// Seeds flown at once.
const BATCH: u64 = 8;

/// How a seed is flown.
type Fly = fn(u64) -> Result<swarm::Exercise, String>;

/// The first seed that detects the mistake, and its error.
fn noticed() -> Option<(u64, String)> {
    noticed_by(swarm::fly, 0..FIRST)
        .or_else(|| noticed_by(swarm::fly_plain, 0..SEEDS))
        .or_else(|| noticed_by(swarm::fly, FIRST..SEEDS))
}

fn noticed_by(fly: Fly, seeds: Range<u64>) -> Option<(u64, String)> {
    let end = seeds.end;
    seeds.step_by(BATCH as usize).find_map(|start| {
        let batch = (start..end.min(start + BATCH)).into_par_iter();
        let found: Vec<_> = batch.filter_map(|seed| Some((seed, fly(seed).err()?))).collect();
        found.into_iter().next()
    })
}

#[test]
fn every_known_mistake_is_noticed() {
    // Panics of mutated agents are expected and caught.
    std::panic::set_hook(Box::new(|_| {}));
    let (mut alive, mut noticing) = (Vec::new(), BTreeSet::from([0]));
    let only = std::env::var("CSAT_MUTANTS").ok();
    let is_tried = |mutant: &Mutant| {
        only.as_ref().is_none_or(|names| names.split(',').any(|name| name == format!("{mutant:?}")))
    };
    for mutant in Mutant::ALL.into_iter().filter(is_tried) {
        switch(Some(mutant));
        match noticed() {
            Some((seed, law)) => {
                println!("{mutant:?}: seed {seed}, {law}");
                noticing.insert(seed);
            }
            None => alive.push(mutant),
        }
    }
    switch(None);
    let _ = std::panic::take_hook();
    assert!(alive.is_empty(), "not noticed within {SEEDS} seeds: {alive:?}");
    for seed in noticing {
        for fly in [swarm::fly, swarm::fly_plain] {
            assert_eq!(fly(seed).err(), None, "seed {seed} notices what is no mistake");
        }
    }
}
