//! The process of one agent: its seat, driven by what comes over Zenoh.
//!
//! In lockstep the world announces what everybody said; the process waits until it holds all of it,
//! lets its links decide, runs the agent and answers. In real time it waits for nobody: frames set
//! its clock, what comes is heard as it comes, and the agent runs when something is due.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use csat_proto::agent::FIRST_ANSWER;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::control::{
    Done, FrameHeader, HeaderError, Order, PROTOCOL, Pace, Probe, Ready, SaidSoFar, Welcome,
};
use csat_proto::frame::Frame;
use csat_proto::frame_wire::{self, PixelsError};
use csat_proto::ids::{AgentId, ChannelId};
use csat_proto::keys::Keys;
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::{SimTime, Step};
use csat_world::world::WorldErrors;
use zenoh::query::Query;
use zenoh::{Session, Wait};

use super::arguments::AgentArguments;
use super::desk::{Desk, Inbox, News, text};
use super::ether::{self, Ether};
use super::join::{join, links};
use super::leash;
use super::mirror::{Mirror, Picture};
use crate::fleet::Passage;
use crate::fleet::remote::account::{Account, Asked, Head, StepTold};
use crate::plug::Mission;
use crate::scenario::Scenario;
use crate::seat::Seat;
use crate::set_membership::SetMembership;
use crate::timing::Stopwatch;
use crate::wire::session::{self, Role, WireError};
use crate::wire::waiting::Waiting;
use crate::words::named;

/// How often a process gives signs of life until it flies.
const PROBE_PERIOD: Duration = Duration::from_millis(50);
/// In real time: the part of a period for which others' messages are waited for.
const GRACE_SHARE: f64 = 0.1;

/// How many may wait to be told what the agent knows.
const MAX_ASKED: usize = 256;

/// Who ended a process that its user ended, as in [`AgentError::Ended`].
pub const ENDED_BY_SIGNAL: &str = "a signal";

/// Why an agent's process ended before its mission.
#[derive(Debug, thiserror::Error)]
pub enum AgentError {
    /// Its session.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// Something else of Zenoh.
    #[error("Zenoh: {0}")]
    Zenoh(String),
    /// No world.
    #[error(
        "waited {limit_s} s for a world to answer on `{key}`\n{cause}\n  = expected a `csat world` or \
         `csat spawn` there; `csat doctor` tells who is"
    )]
    NoWorld {
        /// The key.
        key: String,
        /// What came of connecting, a line for each endpoint.
        cause: String,
        /// How long.
        limit_s: u64,
    },
    /// The world does not want it.
    #[error("the world refuses agent {agent}: {reason}")]
    Refused {
        /// Which agent.
        agent: AgentId,
        /// Its words.
        reason: String,
    },
    /// The world speaks another version.
    #[error("the world's welcome is not understood ({0}): use the same csat everywhere")]
    Version(String),
    /// The world's map, which the links need.
    #[error("the world's town cannot be built: {0}")]
    Town(#[from] WorldErrors),
    /// A frame.
    #[error("the world's frame of step {step} is not understood: {error}")]
    Frame {
        /// k.
        step: Step,
        /// What is wrong.
        error: PixelsError,
    },
    /// What comes with a frame.
    #[error("the world's frame cannot be believed: {0}")]
    Header(#[from] HeaderError),
    /// The world holds no token.
    #[error("waited {limit_s} s for the world's liveliness token `{key}`")]
    NoToken {
        /// The key.
        key: String,
        /// How long.
        limit_s: u64,
    },
    /// The world's scenario.
    #[error("the world's scenario is not understood: {0}")]
    Scenario(String),
    /// A message that was announced does not come.
    #[error(
        "waited {limit_s} s at step {step} for message {number} of agent {from} on radio {radio}"
    )]
    Silence {
        /// How long.
        limit_s: u64,
        /// k.
        step: Step,
        /// Whose.
        from: AgentId,
        /// Its radio.
        radio: ChannelId,
        /// Its number.
        number: u64,
    },
    /// The world's process ended.
    #[error("the world ended without a word; the mission is over for agent {0}")]
    WorldGone(AgentId),
    /// The user, or whoever spawned it.
    #[error("ended by {0}")]
    Ended(&'static str),
}

