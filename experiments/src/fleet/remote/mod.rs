//! Each agent in a process of its own: the world's side of `proto::control`.
//!
//! | module | what it does |
//! |---|---|
//! | [`port`] | the world's Zenoh keys |
//! | [`roster`] | which processes there are, and whether all hear each other |
//! | [`account`] | what a process tells at the end of a step |
//! | [`ended`] | what the links of processes that are gone did |
//!
//! In lockstep a step is a frame for each agent, then turns until nothing is left for the instant,
//! then a report of each; each round waits for everybody. In real time frames and the end of the step
//! come by the clock, and whoever is late is left out.

pub mod account;
pub mod ended;
pub mod port;
pub mod roster;

use std::time::Duration;

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::LinkId;
use csat_proto::control::{Done, FrameHeader, Order, Pace, SaidSoFar};
use csat_proto::ids::AgentId;
use csat_proto::time::{SimTime, Step};
use csat_world::camera::Renderer;
use rayon::prelude::*;

use self::account::Account;
use self::ended::Ended;
use self::port::{News, Port};
use self::roster::Roster;
use super::{Brief, Fleet, Flown, Frames};
use crate::plug::{Detail, Mission};
use crate::stages;
use crate::timing::{StageTimes, Stopwatch};
use crate::wire::rarely::Rarely;

/// The part of a period after which a step in real time is closed.
const CLOSE_SHARE: f64 = 0.8;

/// How long processes may take to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// Why a fleet of processes cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// Somebody did not do something in time.
    #[error("waited {limit_s} s for UAVs {whom} to {what}")]
    Late {
        /// How long.
        limit_s: u64,
        /// Their indexes.
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
    /// Frames that it was shown in all its lives.
    shown: u64,
    /// Frames that processes that are gone looked at.
    ended_looked: u64,
}

/// The agents of a mission in processes of their own.
pub struct RemoteFleet<M: Mission> {
    port: Port,
    roster: Roster,
    pace: Pace,
    patience: Duration,
    members: Vec<Member<M::Report>>,
    renderers: Vec<Renderer>,
    render_times: Vec<StageTimes>,
    /// Since the first frame, in real time.
    clock: Option<Stopwatch>,
    /// Reports that were not understood.
    damaged: Rarely,
}

impl<M: Mission> RemoteFleet<M> {
    /// A fleet that nobody has joined yet. Whoever is waited for longer than `patience` is named in
    /// an error.
    pub fn new(mission: &M, port: Port, roster: Roster, pace: Pace, patience: Duration) -> Self {
        let count = roster.count();
        let renderers = (0..count).map(|_| Renderer::new(mission.camera()));
        let member = |_| Member {
            done: None,
            said: None,
            due: None,
            commands: Vec::new(),
            account: None,
            is_new: false,
            ended: Ended::default(),
            shown: 0,
            ended_looked: 0,
        };
        Self {
            renderers: renderers.collect(),
            members: (0..count).map(member).collect(),
            render_times: vec![StageTimes::default(); count],
            port,
            roster,
            pace,
            patience,
            clock: None,
            damaged: Rarely::new(),
        }
    }

    /// Waits until every agent has a process and all hear each other. `progress` is told how many do.
    ///
    /// # Errors
    /// When somebody is missing for too long, or `is_over` says so.
    pub fn gather(
        &mut self,
        limit: Duration,
        is_over: impl Fn() -> bool,
        mut progress: impl FnMut(usize),
    ) -> Result<(), FleetError> {
        let watch = Stopwatch::start();
        loop {
            self.roster.admit();
            let missing = self.roster.missing();
            progress(self.roster.count() - missing.len());
            if missing.is_empty() {
                return Ok(());
            }
            if is_over() {
                return Err(FleetError::Interrupted);
            }
            let left = watch.left(limit);
            if left.is_zero() {
                return Err(late(limit, &missing, self.roster.what_is_missing(&missing)));
            }
            if let Some(news) = self.port.next(left.min(Duration::from_millis(100))) {
                self.take(news);
            }
        }
    }

    /// Ends the mission for all processes, and waits a little until they are gone: what is said last
    /// must not be overtaken by the end of this process.
    pub fn end(&mut self, reason: &str) {
        self.port.voice().say(&Order::End { reason: reason.to_owned() });
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
        if self.roster.process(agent) != Some(done.process) {
            return;
        }
        let member = &mut self.members[usize::from(agent.0)];
        member.done = Some((done.step, done.round));
        member.said = done.said;
        member.due = done.due;
        member.commands.extend(done.commands);
    }

