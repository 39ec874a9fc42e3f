//! Each agent in a process of its own: the world's side of `proto::control`.
//!
//! | module | what it does |
//! |---|---|
//! | [`port`] | the world's Zenoh keys |
//! | [`roster`] | which processes there are, and whether all hear each other |
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
pub mod now;
pub mod port;
pub mod roster;
pub mod silence;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::LinkId;
use csat_proto::control::{Done, FrameHeader, Order, Pace, SaidSoFar};
use csat_proto::ids::AgentId;
use csat_proto::time::{SimTime, Step};
use csat_world::camera::Renderer;
use rayon::prelude::*;

use self::account::{Account, Asked};
use self::ended::Ended;
use self::now::Now;
use self::port::{News, Port};
use self::roster::Roster;
use self::silence::Silence;
use super::{Brief, Fleet, Flown, Frames, renderers};
use crate::plug::{Detail, Mission};
use crate::stages;
use crate::timing::{StageTimes, Stopwatch};
use crate::wire::refusals;
use crate::wire::waiting::Waiting;
use crate::words::named;

/// The part of a period after which a step in real time is closed.
const CLOSE_SHARE: f64 = 0.8;

/// In real time, how long nothing is to be heard of a process until that is told, seconds.
const SILENCE_S: f64 = 1.0;

/// How often the user is looked after while nothing comes.
const LOOK: Duration = Duration::from_millis(100);

