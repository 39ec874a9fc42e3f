//! The sans-I/O agent of the road clearing: frames and messages in, messages and commands out.
//!
//! A cleaner advances its masks at a frame and says what it knows. In
//! [`handle_timeout`](csat_proto::agent::Agent::handle_timeout), after all messages of the instant, every agent
//! decides about its duty and its displacement.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::Pose;
use csat_proto::command::Command;
use csat_proto::envelope::Envelope;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::radio::Reception;
use csat_proto::time::{SimTime, Step};
use xxhash_rust::xxh3::Xxh3Default;

use crate::bitmap::Bitmap;
use crate::config::AgentConfig;
use crate::exchange::message::Duty;
use crate::exchange::outbox::{Outbox, Stamp};
use crate::exchange::validate::{self, Received};
use crate::fleet::Fleet;
use crate::formation::Place;
use crate::frontier::Run;
use crate::masks::{Masks, Sight};
use crate::motion::Mover;
use crate::registration::Registration;

mod cleaner;
mod duty;
mod follow;
mod report;
mod talk;

use cleaner::Cleaner;
use duty::State;
pub use report::{Counters, Event, Role};

/// One UAV or ground station of the road clearing.
#[derive(Debug, Clone)]
pub struct ClearingAgent {
    config: AgentConfig,
    sight: Sight,
    mover: Mover,
    registration: Registration,
    state: State,
    fleet: Fleet,
    outbox: Outbox,
    /// The pose of its odometry.
    pose: Pose,
    step: Step,
    /// That of its first one.
    first: Step,
    /// Whether it had a frame or a step yet.
    has_begun: bool,
    /// Whether the last frame was not acted upon yet.
    is_pending: bool,
    /// The last command, metres.
    commanded_m: [f64; 2],
    /// What a wing knows of the road in its image, for the time when it becomes a cleaner.
    scout: Option<Masks>,
    claims: Bitmap,
    nothing: Bitmap,
    counters: Counters,
    rejected: BTreeMap<String, u64>,
    /// The reasons that were reported, with the senders of the messages.
    reported: BTreeSet<(String, Option<AgentId>)>,
    commands: VecDeque<Command>,
    events: VecDeque<Event>,
    now: SimTime,
}

impl ClearingAgent {
    /// An agent that has seen nothing yet. UAV 0 clears from the start line on, the others follow it. An agent
    /// that restarted is a helper.
    pub fn new(config: &AgentConfig) -> Self {
        let sight = Sight::new(config);
        let nothing = sight.nothing();
        let mut fleet = Fleet::default();
        // Nobody else can have taken its frontier over.
        if config.incarnation > Incarnation(0) && config.fleet.count == 1 && !config.is_station() {
            fleet.lose(config.id);
        }
        Self {
            mover: Mover::new(config),
            registration: Registration::new(config),
            state: State::initial(config),
            fleet,
            outbox: Outbox::default(),
            pose: Pose::default(),
            step: Step(0),
            first: Step(0),
            has_begun: false,
            is_pending: false,
            commanded_m: [0.0; 2],
            scout: None,
            claims: nothing.clone(),
            nothing,
            counters: Counters::default(),
            rejected: BTreeMap::new(),
            reported: BTreeSet::new(),
            commands: VecDeque::new(),
            events: VecDeque::new(),
            now: SimTime(0),
            sight,
            config: config.clone(),
        }
    }

    /// The configuration.
    pub fn config(&self) -> &AgentConfig {
        &self.config
    }

    /// Its life.
    pub fn incarnation(&self) -> Incarnation {
        self.config.incarnation
    }

    /// The step of its last frame.
    pub fn step(&self) -> Step {
        self.step
    }

    /// The pose of its odometry: only differences mean something.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// What it does.
    pub fn role(&self) -> Role {
        match &self.state {
            State::Station => Role::Station,
            State::Cleaner(_) => Role::Cleaner,
            State::Helper { .. } => Role::Helper,
            State::Follower { place, .. } => match place {
                Some(Place::Wing(0)) => Role::LeftWing,
                Some(Place::Wing(_)) => Role::RightWing,
                Some(Place::Tail(_)) | None => Role::Tail,
            },
        }
    }

    /// Whether it clears.
    pub fn is_cleaner(&self) -> bool {
        self.cleaner().is_some()
    }

    /// Whether it is a cleaner that cannot move on, and for which nobody comes.
    pub fn is_stalled(&self) -> bool {
        self.cleaner().is_some_and(|cleaner| cleaner.is_stalled)
    }

    /// The sub-frontiers that a stalled agent would have to give away; none of another one.
    pub fn stalled_runs(&self) -> Vec<Run> {
        let stalled = self.cleaner().filter(|cleaner| cleaner.is_stalled);
        stalled.map_or_else(Vec::new, |cleaner| {
            cleaner.give.iter().filter_map(|index| cleaner.runs.get(*index)).cloned().collect()
        })
    }

    /// Whether a frontier was lost, for all that it knows. From then on it claims nothing.
    pub fn has_lost(&self) -> bool {
        self.fleet.has_lost()
    }

    /// The agent that it follows or flies to.
    pub fn leader(&self) -> Option<AgentId> {
        self.state.leader()
    }

    /// The number of agents that follow it.
    pub fn followers(&self) -> usize {
        self.cleaner().map_or(0, |cleaner| cleaner.roster.len())
    }

    /// Its frontier, in the image of the present frame: pixels (row, column).
    pub fn frontier(&self) -> &Bitmap {
        self.masks().map_or(&self.nothing, Masks::frontier)
    }

