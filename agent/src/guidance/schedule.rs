//! When each UAV plans, and with which plans of the other UAVs (thesis §5.3.2).
//!
//! A decision is due every T_MPC. Within it each UAV plans once, or twice with a loopback, and sends
//! each plan. The sequential schedules wait for the plans that a pass builds on, up to a deadline:
//! UAV i of N stops waiting in pass p at a share (p·N + i + 1)/(passes·N) of `plan_timeout_s` after
//! the start of the decision. The deadlines have the order of planning, so the order holds even if no
//! plan arrives, and a plan that is late by one slot still arrives in time. A UAV does not wait again
//! for another UAV that missed a deadline until it receives a plan of it: a UAV that failed causes
//! one delay, not one per decision.
//!
//! The horizon of `str4` and `str5` is so long that the rest of the plans of the last decision serves as the
//! first pass of the loopback: each UAV plans once, sends one plan and accounts for all other UAVs.
//!
//! A ground station receives plans and makes none, and no agent waits for a plan of it.
//!
//! [`Scheduler`] has no clock: the time is an argument.

use csat_proto::camera::Pose;
use csat_proto::grid_pose::GridPose;
use csat_proto::ids::AgentId;
use csat_proto::message::{Plan, RelayedPlan};
use csat_proto::time::{SimTime, Step};

use super::rollout::{Motion, ViewOverlap};
use crate::config::{AgentConfig, Schedule};

/// A planning pass that may begin now.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// The step of the decision, which the plan states.
    pub step: Step,
    /// 0, or 1 in the loopback.
    pub pass: u8,
    /// The other UAVs to account for, by increasing index.
    pub neighbours: Vec<AgentId>,
    /// Their poses at the ends of the N_MPC blocks from this decision on, in the same order.
    pub poses: Vec<Vec<Pose>>,
    /// How many decisions ago each of these plans was made, in the same order.
    pub ages: Vec<u32>,
    /// With far-sighted plans, the UAVs of which no plan counts any more, by increasing index. Before its third decision
    /// an agent calls nobody silent.
    pub silent: Vec<AgentId>,
}

/// Why a plan was rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The sender is not another UAV.
    #[error("plan of agent {from}, which is not another UAV than {own} in a fleet of {count}")]
    NotANeighbour {
        /// The sender.
        from: AgentId,
        /// This agent.
        own: AgentId,
        /// N^u.
        count: u16,
    },
    /// There is no decision at its step, or the decision is too far ahead.
    #[error("plan for step {got}: decisions are every {steps} steps and step {max} is the latest")]
    NoSuchDecision {
        /// The plan's step.
        got: Step,
        /// Steps between decisions.
        steps: u32,
        /// The latest step a plan may be for.
        max: Step,
    },
    /// The schedule has no such pass.
    #[error("plan of pass {got}: there are {passes}")]
    NoSuchPass {
        /// The plan's pass.
        got: u8,
        /// Passes of the schedule.
        passes: u8,
    },
    /// No pose, or more poses than the longest horizon.
    #[error("plan of {got} poses: expected 1 to 255")]
    Poses {
        /// Number of poses.
        got: usize,
    },
}

/// A plan is recent if it is at most this many decisions old. Unless contact is predicted, a far-sighted plan counts no
/// longer: a UAV whose messages do not arrive does not tell what it sees either, so ground that is left to it for a minute
/// stays unexplored.
pub(super) const RECENT_DECISIONS: u32 = 2;

/// The plans of another UAV.
#[derive(Debug, Clone, Default)]
struct Neighbour {
    /// Its last plan.
    latest: Option<Plan>,
    /// Its last plan of an earlier decision than `latest`.
    earlier: Option<Plan>,
    /// It missed a deadline, and no plan of it arrived since.
    has_missed: bool,
    /// Its last plan arrived while plans of that decision were still waited for.
    is_prompt: bool,
    /// The step of its last plan that was passed on.
    relayed: Option<Step>,
}

impl Neighbour {
    /// Keeps a plan if it is the newest one, or the newest one of an earlier decision.
    fn keep(&mut self, plan: &Plan, is_prompt: bool) {
        let age = |known: &Option<Plan>| known.as_ref().map(|known| (known.step, known.pass));
        let stamp = Some((plan.step, plan.pass));
        if stamp > age(&self.latest) {
            self.is_prompt = is_prompt;
            let previous = self.latest.replace(plan.clone());
            if previous.as_ref().is_some_and(|previous| previous.step < plan.step) {
                self.earlier = previous;
            }
        } else if stamp > age(&self.earlier)
            && self.latest.as_ref().is_some_and(|latest| plan.step < latest.step)
        {
            self.earlier = Some(plan.clone());
        }
    }
}