pub(super) fn zenoh_error(error: zenoh::Error) -> AgentError {
    AgentError::Zenoh(error.to_string())
}

/// Drives agent `arguments.id` of whatever world answers, until the mission is over. Tells why it is.
///
/// # Errors
/// When it cannot take part, or not go on.
pub fn fly(arguments: &AgentArguments) -> Result<String, AgentError> {
    let inbox = Inbox::default();
    // First of all: whoever spawned this process may be gone before there is a world.
    watch_for_the_end(&inbox, arguments.leashed);
    let session = session::open(&arguments.wire, Role::Agent(arguments.id))?;
    let process = super::process_number();
    let result = join(&session, arguments, process, &inbox)
        .and_then(|welcome| Shell::new(&session, arguments, process, &welcome, inbox)?.run());
    session::close(session);
    result
}

/// A turn that waits for messages.
struct Turn {
    step: Step,
    round: u32,
    now: SimTime,
    said: Vec<SaidSoFar>,
    waiting: Stopwatch,
}

/// The time of a process that flies.
#[derive(Clone, Copy)]
struct Clock {
    step: Step,
    time: SimTime,
    next: SimTime,
    /// Since the frame came.
    watch: Stopwatch,
}

/// A running process.
struct Shell {
    id: AgentId,
    keys: Keys,
    process: u64,
    pace: Pace,
    patience: Duration,
    mission: SetMembership,
    /// `None` for a ground station.
    camera: Option<CameraModel>,
    period_s: f64,
    seat: Seat<SetMembership>,
    desk: Desk,
    mirror: Mirror,
    ether: Ether,
    /// Whom it hears.
    heard: BTreeMap<AgentId, u64>,
    /// Whose processes are gone.
    lost: BTreeSet<AgentId>,
    /// By radio, the number of its next message.
    next: Vec<u64>,
    clock: Option<Clock>,
    /// Lockstep: the turn that was answered last in this step, 0 for the frame.
    round: u32,
    turn: Option<Turn>,
    /// What it has told of this step.
    told: StepTold,
    since_probe: Stopwatch,
    /// Who waits to be told what the agent knows.
    asked: Vec<Query>,
    is_world_here: bool,
    since_start: Stopwatch,
    /// For the first frame; `None` in a spawned agent, whose world tells who is missing.
    waiting: Option<Waiting>,
    /// How many of the agents are UAVs, and how many agents there are.
    fleet: [u16; 2],
    /// Frames that it looked at, or steps that it was told of.
    looked: u64,
}

impl Shell {
    fn new(
        session: &Session,
        arguments: &AgentArguments,
        process: u64,
        welcome: &Welcome,
        inbox: Inbox,
    ) -> Result<Self, AgentError> {
        if welcome.protocol != PROTOCOL {
            let got = welcome.protocol;
            return Err(AgentError::Version(format!("protocol {got}, expected {PROTOCOL}")));
        }
        let scenario: Scenario = toml::from_str(&welcome.scenario)
            .map_err(|error| AgentError::Scenario(error.message().to_owned()))?;
        let id = AgentId(arguments.id);
        let channels = scenario.netem.all_channels().count();
        let mission = SetMembership::new(&scenario);
        let period_s = scenario.run.period_s;
        let desk = Desk::declare(session, welcome, period_s, id, channels, inbox);
        let desk = desk.map_err(zenoh_error)?;
        // Only now, for it may take long: the world gives the place away without the desk's token.
        let links = links(&scenario, welcome.map.as_deref())?;
        let mirror = Mirror::declare(session, Keys(welcome.run), id, mission.clone());
        let mirror = mirror.map_err(zenoh_error)?;
        Ok(Self {
            id,
            keys: Keys(welcome.run),
            process,
            pace: welcome.pace,
            patience: arguments.patience,
            camera: mission.camera(id),
            period_s,
            seat: Seat::new(&mission, id, links),
            mission,
            desk,
            mirror,
            ether: Ether::default(),
            heard: BTreeMap::new(),
            lost: BTreeSet::new(),
            next: vec![0; channels],
            clock: None,
            round: 0,
            turn: None,
            told: StepTold::default(),
            since_probe: Stopwatch::start(),
            asked: Vec::new(),
            is_world_here: false,
            since_start: Stopwatch::start(),
            waiting: (!arguments.leashed).then(Waiting::start),
            fleet: [scenario.agents.count, scenario.agent_count()],
            looked: 0,
        })
    }

