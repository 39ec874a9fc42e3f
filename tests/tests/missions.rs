//! Whole missions without violations.

use csat_agent::config::{Criterion, ExchangeMode, Schedule};
use csat_experiments::scenario::Scenario;
use csat_netem::config::{DelayConfig, LossConfig};
use csat_tests::missions::{fly, small};
use csat_tests::replay::{for_seeds, is_replay};

/// 36 combinations over 10 seeds: every combination flies two seeds, every seed seven or eight
/// combinations.
#[test]
fn every_way_to_plan_and_to_talk_is_sound() {
    let criteria = [Criterion::Str1, Criterion::Str2NoHidden, Criterion::Str2, Criterion::Str3];
    let schedules = [Schedule::Sequential, Schedule::SequentialLoopback, Schedule::Asynchronous];
    let modes = [ExchangeMode::None, ExchangeMode::Facts, ExchangeMode::Snapshot];
    let (mut identified, mut flown) = (0, 0);
    for_seeds(["missions", "every_way_to_plan_and_to_talk_is_sound"], 0..10, |seed| {
        for combination in (0..36).filter(|c| is_replay() || c % 5 == seed % 5) {
            let mut scenario = small(seed, 140.0, 3);
            scenario.guidance.criterion = criteria[combination as usize % 4];
            scenario.guidance.schedule = schedules[combination as usize / 4 % 3];
            scenario.exchange.mode = modes[combination as usize / 12];
            let Scenario { guidance, exchange, .. } = &scenario;
            let what = format!(
                "seed {seed}, {:?}, {:?}, {:?}",
                guidance.criterion, guidance.schedule, exchange.mode
            );
            let outcome = fly(&scenario, 60);
            outcome.check(&what);
            identified += outcome.identified;
            flown += 1;
        }
    });
    println!("{flown} missions, {identified} targets identified");
    assert!(is_replay() || (flown == 72 && identified > 72), "{identified}");
}

/// `str4`, `str5` and the baselines, with perfect links and with bad ones.
#[test]
fn what_is_not_in_the_thesis_is_sound_too() {
    let criteria = [Criterion::Str4, Criterion::Str5, Criterion::Circles, Criterion::Lawnmower];
    for_seeds(["missions", "what_is_not_in_the_thesis_is_sound_too"], 200..208, |seed| {
        let mut scenario = small(seed, 140.0, 3);
        scenario.guidance.criterion = criteria[seed as usize % criteria.len()];
        scenario.guidance.str4.beam = 8;
        for scenario in [lossy(&scenario), scenario] {
            let what = format!("seed {seed}, {:?}", scenario.guidance.criterion);
            let (outcome, again) = (fly(&scenario, 60), fly(&scenario, 60));
            outcome.check(&what);
            assert_eq!(outcome.digest, again.digest, "{what}");
        }
    });
}

fn lossy(scenario: &Scenario) -> Scenario {
    let mut lossy = scenario.clone();
    lossy.netem.radio.range_m = 80.0;
    lossy.netem.radio.loss = LossConfig::Iid { p: 0.4 };
    lossy.netem.radio.delay = DelayConfig::Constant { mean_s: 1.2 };
    lossy
}

#[test]
fn bad_links_cost_knowledge_and_nothing_else() {
    let (mut perfect_pct, mut lossy_pct, mut dropped) = (0.0, 0.0, 0);
    for_seeds(["missions", "bad_links_cost_knowledge_and_nothing_else"], 100..120, |seed| {
        let mut scenario = small(seed, 160.0, 3);
        scenario.exchange.mode =
            [ExchangeMode::Facts, ExchangeMode::FactsRepair][seed as usize % 2];
        for (scenario, pct) in [(lossy(&scenario), &mut lossy_pct), (scenario, &mut perfect_pct)] {
            // `fly` checks after every mission that messages were conserved, the monitor at every
            // step.
            let outcome = fly(&scenario, 60);
            outcome.check(&format!("seed {seed}"));
            *pct += outcome.mean_unexplored_pct / 20.0;
            dropped += outcome.dropped;
        }
    });
    println!("unexplored {perfect_pct:.2} % with perfect links, {lossy_pct:.2} % with bad ones");
    if !is_replay() {
        assert!(lossy_pct > perfect_pct + 1.0, "{lossy_pct} {perfect_pct}");
        assert!(dropped > 2000, "{dropped}");
    }
}
