//! Each agent in a process of its own: the world's side of `proto::control`.
//!
//! | module | what it does |
//! |---|---|
//! | [`port`] | the world's Zenoh keys |
//! | [`roster`] | which processes there are, and whether all hear each other |
//! | `hearing` | what processes say, and what of it is believed |
//! | `lockstep`, `realtime` | how a step goes |
//! | `presence` | whether any process is left |
//! | [`account`] | what a process tells at the end of a step |
//! | [`silence`] | since when nothing is heard of a process |
//! | [`now`] | what an answer must be of to be believed |
//! | [`ended`] | what the links of processes that are gone did |
//!
//! In lockstep a step is a frame for each agent, then turns until nothing is left for the instant,
//! then a report of each; each round waits for everybody. In real time frames and the end of the step
//! come by the clock, and whoever is late is left out.

pub mod account;
pub mod ended;
mod error;
mod hearing;
mod lockstep;
pub mod now;
pub mod port;
mod presence;
mod realtime;
pub mod roster;
pub mod silence;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::LinkId;
use csat_proto::control::{FrameHeader, Order, Pace, SaidSoFar};
use csat_proto::ids::AgentId;
use csat_proto::time::{SimTime, Step};
use csat_world::camera::Renderer;
use rayon::prelude::*;

use self::account::{Account, Asked};
use self::ended::Ended;
pub use self::error::FleetError;
use self::now::Now;
use self::port::Port;
use self::roster::Roster;
use self::silence::Silence;
use crate::wire::refusals;
use crate::wire::waiting::Waiting;
use csat_mission::fleet::{Brief, Fleet, Flown, Frames, renderers};
use csat_mission::mission::Mission;
use csat_mission::stages;
use csat_mission::timing::StageTimes;
use csat_mission::timing::Stopwatch;
use csat_mission::words::named;

/// The part of a period after which a step in real time is closed.
const CLOSE_SHARE: f64 = 0.8;

/// In real time, how long nothing is to be heard of a process until that is told, seconds.
const SILENCE_S: f64 = 1.0;

/// How often the user is looked after while nothing comes.
const LOOK: Duration = Duration::from_millis(100);

/// How long processes may take to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// One agent's process, as far as the current step goes.
#[derive(Debug, Default)]
struct Member<R> {
    /// The round it has finished, of the step it has finished it in.
    done: Option<(Step, u32)>,
    said: Option<SaidSoFar>,
    due: Option<SimTime>,
    commands: Vec<csat_proto::command::YawCommand>,
    /// What it told last.
    account: Option<Account<R>>,
    /// Whether that is new.
    is_new: bool,
    /// What became of messages to processes that are gone.
    ended: Ended,
    /// Frames of its camera so far, or steps where it has none, whether or not there was a process to look at them.
    shown: u64,
    /// Whether its process has said anything since the step began.
    is_heard: bool,
    silence: Silence,
}

/// The agents of a mission in processes of their own.
pub struct RemoteFleet<M: Mission> {
    port: Port,
    roster: Roster,
    pace: Pace,
    patience: Duration,
    members: Vec<Member<M::Report>>,
    /// By index; `None` for agents without camera.
    renderers: Vec<Option<Renderer>>,
    render_times: Vec<StageTimes>,
    /// Since the first frame, in real time.
    clock: Option<Stopwatch>,
    /// Whether processes that end are started again; if so, it is set when the user wants the mission to
    /// end.
    restarts: Option<Arc<AtomicBool>>,
    /// Since when no process takes part.
    deserted: Option<Stopwatch>,
    /// What is flown now.
    now: Now,
}

impl<M: Mission> RemoteFleet<M> {
    /// A fleet that nobody has joined yet. Whoever is waited for longer than `patience` is named in
    /// an error.
    pub fn new(mission: &M, port: Port, roster: Roster, pace: Pace, patience: Duration) -> Self {
        let count = roster.count();
        let member = |_| Member {
            done: None,
            said: None,
            due: None,
            commands: Vec::new(),
            account: None,
            is_new: false,
            ended: Ended::default(),
            shown: 0,
            is_heard: false,
            silence: Silence::default(),
        };
        Self {
            renderers: renderers(mission, count),
            members: (0..count).map(member).collect(),
            render_times: vec![StageTimes::default(); count],
            port,
            roster,
            pace,
            patience,
            clock: None,
            restarts: None,
            deserted: None,
            now: Now::new(pace),
        }
    }