    /// Until the mission is over.
    fn run(mut self) -> Result<String, AgentError> {
        loop {
            self.give_signs_of_life()?;
            match self.desk.next(self.wait_limit()) {
                None => self.idle()?,
                // Nobody waits for whoever is slow: it looks at the newest frame only.
                Some(News::Frame(header, _)) if self.is_late(header.step) => {}
                Some(News::Frame(header, pixels)) => self.look(&header, &pixels)?,
                Some(News::Order(Order::Turn { step, round, now, said })) => {
                    let waiting = Stopwatch::start();
                    self.begin_turn(Turn { step, round, now, said, waiting });
                }
                Some(News::Order(Order::Close { step, full: false })) => {
                    self.report(step, Asked::Brief);
                }
                Some(News::Order(Order::Close { step, full: true })) => {
                    self.report(step, Asked::Full);
                }
                Some(News::Order(Order::Show { step })) => self.report(step, Asked::All),
                Some(News::Order(Order::End { reason })) => {
                    tracing::info!(agent = %self.id, reason, "ends");
                    return Ok(reason);
                }
                Some(News::Link(src, physical, bytes)) => self.hear(src, physical, bytes),
                Some(News::Probe(agent, probe)) => self.probed(agent, probe),
                Some(News::Gone(agent)) => self.miss(agent),
                Some(News::Asked(query)) => {
                    self.asked.push(query);
                    self.asked.truncate(MAX_ASKED);
                    self.tell();
                }
                Some(News::Looked(query)) => {
                    let picture = self.picture(Vec::new(), 0);
                    self.mirror.answer(picture, query);
                }
                Some(News::Answer(agent, physical, bytes)) => self.catch_up(agent, physical, bytes),
                Some(News::WorldHere) => self.is_world_here = true,
                Some(News::WorldGone) => return Err(AgentError::WorldGone(self.id)),
                Some(News::End(who)) => return Err(AgentError::Ended(who)),
            }
        }
    }

    /// Whether a newer frame than that of a step has come already.
    fn is_late(&self, step: Step) -> bool {
        self.pace != Pace::Lockstep && self.desk.newest_frame() > Some(step)
    }

    /// Until it flies, whatever it hears meanwhile.
    fn give_signs_of_life(&mut self) -> Result<(), AgentError> {
        if self.clock.is_some() || !self.since_probe.left(PROBE_PERIOD).is_zero() {
            return Ok(());
        }
        // Without its token the end of the world would not be noticed.
        if !self.is_world_here && self.since_start.left(self.patience).is_zero() {
            let (key, limit_s) = (self.keys.alive_world(), self.patience.as_secs());
            return Err(AgentError::NoToken { key, limit_s });
        }
        self.since_probe = Stopwatch::start();
        self.tell_who_is_missing();
        self.desk.probe(&Probe { process: self.process, answer: true });
        // Said again in case the world was not listening yet.
        self.desk.ready(&self.readiness());
        Ok(())
    }

    /// Says now and then why it does not fly yet.
    fn tell_who_is_missing(&mut self) {
        let Self { id, heard, fleet: [uavs, all], waiting: Some(waiting), .. } = self else {
            return;
        };
        waiting.tell(|| {
            let is_silent = |agent: &u16| *agent != id.0 && !heard.contains_key(&AgentId(*agent));
            let (silent, own) = (named((0..*all).filter(is_silent), *uavs), named([id.0], *uavs));
            match silent.is_empty() {
                true => format!("the world's first frame: {own} hears all others"),
                false => format!("{silent} to be heard by {own}"),
            }
        });
    }

