//! The laws that hold at every step of every mission.

use std::collections::BTreeMap;

use csat_agent::agent::Event;
use csat_experiments::set_membership::judge::{TOLERANCE_M, admits};
use csat_mission::engine::{LifeEvent, StepTrace};
use csat_netem::link::Arrival;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, TargetId};
use csat_proto::message::{Fact, Known, Message};
use csat_proto::region::{Region, metres};
use csat_proto::time::Step;
use csat_world::lie::Liar;

use super::claims::Claims;
use super::draw::Draw;
use super::{Exercise, Handicapped, Swarm, merge};

/// Identity of a message: sender, incarnation, radio, number.
type Identity = (AgentId, Incarnation, ChannelId, u64);

/// Checks one mission.
pub struct Laws {
    period_s: f64,
    max_age_s: f64,
    clock_skew_s: f64,
    /// By how many steps each agent's clock is ahead.
    ahead: Vec<u32>,
    misses_frames: bool,
    /// The first step of the world at which each liar lies.
    liars: BTreeMap<AgentId, u32>,
    /// The locations of the targets, by step.
    truth: Vec<Vec<[f64; 2]>>,
    /// The checksum of the message of each identity.
    said: BTreeMap<Identity, u32>,
    /// Per receiver and sender, the newest incarnation that the receiver believes.
    believed: BTreeMap<(AgentId, AgentId), Incarnation>,
    /// Per receiver, messages of incarnations that were over, in the receiver's current incarnation.
    stale: BTreeMap<AgentId, u64>,
    /// The same for damaged messages.
    damaged: BTreeMap<AgentId, u64>,
    claims: Claims,
    exercise: Exercise,
}

/// What happened in a step.
pub type Trace = StepTrace<Handicapped>;

impl Laws {
    /// The state before the first step.
    pub fn new(draw: &Draw) -> Self {
        Self {
            period_s: draw.scenario.run.period_s,
            max_age_s: draw.scenario.exchange.max_age_s,
            clock_skew_s: draw.scenario.exchange.clock_skew_s,
            ahead: draw.handicaps.iter().map(|handicap| handicap.ahead).collect(),
            misses_frames: draw.handicaps.iter().any(|handicap| !handicap.missed.is_empty()),
            liars: draw.scenario.faults.liar.iter().map(|liar| first_lie(draw, liar)).collect(),
            truth: Vec::new(),
            said: BTreeMap::new(),
            believed: BTreeMap::new(),
            stale: BTreeMap::new(),
            damaged: BTreeMap::new(),
            claims: Claims::default(),
            exercise: Exercise::default(),
        }
    }

    /// Checks one step.
    ///
    /// # Errors
    /// The first law that does not hold.
    pub fn check(&mut self, engine: &Swarm, trace: &Trace) -> Result<(), String> {
        self.truth.push(engine.world().targets().iter().map(|t| t.location).collect());
        for (agent, life) in &trace.lives {
            if let LifeEvent::Crashed { .. } = life {
                self.exercise.crashes += 1;
                self.believed.retain(|(dst, _), _| dst != agent);
                self.stale.remove(agent);
                self.damaged.remove(agent);
                self.claims.forget(*agent);
            }
        }
        if let Some(violation) = trace.violations.first() {
            return Err(format!("violated: {:?}", violation.fault));
        }
        let honest = trace.events.iter().filter(|(agent, _)| !self.has_lied(*agent));
        if let Some((agent, event)) =
            honest.clone().find(|(_, e)| matches!(e, Event::Inconsistent { .. }))
        {
            return Err(format!("UAV {agent}: {event:?}"));
        }
        let named = trace.events.iter().filter(|(_, e)| matches!(e, Event::Liar { .. }));
        self.exercise.named += named.count() as u64;
        self.check_monitor(trace)?;
        self.check_said(trace)?;
        for arrival in &trace.arrivals {
            self.hear(engine, arrival)?;
        }
        self.check_rejections(engine)?;
        self.exercise.merged += merge::check(engine, trace)?;
        Ok(())
    }

    /// What the mission exercised.
    pub fn exercise(&self, engine: &Swarm) -> Exercise {
        let counters = engine.counters();
        let nodes = engine.nodes().iter();
        Exercise {
            missions: 1,
            delivered: counters.delivered,
            dropped: counters.dropped.values().sum(),
            corrupted: counters.corrupted,
            duplicated: counters.duplicated,
            identified: nodes.map(|s| s.agent.inner.knowledge().targets.len() as u64).sum(),
            ..self.exercise
        }
    }

