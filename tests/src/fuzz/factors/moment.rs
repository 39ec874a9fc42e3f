//! Agents of the Bayesian search in the middle of a mission, which hear hostile talk.

use std::sync::OnceLock;

use csat_bayes::agent::BayesAgent;
use csat_bayes::config::{AgentConfig, BeliefKind, ExchangeMode};
use csat_flight::bayes::Bayes;
use csat_flight::scenario::missions::Offered;
use csat_mission::mission::Mission;
use csat_proto::agent::Agent;
use csat_proto::envelope::Envelope;
use csat_proto::frame::Frame as SensorFrame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::SimTime;

use super::Said;
use crate::bayes::equations::Frame;
use crate::bayes::missions::Tables;
use crate::bayes::script::{Heard, Script};

/// Steps of the first life.
const FIRST: u32 = 6;
/// The life after it: so many may have been before that there is no room for the factors of all.
const LIFE: Incarnation = Incarnation(100);
/// Its steps before the talk.
const STEPS: u32 = 8;
/// Steps after the talk.
const AHEAD: u32 = 4;

/// Aircraft 0 of two, in a later life. It missed the first steps, so there are numbers of its factors that it has
/// not stated yet.
pub struct Moment {
    /// Aircraft 0.
    pub agent: BayesAgent,
    /// The time.
    pub now: SimTime,
    /// A valid message to it, with an empty body.
    pub envelope: Envelope,
    /// What it was told, and an answer to one that joins late.
    pub heard: Vec<Said>,
    /// Its next frames.
    pub ahead: Vec<(SimTime, SensorFrame)>,
    /// The configuration of aircraft 1.
    pub listener: AgentConfig,
}

impl Moment {
    /// The moments that all inputs start from: one for each way in which factors and beliefs are applied.
    pub fn all() -> &'static [Self; 4] {
        static MOMENTS: OnceLock<[Moment; 4]> = OnceLock::new();
        MOMENTS.get_or_init(|| {
            let belief = |kind, cell_m| {
                move |tables: &mut Tables| {
                    (tables.belief.kind, tables.belief.cell_m) = (kind, cell_m);
                    (tables.belief.particles, tables.belief.lag_s) = (500, 1.0);
                    (tables.guidance.horizon_s, tables.guidance.beam) = (6.0, 2);
                }
            };
            let beliefs = |tables: &mut Tables| {
                belief(BeliefKind::Adaptive, 12.5)(tables);
                tables.exchange.mode = ExchangeMode::Snapshot;
                tables.exchange.snapshot_period_s = 1.0;
            };
            [
                Self::fly(Script::of(false, belief(BeliefKind::Adaptive, 12.5))),
                Self::fly(Script::of(true, belief(BeliefKind::Grid, 8.0))),
                Self::fly(Script::of(false, belief(BeliefKind::Particles, 12.5))),
                Self::fly(Script::of(false, beliefs)),
            ]
        })
    }

    fn fly(mut script: Script) -> Self {
        for _ in 0..FIRST {
            script.step(Heard::All);
        }
        script.agents[0] = Bayes::of(&script.scenario).agent(AgentId(0), LIFE);
        script.said.clear();
        for _ in 0..STEPS {
            script.step(Heard::All);
        }
        let (agent, now) = (script.agents[0].clone(), script.now());
        let answer = script.agents[1].answer(now).expect("it knows something");
        let others = script.said.iter().filter(|(from, _)| *from == 1).map(|(_, bytes)| bytes);
        let envelopes: Vec<Envelope> = others
            .chain([&answer.bytes])
            .map(|bytes| Envelope::decode(bytes).expect("an agent's own message"))
            .collect();
        let newest = envelopes.last().expect("some");
        let envelope = Envelope { body: Vec::new(), ..newest.clone() };
        let ahead = (0..AHEAD).map(|_| {
            let [Frame { pose, sighting }, _] = script.step(Heard::All);
            let (now, step) = (script.now(), script.agents[0].filter().step());
            (now, SensorFrame::of_detector(step, pose, sighting))
        });
        Self {
            ahead: ahead.collect(),
            heard: envelopes.iter().map(said).collect(),
            listener: script.agents[1].config().clone(),
            agent,
            now,
            envelope,
        }
    }

    /// A message as it is sent.
    pub fn envelope(&self, said: &Said) -> Envelope {
        let Said { src, incarnation, step, .. } = *said;
        let body = postcard::to_stdvec(&said.message).expect("it serialises");
        Envelope { src, incarnation, step, body, ..self.envelope.clone() }
    }
}

fn said(envelope: &Envelope) -> Said {
    let message = postcard::from_bytes(&envelope.body).expect("an honest body");
    let Envelope { src, incarnation, step, .. } = *envelope;
    Said { src, incarnation, step, message }
}