    fn readiness(&self) -> Ready {
        let heard = self.heard.iter().map(|(agent, process)| (*agent, *process));
        Ready { process: self.process, heard: heard.collect() }
    }

    /// Another process gives a sign of life.
    fn probed(&mut self, agent: AgentId, probe: Probe) {
        tracing::debug!(own = %self.id, %agent, ?probe, "is heard");
        self.lost.remove(&agent);
        let is_new = self.heard.insert(agent, probe.process) != Some(probe.process);
        if probe.answer && self.clock.is_some() {
            self.desk.probe(&Probe { process: self.process, answer: false });
        }
        if is_new {
            self.desk.ready(&self.readiness());
        }
    }

    /// Another process is gone. A lease runs out for each of its peers at a time of its own: a successor
    /// may be known already. It answers if there is one.
    fn miss(&mut self, agent: AgentId) {
        self.heard.remove(&agent);
        self.lost.insert(agent);
        self.desk.probe(&Probe { process: self.process, answer: true });
        self.try_turn();
    }

    /// How long nothing has to be done if nothing comes.
    fn wait_limit(&self) -> Duration {
        match (self.clock, self.pace) {
            (None, _) => PROBE_PERIOD,
            (Some(_), Pace::Lockstep) => Duration::from_secs(1),
            (Some(clock), Pace::Realtime(speed)) => match self.due_with_grace(&clock) {
                Some(due) => clock.watch.left(wall(due.seconds_since(clock.time), speed)),
                None => Duration::from_secs(1),
            },
        }
    }

    /// In real time: when to do what is due in this step.
    fn due_with_grace(&self, clock: &Clock) -> Option<SimTime> {
        let due = self.seat.next_due().filter(|due| *due < clock.next)?;
        let grace_s = GRACE_SHARE * clock.next.seconds_since(clock.time);
        Some(due.max(clock.time).after(grace_s))
    }

    /// Nothing came for a while.
    fn idle(&mut self) -> Result<(), AgentError> {
        match (self.clock, self.pace) {
            (None, _) => {}
            (Some(_), Pace::Lockstep) => self.check_patience()?,
            (Some(clock), Pace::Realtime(speed)) => {
                let due = self.seat.next_due().filter(|due| *due < clock.next);
                let is_over = self.due_with_grace(&clock).is_some_and(|due| {
                    clock.watch.left(wall(due.seconds_since(clock.time), speed)).is_zero()
                });
                if let Some(due) = due.filter(|_| is_over) {
                    let now = due.max(clock.time);
                    self.seat.run(now);
                    self.tell();
                    self.talk(now);
                    self.answer(clock.step, 1);
                }
            }
        }
        Ok(())
    }

    fn check_patience(&self) -> Result<(), AgentError> {
        let Some(turn) = &self.turn else { return Ok(()) };
        let is_over = turn.waiting.left(self.patience).is_zero();
        match self.ether.lacks(&turn.said, self.id) {
            Some((from, radio, number)) if is_over => Err(AgentError::Silence {
                limit_s: self.patience.as_secs(),
                step: turn.step,
                from,
                radio,
                number,
            }),
            _ => Ok(()),
        }
    }

    /// A step begins.
    fn look(&mut self, header: &FrameHeader, pixels: &[u8]) -> Result<(), AgentError> {
        let &FrameHeader { step, time, next, pose, incarnation, .. } = header;
        // Crashes by schedule end the agent's mind only: its process needs no help.
        let is_late = self.clock.is_none() && incarnation.is_some_and(|life| life.0 > 0);
        let clock = Clock { step, time, next, watch: Stopwatch::start() };
        let is_first = self.clock.replace(clock).is_none();
        self.round = 0;
        self.told.clear();
        // In real time what was said before may still be on its way.
        if is_first || self.pace == Pace::Lockstep {
            self.ether.skip(&header.said, time);
        }
        let is_another = incarnation.is_some_and(|life| life != self.seat.incarnation());
        if is_another {
            self.next.fill(0);
        }
        let place = Pose { p_world: header.p_world.unwrap_or(pose.p_world), ..pose };
        self.seat.begin(&self.mission, incarnation, &place);
        if incarnation.is_some() {
            self.see(header, pixels)?;
            self.looked += 1;
        }
        self.talk(time);
        self.answer(step, 0);
        if is_late {
            self.desk.ask_all();
        }
        self.try_turn();
        Ok(())
    }

