//! The sans-I/O agent of the set-membership mission: frames and messages in, messages and commands
//! out.
//!
//! Within a step the agent measures its frame, if it has a camera, and sends what the frame proved at
//! once. In [`handle_timeout`](csat_proto::agent::Agent::handle_timeout) it applies the frame
//! together with all facts that arrived, and every T_MPC guidance decides. All evidence of a step is
//! applied together and in one order, so the same evidence makes the same sets in every agent.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::{Pose, PoseError};
use csat_proto::command::Command;
use csat_proto::envelope::Envelope;
use csat_proto::frame::Frame;
use csat_proto::grid_pose::GridPose;
use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::message::{Digest, Fact, Plan, Relay};
use csat_proto::radio::Reception;
use csat_proto::raster::Raster;
use csat_proto::time::{SimTime, Step};
use tracing::info_span;

use crate::config::{AgentConfig, Criterion, ExchangeMode};
use crate::estimate::evidence::ReceivedFact;
use crate::estimate::state::Knowledge;
use crate::estimate::{Changes, Estimator};
use crate::exchange::receiver::{CheckedMessage, Received, Receiver};
use crate::exchange::repair::Repair;
use crate::exchange::transmitter::{SentFact, StepContent, Transmitter};
use crate::exchange::validate::Rejection;
use crate::exchange::version_vector::VersionVector;
use crate::guidance::airspace::{Airspace, WayOut};
use crate::guidance::schedule::{Pass, Scheduler};
use crate::guidance::{Decision, PlanError, Planner, PlannerInput};
use crate::identity::Identity;
use crate::mutant::{Mutant, is_on};
use crate::sense::{Measured, Sensor};
use crate::settled::SettledKnowledge;
use crate::shared_cache::SharedCache;
use own_frame::OwnFrame;

mod drop_reason;
mod event;
mod own_frame;
mod timer;

pub use drop_reason::DropReason;
pub use event::Event;
pub use timer::Timer;

/// Metres. A box about a fix is as wide as the bound of the fix but for less than this.
const MILLIMETRE: f64 = 1e-3;

/// One UAV or ground station of the set-membership mission.
#[derive(Debug, Clone)]
pub struct SetMembershipAgent {
    config: AgentConfig,
    cache: Arc<SharedCache>,
    sensor: Sensor,
    estimator: Estimator,
    planner: Planner,
    /// The free airspace; `None` where all buildings are below the flights.
    airspace: Option<Airspace>,
    scheduler: Scheduler,
    knowledge: Arc<SettledKnowledge>,
    /// The facts that the knowledge contains.
    version_vector: VersionVector,
    receiver: Receiver,
    transmitter: Transmitter,
    repair: Repair,
    pose: Pose,
    /// The half-widths of the box of `pose`.
    pose_error: PoseError,
    /// The poses of the last decision (5.35).
    planned: Vec<Pose>,
    /// The heading of the last command, which the vehicle flies or turns to.
    commanded_yaw_rad: Option<f64>,
    own_frame: OwnFrame,
    /// Of each other UAV.
    last_heard: BTreeMap<AgentId, LastHeard>,
    rejected: BTreeMap<&'static str, u64>,
    /// The reasons that were reported, with the senders of the messages.
    reported: BTreeSet<(&'static str, Option<AgentId>)>,
    commands: VecDeque<Command>,
    events: VecDeque<Event>,
    now: SimTime,
    /// Whether a plan of another UAV arrived since the last [`Agent::handle_timeout`].
    plan_arrived: bool,
}

/// The newest fact that was heard of another UAV.
#[derive(Debug, Clone)]
struct LastHeard {
    step: Step,
    /// Where the UAV was when it sent it, `world`, metres.
    at: [f64; 2],
    /// The fact, where guidance reads its hidden ground: a fact has two rasters.
    fact: Option<Arc<Fact>>,
}

impl SetMembershipAgent {
    /// An agent without knowledge, which shares no results with other agents.
    pub fn new(config: &AgentConfig) -> Self {
        Self::with_cache(config, Arc::default())
    }

