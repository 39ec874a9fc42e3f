//! Agents keep their budget of bytes; only their sets are less precise.

use std::collections::BTreeMap;

use csat_agent::config::ExchangeMode;
use csat_proto::agent::Agent;
use csat_proto::ids::AgentId;
use csat_proto::message::Message;
use csat_proto::time::SimTime;
use csat_tests::flight::Flight;
use csat_tests::hears::Hears;
use csat_tests::missions::small;
use csat_tests::pair::Packet;

use super::packets::{body, script};

const STEPS: u32 = 60;

struct Flown {
    /// Per agent: time in seconds and bytes of each message except plans.
    said: BTreeMap<AgentId, Vec<(f64, f64)>>,
    unexplored_m2: f64,
    identified: usize,
    facts: usize,
    snapshots: usize,
}

fn fly(mode: ExchangeMode, budget_bytes_s: f64) -> Flown {
    let mut scenario = small(5, 140.0, 3);
    scenario.exchange.mode = mode;
    scenario.exchange.budget_bytes_s = budget_bytes_s;
    scenario.agents.start_offset_m = 0.0;
    let mut flight = Flight::scripted(&scenario, script);
    flight.pair.keep_packets();
    let mut unexplored_m2 = 0.0;
    for _ in 0..STEPS {
        flight.step();
        flight.check_guarantee();
        flight.check_consistency();
        let knowledge = flight.pair.agents.iter().map(|agent| agent.knowledge());
        unexplored_m2 += knowledge.map(|k| k.unexplored.region().area_m2()).sum::<f64>();
    }
    let known = flight.pair.agents.iter().map(|agent| agent.knowledge().targets.len());
    let packets = &flight.pair.packets;
    let snapshots = packets.iter().filter(|l| matches!(body(l), Message::Snapshot(_))).count();
    let facts = packets.iter().filter(|l| matches!(body(l), Message::Fact(_))).count();
    Flown {
        said: said(packets),
        facts: facts / 2,
        snapshots: snapshots / 2,
        unexplored_m2: unexplored_m2 / f64::from(3 * STEPS),
        identified: known.sum(),
    }
}

fn said(packets: &[Packet]) -> BTreeMap<AgentId, Vec<(f64, f64)>> {
    let mut said: BTreeMap<_, Vec<_>> = BTreeMap::new();
    // The packets to all other agents are one message.
    let first = |packet: &&Packet| packet.dst == AgentId(if packet.src.0 == 0 { 1 } else { 0 });
    for packet in packets.iter().filter(first) {
        if !matches!(body(packet), Message::Plan(_)) {
            let entry = (packet.sent.seconds(), packet.bytes.len() as f64);
            said.entry(packet.src).or_default().push(entry);
        }
    }
    said
}

/// In no window of time more than the budget and the credit of a snapshot period.
fn check_budget(said: &[(f64, f64)], budget_bytes_s: f64, burst_s: f64, period_s: f64) {
    for (i, (from, _)) in said.iter().enumerate() {
        let mut bytes = 0.0;
        for (until, more) in &said[i..] {
            bytes += more;
            let allowed = budget_bytes_s * (until - from + burst_s);
            assert!(bytes <= allowed, "{bytes} bytes from {from} s to {until} s");
            // There is no credit before the start.
            let since_start = budget_bytes_s * (until + period_s);
            assert!(bytes <= since_start, "{bytes} bytes until {until} s");
        }
    }
}

#[test]
fn a_budget_is_kept_and_costs_only_looseness() {
    for mode in [ExchangeMode::FactsRepair, ExchangeMode::Facts, ExchangeMode::Snapshot] {
        let free = fly(mode, f64::INFINITY);
        let alone = fly(ExchangeMode::None, f64::INFINITY);
        let mut last_m2 = free.unexplored_m2;
        println!("{mode:?}: X̄ {:.0} m² of alone {:.0} m²", free.unexplored_m2, alone.unexplored_m2);
        for budget_bytes_s in [3000.0, 1000.0, 300.0] {
            let tight = fly(mode, budget_bytes_s);
            let mut bytes = 0.0;
            for said in tight.said.values() {
                check_budget(said, budget_bytes_s, 10.0, 0.5);
                bytes += said.iter().map(|(_, bytes)| bytes).sum::<f64>();
            }
            println!(
                "  {budget_bytes_s} B/s: X̄ {:.0} m², {} targets known, {:.0} B/s used, {} snapshots, {} \
                 facts",
                tight.unexplored_m2,
                tight.identified,
                bytes / 3.0 / f64::from(STEPS) / 0.5,
                tight.snapshots,
                tight.facts,
            );
            if mode == ExchangeMode::FactsRepair {
                // Facts that are worth little are not said; snapshots do not take the place of the others.
                assert!(tight.facts > 2 * tight.snapshots, "{} facts", tight.facts);
            }
            // Simplifications of borders differ: with less budget a little more may be known by chance.
            assert!(tight.unexplored_m2 > 0.999 * last_m2, "{mode:?}: less said, more known");
            last_m2 = tight.unexplored_m2;
        }
        assert!(last_m2 > 1.02 * free.unexplored_m2, "{mode:?}: 300 B/s cost nothing");
        assert!(last_m2 < alone.unexplored_m2, "{mode:?}: 300 B/s told nothing");
    }
}

/// Messages with more vertices than receivers accept are simplified, answers as well.
#[test]
fn no_more_vertices_are_said_than_are_accepted() {
    let mut scenario = small(5, 140.0, 2);
    scenario.exchange.max_vertices = 120;
    scenario.exchange.snapshot_period_s = 2.0;
    scenario.agents.start_offset_m = 0.0;
    let mut flight = Flight::scripted(&scenario, script);
    for _ in 0..30 {
        flight.step();
        flight.check_guarantee();
        let now = flight.pair.time;
        let [first, second] = &mut flight.pair.agents[..] else { unreachable!("a fleet of two") };
        second.hear(now, &first.answer(now).expect("it knows something").bytes);
        let vertices = first.knowledge().unexplored.region().vertex_count();
        assert!(first.rejected().is_empty(), "{:?} of {vertices}", first.rejected());
        assert!(second.rejected().is_empty(), "{:?} of {vertices}", second.rejected());
    }
    let unexplored = flight.pair.agent(0).knowledge().unexplored.region().vertex_count();
    assert!(unexplored > 120, "{unexplored} vertices would have been accepted");
}

/// Plans are sent even without credit: they come first.
#[test]
fn plans_are_said_without_a_budget() {
    let mut scenario = small(5, 140.0, 2);
    scenario.exchange.budget_bytes_s = 1.0;
    let mut flight = Flight::new(&scenario);
    flight.pair.keep_packets();
    for _ in 0..14 {
        flight.step();
        flight.check_guarantee();
    }
    assert!(said(&flight.pair.packets).is_empty(), "no fact fits into a byte per second");
    let plans = flight.pair.packets.iter().filter(|l| matches!(body(l), Message::Plan(_))).count();
    assert_eq!(plans, 2 * 2 * 3, "two passes of two UAVs at steps 0, 6 and 12");
    assert!(flight.pair.time > SimTime(0));
}