    /// Hands the agent its frame or, without camera, tells it of the step.
    fn see(&mut self, header: &FrameHeader, pixels: &[u8]) -> Result<(), AgentError> {
        let &FrameHeader { step, time, pose, .. } = header;
        let Some(camera) = &self.camera else {
            header.check_blind(self.period_s, pixels.len())?;
            self.seat.step(time, step);
            return Ok(());
        };
        let (labels, depth) = frame_wire::decode(pixels, camera.pixels())
            .map_err(|error| AgentError::Frame { step, error })?;
        header.check(camera, self.period_s, &labels)?;
        let detections = header.detections.clone();
        self.seat.look(time, || Frame { step, pose, labels, depth, detections });
        Ok(())
    }

    /// Another agent said something.
    fn hear(&mut self, src: AgentId, physical: Option<PhysicalHeader>, bytes: Vec<u8>) {
        // In real time one that was starved is behind all others.
        let newest = self.desk.newest_frame().filter(|_| self.pace == Pace::Lockstep);
        if let Err(error) = self.ether.take(src, physical, bytes, newest) {
            self.desk.refusals().count("message", &error);
            return;
        }
        match self.pace {
            Pace::Lockstep => self.try_turn(),
            Pace::Realtime(_) if self.clock.is_some() => {
                let heard = self.ether.hear_all();
                heard.iter().for_each(|said| self.seat.hear(said));
            }
            Pace::Realtime(_) => {}
        }
    }

    /// Answers those who want to know what the agent knows, or lets them wait while it has a frame
    /// that it has not applied yet.
    fn tell(&mut self) {
        let Some(clock) = self.clock.filter(|_| !self.asked.is_empty()) else { return };
        let Some(answer) = self.seat.answer(clock.time) else { return };
        let key = self.keys.state(self.id, "snapshot");
        let physical = text(&self.seat.physical());
        tracing::debug!(own = %self.id, askers = self.asked.len(), "is asked");
        for query in self.asked.drain(..) {
            // The key that was asked for may be a pattern.
            let reply = query.reply(&key, &answer.bytes).attachment(&physical);
            if let Err(error) = reply.wait() {
                tracing::warn!(%error, "cannot answer a query");
            }
        }
    }

    /// What another agent answered. It passes the links like everything that agents know: what
    /// cannot be heard from there is not learnt.
    fn catch_up(&mut self, agent: AgentId, physical: Option<PhysicalHeader>, bytes: Vec<u8>) {
        tracing::debug!(own = %self.id, %agent, bytes = bytes.len(), "answers");
        match ether::read(agent, physical, bytes) {
            Ok((said, _)) if said.sequence >= FIRST_ANSWER => self.seat.hear(&said),
            Ok(_) => self.desk.refusals().count("message", &"an answer numbered as a message"),
            Err(error) => self.desk.refusals().count("message", &error),
        }
    }

    /// Lockstep: the world says that a turn is to be taken. The first one that can be next counts.
    fn begin_turn(&mut self, turn: Turn) {
        // Who does not fly yet hears the orders to those that do.
        let Some(clock) = self.clock else { return };
        let is_expected = self.pace == Pace::Lockstep && self.turn.is_none();
        let is_next = is_expected && (turn.step, turn.round) == (clock.step, self.round + 1);
        let is_in_step = (clock.time..clock.next).contains(&turn.now);
        if !(is_next && is_in_step && turn.said.iter().all(|said| said.is_possible(turn.step))) {
            let reason = format!("turn {} of step {} cannot be next", turn.round, turn.step);
            self.desk.refusals().count("order", &reason);
            return;
        }
        self.turn = Some(turn);
        self.try_turn();
    }

