//! Anti-entropy: digests show which agent is missing facts, and another agent resends them.

use csat_agent::config::ExchangeMode;
use csat_agent::estimate::state::Knowledge;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Digest, Message};
use csat_proto::time::Step;
use csat_tests::flight::Flight;
use csat_tests::missions::small;
use csat_tests::pair::{Packet, perfect, silence};

use super::packets::{body, script};

/// Steps without links.
const LOST: std::ops::Range<u32> = 6..26;

/// A flight whose regular snapshots are so rare that only repairs resend facts.
fn flight(uavs: u16, mode: ExchangeMode) -> Flight {
    let mut scenario = small(7, 120.0, uavs);
    scenario.exchange.mode = mode;
    scenario.exchange.snapshot_period_s = 1000.0;
    scenario.agents.start_offset_m = 0.0;
    let mut flight = Flight::scripted(&scenario, script);
    flight.pair.keep_packets();
    flight
}

fn step_with(flight: &mut Flight, lossy: fn() -> csat_tests::pair::Filter) {
    let step = flight.pair.step.0 + 1;
    flight.pair.filter = if LOST.contains(&step) { lossy() } else { perfect() };
    flight.step();
    flight.check_guarantee();
    flight.check_consistency();
}

/// The senders and steps of the snapshots, from LOST on.
fn repairs(packets: &[Packet]) -> Vec<(AgentId, Step)> {
    let mut said: Vec<_> = packets
        .iter()
        .filter_map(|packet| match body(packet) {
            Message::Snapshot(snapshot) => Some((packet.src, snapshot.fact.step)),
            _ => None,
        })
        .filter(|(_, step)| step.0 >= LOST.start)
        .collect();
    said.sort();
    said.dedup();
    said
}

/// How many facts of `origin` the digest of `src` claims to hold, and that digest.
fn held(packets: &[Packet], src: u16, step: u32, origin: u16) -> (u32, Digest) {
    let of_step = packets.iter().filter(|l| l.src == AgentId(src)).find_map(|l| match body(l) {
        Message::Fact(fact) if fact.step.0 == step => Some(fact.held),
        Message::Snapshot(snapshot) if snapshot.fact.step.0 == step => Some(snapshot.fact.held),
        _ => None,
    });
    let held = of_step.expect("every agent sends a message at each step");
    let key = (AgentId(origin), Incarnation(0));
    let count = held.facts.iter().find(|f| (f.origin, f.incarnation) == key).map_or(0, |f| f.count);
    (count, held)
}

/// The step by which a repair must have arrived.
fn deadline(flight: &Flight) -> u32 {
    let config = flight.pair.agent(0).config();
    let steps = |seconds: f64| (seconds / config.period_s).ceil() as u32;
    let turns = 2 * u32::from(config.fleet.count);
    steps(config.exchange.repair_delay_s) + steps(config.exchange.repair_period_s) + turns
}

/// X̄ of both UAVs without any repair, m².
fn flown_without_repair(last: u32) -> [f64; 2] {
    let mut flight = flight(2, ExchangeMode::Facts);
    while flight.pair.step.0 < last {
        step_with(&mut flight, silence);
    }
    [0, 1].map(|i| flight.pair.agent(i).knowledge().unexplored.region().area_m2())
}

#[test]
fn what_was_lost_both_ways_is_repaired_long_before_the_next_snapshot() {
    let mut flight = flight(2, ExchangeMode::FactsRepair);
    while flight.pair.step.0 < LOST.end - 1 {
        step_with(&mut flight, silence);
    }
    let knowledge = |flight: &Flight, i: usize| Knowledge::clone(flight.pair.agent(i).knowledge());
    let [before, other] = [0, 1].map(|i| knowledge(&flight, i));
    assert!(before.oem != other.oem && before.digest() != other.digest(), "nothing was lost");
    assert!(repairs(&flight.pair.packets).is_empty(), "no agent can know yet");
    let deadline = deadline(&flight);
    for _ in 0..deadline {
        step_with(&mut flight, silence);
    }
    let packets = std::mem::take(&mut flight.pair.packets);
    let said = repairs(&packets);
    println!("repairs of {LOST:?}: {said:?}, deadline {} steps", deadline);
    // Each UAV is missing what the other saw, and each gets one snapshot: no more is sent than needed.
    assert_eq!(said.len(), 2, "{said:?}");
    assert_ne!(said[0].0, said[1].0);
    for (helper, at) in said {
        assert!((LOST.end..LOST.end + deadline).contains(&at.0), "{at}");
        let lacking = 1 - helper.0;
        // Its digest showed the missing facts, and then that it holds them.
        let (count, shown) = held(&packets, lacking, at.0 - 1, helper.0);
        assert!(count <= LOST.start, "{count} facts");
        let (_, own) = held(&packets, helper.0, at.0 - 1, helper.0);
        assert_ne!(shown.oem, own.oem, "the maps differ as well");
        let (count, _) = held(&packets, lacking, at.0 + 1, helper.0);
        assert_eq!(count, at.0 + 1, "the snapshot and all before");
    }
    let [after, theirs] = [0, 1].map(|i| knowledge(&flight, i));
    let areas = [&after, &theirs].map(|k| k.unexplored.region().area_m2());
    let unrepaired = flown_without_repair(LOST.end - 1 + deadline);
    println!("X̄ {areas:.0?} m², without repair {unrepaired:.0?} m²");
    assert!((0..2).all(|i| areas[i] < unrepaired[i]), "{areas:?} {unrepaired:?}");
    let sum = |areas: [f64; 2]| areas[0] + areas[1];
    assert!(sum(areas) < 0.95 * sum(unrepaired), "{areas:?} {unrepaired:?}");
    assert!((areas[0] - areas[1]).abs() < 0.02 * areas[0], "both know the same: {areas:?}");
    assert!(after.targets.keys().eq(theirs.targets.keys()));
}

