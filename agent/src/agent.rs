//! The sans-I/O agent of the set-membership mission: frames and messages in, messages and commands
//! out.
//!
//! Within a step: the frame predicts and corrects at once and says what it proved; what others say
//! waits until [`handle_timeout`](csat_proto::agent::Agent::handle_timeout), when it is fused in one
//! go and, every T_MPC, guidance decides.

use std::collections::{BTreeMap, VecDeque};

use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::Pose;
use csat_proto::command::YawCommand;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, TargetId};
use csat_proto::message::Plan;
use csat_proto::raster::Raster;
use csat_proto::time::{SimTime, Step};
use serde::Serialize;
use tracing::info_span;

use crate::config::{AgentConfig, ExchangeMode};
use crate::estimate::correct::correct;
use crate::estimate::fuse::Fuser;
use crate::estimate::predict::Predictor;
use crate::estimate::state::Knowledge;
use crate::exchange::inbox::{Inbox, Received};
use crate::exchange::outbox::Outbox;
use crate::exchange::validate::Rejection;
use crate::guidance::schedule::{Pass, Scheduler};
use crate::guidance::{Picture, Planner};
use crate::sense::{Measured, Sensor};

/// What an agent reports to whoever observes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// A target is known of for the first time.
    Identified {
        /// The agent's step.
        step: Step,
        /// j.
        target: TargetId,
        /// Whether another agent saw it.
        by_others: bool,
    },
    /// A target's set became empty and was restarted: an assumption failed or somebody lied.
    Inconsistent {
        /// The agent's step.
        step: Step,
        /// j.
        target: TargetId,
    },
    /// A message was dropped, for a reason not yet reported.
    Rejected {
        /// The agent's step.
        step: Step,
        /// Short name of the reason.
        reason: &'static str,
        /// What was wrong, with values.
        detail: String,
    },
}

/// One UAV of the set-membership mission.
#[derive(Debug, Clone)]
pub struct SetMembershipAgent {
    config: AgentConfig,
    sensor: Sensor,
    predictor: Predictor,
    fuser: Fuser,
    planner: Planner,
    scheduler: Scheduler,
    knowledge: Knowledge,
    inbox: Inbox,
    outbox: Outbox,
    pose: Pose,
    /// The heading last commanded, which the vehicle flies or turns to.
    commanded_yaw_rad: Option<f64>,
    /// This step's own frame.
    measured: Option<Measured>,
    /// What each neighbour last reported as hidden, for `str2`.
    hidden_to: BTreeMap<AgentId, Raster>,
    rejected: BTreeMap<&'static str, u64>,
    commands: VecDeque<YawCommand>,
    events: VecDeque<Event>,
    now: SimTime,
    /// Something happened since the last [`Agent::handle_timeout`].
    stirred: bool,
}

