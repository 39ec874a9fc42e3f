//! The swarm detects every known mistake.
//!
//! `CSAT_MUTANTS=NoPrediction,MonitorLenient` tries those only.

use std::collections::BTreeSet;

use csat_agent::mutant::{Mutant, switch};
use csat_tests::swarm;
use rayon::prelude::*;

/// Seeds after which a mistake counts as undetected.
const SEEDS: u64 = 1000;
/// Seeds flown at once.
const BATCH: u64 = 8;

/// The first seed that detects the mistake, and its error.
fn noticed() -> Option<(u64, String)> {
    (0..SEEDS).step_by(BATCH as usize).find_map(|start| {
        let batch = (start..start + BATCH).into_par_iter();
        let found: Vec<_> =
            batch.filter_map(|seed| Some((seed, swarm::fly(seed).err()?))).collect();
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
        assert_eq!(swarm::fly(seed).err(), None, "seed {seed} notices what is no mistake");
    }
}
