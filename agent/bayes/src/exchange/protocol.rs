//! What an agent states, says and hears, as its mode and its budget require.

use std::collections::BTreeMap;

use csat_proto::agent::Transmit;
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use super::answer;
use super::factor_set::FactorSet;
use super::message::{MAX_FACTOR_BYTES, MAX_PLAN, Message, POSE_BYTES, Plan, size_of};
use super::outbox::Outbox;
pub use super::outbox::Stamp;
use super::ratings::Ratings;
use super::repair::Repair;
use super::validate::{self, Rejection};
use crate::config::{AgentConfig, ExchangeMode};
use crate::factor::{Factor, FactorId};
use crate::mutant::{Mutant, is_on};
use crate::tiles::Tiles;

/// The most factors of a message that is not an answer.
pub const MAX_SAID: usize = 64;
/// Plans take at most this share of a budget.
const PLAN_SHARE: f64 = 0.25;
/// Factors that are worth nothing leave this share of the bucket to others.
const RESERVE: f64 = 0.5;
/// How long what a factor is worth is good for, seconds.
const RATING_S: f64 = 10.0;
/// Room for the lengths of the parts of a message, bytes.
pub const LENGTHS_BYTES: usize = 12;
/// The size of most factors without a sighting, bytes.
const SMALL_FACTOR_BYTES: usize = 31;

/// States the factors of an agent, tells the others, and decides which of their messages to believe.
#[derive(Debug, Clone)]
pub struct Exchange {
    config: AgentConfig,
    outbox: Outbox,
    repair: Repair,
    ratings: Ratings,
    /// How many factors this incarnation stated.
    stated: u32,
    /// Own factors that were not sent yet.
    unsaid: BTreeMap<FactorId, Factor>,
    /// The factor that was stated since the last message.
    fresh: Option<FactorId>,
    /// The first step at which factors that others are missing may be sent.
    next_repair: Step,
    /// The first step at which an agent with little to say, or with a budget, tells what it holds, and its plan.
    next_told: Step,
    /// A belief that waits for its bytes, and how many it takes.
    waiting: Option<(Tiles, usize)>,
    withheld: u64,
}

/// A message that is believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Received {
    /// The sender.
    pub from: AgentId,
    /// Its incarnation.
    pub incarnation: Incarnation,
    /// Its step.
    pub step: Step,
    /// Where it was.
    pub pose: Pose,
    /// Factors of aircraft, stated by any incarnation and known already or not.
    pub factors: Vec<Factor>,
    /// Why other factors of the message are not believed.
    pub dropped: Vec<Rejection>,
    /// Where it will be.
    pub plan: Plan,
    /// What it believes.
    pub belief: Option<Tiles>,
}

