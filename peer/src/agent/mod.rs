//! The process of one agent: its node, driven by what comes over Zenoh.
//!
//! In lockstep the world announces what everybody said; the process waits until it holds all of it,
//! lets its links decide, runs the agent and answers. In real time it waits for nobody: frames set
//! its clock, what comes is heard as it comes, and the agent runs when something is due.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use csat_netem::link::Links;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::control::{FrameHeader, Order, PROTOCOL, Pace, Welcome};
use csat_proto::frame::Frame;
use csat_proto::frame_wire;
use csat_proto::ids::AgentId;
use csat_proto::keys::Keys;
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::{SimTime, Step};
use csat_world::world::WorldErrors;
use zenoh::Session;
use zenoh::query::Query;

use crate::agent::desk::{Desk, Inbox, News};
use crate::agent::mirror::Mirror;
use crate::agent::queue::MessageQueue;
use crate::arguments::AgentArguments;
use crate::parent_death;
use crate::wire::session::{self, Role};
use crate::wire::waiting::Waiting;
use crate::world::account::{Asked, StepTold};
use csat_mission::mission::Mission;
use csat_mission::node::Node;
use csat_mission::timing::Stopwatch;

pub mod desk;
mod error;
pub mod gate;
mod join;
mod lockstep;
pub mod mirror;
mod presence;
pub mod queue;
mod realtime;
mod telling;

pub(crate) use error::zenoh_error;
pub use error::{AgentError, EndedBy};
use lockstep::Turn;

/// How often a process gives signs of life until it flies.
const PROBE_PERIOD: Duration = Duration::from_millis(50);

/// How many may wait to be told what the agent knows.
const MAX_ASKED: usize = 256;

/// What an agent's process flies, as it reads it from the world's welcome.
pub struct Setup<M: Mission> {
    /// The mission.
    pub mission: M,
    /// T, seconds.
    pub period_s: f64,
    /// How many radios there are.
    pub channels: usize,
    /// How many of the agents are UAVs, and how many agents there are.
    pub fleet: [u16; 2],
    /// Makes the links to an agent. This may take long: the process calls it when the world can hear it.
    pub links: Box<dyn FnOnce() -> Result<Links, WorldErrors>>,
}

/// A process that the world has welcomed.
pub struct Welcomed<'a> {
    /// What the world said.
    pub welcome: Welcome,
    session: &'a Session,
    arguments: &'a AgentArguments,
    process: u64,
    inbox: Inbox,
}

impl Welcomed<'_> {
    /// Drives the agent until the mission is over. Gives the reason why it is.
    ///
    /// # Errors
    /// When the process cannot take part, or not go on.
    pub fn fly<M: Mission>(self, setup: Setup<M>) -> Result<String, AgentError> {
        Shell::new(self, setup)?.run()
    }
}