impl SetMembershipAgent {
    /// An agent that knows nothing but its configuration.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            sensor: Sensor::new(config),
            predictor: Predictor::new(config),
            fuser: Fuser::new(config),
            planner: Planner::new(config),
            scheduler: Scheduler::new(config),
            knowledge: Knowledge::at_start(config),
            inbox: Inbox::new(config),
            outbox: Outbox::new(config),
            pose: Pose::default(),
            commanded_yaw_rad: None,
            measured: None,
            hidden_to: BTreeMap::new(),
            rejected: BTreeMap::new(),
            commands: VecDeque::new(),
            events: VecDeque::new(),
            now: SimTime(0),
            stirred: false,
            config: config.clone(),
        }
    }

    /// The configuration.
    pub fn config(&self) -> &AgentConfig {
        &self.config
    }

    /// What the agent knows.
    pub fn knowledge(&self) -> &Knowledge {
        &self.knowledge
    }

    /// What its last frame proved; `None` before the first one.
    pub fn measured(&self) -> Option<&Measured> {
        self.measured.as_ref()
    }

    /// The pose of its last frame.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// How many messages were dropped as invalid, by reason.
    pub fn rejected(&self) -> &BTreeMap<&'static str, u64> {
        &self.rejected
    }

    /// H^OEM(x^u) ∩ F(x^u) at the pose of the last frame, for (5.45).
    pub fn predicted_hidden(&mut self) -> Raster {
        self.planner.predicted_hidden(&self.knowledge.oem, &self.pose)
    }

    fn fuse_what_is_due(&mut self) {
        let step = self.knowledge.step;
        if !self.inbox.has_due(step) {
            return;
        }
        let fused = info_span!("fuse").in_scope(|| {
            let (facts, snapshots) = self.inbox.take_due(step);
            self.fuser.fuse(&mut self.knowledge, &facts, &snapshots)
        });
        self.report(&fused.identified, &fused.inconsistent, true);
    }

    fn report(&mut self, identified: &[TargetId], inconsistent: &[TargetId], by_others: bool) {
        let step = self.knowledge.step;
        let identified =
            identified.iter().map(|&target| Event::Identified { step, target, by_others });
        let inconsistent = inconsistent.iter().map(|&target| Event::Inconsistent { step, target });
        self.events.extend(identified.chain(inconsistent));
    }

    fn reject(&mut self, rejection: &Rejection) {
        let reason = rejection.name();
        let count = self.rejected.entry(reason).or_default();
        *count += 1;
        if *count == 1 {
            let (step, detail) = (self.knowledge.step, rejection.to_string());
            tracing::warn!(agent = %self.config.id, reason, detail, "message dropped");
            self.events.push_back(Event::Rejected { step, reason, detail });
        }
    }

    /// One pass of guidance: plan, announce, and after the last one command the vehicle.
    fn decide(&mut self, pass: Pass) {
        let yaw_rad = self.commanded_yaw_rad.unwrap_or(self.pose.yaw_rad);
        let decision = info_span!("guidance").in_scope(|| {
            let grid = self.config.raster_grid();
            let margin = Raster::of_region(grid, self.knowledge.margin.region());
            let nothing = Raster::empty(grid);
            let neighbours_hidden_now: Vec<Option<&Raster>> =
                pass.neighbours.iter().map(|id| self.hidden_to.get(id)).collect();
            let picture = Picture {
                wanted: &self.knowledge.wanted(),
                margin: &margin,
                hidden_now: self.measured.as_ref().map_or(&nothing, |m| &m.hidden),
                neighbours_hidden_now: &neighbours_hidden_now,
                hidden_recent: &self.knowledge.hidden_recently(),
                oem: &self.knowledge.oem,
            };
            let pose = Pose { yaw_rad, ..self.pose };
            self.planner.plan(&picture, &pose, &pass.poses)
        });
        let plan = Plan { step: pass.step, pass: pass.pass, poses: decision.poses };
        let last = self.scheduler.on_own_plan(&plan);
        if self.config.exchange.mode != ExchangeMode::None {
            self.outbox.say_plan(self.now, self.pose, plan);
        }
        if last {
            let turn_rad = decision.increments_rad.first().copied().unwrap_or_default();
            let yaw_rad = yaw_rad + turn_rad;
            self.commanded_yaw_rad = Some(yaw_rad);
            self.commands.push_back(YawCommand { yaw_rad });
        }
    }
}

impl Agent for SetMembershipAgent {
    type Command = YawCommand;
    type Event = Event;

    fn handle_frame(&mut self, now: SimTime, frame: &Frame) {
        self.now = now;
        self.stirred = true;
        self.pose = frame.pose;
        let measured = info_span!("sense").in_scope(|| self.sensor.measure(frame));
        let changes = info_span!("estimate").in_scope(|| {
            let predicted = self.predictor.predict(&mut self.knowledge, frame.step);
            correct(&mut self.knowledge, &predicted, &measured)
        });
        self.report(&changes.identified, &changes.inconsistent, false);
        self.outbox.say_step(now, self.pose, &self.knowledge, &measured, &changes);
        self.measured = Some(measured);
        if self.scheduler.decides_at(frame.step) {
            self.scheduler.on_instant(now);
        }
    }

    fn handle_message(&mut self, now: SimTime, bytes: &[u8]) {
        self.now = now;
        match self.inbox.receive(self.knowledge.step, bytes) {
            Ok(Received::Knowledge { from, hidden }) => {
                self.hidden_to.insert(from, hidden);
                self.stirred = true;
            }
            Ok(Received::Plan(from, plan)) => match self.scheduler.on_plan(from, &plan) {
                Ok(()) => self.stirred = true,
                Err(error) => self.reject(&Rejection::Plan(error)),
            },
            Err(rejection) => self.reject(&rejection),
        }
    }

    fn handle_timeout(&mut self, now: SimTime) {
        self.now = now;
        self.stirred = false;
        self.fuse_what_is_due();
        self.scheduler.on_timeout(now);
        while let Some(pass) = self.scheduler.ready() {
            self.decide(pass);
        }
    }

    fn poll_transmit(&mut self) -> Option<Transmit> {
        self.outbox.pop()
    }

    fn poll_command(&mut self) -> Option<YawCommand> {
        self.commands.pop_front()
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn poll_timeout(&self) -> Option<SimTime> {
        if self.stirred { Some(self.now) } else { self.scheduler.next_deadline() }
    }

    fn digest(&self) -> u64 {
        self.knowledge.digest()
    }
}
