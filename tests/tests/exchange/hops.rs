//! Knowledge is relayed: UAV 0 hears UAV 1, UAV 1 hears UAV 2, and UAV 0 never hears UAV 2.

use csat_agent::agent::Event;
use csat_agent::config::ExchangeMode;
use csat_proto::ids::{AgentId, TargetId};
use csat_tests::flight::Flight;
use csat_tests::missions::small;
use csat_tests::pair::Packet;
use csat_tests::replay::{for_seeds, is_replay};

/// UAV 2 looks in another direction than the two others.
fn script(step: u32, agent: u16) -> f64 {
    f64::from(step / 6) * 0.3 + if agent == 2 { 2.5 } else { 0.2 * f64::from(agent) }
}

fn flight(seed: u64, mode: ExchangeMode) -> Flight {
    let mut scenario = small(seed, 130.0, 3);
    scenario.exchange.mode = mode;
    scenario.agents.start_offset_m = 0.0;
    let mut flight = Flight::scripted(&scenario, script);
    flight.pair.filter =
        Box::new(
            |packet: &Packet| {
                if packet.src.0.abs_diff(packet.dst.0) == 1 { vec![0.0] } else { vec![] }
            },
        );
    flight
}

/// Flies, and returns the targets that only UAV 2 saw.
fn fly(flight: &mut Flight) -> Vec<TargetId> {
    let mut seen = [const { Vec::new() }; 3];
    for _ in 0..50 {
        flight.step();
        flight.check_guarantee();
        flight.check_consistency();
        for (seen, agent) in seen.iter_mut().zip(&flight.pair.agents) {
            seen.extend(agent.measured().iter().flat_map(|m| &m.targets).map(|t| t.target));
        }
    }
    let [a, b, mut c] = seen;
    c.retain(|j| !a.contains(j) && !b.contains(j));
    c.sort();
    c.dedup();
    c
}

#[test]
fn what_only_the_far_one_saw_gets_through() {
    let (mut told, mut more_m2) = (0, Vec::new());
    let name = ["exchange", "what_only_the_far_one_saw_gets_through"];
    for_seeds(name, 0..6, |seed| {
        let mut near = flight(seed, ExchangeMode::Facts);
        let only_far = fly(&mut near);
        let mut far = flight(seed, ExchangeMode::FactsRepair);
        assert_eq!(fly(&mut far), only_far, "both saw the same");
        let [without, with] = [&near, &far].map(|f| f.pair.agent(0).knowledge());
        let heard = |f: &Flight, j| {
            f.pair.events.iter().any(|(id, event)| {
                *id == AgentId(0)
                    && matches!(event, Event::Identified { target, by_others: true, .. } if *target == j)
            })
        };
        for j in only_far {
            assert!(!without.targets.contains_key(&j), "facts go one hop");
            assert!(with.targets.contains_key(&j) && heard(&far, j), "{j:?} was not passed on");
            told += 1;
        }
        let [without, with] = [without, with].map(|k| k.unexplored.region().area_m2());
        more_m2.push(without - with);
        // The map is repaired block by block.
        let known = |f: &Flight| f.pair.agent(0).knowledge().oem.known().count();
        assert!(known(&far) > known(&near), "{} {}", known(&far), known(&near));
    });
    println!("{told} targets passed on, X̄ less by {more_m2:.0?} m²");
    assert!(more_m2.iter().all(|m2| *m2 > 20.0), "{more_m2:?}");
    assert!(is_replay() || told > 2);
}