    /// The same, for processes that are started again when they end. When none is left it waits for one,
    /// until `interrupted`.
    pub fn with_restarts(self, interrupted: Arc<AtomicBool>) -> Self {
        Self { restarts: Some(interrupted), ..self }
    }

    /// Waits until every agent has a process and all hear each other; says who is missing meanwhile.
    ///
    /// # Errors
    /// When somebody is missing for too long, or `is_over` says so.
    pub fn gather(
        &mut self,
        limit: Duration,
        is_over: impl Fn() -> bool,
    ) -> Result<(), FleetError> {
        let watch = Stopwatch::start();
        let mut waiting = Waiting::start();
        loop {
            self.roster.admit();
            let missing = self.roster.awaited();
            if missing.is_empty() {
                return Ok(());
            }
            if is_over() {
                return Err(FleetError::Interrupted);
            }
            let left = watch.left(limit);
            if left.is_zero() {
                return Err(self.late(limit, &missing, self.roster.what_is_missing(&missing)));
            }
            waiting.tell(|| {
                format!("{} to {}", self.names(&missing), self.roster.what_is_missing(&missing))
            });
            if let Some(news) = self.port.next(left.min(LOOK)) {
                self.take(news);
            }
        }
    }

    /// Ends the mission for all processes, and waits a little until they are gone: what is said last
    /// must not be overtaken by the end of this process.
    pub fn end(&mut self, reason: &str) {
        self.port.voice().say(Order::End { reason: reason.to_owned() });
        let watch = Stopwatch::start();
        while self.roster.is_joined() {
            match self.port.next(watch.left(FAREWELL)) {
                Some(news) => self.take(news),
                None => break,
            }
        }
    }

    /// Waits until `is_finished` holds for every agent that has a process.
    fn wait(
        &mut self,
        what: impl Fn() -> String,
        is_finished: impl Fn(&Member<M::Report>) -> bool,
    ) -> Result<(), FleetError> {
        let watch = Stopwatch::start();
        loop {
            let is_open = |agent: &AgentId| !is_finished(&self.members[usize::from(agent.0)]);
            let open: Vec<AgentId> = self.roster.present().filter(is_open).collect();
            if open.is_empty() {
                return Ok(());
            }
            match self.port.next(watch.left(self.patience)) {
                Some(news) => self.take(news),
                None => return Err(self.late(self.patience, &open, what())),
            }
        }
    }

    fn names(&self, agents: &[AgentId]) -> String {
        let uavs = self.renderers.iter().flatten().count() as u16;
        named(agents.iter().map(|agent| agent.0), uavs)
    }

    fn late(&self, limit: Duration, whom: &[AgentId], what: String) -> FleetError {
        FleetError::Late { limit_s: limit.as_secs(), whom: self.names(whom), what }
    }

    /// Renders and sends all frames; an agent without camera gets one without pixels.
    fn show_frames(&mut self, brief: &Brief) {
        let said: Vec<SaidSoFar> = self.said();
        for (member, is_down) in self.members.iter_mut().zip(&brief.is_down_by_schedule) {
            member.shown += u64::from(!is_down);
        }
        let Self { port, roster, renderers, render_times, .. } = self;
        let (voice, roster, said) = (port.voice(), &*roster, &said);
        let each = renderers.par_iter_mut().zip(render_times).enumerate();
        each.for_each(|(index, (renderer, times))| {
            let agent = AgentId(index as u16);
            if roster.process(agent).is_none() {
                return;
            }
            let incarnation = brief.lives[index];
            let camera = renderer.as_mut().filter(|_| incarnation.is_some());
            let (frame, rendered) =
                stages::collect(|| camera.map(|renderer| brief.frame(renderer, agent)));
            *times = rendered;
            let header = FrameHeader {
                world: voice.world(),
                step: brief.step,
                time: brief.now,
                next: brief.next,
                pose: brief.poses[index],
                p_world: None,
                incarnation,
                detections: frame.as_ref().map(|f| f.detections.clone()).unwrap_or_default(),
                said: said.clone(),
            };
            voice.frame(agent, &header, frame.as_ref());
        });
    }