/// How long processes may take to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// Why a fleet of processes cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// Somebody did not do something in time.
    #[error("waited {limit_s} s for {whom} to {what}")]
    Late {
        /// How long.
        limit_s: u64,
        /// Their names.
        whom: String,
        /// What was waited for.
        what: String,
    },
    /// The user wants the mission to end.
    #[error("ended by the user before all agents were there")]
    Interrupted,
    /// All agents' processes ended.
    #[error("no agent's process is left at step {step}; `csat spawn --restart` brings them back")]
    Deserted {
        /// k.
        step: Step,
    },
    /// All agents' processes ended, and those that were to be started again did not come.
    #[error("waited {limit_s} s at step {step} for an agent's process to come back")]
    Abandoned {
        /// How long.
        limit_s: u64,
        /// k.
        step: Step,
    },
}

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

    /// Takes note of what a process says.
    fn take(&mut self, news: News) {
        match news {
            News::Join(query) => self.roster.join(query),
            News::Ready(agent, ready) => self.roster.ready(agent, &ready),
            News::Here(agent) => self.roster.here(agent),
            News::Gone(agent) => {
                if self.roster.gone(agent) {
                    self.bury(agent);
                }
            }
            News::Done(agent, done) => self.done(agent, done),
            News::Account(agent, bytes) => self.account(agent, &bytes),
        }
    }

    fn done(&mut self, agent: AgentId, done: Done) {
        if let Err(reason) = self.check_done(agent, &done) {
            self.port.refusals().count("answer", &format!("agent {agent}: {reason}"));
            return;
        }
        let member = &mut self.members[usize::from(agent.0)];
        member.is_heard = true;
        member.done = Some((done.step, done.round));
        member.said = done.said;
        member.due = done.due;
        member.commands.extend(done.commands);
    }

    fn check_done(&self, agent: AgentId, done: &Done) -> Result<(), String> {
        self.check_process(agent, done.process)?;
        let Member { done: last, said, .. } = &self.members[usize::from(agent.0)];
        self.now.check_done(agent, *last, said.as_ref(), done)
    }

    fn check_process(&self, agent: AgentId, process: u64) -> Result<(), String> {
        match self.roster.process(agent) {
            Some(own) if own == process => Ok(()),
            _ => Err(format!("process {process} does not fly it")),
        }
    }

    fn account(&mut self, agent: AgentId, bytes: &[u8]) {
        let account = Account::<M::Report>::decode(bytes).map_err(|error| error.to_string());
        let checked = account.and_then(|account| {
            self.check_process(agent, account.head.process)?;
            self.now.check_report(&account.head)?;
            Ok(account)
        });
        match checked {
            Ok(account) if self.now.is_all(&account.head) => {
                let member = &mut self.members[usize::from(agent.0)];
                member.account = Some(account);
                (member.is_new, member.is_heard) = (true, true);
            }
            Ok(_) => {}
            Err(reason) => {
                self.port.refusals().count("report", &format!("agent {agent}: {reason}"));
            }
        }
    }

    /// A process is gone, and with it what was on its way to it.
    fn bury(&mut self, agent: AgentId) {
        let member = &mut self.members[usize::from(agent.0)];
        if let Some(account) = &mut member.account {
            let counters = std::mem::take(&mut account.counters);
            member.ended.bury(counters, std::mem::take(&mut account.links));
            member.ended.looked += std::mem::take(&mut account.head.looked);
            refusals::add(&mut member.ended.refused, &std::mem::take(&mut account.head.refused));
        }
        (member.done, member.said, member.due, member.is_new) = (None, None, None, false);
        member.commands.clear();
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

    /// In lockstep, when no process is left: waits until one that was started again takes part.
    fn await_restart(&mut self) {
        let Some(interrupted) = self.restarts.clone() else { return };
        let watch = Stopwatch::start();
        while self.is_deserted()
            && !interrupted.load(Ordering::SeqCst)
            && !watch.left(self.patience).is_zero()
        {
            if let Some(news) = self.port.next(LOOK) {
                self.take(news);
            }
            self.roster.admit();
        }
    }

    fn is_deserted(&self) -> bool {
        self.roster.present().next().is_none()
    }

    /// Whether a step can be flown: somebody is there or, if processes are started again, may still come.
    fn check_presence(&mut self, step: Step) -> Result<(), FleetError> {
        if !self.is_deserted() {
            self.deserted = None;
            return Ok(());
        }
        let since = *self.deserted.get_or_insert_with(Stopwatch::start);
        let Some(interrupted) = &self.restarts else { return Err(FleetError::Deserted { step }) };
        // In lockstep they have been waited for; in real time it goes on meanwhile.
        let may_come = self.pace != Pace::Lockstep && !since.left(self.patience).is_zero();
        if may_come || interrupted.load(Ordering::SeqCst) {
            return Ok(());
        }
        Err(FleetError::Abandoned { limit_s: self.patience.as_secs(), step })
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

    /// Turns until nothing is left before the next step.
    fn settle(&mut self, brief: &Brief) -> Result<(), FleetError> {
        let step = brief.step;
        let finished =
            |round: u32| move |member: &Member<M::Report>| member.done == Some((step, round));
        self.wait(|| format!("look at their frames of step {step}"), finished(0))?;
        let (mut now, mut round, mut heard) = (brief.now, 0, Vec::new());
        loop {
            let said = self.said();
            // What was said a moment ago may be due at once, which only its receivers know.
            if said == heard {
                let present = self.roster.present();
                let dues = present.filter_map(|agent| self.members[usize::from(agent.0)].due);
                match dues.min() {
                    Some(due) if due < brief.next => now = now.max(due),
                    _ => return Ok(()),
                }
            }
            round += 1;
            self.now.round = round;
            self.port.voice().say(Order::Turn { step, round, now, said: said.clone() });
            heard = said;
            self.wait(|| format!("finish turn {round} of step {step}"), finished(round))?;
        }
    }

    /// Until that many periods of real time after the first frame.
    fn pass_time(&mut self, periods: f64, period_s: f64, speed: f64) {
        let clock = *self.clock.get_or_insert_with(Stopwatch::start);
        let until = Duration::from_secs_f64((periods * period_s / speed).max(0.0));
        loop {
            let left = clock.left(until);
            if left.is_zero() {
                return;
            }
            if let Some(news) = self.port.next(left) {
                self.take(news);
            }
        }
    }

    fn fly_lockstep(&mut self, brief: &Brief) -> Result<(), FleetError> {
        self.settle(brief)?;
        let step = brief.step;
        self.close(brief.detail);
        self.wait(|| format!("report on step {step}"), |member| member.is_new)
    }

    /// Asks for what the step came to.
    fn close(&mut self, detail: Detail) {
        let full = detail == Detail::Full;
        self.now.asked = Some(if full { Asked::Full } else { Asked::Brief });
        self.port.voice().say(Order::Close { step: self.now.step, full });
    }

    fn fly_realtime(&mut self, brief: &Brief, speed: f64) {
        let step = f64::from(brief.step.0);
        let period_s = brief.next.seconds_since(brief.now);
        self.pass_time(step + CLOSE_SHARE, period_s, speed);
        self.close(brief.detail);
        self.pass_time(step + 1.0, period_s, speed);
    }

    /// Keeps account of who said nothing in a step that is over.
    fn note_silence(&mut self, brief: &Brief) {
        let least_s = match self.pace {
            Pace::Lockstep => 0.0,
            Pace::Realtime(speed) => SILENCE_S * speed,
        };
        let span_s = (brief.now.seconds(), brief.next.seconds());
        let members = self.members.iter_mut().zip(&brief.is_down_by_schedule).enumerate();
        for (index, (member, is_down)) in members {
            let is_heard = std::mem::take(&mut member.is_heard) || *is_down;
            if member.silence.note(span_s, is_heard, least_s) {
                let since_s = span_s.1 - member.silence.lasts_s();
                tracing::warn!(agent = index, since_s, "nothing is heard of its process");
            }
        }
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