impl Exchange {
    /// An agent that has stated, said and heard nothing.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            config: config.clone(),
            outbox: Outbox::new(config),
            repair: Repair::new(config),
            ratings: Ratings::new(config.steps(RATING_S)),
            stated: 0,
            unsaid: BTreeMap::new(),
            fresh: None,
            next_repair: Step(0),
            next_told: Step(0),
            waiting: None,
            withheld: 0,
        }
    }

    /// Numbers the factor of the frame of a step: `sighting` is an image point, pixels. An agent states one
    /// factor per step at most, and a ground station none.
    pub fn state(&mut self, step: Step, pose: &Pose, sighting: Option<[f64; 2]>) -> Factor {
        let (source, mut incarnation) = (self.config.id, self.config.incarnation);
        if is_on(Mutant::FirstLifeForEver) {
            incarnation = Incarnation(0);
        }
        let id = FactorId { source, incarnation, number: self.stated };
        self.stated = self.stated.saturating_add(1);
        let sighting = sighting.map(|z| z.map(|x| x as f32));
        let factor = Factor { id, step, pose: pose.into(), sighting };
        let is_told =
            matches!(self.config.exchange.mode, ExchangeMode::Facts | ExchangeMode::FactsRepair);
        // The others would refuse the whole message.
        if is_told && validate::check_factor(&self.config, step, &factor).is_ok() {
            self.unsaid.insert(id, factor);
            self.fresh = Some(id);
        }
        factor
    }

    /// Says what there is to say at the end of a step: at most one message. `set` is what the agent holds,
    /// `belief` is told in mode `snapshot`, `worth` says how much others learn from a factor, and is asked for at
    /// most 128 of them.
    pub fn say(
        &mut self,
        stamp: &Stamp,
        set: &FactorSet,
        plan: &Plan,
        belief: Option<Tiles>,
        worth: &mut dyn FnMut(&Factor) -> f64,
    ) {
        let around = Envelope::HEADER_BYTES_MAX + MAX_PLAN * POSE_BYTES;
        let waiting = self.waiting.as_ref().map_or(0, |(_, bytes)| bytes + around);
        // However small the budget is, a factor can be paid for after some time.
        let one = self.outbox.envelope_bytes(stamp) + LENGTHS_BYTES + MAX_FACTOR_BYTES;
        self.outbox.budget.earn(stamp.now, self.config.period_s, waiting.max(one));
        match self.config.exchange.mode {
            ExchangeMode::None => {}
            ExchangeMode::Facts => self.say_once(stamp, plan),
            ExchangeMode::FactsRepair => self.say_and_repair(stamp, set, plan, worth),
            ExchangeMode::Snapshot => self.say_belief(stamp, plan, belief),
        }
        if let Some(fresh) = self.fresh.take()
            && self.unsaid.contains_key(&fresh)
        {
            self.withheld += 1;
            if self.config.exchange.mode == ExchangeMode::Facts {
                self.unsaid.clear();
            }
        }
    }

    /// Mode `facts`: the factor of the step, now or never.
    fn say_once(&mut self, stamp: &Stamp, plan: &Plan) {
        let factors: Vec<Factor> = self.unsaid.values().copied().collect();
        let mut message = Message { factors, ..Message::default() };
        let room = self.room(stamp) - size_of(&message.factors) as f64;
        if message.factors.is_empty() || room < 0.0 {
            return;
        }
        message.plan = self.plan_for(stamp, plan, room);
        self.outbox.send(stamp, &message);
        self.unsaid.clear();
    }

    /// Mode `facts+repair`: own factors and those that others are missing, the worthiest first.
    fn say_and_repair(
        &mut self,
        stamp: &Stamp,
        set: &FactorSet,
        plan: &Plan,
        worth: &mut dyn FnMut(&Factor) -> f64,
    ) {
        let step = stamp.step;
        let Some(mut message) = self.frame(stamp, set, plan) else { return };
        let due =
            if step >= self.next_repair { self.repair.due(step, set) } else { Default::default() };
        if !due.is_empty() {
            self.next_repair = step.after(self.repair_period());
        }
        let again = due.iter().filter(|id| !self.unsaid.contains_key(id));
        let again = again.filter_map(|id| set.get(*id)).filter(|factor| factor.step <= step);
        let again: Vec<Factor> = again.copied().collect();
        message.factors = if self.outbox.budget.is_limited() {
            let parts = size_of(&message.held) + size_of(&message.plan);
            self.worthiest(step, again, self.room(stamp) - parts as f64, worth)
        } else {
            self.own_first(step, again, worth)
        };
        let is_due = step >= self.next_told;
        let is_empty = message.held.is_none() && message.plan.poses.is_empty();
        if message.factors.is_empty() && (is_empty || !is_due) {
            return;
        }
        if is_due || message.held.is_some() {
            self.next_told = step.after(self.repair_period());
        }
        self.outbox.send(stamp, &message);
        let is_own = |id: &FactorId| self.unsaid.contains_key(id);
        let said = message.factors.iter().map(|factor| factor.id);
        let (new, again): (Vec<FactorId>, Vec<FactorId>) = said.partition(is_own);
        new.iter().for_each(|id| {
            self.unsaid.remove(id);
        });
        self.repair.note(step, new.into_iter());
        self.repair.note_again(step, again.into_iter());
    }

    /// A message without factors: with what is held and the plan if it is time for them. `None` if nothing can be
    /// sent, or if it is time for them and they have to wait for their bytes.
    fn frame(&self, stamp: &Stamp, set: &FactorSet, plan: &Plan) -> Option<Message> {
        let budget = &self.outbox.budget;
        let plan = self.plan_for(stamp, plan, f64::INFINITY);
        let mut frame = Message { held: answer::told(set), plan, ..Message::default() };
        if !budget.is_limited() {
            return Some(frame);
        }
        let least = (self.outbox.envelope_bytes(stamp) + LENGTHS_BYTES + SMALL_FACTOR_BYTES) as f64;
        let need = |frame: &Message| least + (size_of(&frame.held) + size_of(&frame.plan)) as f64;
        if stamp.step < self.next_told || need(&frame) > budget.capacity() {
            frame.plan = Plan::default();
        }
        if stamp.step < self.next_told || need(&frame) > budget.capacity() {
            frame.held = None;
        }
        (need(&frame) <= budget.tokens()).then_some(frame)
    }

    /// Without a budget: own factors, and of those that others are missing the worthiest.
    fn own_first(
        &mut self,
        now: Step,
        mut again: Vec<Factor>,
        worth: &mut dyn FnMut(&Factor) -> f64,
    ) -> Vec<Factor> {
        let mut chosen: Vec<Factor> = self.unsaid.values().take(MAX_SAID).copied().collect();
        let left = MAX_SAID - chosen.len();
        if again.len() > left {
            let ranked = self.ratings.rank(now, again, worth);
            again = ranked.into_iter().take(left).map(|(_, factor)| factor).collect();
        }
        chosen.extend(again);
        chosen
    }

    /// With a budget: the worthiest of own factors and of those that others are missing, in `room` bytes.
    fn worthiest(
        &mut self,
        now: Step,
        again: Vec<Factor>,
        mut room: f64,
        worth: &mut dyn FnMut(&Factor) -> f64,
    ) -> Vec<Factor> {
        let candidates = self.unsaid.values().copied().chain(again).collect();
        let reserve = RESERVE * self.outbox.budget.capacity();
        let mut chosen = Vec::new();
        for (worth, factor) in self.ratings.rank(now, candidates, worth) {
            let left = room - size_of(&factor) as f64;
            let least = if worth > 0.0 { 0.0 } else { reserve };
            // A smaller one that is worth less must not take the bytes for which this one waits.
            if chosen.len() == MAX_SAID || left < least {
                break;
            }
            chosen.push(factor);
            room = left;
        }
        chosen
    }

    /// Mode `snapshot`: the newest belief, as soon as there are enough bytes for it.
    fn say_belief(&mut self, stamp: &Stamp, plan: &Plan, belief: Option<Tiles>) {
        let is_new = belief.is_some();
        if let Some(belief) = belief {
            let bytes = size_of(&belief);
            self.waiting = Some((belief, bytes));
        }
        let Some((belief, bytes)) = self.waiting.take() else { return };
        let plan = self.plan_for(stamp, plan, f64::INFINITY);
        if (bytes + size_of(&plan)) as f64 > self.room(stamp) {
            self.waiting = Some((belief, bytes));
            self.withheld += u64::from(is_new);
            return;
        }
        let message = Message { plan, belief: Some(belief), ..Message::default() };
        self.outbox.send(stamp, &message);
    }

    /// Bytes for the parts of a message.
    fn room(&self, stamp: &Stamp) -> f64 {
        let budget = &self.outbox.budget;
        budget.tokens() - (self.outbox.envelope_bytes(stamp) + LENGTHS_BYTES) as f64
    }

    /// As much of a plan as others accept, the budget allows and `room` bytes can hold.
    fn plan_for(&self, stamp: &Stamp, plan: &Plan, room: f64) -> Plan {
        let is_valid = |pose: &&_| validate::check_pose(&self.config, pose).is_ok();
        let valid = plan.poses.iter().take(MAX_PLAN).take_while(is_valid).count();
        let period_s = f64::from(self.repair_period()) * self.config.period_s;
        let share = PLAN_SHARE * period_s * self.outbox.budget.rate();
        let share = if self.outbox.budget.is_limited() { share } else { f64::INFINITY };
        let plan = plan.first_poses(valid.min((room.min(share) / POSE_BYTES as f64) as usize));
        let checked = validate::check_plan(&self.config, stamp.step, &plan);
        checked.map_or_else(|_| Plan::default(), |()| plan)
    }

    fn repair_period(&self) -> u32 {
        self.config.steps(self.config.exchange.repair_period_s).max(1)
    }

    /// Everything that the agent may tell one that joins late: in modes with factors the factors held, the newest
    /// of them if they are too many for a message; in mode `snapshot` the belief. `None` if there is nothing.
    pub fn answer(
        &mut self,
        stamp: &Stamp,
        set: &FactorSet,
        belief: Option<Tiles>,
    ) -> Option<Transmit> {
        let message = answer::message(&self.config, stamp.step, set, belief)?;
        Some(self.outbox.answer(stamp, &message))
    }

    /// Checks a message that arrived at step `now`, and remembers what its sender holds. Factors that were forged in
    /// the name of this agent are dropped; others believed and relayed them, so the rest of the message is believed.
    ///
    /// # Errors
    /// Why it is not believed; then nothing has changed.
    pub fn receive(&mut self, now: Step, bytes: &[u8]) -> Result<Received, Rejection> {
        let envelope = Envelope::decode(bytes)?;
        let Message { held, mut factors, plan, belief } =
            validate::check(&self.config, now, &envelope)?;
        let Envelope { src: from, incarnation, step, pose, .. } = envelope;
        let known = self.repair.incarnation(from).unwrap_or_default();
        if incarnation < known && !is_on(Mutant::OldLivesBelieved) {
            return Err(Rejection::Incarnation { got: incarnation.0, known: known.0 });
        }
        let mut dropped = Vec::new();
        factors.retain(|factor| {
            let checked = validate::check_own(&self.config, self.stated, factor);
            checked.map_err(|forged| dropped.push(forged)).is_ok()
        });
        self.repair.hear(now, from, incarnation, step, held);
        self.repair.note(now, factors.iter().map(|factor| factor.id));
        let pose = pose.into();
        Ok(Received { from, incarnation, step, pose, factors, dropped, plan, belief })
    }

    /// The next message to send.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        self.outbox.pop()
    }

    /// How many factors this incarnation stated.
    pub fn stated(&self) -> u32 {
        self.stated
    }

    /// How many steps had a factor, or a belief, that was not sent at once because the budget was too small.
    pub fn withheld(&self) -> u64 {
        self.withheld
    }
}

#[cfg(test)]
mod tests;
