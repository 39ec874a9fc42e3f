//! An agent in the middle of a mission, which receives arbitrary messages.

use std::sync::OnceLock;

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::ExchangeMode;
use csat_proto::agent::Agent;
use csat_proto::envelope::Envelope;
use csat_proto::frame::Frame;
use csat_proto::ids::AgentId;
use csat_proto::time::SimTime;

use crate::flight::Flight;
use crate::missions::small;

/// Steps before the messages.
const STEPS: u32 = 24;
/// Steps after the messages.
const AHEAD: usize = 2;

/// UAV 0 of three, with a frame that it has not applied yet.
pub struct Moment {
    /// UAV 0.
    pub agent: SetMembershipAgent,
    /// The time.
    pub now: SimTime,
    /// Its digest if it receives no message.
    pub undisturbed: u64,
    /// A valid message to it, with an empty body.
    pub envelope: Envelope,
    /// Valid messages that it has not received.
    pub heard: Vec<Envelope>,
    /// Its next frames.
    pub ahead: Vec<(SimTime, Frame)>,
    /// UAV 2.
    pub listener: SetMembershipAgent,
}

impl Moment {
    /// The moment that all inputs start from.
    pub fn shared() -> &'static Self {
        static MOMENT: OnceLock<Moment> = OnceLock::new();
        MOMENT.get_or_init(Self::fly)
    }

    fn fly() -> Self {
        let mut scenario = small(3, 120.0, 3);
        scenario.exchange.mode = ExchangeMode::FactsRepair;
        // Agents send all knowledge at each step.
        scenario.exchange.snapshot_period_s = scenario.run.period_s;
        scenario.agents.start_offset_m = 0.0;
        let mut flight = Flight::scripted(&scenario, |step, agent| {
            f64::from(step / 6) * 0.5 - 1.0 + 0.8 * f64::from(agent)
        });
        // UAV 0 hears only UAV 2, so UAV 1 has much that UAV 0 is missing.
        let unheard = (AgentId(1), AgentId(0));
        flight.pair.filter =
            Box::new(
                move |packet| {
                    if (packet.src, packet.dst) == unheard { vec![] } else { vec![0.0] }
                },
            );
        flight.pair.keep_packets();
        for _ in 0..STEPS {
            flight.step();
        }
        let frames = flight.look();
        let now = SimTime::from_seconds(f64::from(frames[0].step.0) * scenario.run.period_s);
        let mut agent = flight.pair.agent(0).clone();
        agent.handle_frame(now, &frames[0]);
        while agent.poll_transmit().is_some() || agent.poll_event().is_some() {}
        let mut undisturbed = agent.clone();
        undisturbed.handle_timeout(now);
        flight.pair.step(&frames);
        let packets = &flight.pair.packets;
        let unheard = packets.iter().filter(|packet| (packet.src, packet.dst) == unheard);
        let heard: Vec<Envelope> = unheard
            .map(|packet| Envelope::decode(&packet.bytes).expect("an agent's own packet"))
            .filter(|envelope| envelope.step.0 % 6 == 0)
            .collect();
        let envelope = Envelope { body: Vec::new(), ..heard.last().expect("some").clone() };
        let listener = flight.pair.agent(2).clone();
        let ahead = (0..AHEAD).map(|_| {
            flight.obey();
            let frame = flight.look().swap_remove(0);
            let now = SimTime::from_seconds(f64::from(frame.step.0) * scenario.run.period_s);
            (now, frame)
        });
        Self {
            ahead: ahead.collect(),
            undisturbed: undisturbed.digest(),
            agent,
            now,
            envelope,
            heard,
            listener,
        }
    }
}
