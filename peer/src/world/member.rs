//! What the world knows of one agent's process.

use std::collections::BTreeMap;

use csat_mission::fleet::{Flown, Frames};
use csat_mission::mission::Mission;
use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::LinkId;
use csat_proto::command::Command;
use csat_proto::control::{Done, SaidSoFar};
use csat_proto::ids::AgentId;
use csat_proto::time::{SimTime, Step};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::past::PastProcesses;
use super::report::StepReport;
use super::silence::Silence;
use crate::wire::refusals;

/// What the world knows of one agent's process; `R` is the mission's report.
#[derive(Debug)]
pub struct Member<R> {
    /// The step and turn of its last answer.
    pub done: Option<(Step, u32)>,
    /// How many messages it has sent.
    pub said: Option<SaidSoFar>,
    /// When the agent is to run next.
    pub due: Option<SimTime>,
    commands: Vec<Command>,
    /// Its last report.
    report: Option<StepReport<R>>,
    /// Whether that report is one of the present request.
    pub has_reported: bool,
    past: PastProcesses,
    /// Frames of the agent's camera, or steps of an agent without one, so far, whether or not there was a
    /// process to receive them.
    pub frames: u64,
    /// Whether the process has sent something since the step began.
    pub has_sent: bool,
    /// When the world received nothing from it.
    pub silence: Silence,
}

impl<R> Default for Member<R> {
    fn default() -> Self {
        Self {
            done: None,
            said: None,
            due: None,
            commands: Vec::new(),
            report: None,
            has_reported: false,
            past: PastProcesses::default(),
            frames: 0,
            has_sent: false,
            silence: Silence::default(),
        }
    }
}

impl<R: Serialize + DeserializeOwned> Member<R> {
    /// Takes an answer to a frame or a turn.
    pub fn answer(&mut self, done: Done) {
        self.has_sent = true;
        self.done = Some((done.step, done.round));
        self.said = done.said;
        self.due = done.due;
        self.commands.extend(done.commands);
    }

    /// Takes a report.
    pub fn take_report(&mut self, report: StepReport<R>) {
        self.report = Some(report);
        (self.has_reported, self.has_sent) = (true, true);
    }

    /// The process is gone, and with it the messages on their way to it.
    pub fn lose_process(&mut self) {
        if let Some(report) = &mut self.report {
            self.past.add(report);
        }
        (self.done, self.said, self.due, self.has_reported) = (None, None, None, false);
        self.commands.clear();
    }

    /// What the process said of the step; empty if it said nothing.
    pub fn flown<M: Mission<Report = R>>(&mut self, agent: AgentId) -> Flown<M> {
        let report = self.report.as_mut().filter(|_| std::mem::take(&mut self.has_reported));
        let flown = report.map_or_else(|| Flown::nothing(agent), |report| report.flown(agent));
        Flown { commands: std::mem::take(&mut self.commands), ..flown }
    }

    /// The mission's report of the present request.
    pub fn mission_report(&mut self) -> Option<R> {
        self.report.as_mut().filter(|_| self.has_reported)?.report.take()
    }

    /// What the links to the agent did so far.
    pub fn counters(&self) -> Counters {
        let mut all = self.past.counters.clone();
        self.report.iter().for_each(|report| all.add(&report.counters));
        all
    }

    /// The same, by link.
    pub fn per_link(&self) -> BTreeMap<LinkId, LinkCounters> {
        let now = self.report.as_ref().map(|report| &report.links[..]);
        self.past.with(now.unwrap_or_default())
    }

    /// What became of the agent's frames so far.
    pub fn frames(&self) -> Frames {
        let looked = self.report.as_ref().map_or(0, |report| report.header.frames);
        let missed = self.frames.saturating_sub(self.past.frames + looked);
        Frames { shown: self.frames, missed, silent_s: self.silence.spans_s() }
    }

    /// Adds the samples that the agent's processes refused so far, by kind.
    pub fn add_refused(&self, to: &mut BTreeMap<String, u64>) {
        refusals::add(to, &self.past.refused);
        let report = self.report.iter();
        report.for_each(|report| refusals::add(to, &report.header.refused));
    }
}
