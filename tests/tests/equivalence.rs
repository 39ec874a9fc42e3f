//! With perfect links the mode of exchange does not matter: facts, snapshots and facts with repairs
//! give the same knowledge, and all agents have it, to the last bit.

use csat_agent::config::ExchangeMode;
use csat_proto::agent::Agent;
use csat_tests::flight::Flight;
use csat_tests::geometry::difference_m2;
use csat_tests::missions::{small, with_mode};
use csat_tests::replay::{for_seeds, is_replay};

const STEPS: u32 = 60;
const MODES: [ExchangeMode; 3] =
    [ExchangeMode::Snapshot, ExchangeMode::Facts, ExchangeMode::FactsRepair];

/// A script, so that the knowledge does not change the paths.
fn sweep(step: u32, agent: u16) -> f64 {
    f64::from(step / 6) * 0.35 + f64::from(agent) * 0.8 - 1.0
}

fn fleet(seed: u64, mode: ExchangeMode) -> Flight {
    Flight::scripted(&with_mode(small(seed, 120.0, 3), mode), sweep)
}

/// For every limit of vertices: all agents simplify the same sets at the same time.
#[test]
fn limited_to_few_vertices_they_give_the_same_bits_to_all_too() {
    for seed in 0..3 {
        let limited = |mode, vertices| {
            let mut scenario = with_mode(small(seed, 120.0, 3), mode);
            scenario.estimator.max_vertices = vertices;
            Flight::scripted(&scenario, sweep)
        };
        let mut flights = MODES.map(|mode| limited(mode, 80));
        let mut free = limited(ExchangeMode::Facts, 8000);
        for step in 0..=STEPS / 2 {
            free.step();
            for flight in &mut flights {
                flight.step();
                flight.check_guarantee();
            }
            let fleets = flights.each_ref().map(|flight| flight.pair.digests());
            let same = fleets.iter().flatten().all(|digest| *digest == fleets[0][0]);
            assert!(same, "seed {seed} step {step}: {fleets:?}");
        }
        flights.iter().for_each(Flight::check_consistency);
        let vertices =
            |flight: &Flight| flight.pair.agent(0).knowledge().unexplored.region().vertex_count();
        assert!(vertices(&free) > 80 && vertices(&flights[0]) < vertices(&free), "seed {seed}");
        assert!(unexplored_share(&flights[0], 0) > unexplored_share(&free, 0), "seed {seed}");
    }
}

fn unexplored_share(flight: &Flight, agent: usize) -> f64 {
    let knowledge = flight.pair.agent(agent).knowledge();
    knowledge.unexplored.region().area_m2() / knowledge.ground().area_m2()
}

#[test]
fn facts_snapshots_and_both_give_the_same_bits_to_all() {
    let (mut identified, mut unexplored) = (0, 1.0f64);
    let name = ["equivalence", "facts_snapshots_and_both_give_the_same_bits_to_all"];
    for_seeds(name, 0..6, |seed| {
        let mut flights = MODES.map(|mode| fleet(seed, mode));
        for step in 0..=STEPS {
            for (flight, mode) in flights.iter_mut().zip(MODES) {
                flight.step();
                flight.check_guarantee();
                let digests = flight.pair.digests();
                assert!(digests.iter().all(|d| *d == digests[0]), "step {step}, within {mode:?}");
            }
            let fleets = flights.each_ref().map(|flight| flight.pair.digests());
            assert!(fleets.iter().all(|fleet| *fleet == fleets[0]), "step {step}, between modes");
        }
        flights.iter().for_each(Flight::check_consistency);
        identified += flights[0].pair.agent(0).knowledge().targets.len();
        unexplored = unexplored.min(unexplored_share(&flights[0], 0));
    });
    println!("{identified} targets known, X̄ down to {:.0} % of the region", 100.0 * unexplored);
    assert!(is_replay() || (identified > 6 && unexplored < 0.7));
}

/// The exchange matters: without it UAVs know clearly less, and not the same.
#[test]
fn alone_they_know_less() {
    let mut alone = fleet(0, ExchangeMode::None);
    let mut together = fleet(0, ExchangeMode::Facts);
    for _ in 0..=STEPS {
        alone.step();
        together.step();
    }
    for i in 0..3 {
        let [a, b] = [&alone, &together].map(|flight| flight.pair.agent(i).knowledge());
        let ground_m2 = a.ground().area_m2();
        let apart_m2 = difference_m2(a.unexplored.region(), b.unexplored.region());
        println!("UAV {i}: {:.1} % of the region apart", 100.0 * apart_m2 / ground_m2);
        assert!(apart_m2 > 0.03 * ground_m2, "UAV {i}: {apart_m2} m²");
        assert!(unexplored_share(&alone, i) > unexplored_share(&together, i) + 0.03, "UAV {i}");
    }
    let digests = alone.pair.agents.iter().map(Agent::digest);
    let different: std::collections::BTreeSet<u64> = digests.collect();
    assert_eq!(different.len(), 3);
}
