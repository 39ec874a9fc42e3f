//! What of the others' messages is believed, kept until it can be applied.

use std::collections::BTreeMap;

use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Fact, Message, Plan, Snapshot};
use csat_proto::raster::Raster;
use csat_proto::time::Step;

use super::validate::{self, Rejection};
use crate::config::AgentConfig;

/// Valid facts and snapshots that wait for the next fusion.
#[derive(Debug, Clone)]
pub struct Inbox {
    config: AgentConfig,
    incarnations: BTreeMap<AgentId, Incarnation>,
    facts: Vec<Fact>,
    snapshots: Vec<Snapshot>,
}

/// What became of a valid message.
#[derive(Debug, Clone, PartialEq)]
pub enum Received {
    /// Kept for the next fusion.
    Knowledge {
        /// The sender.
        from: AgentId,
        /// What its frame could not see.
        hidden: Raster,
    },
    /// Somebody's flight plan.
    Plan(AgentId, Plan),
}

impl Inbox {
    /// An inbox that has heard nobody.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            config: config.clone(),
            incarnations: BTreeMap::new(),
            facts: Vec::new(),
            snapshots: Vec::new(),
        }
    }

    /// Decodes, checks and files a message that arrived at the receiver's step `now`.
    pub fn receive(&mut self, now: Step, bytes: &[u8]) -> Result<Received, Rejection> {
        let envelope = Envelope::decode(bytes)?;
        let known = self.incarnations.get(&envelope.src).copied().unwrap_or_default();
        let message = validate::check(&self.config, now, &envelope)?;
        if envelope.incarnation < known {
            return Err(Rejection::Incarnation { got: envelope.incarnation.0, known: known.0 });
        }
        let (max, waiting) = (self.capacity(), self.facts.len() + self.snapshots.len());
        if waiting >= max && !matches!(message, Message::Plan(_)) {
            return Err(Rejection::Full { max });
        }
        self.incarnations.insert(envelope.src, envelope.incarnation);
        let from = envelope.src;
        Ok(match message {
            Message::Fact(fact) => {
                let hidden = fact.hidden.clone();
                self.facts.push(fact);
                Received::Knowledge { from, hidden }
            }
            Message::Snapshot(snapshot) => {
                let hidden = snapshot.hidden.clone();
                self.snapshots.push(snapshot);
                Received::Knowledge { from, hidden }
            }
            Message::Plan(plan) => Received::Plan(from, plan),
        })
    }

    /// As many messages as the fleet can have sent within the accepted age: a fact and a snapshot
    /// per neighbour and step.
    fn capacity(&self) -> usize {
        let AgentConfig { exchange, period_s, fleet, .. } = &self.config;
        let steps = (exchange.max_age_s / period_s).ceil().max(1.0) as usize + 1;
        2 * steps * usize::from(fleet.count)
    }

    /// Whether anything waits that can be applied at `now`.
    pub fn has_due(&self, now: Step) -> bool {
        self.facts.iter().any(|f| f.step <= now) || self.snapshots.iter().any(|s| s.step <= now)
    }

    /// Takes everything that can be applied at `now`; what comes from a step ahead stays.
    pub fn take_due(&mut self, now: Step) -> (Vec<Fact>, Vec<Snapshot>) {
        let facts = self.facts.extract_if(.., |f| f.step <= now).collect();
        let snapshots = self.snapshots.extract_if(.., |s| s.step <= now).collect();
        (facts, snapshots)
    }
}