    /// The monitor admits a target ε/2 beyond the northern end of its set, and none 2 ε beyond.
    fn check_monitor(&self, trace: &Trace) -> Result<(), String> {
        let count = self.truth.last().map_or(0, Vec::len) as u16;
        for report in trace.flown.iter().filter_map(|flown| flown.report.as_ref()) {
            for target in (0..count).map(TargetId) {
                let corners = report.inner.set_of(target).rings().flatten();
                let Some(north) = corners.max_by_key(|p| p.y) else { continue };
                let [x, y] = metres(*north);
                let admits = |beyond: f64| {
                    let p = [x, y + beyond * TOLERANCE_M];
                    admits(&report.inner, target, p)
                };
                if !admits(0.5) || admits(2.0) {
                    return Err(format!(
                        "the monitor is not sharp at {:?}, target {target}",
                        [x, y]
                    ));
                }
            }
        }
        Ok(())
    }

    /// Every message has its own identity, and its contents are true at its step.
    fn check_said(&mut self, trace: &Trace) -> Result<(), String> {
        for passage in &trace.passages {
            let sent = &passage.sent;
            let late_us = (self.period_s * 1e6) as u64;
            let late = |d: csat_netem::fate::Delivery| d.at.0 >= sent.time.0 + late_us;
            self.exercise.late +=
                passage.fate.copies().flatten().filter(|d| late(*d)).count() as u64;
            let envelope = Envelope::decode(&passage.bytes).map_err(|e| format!("said: {e}"))?;
            let Envelope { src, incarnation, channel, sequence, .. } = envelope;
            let checksum = csat_proto::envelope::checksum(&passage.bytes);
            let identity = (src, incarnation, channel, sequence);
            match self.said.insert(identity, checksum) {
                None => {
                    let message = message_of(&envelope)?;
                    if !self.has_lied(src) {
                        self.check_truth(src, &message)?;
                    }
                    self.exercise.relayed += u64::from(matches!(message, Message::Relay(_)));
                    self.claims.say(src, incarnation, &message)?;
                }
                Some(before) if before == checksum => {}
                Some(_) => return Err(format!("two messages are {identity:?}")),
            }
        }
        Ok(())
    }

    /// Whether an agent has begun to lie by the last step.
    fn has_lied(&self, agent: AgentId) -> bool {
        let now = self.truth.len() as u32 - 1;
        self.liars.get(&agent).is_some_and(|first| *first <= now)
    }

    fn check_truth(&self, src: AgentId, message: &Message) -> Result<(), String> {
        match message {
            Message::Fact(fact) => self.check_fact(src, fact),
            Message::Snapshot(snapshot) => {
                self.check_fact(src, &snapshot.fact)?;
                self.check_known(src, &snapshot.known)
            }
            Message::Plan(_) | Message::Relay(_) => Ok(()),
        }
        .map_err(|law| format!("UAV {src} said: {law}"))
    }

