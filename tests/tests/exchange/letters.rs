//! A fleet of two whose first message is worth tampering with.

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::ExchangeMode;
use csat_proto::envelope::Envelope;
use csat_proto::ids::AgentId;
use csat_proto::message::Message;
use csat_tests::flight::Flight;
use csat_tests::missions::small;
use csat_tests::pair::Letter;

/// Both UAVs over the same ground, so that one can tell the other something.
pub fn script(step: u32, agent: u16) -> f64 {
    f64::from(step / 6) * 0.5 - 1.0 + 0.8 * f64::from(agent)
}

/// Two UAVs (or more) in a small world.
pub fn flight(seed: u64, uavs: u16, mode: ExchangeMode) -> Flight {
    let mut scenario = small(seed, 120.0, uavs);
    scenario.exchange.mode = mode;
    scenario.agents.start_offset_m = 0.0;
    Flight::scripted(&scenario, script)
}

/// UAV 0 at a step, before it reads what UAV 1 has to say about it: the last fact of UAV 1 that
/// saw clear ground, a target and an obstacle.
pub fn unread_fact(seed: u64) -> (Flight, Letter) {
    let mut flight = flight(seed, 2, ExchangeMode::Facts);
    flight.pair.filter = csat_tests::pair::silence();
    flight.pair.keep_letters();
    for _ in 0..60 {
        flight.step();
        let telling = |letter: &&Letter| {
            let rich = matches!(body(letter), Message::Fact(fact)
                if !fact.clear_ground.is_empty() && !fact.targets.is_empty()
                    && !fact.oem.is_empty());
            letter.dst == AgentId(0) && rich && letter.sent == flight.pair.time
        };
        if let Some(letter) = flight.pair.letters.iter().find(telling).cloned() {
            return (flight, letter);
        }
        flight.pair.letters.clear();
    }
    panic!("seed {seed}: UAV 1 never sees a target");
}

/// What a letter says.
pub fn body(letter: &Letter) -> Message {
    let envelope = Envelope::decode(&letter.bytes).expect("an agent's own letter");
    postcard::from_bytes(&envelope.body).expect("an agent's own body")
}

/// What an agent knows, as a number.
pub fn digest(agent: &SetMembershipAgent) -> u64 {
    csat_proto::agent::Agent::digest(agent)
}
