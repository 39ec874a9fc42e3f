//! The sans-I/O agent of the Bayesian search: frames and messages in, messages and commands out.
//!
//! A frame becomes a factor, which the agent says at once. In
//! [`handle_timeout`](csat_proto::agent::Agent::handle_timeout) it applies its own factor together with all that
//! arrived, in one order, so the same news make the same belief in every agent; then guidance decides.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::Pose;
use csat_proto::command::Command;
use csat_proto::envelope::Envelope;
use csat_proto::frame::Frame;
use csat_proto::ids::AgentId;
use csat_proto::radio::Reception;
use csat_proto::time::{SimTime, Step};
use serde::{Deserialize, Serialize};
use tracing::info_span;
use xxhash_rust::xxh3::Xxh3Default;

use crate::config::{AgentConfig, ExchangeMode};
use crate::exchange::factor_set::FactorSet;
use crate::exchange::message::Plan;
use crate::exchange::protocol::{Exchange, Received, Stamp};
use crate::factor::{Factor, ReportedPose};
use crate::filter::Filter;
use crate::guidance::{GuidanceInput, Guide, NeighbourPlan};
use crate::mutant::{Mutant, is_on};
use crate::tiles::Tiles;
use crate::worth::Worth;

/// With a smaller deviation than this the target counts as found, and guidance localises it, metres.
pub const FOUND_SIGMA_M: f64 = 50.0;

/// What an agent reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// Its detector saw the target, or took something else for it.
    Sighting {
        /// The step of the frame.
        step: Step,
        /// The image point, pixels.
        pixel: [f64; 2],
        /// Where that is on the ground from the reported pose, `world`, metres; `None` above the horizon.
        #[serde(skip_serializing_if = "Option::is_none")]
        location: Option<[f64; 2]>,
    },
    /// It dropped a message, or a factor of one; reported once per reason and sender.
    Rejected {
        /// The step of its belief.
        step: Step,
        /// The sender, if it is an agent of the mission.
        from: Option<AgentId>,
        /// Why, in a word.
        reason: String,
        /// Why, with values.
        detail: String,
    },
    /// Two factors had the same identity and said different things. The first one stays.
    Conflict {
        /// The step of its belief.
        step: Step,
        /// Who sent the second one.
        from: AgentId,
    },
}

/// One aircraft or ground station of the Bayesian search.
#[derive(Debug, Clone)]
pub struct BayesAgent {
    config: AgentConfig,
    exchange: Exchange,
    set: FactorSet,
    filter: Filter,
    guide: Guide,
    pose: Pose,
    step: Step,
    /// Whether it had a frame or a step yet.
    has_begun: bool,
    /// The factor of the last frame.
    own: Option<Factor>,
    /// Whether the last frame was not applied yet.
    is_pending: bool,
    /// Factors that are held and were not applied yet.
    news: Vec<Factor>,
    /// The factors that it got to hold in the step before, and in this one.
    recent: [Vec<Factor>; 2],
    /// Beliefs of others that were not fused yet.
    beliefs: Vec<Arc<Tiles>>,
    neighbours: BTreeMap<AgentId, NeighbourPlan>,
    rejected: BTreeMap<String, u64>,
    /// The reasons that were reported, with the senders of the messages.
    reported: BTreeSet<(String, Option<AgentId>)>,
    commands: VecDeque<Command>,
    events: VecDeque<Event>,
    now: SimTime,
}