/// The stage of the current decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DecisionStage {
    /// No plan is due until the next decision.
    Idle,
    /// This pass is due, once all plans that it waits for have arrived.
    Pass(u8),
}

/// The schedule of one agent.
#[derive(Debug, Clone)]
pub struct Scheduler {
    /// The own index; that of a station is beyond the fleet.
    own: usize,
    schedule: Schedule,
    motion: Motion,
    blocks: usize,
    steps_per_block: u32,
    period_s: f64,
    timeout_s: f64,
    /// Whether the horizon is so long that the plans of the last decision serve as a first pass.
    far_sighted: bool,
    /// For how many decisions a far-sighted plan counts.
    lasts: u32,
    overlap: ViewOverlap,
    passes: u8,
    /// By index; the own entry stays empty.
    fleet: Vec<Neighbour>,
    start: SimTime,
    /// The step of the first decision.
    first: Option<Step>,
    /// The step of the current decision.
    step: Step,
    /// The step of the last frame. An agent that starts during a mission has no decision yet.
    frame: Step,
    stage: DecisionStage,
}

impl Scheduler {
    /// The schedule of `config.guidance`, before its first decision.
    pub fn new(config: &AgentConfig) -> Self {
        let guidance = &config.guidance;
        let uavs = config.fleet.count;
        let count =
            if config.is_station() { uavs } else { uavs.max(config.id.0.saturating_add(1)) };
        let count = usize::from(count);
        let far_sighted = guidance.criterion.is_far_sighted();
        let loopback = guidance.schedule == Schedule::SequentialLoopback && count > 1;
        Self {
            own: usize::from(config.id.0),
            schedule: guidance.schedule,
            motion: Motion::new(config),
            blocks: guidance.blocks(),
            steps_per_block: (guidance.period_s / config.period_s).round().max(1.0) as u32,
            period_s: config.period_s,
            // A decision that takes longer than its block would never be flown.
            timeout_s: guidance.plan_timeout_s.clamp(0.0, 0.99 * guidance.period_s),
            far_sighted,
            lasts: if config.predicts_contact() {
                guidance.blocks() as u32
            } else {
                RECENT_DECISIONS
            },
            overlap: ViewOverlap::new(config),
            passes: if loopback && !far_sighted { 2 } else { 1 },
            fleet: vec![Neighbour::default(); count],
            start: SimTime(0),
            first: None,
            step: Step(0),
            frame: Step(0),
            stage: DecisionStage::Idle,
        }
    }

    /// Whether a decision is due at a step: every T_MPC, from t = 0 on.
    pub fn decides_at(&self, step: Step) -> bool {
        step.0.is_multiple_of(self.steps_per_block)
    }

    /// A frame arrived; every T_MPC a decision begins with it.
    pub fn on_frame(&mut self, now: SimTime, step: Step) {
        self.frame = step;
        if self.own < self.fleet.len() && self.decides_at(step) {
            self.on_instant(now);
        }
    }

    /// Begins a decision and drops the rest of the decision before.
    pub fn on_instant(&mut self, now: SimTime) {
        self.start = now;
        self.step = Step((now.seconds() / self.period_s).round() as u32);
        self.first.get_or_insert(self.step);
        self.stage = DecisionStage::Pass(0);
    }

    /// A plan of another UAV arrives now. Plans may be of any decision, arrive in any order, and be
    /// repeated.
    ///
    /// # Errors
    /// Why it was rejected; then nothing has changed.
    pub fn on_plan(&mut self, now: SimTime, from: AgentId, plan: &Plan) -> Result<(), PlanError> {
        self.check(from, plan)?;
        let waited_s = f64::from(plan.step.0) * self.period_s + self.timeout_s;
        let is_prompt = now <= SimTime(0).after(waited_s);
        let neighbour = &mut self.fleet[usize::from(from.0)];
        neighbour.has_missed = false;
        neighbour.keep(plan, is_prompt);
        Ok(())
    }