/// Joins the world that answers and calls `fly` with its welcome. `why_nobody` says why no world may have
/// answered.
///
/// # Errors
/// When the process cannot take part, or not go on.
pub fn join(
    arguments: &AgentArguments,
    why_nobody: impl Fn(&Session) -> String,
    fly: impl FnOnce(Welcomed<'_>) -> Result<String, AgentError>,
) -> Result<String, AgentError> {
    let inbox = Inbox::default();
    // First of all: the parent process may be gone before there is a world.
    watch_for_the_end(&inbox, arguments.leashed);
    let session = session::open(&arguments.wire, Role::Agent(arguments.id))?;
    let process = crate::process_number();
    let result = join::join(&session, arguments, process, &inbox, why_nobody).and_then(|welcome| {
        fly(Welcomed { welcome, session: &session, arguments, process, inbox })
    });
    session::close(session);
    result
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
struct Shell<M: Mission> {
    id: AgentId,
    keys: Keys,
    process: u64,
    pace: Pace,
    patience: Duration,
    mission: M,
    /// `None` for a ground station.
    camera: Option<CameraModel>,
    period_s: f64,
    node: Node<M>,
    desk: Desk,
    mirror: Mirror<M::Report>,
    queue: MessageQueue,
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

impl<M: Mission> Shell<M> {
    fn new(welcomed: Welcomed<'_>, setup: Setup<M>) -> Result<Self, AgentError> {
        let Welcomed { welcome, session, arguments, process, inbox } = welcomed;
        if welcome.protocol != PROTOCOL {
            let got = welcome.protocol;
            return Err(AgentError::Version(format!("protocol {got}, expected {PROTOCOL}")));
        }
        let Setup { mission, period_s, channels, fleet, links } = setup;
        let id = AgentId(arguments.id);
        let desk = Desk::declare(session, &welcome, period_s, id, channels, inbox);
        let desk = desk.map_err(zenoh_error)?;
        // Only now, for it may take long: the world gives the place away without the desk's token.
        let links = links()?;
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
            node: Node::new(&mission, id, links),
            mission,
            desk,
            mirror,
            queue: MessageQueue::default(),
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
            fleet,
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

    /// How long nothing has to be done if nothing comes.
    fn wait_limit(&self) -> Duration {
        match (self.clock, self.pace) {
            (None, _) => PROBE_PERIOD,
            (Some(_), Pace::Lockstep) => Duration::from_secs(1),
            (Some(clock), Pace::Realtime(speed)) => self.left_until_due(&clock, speed),
        }
    }

    /// Nothing came for a while.
    fn idle(&mut self) -> Result<(), AgentError> {
        match (self.clock, self.pace) {
            (None, _) => {}
            (Some(_), Pace::Lockstep) => self.check_patience()?,
            (Some(clock), Pace::Realtime(speed)) => self.run_if_due(clock, speed),
        }
        Ok(())
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
            self.queue.skip(&header.said, time);
        }
        let is_another = incarnation.is_some_and(|life| life != self.node.incarnation());
        if is_another {
            self.next.fill(0);
        }
        let place = Pose { p_world: header.p_world.unwrap_or(pose.p_world), ..pose };
        self.node.begin(&self.mission, incarnation, &place);
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
            self.node.step(time, step);
            return Ok(());
        };
        let (labels, depth) = frame_wire::decode(pixels, camera.pixels())
            .map_err(|error| AgentError::Frame { step, error })?;
        header.check(camera, self.period_s, &labels)?;
        let detections = header.detections.clone();
        self.node.look(time, || Frame { step, pose, labels, depth, detections });
        Ok(())
    }

    /// Another agent said something.
    fn hear(&mut self, src: AgentId, physical: Option<PhysicalHeader>, bytes: Vec<u8>) {
        // In real time one that was starved is behind all others.
        let newest = self.desk.newest_frame().filter(|_| self.pace == Pace::Lockstep);
        if let Err(error) = self.queue.take(src, physical, bytes, newest) {
            self.desk.refusals().count("message", &error);
            return;
        }
        match self.pace {
            Pace::Lockstep => self.try_turn(),
            Pace::Realtime(_) if self.clock.is_some() => {
                let heard = self.queue.hear_all();
                heard.iter().for_each(|said| self.node.hear(said));
            }
            Pace::Realtime(_) => {}
        }
    }

    /// Says what there is to say.
    fn talk(&mut self, now: SimTime) {
        for said in self.node.say(now) {
            if let Some(next) = self.next.get_mut(usize::from(said.channel.0)) {
                *next = said.sequence + 1;
            }
            self.desk.say(&said);
        }
    }
}

/// Ctrl-C and SIGTERM end the process, and so does the end of standard input if it is a leash.
fn watch_for_the_end(inbox: &Inbox, leashed: bool) {
    let sender = inbox.sender();
    let signal = sender.clone();
    let installed = ctrlc::set_handler(move || {
        if signal.try_send(News::End(EndedBy::Signal)).is_err() {
            std::process::exit(130);
        }
    });
    if let Err(error) = installed {
        tracing::warn!(%error, "cannot listen to Ctrl-C");
    }
    if leashed {
        parent_death::when_let_go(move || {
            let _ = sender.send(News::End(EndedBy::Spawner));
        });
    }
}
