//! An agent in the middle of a mission, to be told anything.

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

/// Steps before it.
const STEPS: u32 = 24;
/// Steps after it.
const AHEAD: usize = 2;

/// UAV 0 of three, with a frame that it has not applied yet.
pub struct Moment {
    /// UAV 0.
    pub agent: SetMembershipAgent,
    /// When.
    pub now: SimTime,
    /// Its digest if it hears nothing.
    pub undisturbed: u64,
    /// An honest message to it, with an empty body.
    pub envelope: Envelope,
    /// Honest messages that it has not heard.
    pub heard: Vec<Envelope>,
    /// Its next frames.
    pub ahead: Vec<(SimTime, Frame)>,
    /// UAV 2.
    pub listener: SetMembershipAgent,
}

impl Moment {
    /// The one that all tries begin at.
    pub fn shared() -> &'static Self {
        static MOMENT: OnceLock<Moment> = OnceLock::new();
        MOMENT.get_or_init(Self::fly)
    }

    fn fly() -> Self {
        let mut scenario = small(3, 120.0, 3);
        scenario.exchange.mode = ExchangeMode::FactsRepair;
        // It says all it knows at each step.
        scenario.exchange.snapshot_period_s = scenario.run.period_s;
        scenario.agents.start_offset_m = 0.0;
        let mut flight = Flight::scripted(&scenario, |step, agent| {
            f64::from(step / 6) * 0.5 - 1.0 + 0.8 * f64::from(agent)
        });
        // UAV 0 hears only UAV 2, and UAV 1 has much to tell it.
        let unheard = (AgentId(1), AgentId(0));
        flight.pair.filter =
            Box::new(
                move |letter| {
                    if (letter.src, letter.dst) == unheard { vec![] } else { vec![0.0] }
                },
            );
        flight.pair.keep_letters();
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
        let letters = &flight.pair.letters;
        let unheard = letters.iter().filter(|letter| (letter.src, letter.dst) == unheard);
        let heard: Vec<Envelope> = unheard
            .map(|letter| Envelope::decode(&letter.bytes).expect("an agent's own letter"))
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