    /// Plans of other UAVs arrive that another one passed on. They are not waited for. UAVs that hear of each other through
    /// a third one account for each other, whoever plans first; not under the asynchronous schedule.
    ///
    /// # Errors
    /// Why the first wrong one was rejected; then nothing has changed.
    pub fn on_relayed(&mut self, plans: &[RelayedPlan]) -> Result<(), PlanError> {
        plans.iter().try_for_each(|RelayedPlan { uav, plan }| self.check(*uav, plan))?;
        for RelayedPlan { uav, plan } in plans {
            self.fleet[usize::from(uav.0)].keep(plan, true);
        }
        Ok(())
    }

    /// The plans to pass on from the pose `own`, by increasing UAV: each recent one once, of UAVs whose views may overlap
    /// the own ones.
    pub fn plans_to_relay(&mut self, own: &Pose) -> Vec<RelayedPlan> {
        let oldest =
            self.step.0.saturating_sub(self.steps_per_block.saturating_mul(RECENT_DECISIONS));
        let overlap = self.overlap;
        let is_of_interest = |plan: &&Plan| {
            let may_overlap = |pose: &GridPose| overlap.may_see_the_same(own, &Pose::from(*pose));
            plan.step.0 >= oldest && plan.poses.first().is_some_and(may_overlap)
        };
        let relay = |(index, neighbour): (usize, &mut Neighbour)| {
            let plan = neighbour.latest.as_ref().filter(is_of_interest)?.clone();
            let is_new = neighbour.relayed < Some(plan.step);
            neighbour.relayed = Some(plan.step);
            is_new.then_some(RelayedPlan { uav: AgentId(index as u16), plan })
        };
        self.fleet.iter_mut().enumerate().filter_map(relay).collect()
    }

    /// Forgets the plans of another UAV, and waits for none of it.
    pub fn forget(&mut self, uav: AgentId) {
        if let Some(neighbour) = self.fleet.get_mut(usize::from(uav.0)) {
            *neighbour = Neighbour { has_missed: true, ..Neighbour::default() };
        }
    }

    /// Checks a plan. A plan from the far future would otherwise displace all later plans.
    fn check(&self, from: AgentId, plan: &Plan) -> Result<(), PlanError> {
        let index = usize::from(from.0);
        if index == self.own || index >= self.fleet.len() {
            let own = AgentId(self.own as u16);
            return Err(PlanError::NotANeighbour { from, own, count: self.fleet.len() as u16 });
        }
        // The sender may have begun the next decision before this agent did.
        let max = Step(self.step.max(self.frame).0.saturating_add(self.steps_per_block));
        if plan.step > max || !self.decides_at(plan.step) {
            let steps = self.steps_per_block;
            return Err(PlanError::NoSuchDecision { got: plan.step, steps, max });
        }
        if plan.pass >= self.passes {
            return Err(PlanError::NoSuchPass { got: plan.pass, passes: self.passes });
        }
        if !(1..=255).contains(&plan.poses.len()) {
            return Err(PlanError::Poses { got: plan.poses.len() });
        }
        Ok(())
    }

    /// The own plan of a pass was made and sent. True when it was the last pass, whose first
    /// increment is the command. A plan of a pass other than the current one changes nothing.
    pub fn on_own_plan(&mut self, plan: &Plan) -> bool {
        if plan.step != self.step || self.stage != DecisionStage::Pass(plan.pass) {
            return false;
        }
        let last = plan.pass + 1 >= self.passes;
        self.stage = if last { DecisionStage::Idle } else { DecisionStage::Pass(plan.pass + 1) };
        last
    }

    /// The time is `now`: at the deadline the agent stops waiting for the plans that did not arrive.
    pub fn on_timeout(&mut self, now: SimTime) {
        if self.next_deadline().is_some_and(|deadline| deadline <= now) {
            let awaited: Vec<usize> = self.awaited().collect();
            awaited.into_iter().for_each(|index| self.fleet[index].has_missed = true);
        }
    }

    /// When to call [`Self::on_timeout`]: the deadline of the current wait; `None` when it waits for
    /// no plan.
    pub fn next_deadline(&self) -> Option<SimTime> {
        let DecisionStage::Pass(pass) = self.stage else { return None };
        self.awaited().next()?;
        let count = self.fleet.len();
        let slot = (usize::from(pass) * count + self.own + 1) as f64;
        let slots = (usize::from(self.passes) * count) as f64;
        Some(self.start.after(self.timeout_s * slot / slots))
    }