    fn account(&mut self, agent: AgentId, bytes: &[u8]) {
        match Account::<M::Report>::decode(bytes) {
            Ok(account) if self.roster.process(agent) == Some(account.process) => {
                let member = &mut self.members[usize::from(agent.0)];
                member.account = Some(account);
                member.is_new = true;
            }
            Ok(_) => {}
            Err(error) => {
                if let Some(times) = self.damaged.another() {
                    tracing::warn!(%agent, %error, times, "report not understood");
                }
            }
        }
    }

    /// A process is gone, and with it what was on its way to it.
    fn bury(&mut self, agent: AgentId) {
        let member = &mut self.members[usize::from(agent.0)];
        if let Some(account) = &mut member.account {
            let counters = std::mem::take(&mut account.counters);
            member.ended.bury(counters, std::mem::take(&mut account.links));
            member.ended_looked += std::mem::take(&mut account.looked);
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
                None => return Err(late(self.patience, &open, what())),
            }
        }
    }

    /// Renders and sends all frames.
    fn show_frames(&mut self, brief: &Brief) {
        let said: Vec<SaidSoFar> = self.said();
        for agent in self.roster.present() {
            let index = usize::from(agent.0);
            self.members[index].shown += u64::from(brief.lives[index].is_some());
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
            let (frame, rendered) =
                stages::collect(|| incarnation.map(|_| brief.frame(renderer, agent)));
            *times = rendered;
            let header = FrameHeader {
                step: brief.step,
                time: brief.now,
                next: brief.next,
                pose: brief.poses[index],
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
            self.port.voice().say(&Order::Turn { step, round, now, said: said.clone() });
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
        let (step, full) = (brief.step, brief.detail == Detail::Full);
        self.port.voice().say(&Order::Close { step, full });
        self.wait(|| format!("report on step {step}"), |member| member.is_new)
    }

    fn fly_realtime(&mut self, brief: &Brief, speed: f64) {
        let step = f64::from(brief.step.0);
        let period_s = brief.next.seconds_since(brief.now);
        self.pass_time(step + CLOSE_SHARE, period_s, speed);
        let full = brief.detail == Detail::Full;
        self.port.voice().say(&Order::Close { step: brief.step, full });
        self.pass_time(step + 1.0, period_s, speed);
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

fn late(limit: Duration, whom: &[AgentId], what: String) -> FleetError {
    let whom: Vec<String> = whom.iter().map(ToString::to_string).collect();
    FleetError::Late { limit_s: limit.as_secs(), whom: whom.join(", "), what }
}

impl<M: Mission> Fleet<M> for RemoteFleet<M> {
    type Error = FleetError;

    fn attendance(&mut self) -> Vec<Option<u64>> {
        while let Some(news) = self.port.next(Duration::ZERO) {
            self.take(news);
        }
        self.roster.admit();
        self.roster.attendance()
    }

    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<M>>, FleetError> {
        if self.roster.present().next().is_none() {
            return Err(FleetError::Deserted { step: brief.step });
        }
        if let Pace::Realtime(speed) = self.pace {
            let period_s = brief.next.seconds_since(brief.now);
            self.pass_time(f64::from(brief.step.0), period_s, speed);
        }
        self.show_frames(brief);
        match self.pace {
            Pace::Lockstep => self.fly_lockstep(brief)?,
            Pace::Realtime(speed) => self.fly_realtime(brief, speed),
        }
        Ok(self.collect())
    }

    fn show(&mut self) -> Vec<Option<M::Report>> {
        self.members.iter_mut().for_each(|member| member.is_new = false);
        self.port.voice().say(&Order::Show);
        if let Err(error) = self.wait(|| "show what they know".to_owned(), |member| member.is_new) {
            tracing::warn!(%error, "the picture of the end is not complete");
        }
        self.members.iter_mut().map(|m| m.account.as_mut().and_then(|a| a.report.take())).collect()
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
            let looked = member.account.as_ref().map_or(0, |account| account.looked);
            let missed = member.shown.saturating_sub(member.ended_looked + looked);
            Frames { shown: member.shown, missed }
        };
        self.members.iter().map(frames).collect()
    }
}