    /// An agent without knowledge, one of several in a process that share `cache`. The configurations
    /// of these agents must not differ except in `id` and `incarnation`.
    pub fn with_cache(config: &AgentConfig, cache: Arc<SharedCache>) -> Self {
        Self {
            sensor: Sensor::new(config),
            estimator: Estimator::with_memo(config, cache.memo()),
            planner: Planner::new(config),
            airspace: Airspace::new(config),
            scheduler: Scheduler::new(config),
            knowledge: Arc::new(SettledKnowledge::new(
                Knowledge::at_start(config),
                Self::first_lineage(config),
            )),
            version_vector: VersionVector::new(config),
            receiver: Receiver::new(config),
            cache,
            transmitter: Transmitter::new(config),
            repair: Repair::new(config),
            own_frame: OwnFrame::default(),
            pose: Pose::default(),
            pose_error: PoseError::NONE,
            planned: Vec::new(),
            commanded_yaw_rad: None,
            last_heard: BTreeMap::new(),
            rejected: BTreeMap::new(),
            reported: BTreeSet::new(),
            commands: VecDeque::new(),
            events: VecDeque::new(),
            now: SimTime(0),
            plan_arrived: false,
            config: config.clone(),
        }
    }

    /// The configuration.
    pub fn config(&self) -> &AgentConfig {
        &self.config
    }

    /// What the agent knows.
    pub fn knowledge(&self) -> &SettledKnowledge {
        &self.knowledge
    }

    /// What its last frame proved; `None` before the first one, and of a ground station.
    pub fn measured(&self) -> Option<&Measured> {
        self.own_frame.measured().filter(|_| !self.config.is_station())
    }

    /// The age of information: the age of the newest frame of another UAV of which this agent
    /// received a fact from that UAV, mean over the other UAVs, seconds. For a UAV from which no fact
    /// arrived it is the age of the mission. Named liars are left out. `None` without other UAVs.
    ///
    /// # References
    /// S. Kaul, R. Yates, M. Gruteser, *Real-time status: how often should one update?*, INFOCOM 2012.
    pub fn news_age_s(&self) -> Option<f64> {
        let is_other =
            |id: &AgentId| *id != self.config.id && !self.liars().any(|liar| liar == *id);
        let others = (0..self.config.fleet.count).map(AgentId).filter(is_other);
        let now = self.knowledge.step.0;
        let age = |id| now.saturating_sub(self.last_heard.get(&id).map_or(0, |last| last.step.0));
        let ages: Vec<f64> = others.map(|id| f64::from(age(id)) * self.config.period_s).collect();
        (!ages.is_empty()).then(|| ages.iter().sum::<f64>() / ages.len() as f64)
    }

    /// The pose of its last frame, or of its last step if it has no camera.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// The half-widths of the box about that pose that contains the true one; all 0 where it is exact.
    pub fn pose_error(&self) -> &PoseError {
        &self.pose_error
    }

    /// The poses that it plans at the ends of the blocks of T_MPC; empty before its first decision.
    pub fn planned(&self) -> &[Pose] {
        &self.planned
    }

    /// How many messages and own frames were dropped, by reason.
    pub fn rejected(&self) -> &BTreeMap<&'static str, u64> {
        &self.rejected
    }

