//! Which messages of other agents are believed, and facts kept until they can be applied.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use csat_proto::agent::FIRST_ANSWER;
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Fact, Known, Message, Plan, RelayedPlan};
use csat_proto::time::Step;

use super::validate::{self, Rejection};
use super::version_vector::VersionVector;
use crate::config::AgentConfig;
use crate::estimate::evidence::ReceivedFact;
use crate::identity::Identity;
use crate::mutant::{Mutant, is_on};

/// Believes or rejects checked messages, and keeps facts and snapshots for the next update.
#[derive(Debug, Clone)]
pub struct Receiver {
    config: AgentConfig,
    /// The newest incarnation of each agent of which a message was believed.
    incarnations: BTreeMap<AgentId, Incarnation>,
    waiting: Vec<ReceivedFact>,
    /// The agents that were proven to have said something false.
    liars: BTreeSet<AgentId>,
}

/// A message that passed the checks that are the same for every receiver at a step.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedMessage {
    identity: Identity,
    src: AgentId,
    incarnation: Incarnation,
    sequence: u64,
    /// Where the sender was, `world`, metres.
    p_world: [f64; 3],
    body: Body,
}

#[derive(Debug, Clone, PartialEq)]
enum Body {
    Knowledge { fact: Arc<Fact>, known: Option<Arc<Known>> },
    Plan(Plan),
    Relay(Vec<RelayedPlan>),
}

impl CheckedMessage {
    /// Decodes and checks a message, with its identity, that arrived at step `now`.
    ///
    /// # Errors
    /// The first check that it did not pass.
    pub fn decode(
        config: &AgentConfig,
        now: Step,
        identity: Identity,
        bytes: &[u8],
    ) -> Result<Self, Rejection> {
        let envelope = Envelope::decode(bytes)?;
        let body = match validate::check(config, now, &envelope)? {
            Message::Plan(plan) => Body::Plan(plan),
            Message::Relay(relay) => Body::Relay(relay.plans),
            Message::Fact(fact) => Body::Knowledge { fact: Arc::new(fact), known: None },
            Message::Snapshot(snapshot) => Body::Knowledge {
                fact: Arc::new(snapshot.fact),
                known: Some(Arc::new(snapshot.known)),
            },
        };
        let Envelope { src, incarnation, sequence, pose, .. } = envelope;
        let p_world = Pose::from(pose).p_world;
        Ok(Self { identity, src, incarnation, sequence, p_world, body })
    }
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
        /// What its frame proved.
        fact: Arc<Fact>,
    },
    /// A flight plan, which the scheduler has yet to check.
    Plan {
        /// The sender.
        from: AgentId,
        /// Its incarnation.
        incarnation: Incarnation,
        /// The plan.
        plan: Plan,
    },
    /// Flight plans of others, which the scheduler has yet to check.
    Relay {
        /// The sender.
        from: AgentId,
        /// Its incarnation.
        incarnation: Incarnation,
        /// The plans.
        plans: Vec<RelayedPlan>,
    },
    /// Applied before, or waiting already: it would change nothing.
    Repeat,
}

impl Receiver {
    /// A receiver without any message.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            config: config.clone(),
            incarnations: BTreeMap::new(),
            waiting: Vec::new(),
            liars: BTreeSet::new(),
        }
    }

    /// Keeps the facts of a message for the next update, unless it repeats what is in `held` or waits
    /// already. Plans are handed back.
    ///
    /// # Errors
    /// Why it is not believed; then nothing has changed.
    pub fn receive(
        &mut self,
        message: &CheckedMessage,
        held: &VersionVector,
    ) -> Result<Received, Rejection> {
        let CheckedMessage { identity, src, incarnation, sequence, p_world, ref body } = *message;
        validate::check_sender(&self.config, src)?;
        if self.liars.contains(&src) {
            return Err(Rejection::Liar { from: src.0 });
        }
        let known = self.incarnations.get(&src).copied().unwrap_or_default();
        if incarnation < known && !is_on(Mutant::StaleIncarnationAccepted) {
            return Err(Rejection::Incarnation { got: incarnation.0, known: known.0 });
        }
        let (fact, known) = match body.clone() {
            Body::Plan(plan) => return Ok(Received::Plan { from: src, incarnation, plan }),
            Body::Relay(plans) => return Ok(Received::Relay { from: src, incarnation, plans }),
            Body::Knowledge { fact, known } => (fact, known),
        };
        // An answer contains more than the fact whose number it has, so it is no repeat of that fact.
        let is_answer = sequence >= FIRST_ANSWER;
        let is_same = |h: &ReceivedFact| {
            let stamp = (h.src, h.incarnation, h.fact.number, h.known.is_some(), h.is_answer);
            stamp == (src, incarnation, fact.number, known.is_some(), is_answer)
        };
        let is_applied = !is_answer && held.has_applied(src, incarnation, fact.number);
        if is_applied || self.waiting.iter().any(is_same) {
            return Ok(Received::Repeat);
        }
        let max = self.capacity();
        if self.waiting.len() >= max {
            return Err(Rejection::Full { max });
        }
        self.believe(src, incarnation);
        let received = Received::Knowledge { from: src, p_world, fact: fact.clone() };
        self.waiting.push(ReceivedFact { src, incarnation, fact, known, is_answer, identity });
        Ok(received)
    }

    /// A message of this incarnation of an agent was believed: its earlier incarnations are over.
    pub fn believe(&mut self, src: AgentId, incarnation: Incarnation) {
        let known = self.incarnations.entry(src).or_default();
        *known = incarnation.max(*known);
    }

    /// An agent was proven to have said something false: none of its messages is believed any more.
    pub fn ignore(&mut self, liar: AgentId) {
        if !is_on(Mutant::NamedLiarHeard) {
            self.waiting.retain(|h| h.src != liar);
            self.liars.insert(liar);
        }
    }

    /// The number of facts that all agents can state within the accepted age, one per agent and step.
    fn capacity(&self) -> usize {
        let steps = self.config.steps(self.config.exchange.max_age_s).max(1) as usize + 1;
        steps.saturating_mul(usize::from(self.config.agents()))
    }

    /// Whether a fact waits that can be applied at `now`.
    pub fn has_due(&self, now: Step) -> bool {
        self.waiting.iter().any(|h| h.fact.step <= now)
    }

    /// Takes all that can be applied at `now`; facts of later steps go on waiting.
    pub fn take_due(&mut self, now: Step) -> Vec<ReceivedFact> {
        self.waiting.extract_if(.., |h| h.fact.step <= now).collect()
    }
}