    fn said(&self) -> Vec<SaidSoFar> {
        self.members.iter().filter_map(|member| member.said.clone()).collect()
    }

    /// What everybody told of the step, and nothing of those who told nothing.
    fn collect(&mut self) -> Vec<Flown<M>> {
        let members = self.members.iter_mut().zip(&self.render_times).enumerate();
        members
            .map(|(index, (member, render_times))| {
                let commands = std::mem::take(&mut member.commands);
                let is_new = std::mem::take(&mut member.is_new);
                let account = member.account.as_mut().filter(|_| is_new);
                let mut flown = match account {
                    Some(account) => account.flown(AgentId(index as u16)),
                    None => Flown::nothing(AgentId(index as u16)),
                };
                flown.commands = commands;
                flown.times.render = render_times.render;
                flown
            })
            .collect()
    }
}

impl<M: Mission> Fleet<M> for RemoteFleet<M> {
    type Error = FleetError;

    fn attendance(&mut self) -> Vec<Option<u64>> {
        while let Some(news) = self.port.next(Duration::ZERO) {
            self.take(news);
        }
        self.roster.admit();
        if self.pace == Pace::Lockstep {
            self.await_restart();
        }
        self.roster.attendance()
    }

    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<M>>, FleetError> {
        self.check_presence(brief.step)?;
        if let Pace::Realtime(speed) = self.pace {
            let period_s = brief.next.seconds_since(brief.now);
            self.pass_time(f64::from(brief.step.0), period_s, speed);
        }
        self.now.begin(brief.step, &brief.lives);
        self.show_frames(brief);
        match self.pace {
            Pace::Lockstep => self.fly_lockstep(brief)?,
            Pace::Realtime(speed) => self.fly_realtime(brief, speed),
        }
        self.note_silence(brief);
        Ok(self.collect())
    }

    fn show(&mut self) -> Vec<Option<M::Report>> {
        self.members.iter_mut().for_each(|member| member.is_new = false);
        self.now.asked = Some(Asked::All);
        self.port.voice().say(Order::Show { step: self.now.step });
        if let Err(error) = self.wait(|| "show what they know".to_owned(), |member| member.is_new) {
            tracing::warn!(%error, "the picture of the end is not complete");
        }
        let report = |member: &mut Member<M::Report>| {
            member
                .account
                .as_mut()
                .filter(|_| member.is_new)
                .and_then(|account| account.report.take())
        };
        self.members.iter_mut().map(report).collect()
    }

    fn counters(&self) -> Counters {
        let mut all = Counters::default();
        for member in &self.members {
            all.add(&member.ended.all);
            member.account.iter().for_each(|account| all.add(&account.counters));
        }
        all
    }

    fn per_link(&self) -> Vec<(LinkId, LinkCounters)> {
        let link = |member: &Member<M::Report>| {
            let now = member.account.as_ref().map(|account| &account.links[..]);
            member.ended.with(now.unwrap_or_default())
        };
        let mut links: Vec<_> = self.members.iter().flat_map(link).collect();
        links.sort_by_key(|(id, _)| *id);
        links
    }

    fn frames(&self) -> Vec<Frames> {
        let frames = |member: &Member<M::Report>| {
            let looked = member.account.as_ref().map_or(0, |account| account.head.looked);
            let missed = member.shown.saturating_sub(member.ended.looked + looked);
            Frames { shown: member.shown, missed, silent_s: member.silence.spans_s() }
        };
        self.members.iter().map(frames).collect()
    }

    fn refused(&self) -> BTreeMap<String, u64> {
        let mut all = self.port.refusals().counts();
        for member in &self.members {
            refusals::add(&mut all, &member.ended.refused);
            let account = member.account.iter();
            account.for_each(|account| refusals::add(&mut all, &account.head.refused));
        }
        all
    }
}