    /// The sub-frontiers.
    pub fn runs(&self) -> &[Run] {
        self.cleaner().map_or(&[], |cleaner| &cleaner.runs)
    }

    /// The pixels of the image of the present frame that it claims to have cleared; none if it is no cleaner.
    pub fn claims(&self) -> &Bitmap {
        &self.claims
    }

    /// What it knows of the road in its image; `None` if it is no cleaner.
    pub fn masks(&self) -> Option<&Masks> {
        self.cleaner().map(|cleaner| &cleaner.masks)
    }

    /// What happened to it so far.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// How many messages and own frames were dropped, by reason.
    pub fn rejected(&self) -> &BTreeMap<String, u64> {
        &self.rejected
    }

    fn cleaner(&self) -> Option<&Cleaner> {
        match &self.state {
            State::Cleaner(cleaner) => Some(cleaner),
            _ => None,
        }
    }

    /// Where it is in the frame of its odometry, metres.
    fn place_m(&self) -> [f64; 2] {
        [self.pose.p_world[0], self.pose.p_world[1]]
    }

    fn stamp(&self) -> Stamp {
        Stamp { now: self.now, step: self.step, pose: self.pose }
    }

    /// Begins a step; returns whether it is a new one.
    fn begin(&mut self, now: SimTime, step: Step, pose: Pose) -> bool {
        self.now = now;
        if self.has_begun && step <= self.step {
            self.reject(None, "old-frame", format!("step {step} after step {}", self.step));
            return false;
        }
        if !self.has_begun {
            self.first = step;
        }
        (self.step, self.pose, self.has_begun, self.is_pending) = (step, pose, true, true);
        true
    }

    fn hear(&mut self, message: &Reception, got: &Received) {
        let bearing_rad = self.pose.yaw_rad + message.bearing_rad;
        let newest = self.fleet.hear(self.step, self.place_m(), bearing_rad, got);
        let is_newest = match newest {
            Ok(is_newest) => is_newest,
            Err(rejection) => {
                return self.reject(Some(got.from), rejection.name(), rejection.to_string());
            }
        };
        if got.message.beat.duty == Duty::Cleaner {
            self.learn(got);
            if is_newest {
                self.consider_requests(got);
            }
        }
    }

    fn reject(&mut self, from: Option<AgentId>, reason: &str, detail: String) {
        *self.rejected.entry(reason.to_owned()).or_default() += 1;
        if self.reported.insert((reason.to_owned(), from)) {
            tracing::info!(agent = %self.config.id, ?from, reason, detail, "dropped");
            let reason = reason.to_owned();
            self.events.push_back(Event::Rejected { step: self.step, from, reason, detail });
        }
    }

    /// The agent that sent a message; `None` for an invalid sender, of which there may be any number.
    fn sender_of(&self, bytes: &[u8]) -> Option<AgentId> {
        let sender = Envelope::decode(bytes).ok()?.src;
        (sender.0 < self.config.agents()).then_some(sender)
    }
}

impl Agent for ClearingAgent {
    type Command = Command;
    type Event = Event;

    fn handle_frame(&mut self, now: SimTime, frame: &Frame) {
        let size = usize::from(self.sight.size);
        if frame.labels.len() != size * size {
            let detail = format!("{} labels, expected {}", frame.labels.len(), size * size);
            return self.reject(None, "labels", detail);
        }
        if self.begin(now, frame.step, frame.pose) {
            self.look(frame);
            self.say();
        }
    }

    fn handle_step(&mut self, now: SimTime, step: Step, pose: Pose) {
        self.begin(now, step, pose);
    }

    fn handle_message(&mut self, now: SimTime, message: &Reception) {
        self.now = now;
        match validate::check(&self.config, self.step, message) {
            Ok(received) => self.hear(message, &received),
            Err(rejection) => {
                let from = self.sender_of(&message.bytes);
                self.reject(from, rejection.name(), rejection.to_string());
            }
        }
    }

    fn handle_timeout(&mut self, now: SimTime) {
        self.now = now;
        if std::mem::take(&mut self.is_pending) {
            self.decide();
        }
    }

    fn poll_transmit(&mut self) -> Option<Transmit> {
        let message = self.outbox.pop()?;
        let said = if message.channel == self.config.hbsr {
            &mut self.counters.hbsr_bytes
        } else {
            &mut self.counters.lblr_bytes
        };
        *said += message.bytes.len() as u64;
        Some(message)
    }

    /// Nothing: what a late agent needs, it hears within seconds.
    fn answer(&mut self, _: SimTime) -> Option<Transmit> {
        None
    }

    fn poll_command(&mut self) -> Option<Command> {
        self.commands.pop_front()
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn poll_timeout(&self) -> Option<SimTime> {
        self.is_pending.then_some(self.now)
    }

    fn digest(&self) -> u64 {
        let mut hasher = Xxh3Default::new();
        hasher.update(&self.step.0.to_le_bytes());
        hasher.update(&[self.role() as u8, u8::from(self.has_lost())]);
        let Pose { p_world, yaw_rad, .. } = self.pose;
        let numbers = p_world.into_iter().chain([yaw_rad]);
        numbers.for_each(|x| hasher.update(&x.to_le_bytes()));
        if let Some(masks) = self.masks() {
            let known = [masks.road(), masks.mine(), masks.foreign(), masks.frontier()];
            known.iter().for_each(|mask| hasher.update(&mask.to_bytes()));
        }
        hasher.digest()
    }
}
