//! Agents claim to hold only facts that they received.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Fact, Message};

/// The facts that each agent can hold in its current incarnation, by their origin.
#[derive(Debug, Default)]
pub struct Claims {
    told: BTreeMap<AgentId, Facts>,
}

/// The numbers of facts, per incarnation of an agent.
type Facts = BTreeMap<(AgentId, Incarnation), BTreeSet<u32>>;

impl Claims {
    /// Notes that an agent crashed and lost its knowledge.
    pub fn forget(&mut self, agent: AgentId) {
        self.told.remove(&agent);
    }

    /// Notes that an agent sent a message.
    ///
    /// # Errors
    /// It claims a fact that it cannot hold.
    pub fn say(
        &mut self,
        src: AgentId,
        incarnation: Incarnation,
        message: &Message,
    ) -> Result<(), String> {
        let Some((fact, _)) = fact_of(message) else { return Ok(()) };
        let own = self.told.entry(src).or_default();
        for held in &fact.held.facts {
            let told = own.get(&(held.origin, held.incarnation));
            let is_told = |number: &u32| told.is_some_and(|told| told.contains(number));
            if let Some(number) = (0..held.count).find(|number| !is_told(number)) {
                return Err(format!("UAV {src} claims {held:?}, but was never told {number}"));
            }
        }
        own.entry((src, incarnation)).or_default().insert(fact.number);
        Ok(())
    }

    /// Notes that a message arrived and was not rejected. The claims of a snapshot were checked when
    /// it was sent.
    pub fn hear(
        &mut self,
        dst: AgentId,
        src: AgentId,
        incarnation: Incarnation,
        message: &Message,
    ) {
        let Some((fact, is_snapshot)) = fact_of(message) else { return };
        let told = self.told.entry(dst).or_default();
        told.entry((src, incarnation)).or_default().insert(fact.number);
        for held in fact.held.facts.iter().filter(|_| is_snapshot) {
            told.entry((held.origin, held.incarnation)).or_default().extend(0..held.count);
        }
    }
}

/// The fact in a message, and whether the message is a snapshot.
fn fact_of(message: &Message) -> Option<(&Fact, bool)> {
    match message {
        Message::Fact(fact) => Some((fact, false)),
        Message::Snapshot(snapshot) => Some((&snapshot.fact, true)),
        Message::Plan(_) | Message::Relay(_) => None,
    }
}
