//! An agent that joins late asks, and then knows as much as the agent that answers.

use csat_agent::config::ExchangeMode;
use csat_proto::agent::Agent;
use csat_proto::ids::AgentId;
use csat_tests::flight::Flight;
use csat_tests::geometry::difference_m2;
use csat_tests::hears::Hears;
use csat_tests::missions::small;
use csat_tests::replay::for_seeds;

/// The allowed difference of sets that grew from equal ones with different simplifications, as a
/// share of the ground.
const SHARE: f64 = 0.001;

/// Two UAVs after 30 steps, the second of which has just been restarted and seen one frame.
fn restarted(seed: u64, mode: ExchangeMode) -> Flight {
    let mut scenario = small(seed, 130.0, 2);
    scenario.exchange.mode = mode;
    let mut flight = Flight::new(&scenario);
    for _ in 0..30 {
        flight.step();
    }
    flight.pair.restart(1);
    flight.step();
    flight
}

/// The difference of the unexplored areas of the second and the first UAV, m².
fn lead_m2(flight: &Flight) -> f64 {
    let area_m2 = |i: usize| flight.pair.agent(i).knowledge().unexplored.region().area_m2();
    area_m2(1) - area_m2(0)
}

#[test]
fn an_answer_tells_all_and_twice_the_same() {
    for_seeds(["exchange", "an_answer_tells_all_and_twice_the_same"], 0..6, |seed| {
        let mut flight = restarted(seed, ExchangeMode::Facts);
        assert!(lead_m2(&flight) > 100.0, "nothing to catch up on: {}", lead_m2(&flight));
        let now = flight.pair.time;
        let answer = flight.pair.agents[0].answer(now).expect("it knows something");
        for _ in 0..2 {
            flight.pair.agents[1].hear(now, &answer.bytes);
        }
        for _ in 0..3 {
            flight.step();
            flight.check_guarantee();
        }
        let [a, b] = [0, 1].map(|i| flight.pair.agent(i).knowledge());
        let apart_m2 = difference_m2(a.unexplored.region(), b.unexplored.region());
        assert!(apart_m2 < SHARE * a.ground().area_m2(), "X̄ is {apart_m2} m² apart");
        assert!(a.targets.keys().eq(b.targets.keys()) && a.oem == b.oem);
        let another = flight.pair.agents[0].answer(flight.pair.time).unwrap();
        assert_eq!(another.sequence, answer.sequence + 1, "answers are numbered");
        assert!(flight.pair.agent(1).rejected().is_empty());
    });
}

#[test]
fn late_answers_are_grown_by_their_age() {
    for_seeds(["exchange", "late_answers_are_grown_by_their_age"], 0..6, |seed| {
        let mut flight = restarted(seed, ExchangeMode::Facts);
        let answer = flight.pair.agents[0].answer(flight.pair.time).unwrap();
        for _ in 0..8 {
            flight.step();
        }
        let before_m2 = lead_m2(&flight);
        flight.pair.agents[1].hear(flight.pair.time, &answer.bytes);
        for _ in 0..4 {
            flight.step();
            flight.check_guarantee();
        }
        assert!(lead_m2(&flight) < before_m2, "{} of {before_m2}", lead_m2(&flight));
    });
}

/// An answer has the number of the fact before it, and other contents.
#[test]
fn an_answer_and_the_snapshot_of_its_number_are_both_heard() {
    let mut flight = restarted(1, ExchangeMode::Snapshot);
    flight.pair.filter = csat_tests::pair::silence();
    flight.pair.keep_packets();
    flight.step();
    let now = flight.pair.time;
    let answer = flight.pair.agents[0].answer(now).unwrap().bytes;
    let said = flight.pair.packets.iter().find(|l| l.src == AgentId(0) && l.sent == now);
    let snapshot = said.expect("it says a snapshot at every step").bytes.clone();
    let hearing = |packets: &[&[u8]]| {
        let mut agent = flight.pair.agents[1].clone();
        packets.iter().for_each(|bytes| agent.hear(now, bytes));
        agent.handle_timeout(now);
        agent.digest()
    };
    let both = hearing(&[&answer, &snapshot]);
    assert_eq!(hearing(&[&snapshot, &answer]), both, "in whatever order");
    assert_ne!(hearing(&[&snapshot]), both);
    assert_ne!(hearing(&[&answer]), both);
}

#[test]
fn there_is_no_answer_before_there_is_knowledge() {
    let mut flight = Flight::new(&small(1, 130.0, 2));
    let now = flight.pair.time;
    assert!(flight.pair.agents[0].answer(now).is_none(), "before the first frame");
    let frames = flight.look();
    flight.pair.look(&frames);
    assert!(flight.pair.agents[0].answer(now).is_none(), "between frame and update");
    flight.pair.drive();
    assert!(flight.pair.agents[0].answer(now).is_some());
    let mut silent = restarted(1, ExchangeMode::None);
    assert!(silent.pair.agents[0].answer(now).is_none(), "in silence");
}
