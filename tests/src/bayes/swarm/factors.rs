//! Agents hold the factors that they stated and that they were told in this life: no others, no fewer, and each
//! as its source stated it.

use std::collections::{BTreeMap, BTreeSet};

use csat_bayes::agent::BayesAgent;
use csat_bayes::exchange::message::Message;
use csat_bayes::factor::{Factor, FactorId, ReportedPose};
use csat_netem::link::Arrival;
use csat_proto::camera::Pose;
use csat_proto::envelope::{Envelope, decode_whole};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use super::Exercise;

/// All factors of a mission.
#[derive(Debug, Default)]
pub struct Ledger {
    stated: BTreeMap<FactorId, Factor>,
    lives: BTreeMap<AgentId, Life>,
}

/// The present life of an agent.
#[derive(Debug, Default)]
struct Life {
    incarnation: Incarnation,
    /// The step of the newest frame that it did not miss.
    step: Step,
    /// How many factors it stated.
    stated: u32,
    /// What it has to hold.
    held: BTreeSet<FactorId>,
    /// Per sender, the newest incarnation that it believes.
    believed: BTreeMap<AgentId, Incarnation>,
    /// What it has to have rejected, by reason.
    rejected: BTreeMap<String, u64>,
}

/// What decides for how long agents believe a message.
#[derive(Debug, Clone, Copy)]
pub struct Now {
    /// Seconds between steps.
    pub period_s: f64,
    /// `exchange.max_age_s`.
    pub max_age_s: f64,
}

impl Ledger {
    /// An agent crashed: what it knew is lost.
    pub fn forget(&mut self, agent: AgentId) {
        let incarnation = self.lives.get(&agent).map_or(Incarnation(0), |life| life.incarnation);
        self.lives.insert(agent, Life { incarnation, ..Life::default() });
    }

    /// An agent did not miss a step: a UAV stated the factor of its frame, taken at `reported`; a station none.
    ///
    /// # Errors
    /// It is not that factor, or its identity was used before.
    pub fn state(
        &mut self,
        id: AgentId,
        incarnation: Incarnation,
        agent: &BayesAgent,
        step: Step,
        reported: &Pose,
    ) -> Result<bool, String> {
        let life = self.lives.entry(id).or_default();
        (life.incarnation, life.step) = (incarnation, step);
        if agent.config().is_station() {
            return match agent.own_factor() {
                Some(own) => Err(format!("station {id} states {own:?}")),
                None => Ok(false),
            };
        }
        let own = *agent.own_factor().ok_or(format!("UAV {id} states nothing"))?;
        let number = life.stated;
        let expected = FactorId { source: id, incarnation, number };
        if own.id != expected || own.step != step || own.pose != ReportedPose::from(reported) {
            return Err(format!("UAV {id} states {own:?}, not {expected:?} from {reported:?}"));
        }
        life.stated += 1;
        life.held.insert(own.id);
        match self.stated.insert(own.id, own) {
            Some(before) => Err(format!("{own:?} has the identity of {before:?}")),
            None => Ok(own.sighting.is_some()),
        }
    }

    /// A message arrived at an agent that runs.
    ///
    /// # Errors
    /// It holds a factor that nobody stated.
    pub fn hear(
        &mut self,
        arrival: &Arrival,
        now: Now,
        exercise: &mut Exercise,
    ) -> Result<(), String> {
        let life = self.lives.entry(arrival.dst).or_default();
        let mut reject = |reason: &str| *life.rejected.entry(reason.to_owned()).or_default() += 1;
        let envelope = match Envelope::decode(&arrival.bytes) {
            Ok(envelope) => envelope,
            Err(_) => {
                reject("damaged");
                return Ok(());
            }
        };
        let Envelope { src, incarnation, step, .. } = envelope;
        if step > life.step.after(1) {
            exercise.ahead += 1;
            reject("future");
            return Ok(());
        }
        let age_s = f64::from(life.step.0.saturating_sub(step.0)) * now.period_s;
        if age_s > now.max_age_s {
            exercise.old += 1;
            reject("too-old");
            return Ok(());
        }
        let known = life.believed.entry(src).or_default();
        if incarnation < *known {
            exercise.stale += 1;
            reject("incarnation");
            return Ok(());
        }
        *known = incarnation;
        let message: Message = decode_whole(&envelope.body).ok_or("a body that does not decode")?;
        for factor in message.factors {
            exercise.relayed += u64::from(factor.id.source != src);
            match self.stated.get(&factor.id) {
                Some(stated) if is_same(stated, &factor) => {}
                stated => return Err(format!("{src} said {factor:?}, stated was {stated:?}")),
            }
            exercise.repeated += u64::from(!life.held.insert(factor.id));
        }
        Ok(())
    }

    /// Compares what an agent holds, and what it rejected, with what it has to.
    ///
    /// # Errors
    /// What differs.
    pub fn check(&self, id: AgentId, agent: &BayesAgent) -> Result<(), String> {
        let Some(life) = self.lives.get(&id) else { return Ok(()) };
        let held: BTreeSet<FactorId> = agent.factors().iter().map(|factor| factor.id).collect();
        if held != life.held {
            let missing = life.held.difference(&held).next();
            let other = held.difference(&life.held).next();
            return Err(format!("agent {id} does not hold {missing:?}, or holds {other:?}"));
        }
        let wrong = agent
            .factors()
            .iter()
            .find(|f| !self.stated.get(&f.id).is_some_and(|stated| is_same(stated, f)));
        if let Some(factor) = wrong {
            return Err(format!("agent {id} holds {factor:?}, which was not stated so"));
        }
        let mut rejected: BTreeMap<String, u64> = BTreeMap::new();
        for (reason, count) in agent.rejected() {
            let is_damage = ["checksum", "envelope"].contains(&reason.as_str());
            let reason = if is_damage { "damaged" } else { reason };
            *rejected.entry(reason.to_owned()).or_default() += count;
        }
        if rejected != life.rejected {
            return Err(format!("agent {id} rejected {rejected:?}, not {:?}", life.rejected));
        }
        Ok(())
    }

    /// The factors that an agent holds.
    pub fn held(&self, id: AgentId) -> BTreeSet<FactorId> {
        self.lives.get(&id).map(|life| life.held.clone()).unwrap_or_default()
    }
}

/// Whether two factors are equal bit for bit.
fn is_same(a: &Factor, b: &Factor) -> bool {
    let bits = |factor: &Factor| {
        let ReportedPose { p_world, angles_rad } = factor.pose;
        let pose = [p_world, angles_rad].map(|three| three.map(f32::to_bits));
        (factor.id, factor.step, pose, factor.sighting.map(|z| z.map(f32::to_bits)))
    };
    bits(a) == bits(b)
}