    /// The agents that it has proven to have said something false, itself included, where
    /// [`ExchangeConfig::liars`](crate::config::ExchangeConfig::liars) is above 0.
    pub fn liars(&self) -> impl Iterator<Item = AgentId> + '_ {
        self.knowledge.liars()
    }

    /// How many steps it sent no fact of because none fitted its budget or was worth its bytes.
    pub fn withheld(&self) -> u64 {
        self.transmitter.withheld()
    }

    /// H^OEM(x^u) ∩ F(x^u) at the pose of the last frame, for (5.45); empty without a camera.
    pub fn predicted_hidden(&mut self) -> Raster {
        if self.config.is_station() {
            return Raster::empty(self.config.raster_grid());
        }
        let Self { planner, knowledge, pose, .. } = self;
        planner.predicted_hidden(&knowledge.oem, Some(knowledge.view_cache()), pose)
    }

    /// When the agent next wants [`Agent::handle_timeout`], and why; `None` if it waits for nothing.
    pub fn next_timer(&self) -> Option<(SimTime, Timer)> {
        if self.own_frame.pending().is_some() {
            Some((self.now, Timer::OwnFrame))
        } else if self.plan_arrived {
            Some((self.now, Timer::PlanArrived))
        } else {
            self.scheduler.next_deadline().map(|at| (at, Timer::PlanDeadline))
        }
    }

    /// The step of the last frame.
    fn step(&self) -> Step {
        self.own_frame.pending().map_or(self.knowledge.step, |(step, _)| step)
    }

    /// Applies the own frame, if it is not applied yet, and all facts that arrived.
    fn update(&mut self) {
        let step = self.step();
        if self.own_frame.pending().is_none() && !self.receiver.has_due(step) {
            return;
        }
        let heard = self.receiver.take_due(step);
        if self.own_frame.pending_said().is_some() {
            let number = self.transmitter.facts_said() - 1;
            self.version_vector.apply(self.config.id, self.config.incarnation, number);
        }
        for h in &heard {
            // The fact whose number an answer has is among those that the answer lists.
            if !h.is_answer {
                self.version_vector.apply(h.src, h.incarnation, h.fact.number);
            }
            if h.known.is_some() || is_on(Mutant::ClaimsWhatOthersHold) {
                self.adopt(h);
            }
            self.repair.hear(step, h.src, h.incarnation, h.fact.step, &h.fact.held);
        }
        let own = self.own_frame.pending();
        let lineage = self.lineage(&heard);
        let (knowledge, changes) = self.cache.updated(step, lineage, || {
            let mut knowledge = Knowledge::clone(&self.knowledge);
            let changes = self.estimator.update(&mut knowledge, own, heard.clone());
            (knowledge, changes)
        });
        self.knowledge = knowledge;
        self.own_frame.set_applied();
        changes.liars.iter().for_each(|&liar| self.ignore(liar));
        self.report(&changes);
    }

    /// Notes which facts a snapshot contains, as far as it counts for them.
    fn adopt(&mut self, heard: &ReceivedFact) {
        let facts = &heard.fact.held.facts;
        match self.config.exchange.liars {
            0 => {
                self.version_vector.adopt(facts);
                self.repair.snapshot_heard(self.step());
            }
            // The facts of other agents are still missing: each agent resends its own.
            _ => self.version_vector.adopt_own(heard.src, heard.incarnation, facts),
        }
    }

    /// Believes nothing of an agent any more.
    fn ignore(&mut self, liar: AgentId) {
        self.receiver.ignore(liar);
        self.scheduler.forget(liar);
        self.last_heard.remove(&liar);
    }

    /// The lineage of the knowledge at the start. Where some agents may lie, what an agent knows
    /// depends on which of the frames are its own, so that no two lineages are equal.
    fn first_lineage(config: &AgentConfig) -> Identity {
        match config.exchange.liars {
            0 => Identity::default(),
            _ => Identity::of_all([config.id.0.into(), config.incarnation.0.into()]),
        }
    }

    /// The lineage of the knowledge after an update with the own frame and the received facts.
    ///
    /// A frame that was told in full stands for the same evidence in its sender as in the receivers
    /// of the fact, unless clocks may differ.
    fn lineage(&self, heard: &[ReceivedFact]) -> Identity {
        let AgentConfig { id, incarnation, exchange, .. } = &self.config;
        let told = |said: &SentFact| said.in_full && exchange.clock_skew_s == 0.0;
        let step = self.own_frame.pending().map(|(step, _)| step);
        let own = step.and_then(|step| match self.own_frame.pending_said().filter(told) {
            Some(said) => Some(said.identity),
            // The step of a station proves nothing.
            None if self.config.is_station() => None,
            None => Some(Identity::of_all([id.0.into(), incarnation.0.into(), step.0.into()])),
        });
        let mut news: Vec<Identity> =
            own.into_iter().chain(heard.iter().map(|h| h.identity)).collect();
        news.sort_unstable();
        let frame = step.map_or(0, |step| u128::from(step.0) + 1);
        let news = news.into_iter().map(Identity::bits);
        Identity::of_all([self.knowledge.lineage().bits(), frame].into_iter().chain(news))
    }

    fn report(&mut self, changes: &Changes) {
        let step = self.knowledge.step;
        let own =
            self.own_frame.measured().into_iter().flat_map(|m| &m.targets).map(|seen| seen.target);
        let own: Vec<TargetId> = own.collect();
        let identified = changes.identified.iter().map(|&target| Event::Identified {
            step,
            target,
            by_others: !own.contains(&target),
        });
        let inconsistent =
            changes.inconsistent.iter().map(|&target| Event::Inconsistent { step, target });
        let liars = changes.liars.iter().map(|&liar| Event::Liar { step, liar });
        self.events.extend(identified.chain(inconsistent).chain(liars));
    }

    /// The last known positions of UAVs.
    fn fleet(&self) -> Vec<[f64; 2]> {
        let own = [self.pose.p_world[0], self.pose.p_world[1]];
        let own = (!self.config.is_station()).then_some(own);
        own.into_iter().chain(self.last_heard.values().map(|last| last.at)).collect()
    }

    /// The agent that sent a message; `None` for an invalid sender, of which there may be any number.
    fn sender_of(&self, bytes: &[u8]) -> Option<AgentId> {
        let sender = Envelope::decode(bytes).ok()?.src;
        (sender.0 < self.config.agents()).then_some(sender)
    }

    /// Checks a message, unless another agent of the process did already, and keeps its facts.
    fn receive(&mut self, bytes: &[u8]) -> Result<Received, Rejection> {
        let (now, config) = (self.step(), &self.config);
        let identity = Identity::of(bytes);
        let check = || CheckedMessage::decode(config, now, identity, bytes);
        let message = self.cache.message(now, identity, check)?;
        self.receiver.receive(&message, &self.version_vector)
    }

    fn reject(&mut self, from: Option<AgentId>, dropped: &DropReason) {
        let reason = dropped.name();
        *self.rejected.entry(reason).or_default() += 1;
        if self.reported.insert((reason, from)) {
            let (step, detail) = (self.knowledge.step, dropped.to_string());
            // Links that damage messages cause many of these; the terminal shows only their sum at
            // the end.
            tracing::info!(agent = %self.config.id, ?from, reason, detail, "dropped");
            self.events.push_back(Event::Rejected { step, from, reason: reason.into(), detail });
        }
    }

    /// Begins a step at `pose`: measures its frame with `measure` and sends what it proved.
    fn begin(
        &mut self,
        now: SimTime,
        step: Step,
        pose: Pose,
        measure: impl FnOnce(&mut Sensor) -> Measured,
    ) {
        self.now = now;
        let last = self.step();
        if self.own_frame.measured().is_some() && step <= last {
            // The frame shows the past, and would be applied to the present.
            return self.reject(None, &DropReason::OldFrame { got: step.0, last: last.0 });
        }
        self.pose = pose;
        // A frame that is still pending had no timeout: the driver is late.
        self.update();
        let measured = measure(&mut self.sensor);
        let held = match self.config.exchange.mode {
            ExchangeMode::FactsRepair => {
                let map = self.knowledge.block_hashes();
                self.repair.hold(step, self.version_vector.facts(), map)
            }
            _ => Digest::default(),
        };
        let content = StepContent {
            now,
            step,
            pose,
            measured: &measured,
            changed: self.knowledge.oem.changes(&measured.oem),
            knowledge: &self.knowledge,
            unexplored_cells: self.knowledge.unexplored_cells(),
            held,
            uavs: self.fleet(),
        };
        let said = self.transmitter.say_step(&content, &mut self.repair);
        self.own_frame = OwnFrame::new(step, measured, said);
        self.scheduler.on_frame(now, step);
    }

    /// One pass of guidance: plans, sends the plan, and after the last pass commands the vehicle.
    fn decide(&mut self, pass: Pass) {
        let yaw_rad = self.commanded_yaw_rad.unwrap_or(self.pose.yaw_rad);
        let (decision, way_out) = info_span!("guidance").in_scope(|| self.plan(&pass, yaw_rad));
        let turn_rad = decision.increments_rad.first().copied().unwrap_or_default();
        self.planned.clone_from(&decision.poses);
        let poses = decision.poses.into_iter().map(GridPose::from).collect();
        let plan = Plan { step: pass.step, pass: pass.pass, poses };
        let last = self.scheduler.on_own_plan(&plan);
        if self.config.exchange.mode != ExchangeMode::None {
            self.transmitter.say_plan(self.now, self.pose, plan);
            self.relay_plans(pass.step);
        }
        if last {
            let is_lost = self.airspace.as_mut().is_some_and(|air| air.fly(pass.step, way_out));
            self.events.extend(is_lost.then_some(Event::NoWayOut { step: pass.step }));
            let yaw_rad = yaw_rad + turn_rad;
            self.commanded_yaw_rad = Some(yaw_rad);
            self.commands.push_back(Command::Yaw { yaw_rad });
        }
    }

    /// Believes a sender whose plans the scheduler has taken, and rejects the others.
    fn believe_plans(
        &mut self,
        from: AgentId,
        incarnation: Incarnation,
        taken: Result<(), PlanError>,
    ) {
        match taken {
            Ok(()) => {
                self.receiver.believe(from, incarnation);
                // No decision of a station waits for it.
                self.plan_arrived |= !self.config.is_station();
            }
            Err(error) => self.reject(Some(from), &error.into()),
        }
    }

    /// Passes on the plans that arrived since the last decision, unless the budget is used up.
    fn relay_plans(&mut self, step: Step) {
        if self.config.relays_plans() && self.transmitter.has_credit() {
            let plans = self.scheduler.plans_to_relay(&self.pose);
            if !plans.is_empty() {
                self.transmitter.relay_plans(self.now, self.pose, Relay { step, plans });
            }
        }
    }

    /// The decision from the current pose with the heading `yaw_rad`, and the way out behind its
    /// first block.
    fn plan(&mut self, pass: &Pass, yaw_rad: f64) -> (Decision, Option<WayOut>) {
        let pose = Pose { yaw_rad, ..self.pose };
        let expected = expected_pose_error(&self.config.pose_error, &self.pose_error);
        let is_shared = expected == self.config.pose_error;
        let oem = &self.knowledge.oem;
        let ways = self.airspace.as_ref().map(|air| air.ways(&pose, oem, pass.step));
        if let Some(ways) = ways.as_ref().filter(|ways| !ways.is_any_safe()) {
            return (ways.retreat(), ways.behind_retreat());
        }
        let rasters = self.knowledge.planner_rasters();
        let nothing = Raster::empty(self.config.raster_grid());
        let hidden_to = |id| self.last_heard.get(id)?.fact.as_ref().map(|fact| &fact.hidden);
        let neighbours_hidden_now: Vec<Option<&Raster>> =
            pass.neighbours.iter().map(hidden_to).collect();
        let input = PlannerInput {
            wanted: &rasters.wanted,
            margin: &rasters.margin,
            hidden_now: self.own_frame.measured().map_or(&nothing, |m| &m.hidden),
            neighbours: &pass.neighbours,
            plan_ages: &pass.ages,
            silent: &pass.silent,
            neighbours_hidden_now: &neighbours_hidden_now,
            hidden_recent: &rasters.hidden_recently,
            oem,
            view_cache: is_shared.then(|| self.knowledge.view_cache()),
            pose_error: expected,
            ways: ways.as_ref(),
        };
        let decision = self.planner.plan(&input, &pose, &pass.poses);
        let first = decision.increments_rad.first();
        let way_out = first.zip(ways.as_ref()).and_then(|(first, ways)| ways.behind(*first));
        (decision, way_out)
    }
}