/// Blocks of the map that differ are resent until they are equal.
#[test]
fn maps_that_differ_are_repaired() {
    for (mode, repaired) in [(ExchangeMode::FactsRepair, true), (ExchangeMode::Facts, false)] {
        let mut flight = flight(3, mode);
        while flight.pair.step.0 < LOST.end - 1 {
            step_with(&mut flight, silence);
        }
        let deadline = deadline(&flight);
        let mut equal_at = None;
        for _ in 0..deadline {
            let maps: Vec<_> = flight.pair.agents.iter().map(|a| &a.knowledge().oem).collect();
            let equal = maps.iter().all(|map| *map == maps[0]);
            equal_at = equal_at.or(equal.then_some(flight.pair.step));
            step_with(&mut flight, silence);
        }
        println!("{mode:?}: equal maps at {equal_at:?}");
        assert_eq!(equal_at.is_some(), repaired, "{mode:?}");
        assert!(equal_at.is_none_or(|at| at.0 >= LOST.end), "nothing was lost");
    }
}

/// A receiver of a snapshot that was simplified for a budget does not take over which facts its
/// sender held: lost facts are still missing.
#[test]
fn coarse_snapshots_replace_no_facts() {
    let mut scenario = small(7, 120.0, 2);
    scenario.exchange.budget_bytes_s = 250.0;
    scenario.agents.start_offset_m = 0.0;
    let mut flight = Flight::scripted(&scenario, script);
    flight.pair.keep_packets();
    let mut coarse = 0;
    while flight.pair.step.0 < 80 {
        step_with(&mut flight, silence);
        let sees = |agent: &AgentId| {
            let measured = flight.pair.agent(agent.0.into()).measured();
            measured.is_some_and(|measured| measured.seen.count() > 0)
        };
        let seeing: Vec<AgentId> = [0, 1].map(AgentId).into_iter().filter(sees).collect();
        let packets = std::mem::take(&mut flight.pair.packets);
        for packet in packets.iter().filter(|packet| seeing.contains(&packet.src)) {
            let Message::Snapshot(snapshot) = body(packet) else { continue };
            let is_coarse = snapshot.fact.seen.count() == 0;
            assert_eq!(is_coarse, snapshot.fact.held == Digest::default());
            coarse += u32::from(is_coarse);
        }
    }
    assert!(coarse > 2, "all snapshots were precise enough");
}

/// Facts and digests have the greatest allowed delay: no agent counts as missing facts.
#[test]
fn slow_links_need_no_repair() {
    for delay_s in [1.0, 1.5, 2.0] {
        let mut flight = flight(3, ExchangeMode::FactsRepair);
        assert!(delay_s <= flight.pair.agent(0).config().exchange.repair_delay_s);
        flight.pair.filter = Box::new(move |_| vec![delay_s]);
        for _ in 0..30 {
            flight.step();
            flight.check_guarantee();
        }
        assert_eq!(repairs(&flight.pair.packets), [], "{delay_s} s");
    }
}

/// UAV 2 hears UAV 1 but not UAV 0: a UAV that it hears sends a snapshot, once.
#[test]
fn somebody_else_can_help() {
    let mut flight = flight(3, ExchangeMode::FactsRepair);
    let one_way = || -> csat_tests::pair::Filter {
        let lost = (AgentId(0), AgentId(2));
        Box::new(move |packet| if (packet.src, packet.dst) == lost { vec![] } else { vec![0.0] })
    };
    while flight.pair.step.0 < LOST.end - 1 {
        step_with(&mut flight, one_way);
    }
    let said = repairs(&flight.pair.packets);
    println!("repairs while UAV 2 did not hear UAV 0: {said:?}");
    assert!(said.iter().any(|(who, _)| *who == AgentId(1)), "{said:?}");
    let (count, _) = held(&flight.pair.packets, 2, LOST.end - 1, 0);
    assert!(count > LOST.start + 4, "UAV 2 holds {count} facts of UAV 0 through UAV 1");
}