    /// The locations of the targets at a step of an agent's clock.
    fn at(
        &self,
        clock: AgentId,
        step: Step,
    ) -> Result<impl Iterator<Item = (usize, [f64; 2])> + '_, String> {
        let world_step = step.0.saturating_sub(self.ahead[usize::from(clock.0)]);
        let truth = self.truth.get(world_step as usize);
        let truth = truth.ok_or(format!("step {step} is yet to come"))?;
        Ok(truth.iter().copied().enumerate())
    }

    fn check_fact(&self, src: AgentId, fact: &Fact) -> Result<(), String> {
        for (j, location) in self.at(src, fact.step)? {
            for (what, part) in [("clear", &fact.clear_ground), ("margin", &fact.obstacle_margin)] {
                if is_deep_in(part, location) {
                    return Err(format!("{what} where target {j} is, {location:?}"));
                }
            }
            for seen in &fact.targets {
                let is_it = usize::from(seen.target.0) == j;
                if is_it && seen.location.distance_m(location) > TOLERANCE_M {
                    return Err(format!("target {j} is not where it was seen, {location:?}"));
                }
                if !is_it && is_deep_in(&seen.exclusion, location) {
                    return Err(format!("target {j} is excluded by {}", seen.target));
                }
            }
        }
        Ok(())
    }

    fn check_known(&self, src: AgentId, known: &Known) -> Result<(), String> {
        for (j, location) in self.at(src, known.step)? {
            let own = known.targets.iter().find(|(target, _)| usize::from(target.0) == j);
            let set = own.map_or(&known.unexplored, |(_, set)| set);
            if set.distance_m(location) > TOLERANCE_M {
                return Err(format!("target {j} is not where it is known to be, {location:?}"));
            }
            if is_deep_in(&known.obstacle_margin, location) {
                return Err(format!("the margin is where target {j} is, {location:?}"));
            }
        }
        Ok(())
    }

    /// Notes an arrival: which incarnation the receiver believes, and which facts it gets.
    fn hear(&mut self, engine: &Swarm, arrival: &Arrival) -> Result<(), String> {
        let node = &engine.nodes()[usize::from(arrival.dst.0)];
        if !node.is_alive() {
            return Ok(());
        }
        let Ok(envelope) = Envelope::decode(&arrival.bytes) else {
            *self.damaged.entry(arrival.dst).or_default() += 1;
            return Ok(());
        };
        // The age of messages is relative to the receiver's last frame.
        let now = node.agent.inner.knowledge().step;
        let soonest = now.after((self.clock_skew_s / self.period_s).ceil() as u32 + 1);
        let age_s = f64::from(now.0.saturating_sub(envelope.step.0)) * self.period_s;
        if envelope.step > soonest || age_s > self.max_age_s {
            return Ok(());
        }
        let known = self.believed.entry((arrival.dst, envelope.src)).or_default();
        if envelope.incarnation < *known {
            *self.stale.entry(arrival.dst).or_default() += 1;
            self.exercise.stale += 1;
            return Ok(());
        }
        *known = envelope.incarnation;
        let message = message_of(&envelope)?;
        self.claims.hear(arrival.dst, envelope.src, envelope.incarnation, &message);
        Ok(())
    }

    /// Agents reject all messages that are damaged, too old or of an earlier incarnation, and no
    /// others.
    fn check_rejections(&self, engine: &Swarm) -> Result<(), String> {
        for (node, id) in engine.nodes().iter().zip(0..).filter(|(node, _)| node.is_alive()) {
            let rejected = node.agent.inner.rejected();
            let count = |reason| rejected.get(reason).copied().unwrap_or_default();
            let of = |counts: &BTreeMap<AgentId, u64>| {
                counts.get(&AgentId(id)).copied().unwrap_or_default()
            };
            let expected = of(&self.stale);
            if count("incarnation") != expected {
                return Err(format!("UAV {id}: {rejected:?}, but {expected} of earlier lives"));
            }
            let damaged = count("checksum") + count("envelope");
            if damaged != of(&self.damaged) {
                return Err(format!("UAV {id}: {rejected:?}, but {} damaged", of(&self.damaged)));
            }
            let mut allowed = vec!["incarnation", "checksum", "envelope", "too-old"];
            // The monitor checks who is named.
            allowed.extend((!self.liars.is_empty()).then_some("liar"));
            if self.misses_frames || self.clock_skew_s > 0.0 {
                // An agent that is behind, by its clock or by missed frames, may reject messages of
                // later steps.
                allowed.extend(["future", "plan"]);
            }
            if let Some(reason) = rejected.keys().find(|reason| !allowed.contains(reason)) {
                return Err(format!("UAV {id} rejected an honest message: {reason}"));
            }
        }
        Ok(())
    }
}

/// The first step at which a liar lies.
fn first_lie(draw: &Draw, liar: &Liar) -> (AgentId, u32) {
    let first = (liar.from_s / draw.scenario.run.period_s).ceil();
    (AgentId(liar.agent), first as u32)
}

/// The message in an envelope.
fn message_of(envelope: &Envelope) -> Result<Message, String> {
    postcard::from_bytes(&envelope.body).map_err(|e| format!("said: {e}"))
}

/// Whether a point is in a set, and more than ε from its border.
fn is_deep_in(region: &Region, p: [f64; 2]) -> bool {
    let e = TOLERANCE_M;
    region.contains(p)
        && [[e, 0.0], [-e, 0.0], [0.0, e], [0.0, -e]]
            .iter()
            .all(|d| region.contains([p[0] + d[0], p[1] + d[1]]))
}