impl BayesAgent {
    /// An agent that knows nothing but the region.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            exchange: Exchange::new(config),
            set: FactorSet::new(),
            filter: Filter::new(config),
            guide: Guide::new(config),
            pose: Pose::default(),
            step: Step(0),
            has_begun: false,
            own: None,
            is_pending: false,
            news: Vec::new(),
            recent: Default::default(),
            beliefs: Vec::new(),
            neighbours: BTreeMap::new(),
            rejected: BTreeMap::new(),
            reported: BTreeSet::new(),
            commands: VecDeque::new(),
            events: VecDeque::new(),
            now: SimTime(0),
            config: config.clone(),
        }
    }

    /// The configuration.
    pub fn config(&self) -> &AgentConfig {
        &self.config
    }

    /// The belief, and how it follows from factors.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// The factors that the agent holds.
    pub fn factors(&self) -> &FactorSet {
        &self.set
    }

    /// The factors that it got to hold in this step and in the one before.
    pub fn recent(&self) -> impl Iterator<Item = &Factor> {
        self.recent.iter().flatten()
    }

    /// The factor of its last frame; `None` before the first one, and of a ground station.
    pub fn own_factor(&self) -> Option<&Factor> {
        self.own.as_ref()
    }

    /// The reported pose of the last frame, or where a ground station stands.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Where it intends to be, one pose per second.
    pub fn planned(&self) -> &[Pose] {
        self.guide.planned()
    }

    /// How many messages, factors and own frames were dropped, by reason.
    pub fn rejected(&self) -> &BTreeMap<String, u64> {
        &self.rejected
    }

    /// How many steps had something to say that was not sent at once because of the budget.
    pub fn withheld(&self) -> u64 {
        self.exchange.withheld()
    }

    /// How many steps there are in a second, at least one.
    fn steps_per_s(&self) -> u32 {
        ((1.0 / self.config.period_s).round() as u32).max(1)
    }

    /// Begins a step: says its factor, and applies it at the next timeout.
    fn begin(&mut self, now: SimTime, step: Step, pose: Pose, sighting: Option<Option<[f64; 2]>>) {
        self.now = now;
        if self.has_begun && step <= self.step {
            let detail = format!("step {step} after step {}", self.step);
            return self.reject(None, "old-frame", detail);
        }
        // A frame that is still pending had no timeout: the driver is late.
        self.update();
        (self.step, self.pose, self.has_begun, self.is_pending) = (step, pose, true, true);
        self.recent.rotate_left(1);
        self.recent[1].clear();
        self.own = sighting.map(|sighting| self.exchange.state(step, &pose, sighting));
        if let Some(factor) = self.own {
            self.set.state(factor);
            self.recent[1].push(factor);
            self.news.push(factor);
        }
        self.report_sighting();
        self.say();
    }

    fn report_sighting(&mut self) {
        let Some(Factor { step, sighting: Some(z), .. }) = self.own else { return };
        let pixel = z.map(f64::from);
        let location = self.config.camera.at(&self.pose).ground_point(pixel[0], pixel[1]);
        self.events.push_back(Event::Sighting { step, pixel, location });
    }

    fn say(&mut self) {
        let stamp = self.stamp();
        let plan = Plan {
            first: self.guide.planned_at().after(self.steps_per_s()),
            period: self.steps_per_s(),
            poses: self.guide.planned().iter().map(ReportedPose::from).collect(),
        };
        let belief = self.is_time_for_belief().then(|| self.filter.belief().tiles());
        let Self { exchange, set, filter, .. } = self;
        // Most steps no factor has to be rated.
        let mut worth = None;
        exchange.say(&stamp, set, &plan, belief, &mut |factor| {
            worth.get_or_insert_with(|| Worth::new(filter)).of(factor)
        });
    }

    fn stamp(&self) -> Stamp {
        Stamp { now: self.now, step: self.step, pose: self.pose }
    }

    fn is_time_for_belief(&self) -> bool {
        let period = self.config.steps(self.config.exchange.snapshot_period_s).max(1);
        self.config.exchange.mode == ExchangeMode::Snapshot && self.step.0.is_multiple_of(period)
    }

    /// Applies everything that is known of the present step and of earlier ones.
    fn update(&mut self) {
        self.is_pending = false;
        let step = self.step;
        let news: Vec<Factor> = self.news.extract_if(.., |factor| factor.step <= step).collect();
        info_span!("estimate").in_scope(|| {
            self.filter.advance(step);
            self.filter.apply(news);
        });
        let beliefs = std::mem::take(&mut self.beliefs);
        let fusion = self.config.exchange.fusion;
        info_span!("fuse")
            .in_scope(|| beliefs.iter().for_each(|belief| self.filter.fuse(belief, fusion)));
    }

    fn decide(&mut self) {
        let Self { filter, guide, neighbours, pose, step, .. } = self;
        let neighbours: Vec<NeighbourPlan> = neighbours.values().cloned().collect();
        let estimate = filter.belief().gaussian();
        let input = GuidanceInput {
            step: *step,
            pose,
            map: &|| filter.belief().map(),
            target: (estimate.sigma_m() < FOUND_SIGMA_M).then_some(estimate),
            neighbours: &neighbours,
        };
        let command = info_span!("guidance").in_scope(|| guide.step(&input));
        self.commands.extend(command);
    }

    fn hear(&mut self, received: Received) {
        let Received { from, factors, dropped, plan, belief, step, .. } = received;
        for rejection in dropped {
            self.reject(Some(from), rejection.name(), rejection.to_string());
        }
        let (conflicts, refused) = (self.set.conflicts(), self.set.refused());
        for factor in factors {
            let is_new = self.set.insert(factor);
            self.recent[1].extend(is_new.then_some(factor));
            if is_new || is_on(Mutant::FactorAppliedTwice) {
                let pose = if is_on(Mutant::OwnPoseForOthers) {
                    ReportedPose::from(&self.pose)
                } else {
                    factor.pose
                };
                self.news.push(Factor { pose, ..factor });
            }
        }
        self.count("room", self.set.refused() - refused);
        self.count("conflict", self.set.conflicts() - conflicts);
        if self.set.conflicts() > conflicts {
            self.events.push_back(Event::Conflict { step: self.step, from });
        }
        let is_newer = self.neighbours.get(&from).is_none_or(|known| known.step <= step);
        if !plan.poses.is_empty() && is_newer && from.0 < self.config.fleet.count {
            let poses = plan.poses.iter().map(|pose| Pose::from(*pose)).collect();
            // Poses are one per second from a second after the plan was made.
            let first = Step(plan.first.0.saturating_sub(plan.period));
            self.neighbours.insert(from, NeighbourPlan { id: from, step: first, poses });
        }
        if let Some(belief) = belief
            && self.config.exchange.mode == ExchangeMode::Snapshot
        {
            self.beliefs.push(Arc::new(belief));
        }
    }

    fn count(&mut self, reason: &str, dropped: u64) {
        if dropped > 0 {
            *self.rejected.entry(reason.to_owned()).or_default() += dropped;
        }
    }

    fn reject(&mut self, from: Option<AgentId>, reason: &str, detail: String) {
        self.count(reason, 1);
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

impl Agent for BayesAgent {
    type Command = Command;
    type Event = Event;

    fn handle_frame(&mut self, now: SimTime, frame: &Frame) {
        self.begin(now, frame.step, frame.pose, Some(frame.sighting));
    }

    fn handle_step(&mut self, now: SimTime, step: Step, pose: Pose) {
        self.begin(now, step, pose, None);
    }

    fn handle_message(&mut self, now: SimTime, message: &Reception) {
        self.now = now;
        match self.exchange.receive(self.step, &message.bytes) {
            Ok(received) => self.hear(received),
            Err(rejection) => {
                let from = self.sender_of(&message.bytes);
                self.reject(from, rejection.name(), rejection.to_string());
            }
        }
    }

    fn handle_timeout(&mut self, now: SimTime) {
        self.now = now;
        let is_new_step = self.is_pending;
        self.update();
        if is_new_step && !self.config.is_station() {
            self.decide();
        }
    }

    fn poll_transmit(&mut self) -> Option<Transmit> {
        self.exchange.poll_transmit()
    }

    fn answer(&mut self, _: SimTime) -> Option<Transmit> {
        let is_snapshot = self.config.exchange.mode == ExchangeMode::Snapshot;
        let belief = is_snapshot.then(|| self.filter.belief().tiles());
        let stamp = self.stamp();
        self.exchange.answer(&stamp, &self.set, belief)
    }

    fn poll_command(&mut self) -> Option<Command> {
        self.commands.pop_front()
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn poll_timeout(&self) -> Option<SimTime> {
        let is_due = self.news.iter().any(|factor| factor.step <= self.step);
        (self.is_pending || is_due || !self.beliefs.is_empty()).then_some(self.now)
    }

    fn digest(&self) -> u64 {
        let mut hasher = Xxh3Default::new();
        hasher.update(&self.step.0.to_le_bytes());
        let Pose { p_world, yaw_rad, pitch_rad, roll_rad } = self.pose;
        let numbers = p_world.into_iter().chain([yaw_rad, pitch_rad, roll_rad]);
        numbers.for_each(|x| hasher.update(&x.to_le_bytes()));
        hasher.update(&(self.set.len() as u64).to_le_bytes());
        self.filter.belief().numbers(&mut |x| hasher.update(&x.to_le_bytes()));
        hasher.digest()
    }
}