/// The box that the planner expects about its poses: the bound of a fix, or what the box has grown to without one, in
/// whole metres, so that the views of a pose can be kept for some time.
fn expected_pose_error(fix: &PoseError, now: &PoseError) -> PoseError {
    let wider = |axis: usize| {
        let [fix, now] = [fix, now].map(|error| error.p_world[axis]);
        if now > fix + MILLIMETRE { now.ceil() } else { fix }
    };
    PoseError { p_world: std::array::from_fn(wider), ..*fix }
}

impl Agent for SetMembershipAgent {
    type Command = Command;
    type Event = Event;

    fn handle_frame(&mut self, now: SimTime, frame: &Frame) {
        if let Some(airspace) = &mut self.airspace {
            airspace.see(&self.config.camera.at(&frame.pose), frame);
        }
        self.pose_error = frame.pose_error;
        self.begin(now, frame.step, frame.pose, |sensor| {
            info_span!("sense").in_scope(|| sensor.measure(frame))
        });
    }

    fn handle_step(&mut self, now: SimTime, step: Step, pose: Pose) {
        let grid = self.config.raster_grid();
        self.begin(now, step, pose, |_| Measured::nothing(grid));
    }

    fn handle_message(&mut self, now: SimTime, message: &Reception) {
        let bytes = &message.bytes[..];
        self.now = now;
        match self.receive(bytes) {
            Ok(Received::Knowledge { from, p_world, fact }) => {
                let is_uav = from.0 < self.config.fleet.count;
                let known = self.last_heard.get(&from);
                if is_uav && known.is_none_or(|known| known.step <= fact.step) {
                    let (step, at) = (fact.step, [p_world[0], p_world[1]]);
                    let is_read = self.config.guidance.criterion == Criterion::Str2;
                    let fact = is_read.then_some(fact);
                    self.last_heard.insert(from, LastHeard { step, at, fact });
                }
            }
            Ok(Received::Plan { from, incarnation, plan }) => {
                let taken = self.scheduler.on_plan(self.now, from, &plan);
                self.believe_plans(from, incarnation, taken);
            }
            Ok(Received::Relay { from, incarnation, mut plans }) => {
                plans.retain(|relayed| relayed.uav != self.config.id);
                let taken = self.scheduler.on_relayed(&plans);
                self.believe_plans(from, incarnation, taken);
            }
            Ok(Received::Repeat) => {}
            Err(rejection) => self.reject(self.sender_of(bytes), &rejection.into()),
        }
    }

    fn handle_timeout(&mut self, now: SimTime) {
        self.now = now;
        self.plan_arrived = false;
        self.update();
        self.scheduler.on_timeout(now);
        while let Some(pass) = self.scheduler.ready() {
            self.decide(pass);
        }
    }

    fn poll_transmit(&mut self) -> Option<Transmit> {
        self.transmitter.pop()
    }

    fn answer(&mut self, now: SimTime) -> Option<Transmit> {
        // A pending frame is not part of the knowledge yet.
        if self.own_frame.pending().is_some() || self.config.exchange.mode == ExchangeMode::None {
            return None;
        }
        let (held, hidden) =
            (self.version_vector.facts(), self.own_frame.measured()?.hidden.clone());
        self.transmitter.answer(now, self.pose, &self.knowledge, held, hidden)
    }

    fn poll_command(&mut self) -> Option<Command> {
        self.commands.pop_front()
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn poll_timeout(&self) -> Option<SimTime> {
        self.next_timer().map(|(at, _)| at)
    }

    fn digest(&self) -> u64 {
        self.knowledge.digest()
    }
}