    /// Lockstep: takes the turn once all that was announced is here.
    fn try_turn(&mut self) {
        let Some(mut turn) = self.turn.take() else { return };
        // Those who are gone may have left something unsaid.
        let lost = &self.lost;
        turn.said.retain(|said| !lost.contains(&said.agent));
        if self.ether.lacks(&turn.said, self.id).is_some() {
            self.turn = Some(turn);
            return;
        }
        for said in self.ether.hear(&turn.said, self.id) {
            self.seat.hear(&said);
        }
        if self.seat.next_due().is_some_and(|due| due <= turn.now) {
            self.seat.run(turn.now);
            self.tell();
        }
        self.talk(turn.now);
        self.round = turn.round;
        self.answer(turn.step, turn.round);
    }

    /// Says what there is to say.
    fn talk(&mut self, now: SimTime) {
        for said in self.seat.say(now) {
            if let Some(next) = self.next.get_mut(usize::from(said.channel.0)) {
                *next = said.sequence + 1;
            }
            self.desk.say(&said);
        }
    }

    /// Tells the world that a frame or a turn is done.
    fn answer(&mut self, step: Step, round: u32) {
        let said = SaidSoFar {
            agent: self.id,
            incarnation: self.seat.incarnation(),
            next: self.next.clone(),
        };
        self.desk.done(&Done {
            process: self.process,
            step,
            round,
            said: self.seat.is_alive().then_some(said),
            due: self.seat.next_due(),
            commands: self.seat.take_commands(),
        });
    }

    /// What people may see of the agent now.
    fn picture(&mut self, passages: Vec<Passage>, bytes_sent: u64) -> Picture {
        let (step, time_s) = self.clock.map_or((Step(0), 0.0), |c| (c.step, c.time.seconds()));
        let report = self.seat.show(&self.mission);
        let incarnation = self.seat.incarnation();
        Picture { incarnation, step, time_s, report, passages, bytes_sent }
    }

    /// Tells the world what a step came to, as often as it asks: it knows what it asked for.
    fn report(&mut self, step: Step, asked: Asked) {
        let Some(clock) = self.clock else { return };
        // In real time the step that is over may be one whose frame was missed.
        let newest = self.desk.newest_frame().filter(|_| self.pace != Pace::Lockstep);
        if !(clock.step..=newest.unwrap_or(clock.step)).contains(&step) {
            let reason = format!("the end of step {step} during step {}", clock.step);
            self.desk.refusals().count("order", &reason);
            return;
        }
        let mut flown = self.seat.finish(&self.mission, asked.detail());
        if asked == Asked::All {
            flown.report = Some(self.seat.show(&self.mission));
        } else if self.mirror.is_wanted() && self.seat.is_alive() {
            let picture = self.picture(flown.passages.clone(), flown.bytes_sent);
            self.mirror.show(picture);
        }
        self.told.add(&flown);
        let head = Head {
            process: self.process,
            step: clock.step,
            round: self.round,
            asked,
            looked: self.looked,
            refused: self.desk.refusals().counts(),
        };
        let account = Account::new(head, flown, &self.told, self.seat.links());
        self.desk.report(account.encode());
    }
}

/// Simulated seconds in real time.
fn wall(simulated_s: f64, speed: f64) -> Duration {
    Duration::try_from_secs_f64(simulated_s / speed).unwrap_or(Duration::MAX)
}

/// Ctrl-C and SIGTERM end the process, and so does the end of standard input if it is a leash.
fn watch_for_the_end(inbox: &Inbox, leashed: bool) {
    let sender = inbox.sender();
    let signal = sender.clone();
    let installed = ctrlc::set_handler(move || {
        if signal.try_send(News::End(ENDED_BY_SIGNAL)).is_err() {
            std::process::exit(130);
        }
    });
    if let Err(error) = installed {
        tracing::warn!(%error, "cannot listen to Ctrl-C");
    }
    if leashed {
        leash::when_let_go(move || {
            let _ = sender.send(News::End("whoever spawned it"));
        });
    }
}
