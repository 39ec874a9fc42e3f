//! Packets that are lost, late, repeated or reordered; agents that are deaf or restarted.

use csat_agent::config::ExchangeMode;
use csat_proto::agent::Agent;
use csat_proto::ids::AgentId;
use csat_proto::message::Message;
use csat_tests::hears::Hears;
use csat_tests::pair::{Packet, silence};

use super::packets::{digest, flight, unread_fact};

#[test]
fn a_fact_tells_what_its_loss_does_not() {
    let (flight, packet) = unread_fact(3);
    let lost = flight.pair.agent(0).clone();
    let mut told = lost.clone();
    told.hear(flight.pair.time, &packet.bytes);
    told.handle_timeout(flight.pair.time);
    let area = |agent: &csat_agent::agent::SetMembershipAgent| {
        agent.knowledge().unexplored.region().area_m2()
    };
    assert!(area(&told) < area(&lost) - 1.0, "{} {}", area(&told), area(&lost));
    assert_ne!(digest(&told), digest(&lost));
    flight.check_guarantee();
}

#[test]
fn a_repeated_message_changes_nothing() {
    let (flight, packet) = unread_fact(3);
    let now = flight.pair.time;
    let read = |chunks: &[usize]| {
        let mut agent = flight.pair.agent(0).clone();
        for &copies in chunks {
            (0..copies).for_each(|_| agent.hear(now, &packet.bytes));
            agent.handle_timeout(now);
        }
        agent
    };
    let (unread, once) = (read(&[]), read(&[1]));
    assert_ne!(digest(&unread), digest(&once), "once it says something");
    for repeated in [read(&[2]), read(&[1, 1]), read(&[1, 3, 1])] {
        assert_eq!(digest(&repeated), digest(&once));
    }
}

#[test]
fn every_way_to_lose_a_letter_keeps_the_guarantee() {
    type Way = (&'static str, fn(&Packet) -> Vec<f64>);
    let ways: [Way; 5] = [
        ("every third lost", |l| if l.sequence % 3 == 0 { vec![] } else { vec![0.0] }),
        ("all late", |_| vec![3.3]),
        ("all repeated later", |_| vec![0.0, 1.2, 4.0]),
        ("reordered", |l| vec![f64::from((l.sequence * 7 % 5) as u8) * 0.9]),
        ("one way", |l| if l.src < l.dst { vec![0.0] } else { vec![] }),
    ];
    for (what, way) in ways {
        for mode in [ExchangeMode::Facts, ExchangeMode::Snapshot, ExchangeMode::FactsRepair] {
            let mut flight = flight(5, 3, mode);
            flight.pair.filter = Box::new(way);
            for _ in 0..30 {
                flight.step();
                flight.check_guarantee();
                flight.check_consistency();
            }
            let rejected: Vec<_> =
                flight.pair.agents.iter().flat_map(|agent| agent.rejected()).collect();
            // Late plans are for decisions that are over; they are not invalid.
            assert!(rejected.is_empty(), "{what}, {mode:?}: {rejected:?}");
        }
    }
}

/// A snapshot with an unlimited period is never sent, in particular not at every step.
#[test]
fn times_beyond_all_steps_are_endless() {
    let mut scenario = csat_tests::missions::small(5, 120.0, 2);
    scenario.exchange.max_age_s = 1e30;
    scenario.exchange.snapshot_period_s = 1e30;
    let mut flight = csat_tests::flight::Flight::new(&scenario);
    flight.pair.keep_packets();
    for _ in 0..10 {
        flight.step();
        let digests = flight.pair.digests();
        assert_eq!(digests[0], digests[1], "what is said is believed");
    }
    let is_snapshot = |l: &&Packet| matches!(super::packets::body(l), Message::Snapshot(_));
    assert_eq!(flight.pair.packets.iter().filter(is_snapshot).count(), 2, "each agent's first");
    assert!(flight.pair.agents.iter().all(|agent| agent.rejected().is_empty()));
}

/// A deaf agent has the same knowledge as an agent alone: only its own frames matter.
#[test]
fn whoever_hears_nobody_knows_what_its_own_frames_say() {
    let mut deaf = flight(7, 3, ExchangeMode::FactsRepair);
    deaf.pair.filter = Box::new(|packet| if packet.dst == AgentId(2) { vec![] } else { vec![0.0] });
    let mut alone = flight(7, 3, ExchangeMode::None);
    alone.pair.filter = silence();
    for _ in 0..40 {
        deaf.step();
        alone.step();
        assert_eq!(deaf.pair.digests()[2], alone.pair.digests()[2]);
        deaf.check_guarantee();
    }
    assert_ne!(deaf.pair.digests()[0], alone.pair.digests()[0], "the others do hear");
}

#[test]
fn a_restarted_agent_catches_up_and_its_old_life_is_not_believed() {
    let mut flight = flight(9, 2, ExchangeMode::FactsRepair);
    flight.pair.keep_packets();
    for _ in 0..20 {
        flight.step();
    }
    let old = flight.pair.packets.iter().rev().find(|l| l.src == AgentId(1)).cloned();
    let before = flight.pair.agent(0).knowledge().targets.len();
    flight.pair.restart(1);
    for _ in 0..30 {
        flight.step();
        flight.check_guarantee();
        flight.check_consistency();
    }
    let [own, theirs] = [0, 1].map(|i| flight.pair.agent(i).knowledge());
    assert!(own.targets.len() >= before, "nothing is forgotten");
    assert!(theirs.targets.keys().eq(own.targets.keys()), "the new life was told everything");
    let now = flight.pair.time;
    let agent = &mut flight.pair.agents[0];
    let known = digest(agent);
    agent.hear(now, &old.expect("UAV 1 said something").bytes);
    assert_eq!(agent.rejected().get("incarnation"), Some(&1));
    agent.handle_timeout(now);
    assert_eq!(digest(agent), known);
}
