//! What of the others' messages is believed, kept until it can be applied.

use std::collections::BTreeMap;

use csat_proto::agent::FIRST_ANSWER;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Message, Plan};
use csat_proto::raster::Raster;
use csat_proto::time::Step;

use super::held::Held;
use super::validate::{self, Rejection};
use crate::config::AgentConfig;
use crate::estimate::evidence::Heard;
use crate::mutant::{Mutant, is_on};

/// Valid facts and snapshots that wait for the next update.
#[derive(Debug, Clone)]
pub struct Inbox {
    config: AgentConfig,
    incarnations: BTreeMap<AgentId, Incarnation>,
    waiting: Vec<Heard>,
}

/// What became of a valid message.
#[derive(Debug, Clone, PartialEq)]
pub enum Received {
    /// Kept for the next update.
    Knowledge {
        /// The sender.
        from: AgentId,
        /// Where it was, `world`, metres.
        p_world: [f64; 3],
        /// What its frame could not see.
        hidden: Raster,
    },
    /// Somebody's flight plan, yet to be judged by the scheduler.
    Plan {
        /// The sender.
        from: AgentId,
        /// Its life.
        incarnation: Incarnation,
        /// The plan.
        plan: Plan,
    },
    /// Heard before, or waiting already: it would change nothing.
    Repeat,
}

impl Inbox {
    /// An inbox that has heard nobody.
    pub fn new(config: &AgentConfig) -> Self {
        Self { config: config.clone(), incarnations: BTreeMap::new(), waiting: Vec::new() }
    }

    /// Decodes, checks and files a message that arrived at the receiver's step `now`, unless it
    /// repeats what is held.
    pub fn receive(&mut self, now: Step, bytes: &[u8], held: &Held) -> Result<Received, Rejection> {
        let envelope = Envelope::decode(bytes)?;
        let (src, incarnation) = (envelope.src, envelope.incarnation);
        let known = self.incarnations.get(&src).copied().unwrap_or_default();
        let message = validate::check(&self.config, now, &envelope)?;
        if incarnation < known && !is_on(Mutant::StaleIncarnationAccepted) {
            return Err(Rejection::Incarnation { got: incarnation.0, known: known.0 });
        }
        let (fact, known) = match message {
            Message::Plan(plan) => return Ok(Received::Plan { from: src, incarnation, plan }),
            Message::Fact(fact) => (fact, None),
            Message::Snapshot(snapshot) => (snapshot.fact, Some(snapshot.known)),
        };
        // An answer tells more than the fact whose number it has, even to who has applied that.
        let is_answer = envelope.sequence >= FIRST_ANSWER;
        let identity = (src, incarnation, fact.number, known.is_some());
        let is_same =
            |h: &Heard| (h.src, h.incarnation, h.fact.number, h.known.is_some()) == identity;
        let is_applied = !is_answer && held.has_applied(src, incarnation, fact.number);
        if is_applied || self.waiting.iter().any(is_same) {
            return Ok(Received::Repeat);
        }
        let max = self.capacity();
        if self.waiting.len() >= max {
            return Err(Rejection::Full { max });
        }
        self.believe(src, incarnation);
        let hidden = fact.hidden.clone();
        self.waiting.push(Heard { src, incarnation, fact, known });
        Ok(Received::Knowledge { from: src, p_world: envelope.pose.p_world, hidden })
    }

    /// Something of this life of an agent was believed: earlier lives are over.
    pub fn believe(&mut self, src: AgentId, incarnation: Incarnation) {
        let known = self.incarnations.entry(src).or_default();
        *known = incarnation.max(*known);
    }

    /// As many facts as the fleet can have stated within the accepted age, one per neighbour and step.
    fn capacity(&self) -> usize {
        let AgentConfig { exchange, period_s, fleet, .. } = &self.config;
        let steps = (exchange.max_age_s / period_s).ceil().max(1.0) as usize + 1;
        steps * usize::from(fleet.count)
    }

    /// Whether anything waits that can be applied at `now`.
    pub fn has_due(&self, now: Step) -> bool {
        self.waiting.iter().any(|h| h.fact.step <= now)
    }

    /// Takes everything that can be applied at `now`; what comes from a step ahead stays.
    pub fn take_due(&mut self, now: Step) -> Vec<Heard> {
        self.waiting.extract_if(.., |h| h.fact.step <= now).collect()
    }
}