    /// The pass this agent may plan now.
    pub fn ready(&self) -> Option<Pass> {
        let DecisionStage::Pass(pass) = self.stage else { return None };
        if self.awaited().next().is_some() {
            return None;
        }
        let (mut neighbours, mut poses, mut ages) = (Vec::new(), Vec::new(), Vec::new());
        let mut silent = Vec::new();
        for index in self.accounted_for(pass) {
            let id = AgentId(index as u16);
            if let Some(plan) = self.known_plan(index) {
                if !self.gives_way(index) {
                    continue;
                }
                let elapsed = (self.step.0 - plan.step.0) / self.steps_per_block;
                neighbours.push(id);
                let planned: Vec<Pose> = plan.poses.iter().copied().map(Pose::from).collect();
                poses.push(self.motion.forecast(&planned, elapsed as usize, self.blocks));
                ages.push(elapsed);
            } else if self.far_sighted && self.has_decided_often() {
                silent.push(id);
            }
        }
        Some(Pass { step: self.step, pass, neighbours, poses, ages, silent })
    }

    /// The UAVs whose plans the current pass builds on and waits for.
    fn awaited(&self) -> impl Iterator<Item = usize> + '_ {
        let pass = match (self.stage, self.schedule) {
            (DecisionStage::Idle, _) | (_, Schedule::Asynchronous) => None,
            (DecisionStage::Pass(pass), _) => Some(pass),
        };
        pass.into_iter()
            .flat_map(|pass| self.built_on(pass).map(move |index| (pass, index)))
            .filter_map(|(pass, index)| {
                // In the loopback, UAVs before this one have planned again, UAVs after it have not yet.
                let needed = if index < self.own { pass } else { 0 };
                let neighbour = &self.fleet[index];
                let said = neighbour.latest.as_ref().map(|plan| (plan.step, plan.pass));
                let missing = said < Some((self.step, needed));
                (missing && !neighbour.has_missed).then_some(index)
            })
    }

    /// The UAVs on whose plans of this decision a pass builds: in the first sequential pass those
    /// before this agent.
    fn built_on(&self, pass: u8) -> impl Iterator<Item = usize> + use<> {
        self.others(self.reach(pass))
    }

    /// One past the last UAV on whose plans a pass builds.
    fn reach(&self, pass: u8) -> usize {
        let all = pass > 0 || self.schedule == Schedule::Asynchronous;
        if all { self.fleet.len() } else { self.own }
    }

    /// Whether plans of a UAV may change those of this one. With far-sighted plans a UAV accounts for the last plan of one
    /// with a higher number, which in turn accounts for the new plan. If messages take longer than plans are waited for, or
    /// nobody waits, the other one cannot: both would leave the same ground to each other, and at the next decision both
    /// would fly to it. Then only the one with the higher number gives way.
    fn gives_way(&self, index: usize) -> bool {
        let is_heard_in_time =
            self.schedule != Schedule::Asynchronous && self.fleet[index].is_prompt;
        !self.far_sighted || index < self.own || is_heard_in_time
    }

    /// The UAVs that a pass accounts for: with far-sighted plans of the last decision also those
    /// after it.
    fn accounted_for(&self, pass: u8) -> impl Iterator<Item = usize> + use<> {
        self.others(if self.far_sighted { self.fleet.len() } else { self.reach(pass) })
    }

    fn others(&self, end: usize) -> impl Iterator<Item = usize> + use<> {
        let own = self.own;
        (0..end).filter(move |&index| index != own)
    }

    /// Whether there was time for a plan to arrive since the first decision of this agent.
    fn has_decided_often(&self) -> bool {
        let decisions = self.steps_per_block.saturating_mul(RECENT_DECISIONS);
        self.first.is_some_and(|first| first.after(decisions) <= self.step)
    }

    /// For how many steps a far-sighted plan counts.
    fn lasts(&self) -> u32 {
        self.steps_per_block.saturating_mul(self.lasts)
    }

    /// The newest usable plan of another UAV: none of a later decision, and in the asynchronous
    /// schedule none of this decision, so that the order of the agents within an instant does not
    /// matter.
    fn known_plan(&self, index: usize) -> Option<&Plan> {
        let neighbour = &self.fleet[index];
        let oldest = if self.far_sighted { self.step.0.saturating_sub(self.lasts()) } else { 0 };
        let usable = |plan: &&Plan| match self.schedule {
            _ if plan.step.0 < oldest => false,
            Schedule::Asynchronous => plan.step < self.step,
            Schedule::Sequential | Schedule::SequentialLoopback => plan.step <= self.step,
        };
        let known = [&neighbour.latest, &neighbour.earlier];
        known.into_iter().flatten().find(usable)
    }
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
