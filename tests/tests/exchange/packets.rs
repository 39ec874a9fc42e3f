//! A fleet of two whose first packet has all parts that tests change.

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::ExchangeMode;
use csat_proto::envelope::Envelope;
use csat_proto::ids::AgentId;
use csat_proto::message::Message;
use csat_tests::flight::Flight;
use csat_tests::missions::small;
use csat_tests::pair::Packet;

/// Both UAVs fly over the same ground, so that facts of one are useful to the other.
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

/// UAV 0 at a step before it receives the packet of UAV 1: the last fact of UAV 1 with clear ground,
/// a target and an obstacle margin.
pub fn unread_fact(seed: u64) -> (Flight, Packet) {
    let mut flight = flight(seed, 2, ExchangeMode::Facts);
    flight.pair.filter = csat_tests::pair::silence();
    flight.pair.keep_packets();
    for _ in 0..60 {
        flight.step();
        let telling = |packet: &&Packet| {
            let rich = matches!(body(packet), Message::Fact(fact)
                if !fact.clear_ground.is_empty() && !fact.targets.is_empty()
                    && !fact.oem.is_empty());
            packet.dst == AgentId(0) && rich && packet.sent == flight.pair.time
        };
        if let Some(packet) = flight.pair.packets.iter().find(telling).cloned() {
            return (flight, packet);
        }
        flight.pair.packets.clear();
    }
    panic!("seed {seed}: UAV 1 never sees a target");
}

/// The message in a packet.
pub fn body(packet: &Packet) -> Message {
    let envelope = Envelope::decode(&packet.bytes).expect("an agent's own packet");
    postcard::from_bytes(&envelope.body).expect("an agent's own body")
}

/// The digest of an agent's knowledge.
pub fn digest(agent: &SetMembershipAgent) -> u64 {
    csat_proto::agent::Agent::digest(agent)
}
