//! Fleets in which a UAV lies: the honest agents' sets hold, and the liar is found out (docs/liars.md).

use csat_agent::config::ExchangeMode;
use csat_experiments::scenario::Scenario;
use csat_proto::ids::AgentId;
use csat_tests::missions::{Outcome, fly, small, with_mode};
use csat_world::lie::{Liar, LieKind};
use rayon::prelude::*;

const KINDS: [LieKind; 3] = [LieKind::Clear, LieKind::Phantom, LieKind::Misidentify];
/// Who lies, and from when on, seconds.
const LIAR: AgentId = AgentId(2);
const FROM_S: f64 = 10.0;
/// Steps of half a second.
const STEPS: u32 = 160;

/// Four UAVs that allow for `q` liars, of which one lies as `kind` says, if at all.
fn fleet(seed: u64, q: u16, kind: Option<LieKind>) -> Scenario {
    let mut scenario = small(seed, 140.0, 4);
    scenario.exchange.liars = q;
    let liar = |kind| Liar { agent: LIAR.0, from_s: FROM_S, kind };
    scenario.faults.liar = kind.map(liar).into_iter().collect();
    scenario
}

/// Whether an honest agent named the liar.
fn is_named(outcome: &Outcome) -> bool {
    outcome.named.iter().any(|named| named.liar == LIAR)
}

#[test]
fn with_one_liar_of_four_the_sets_of_the_others_hold_and_it_is_named() {
    let all: Vec<(LieKind, u64)> =
        KINDS.into_iter().flat_map(|kind| (0..4).map(move |seed| (kind, seed))).collect();
    let named: Vec<bool> = all
        .par_iter()
        .map(|&(kind, seed)| {
            let outcome = fly(&fleet(seed, 1, Some(kind)), STEPS);
            outcome.check(&format!("{kind:?}, seed {seed}"));
            is_named(&outcome)
        })
        .collect();
    let count = named.iter().filter(|is_named| **is_named).count();
    assert!(count >= 10, "{count} of {}: {named:?}", named.len());
}

#[test]
fn who_believes_a_liar_loses_targets() {
    for kind in KINDS {
        let violations = |seed| fly(&fleet(seed, 0, Some(kind)), STEPS).violations.len();
        let count: usize = (0..4u64).into_par_iter().map(violations).sum();
        assert!(count > 0, "{kind:?}");
    }
}

#[test]
fn the_sets_hold_in_every_mode_of_exchange() {
    use ExchangeMode::{Facts, None, Snapshot};
    [Facts, Snapshot, None].into_par_iter().zip(20..23u32).for_each(|(mode, seed)| {
        for kind in KINDS {
            let scenario = with_mode(fleet(seed.into(), 1, Some(kind)), mode);
            fly(&scenario, 100).check(&format!("{kind:?}, {mode:?}"));
        }
    });
}

#[test]
fn without_a_liar_nobody_is_named_and_sets_are_less_precise() {
    let flown = |q| fly(&fleet(3, q, None), STEPS);
    let outcomes = [0, 1, 2].map(flown);
    for (q, outcome) in outcomes.iter().enumerate() {
        outcome.check(&format!("q = {q}"));
        assert_eq!(outcome.named, [], "q = {q}");
    }
    let [none, one, two] = outcomes.map(|outcome| outcome.mean_unexplored_pct);
    assert!(none < one && one <= two, "{none} {one} {two}");
}

#[test]
fn mistaken_cameras_break_the_guarantee_of_others_and_are_counted() {
    let mut scenario = fleet(5, 0, None);
    scenario.camera.misidentify = 0.05;
    assert!(
        !fly(&scenario, 40).violations.is_empty() || !fly(&scenario, 100).violations.is_empty()
    );
}

/// Missions of each kind of the table in docs/liars.md: `CSAT_LIARS`, or 50.
fn table_seeds() -> std::ops::Range<u64> {
    let count = std::env::var("CSAT_LIARS").ok().and_then(|n| n.parse().ok());
    100..100 + count.unwrap_or(50)
}

/// `cargo test -p csat-tests --test liars -- --ignored --nocapture` prints the table of docs/liars.md: a row for each
/// kind, and the price of q.
fn all(q: u16, kind: Option<LieKind>) -> Vec<Outcome> {
    table_seeds().into_par_iter().map(|seed| fly(&fleet(seed, q, kind), STEPS)).collect()
}

fn fifty_missions(kind: LieKind) {
    let outcomes = all(1, Some(kind));
    let first_s = |outcome: &Outcome| {
        outcome.named.iter().map(|named| named.time_s - FROM_S).reduce(f64::min)
    };
    let mut times: Vec<f64> = outcomes.iter().filter_map(first_s).collect();
    times.sort_by(f64::total_cmp);
    let violations: usize = outcomes.iter().map(|outcome| outcome.violations.len()).sum();
    println!(
        "{kind:?}: {} missions, {violations} violations, named in {}, by all in {}, after {:.1} s (median); with \
         q = 0 violations in {}",
        outcomes.len(),
        times.len(),
        outcomes.iter().filter(|outcome| outcome.named.len() == 3).count(),
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN),
        all(0, Some(kind)).iter().filter(|outcome| !outcome.violations.is_empty()).count(),
    );
    assert_eq!(violations, 0);
}

#[test]
#[ignore = "takes minutes: 50 missions"]
fn fifty_missions_of_clear() {
    fifty_missions(LieKind::Clear);
}

#[test]
#[ignore = "takes minutes: 50 missions"]
fn fifty_missions_of_phantom() {
    fifty_missions(LieKind::Phantom);
}

#[test]
#[ignore = "takes minutes: 50 missions"]
fn fifty_missions_of_misidentify() {
    fifty_missions(LieKind::Misidentify);
}

#[test]
#[ignore = "takes minutes: 50 missions for each q"]
fn the_price_of_q() {
    for q in 0..3 {
        let outcomes = all(q, None);
        let count = outcomes.len() as f64;
        let mean = |value: fn(&Outcome) -> f64| outcomes.iter().map(value).sum::<f64>() / count;
        println!(
            "q = {q}: unexplored {:.1} % on the mean, {:.1} % at the end",
            mean(|outcome| outcome.mean_unexplored_pct),
            mean(|outcome| outcome.unexplored_pct)
        );
    }
}
