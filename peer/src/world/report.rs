//! The report of an agent's process at the end of a step: a [`Flown`] on the wire.

use std::collections::BTreeMap;

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::fate::{Fate, Sent};
use csat_netem::link::{LinkId, Links};
use csat_proto::agent::Agent;
use csat_proto::ids::AgentId;
use csat_proto::time::Step;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use csat_mission::fleet::{Flown, Passage};
use csat_mission::mission::{Detail, Mission};
use csat_mission::timing::StageTimes;

/// The report of an agent's process at the end of a step; `R` is the mission's report.
#[derive(Debug, Serialize, Deserialize)]
pub struct StepReport<R> {
    /// Who reports, and on what.
    pub header: ReportHeader,
    /// The hash of the agent's state; 0 while it is down.
    pub digest: u64,
    /// What the agent knows; `None` while it is down, except in the report at the end of the mission.
    pub report: Option<R>,
    times: StageTimes,
    bytes_sent: u64,
    /// What the links to the agent did so far.
    pub counters: Counters,
    /// The same, by link.
    pub links: Vec<(LinkId, LinkCounters)>,
    log: StepLog,
}

/// Who reports, and on what.
#[derive(Debug, Serialize, Deserialize)]
pub struct ReportHeader {
    /// The process that reports.
    pub process: u64,
    /// The step that it reports on.
    pub step: Step,
    /// The turn that it finished last; 0 in real time.
    pub round: u32,
    /// What the world asked for.
    pub scope: Scope,
    /// How many frames the process handed to its agent so far.
    pub frames: u64,
    /// How many samples the process refused so far, by kind.
    pub refused: BTreeMap<String, u64>,
}

/// The events of an agent in a step, and the fates of messages to it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct StepLog {
    /// Each as JSON.
    events: Vec<String>,
    /// In the order of sending.
    passages: Vec<(Sent, Fate)>,
}

/// What the world asks of agents at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scope {
    /// What the monitor and the metrics need.
    Brief,
    /// Maps, too.
    Full,
    /// At the end of the mission: maps, too, also of agents that are down.
    Final,
}

impl Scope {
    /// The scope of a report at the end of a step.
    pub fn of_step(full: bool) -> Self {
        if full { Self::Full } else { Self::Brief }
    }

    /// The detail of the mission's report.
    pub fn detail(self) -> Detail {
        if self == Self::Brief { Detail::Brief } else { Detail::Full }
    }
}

impl StepLog {
    /// Another step begins.
    pub fn clear(&mut self) {
        self.events.clear();
        self.passages.clear();
    }

    /// Adds what happened since the last call.
    pub fn add<M: Mission>(&mut self, flown: &Flown<M>) {
        let events = flown.events.iter();
        self.events.extend(events.filter_map(|event| serde_json::to_string(event).ok()));
        self.passages.extend(flown.passages.iter().map(|p| (p.sent, p.fate)));
    }
}

impl<R: Serialize + DeserializeOwned> StepReport<R> {
    /// The report of `flown`, with the log of the whole step. It has no commands: the process sent them
    /// with its answers.
    pub fn new<M: Mission<Report = R>>(
        header: ReportHeader,
        flown: Flown<M>,
        log: &StepLog,
        links: &Links,
    ) -> Self {
        Self {
            header,
            digest: flown.digest,
            report: flown.report,
            times: flown.times,
            bytes_sent: flown.bytes_sent,
            counters: links.counters().clone(),
            links: links.per_link().map(|(id, counters)| (id, counters.clone())).collect(),
            log: log.clone(),
        }
    }

    /// The report as postcard.
    pub fn encode(&self) -> Vec<u8> {
        postcard::to_stdvec(self).expect("a report has a postcard form")
    }

    /// The inverse of [`Self::encode`].
    ///
    /// # Errors
    /// When the bytes are no report of this version.
    pub fn decode(bytes: &[u8]) -> Result<Self, postcard::Error> {
        postcard::from_bytes(bytes)
    }

    /// What the report says of the step. It moves the mission's report out: another call returns none.
    pub fn flown<M: Mission<Report = R>>(&mut self, agent: AgentId) -> Flown<M> {
        type Event<M> = <<M as Mission>::Agent as Agent>::Event;
        let event = |text: &String| serde_json::from_str::<Event<M>>(text).ok();
        let StepLog { events, passages } = std::mem::take(&mut self.log);
        let passage = |(sent, fate)| Passage { sent, bytes: [].into(), fate };
        Flown {
            agent,
            digest: self.digest,
            report: self.report.take(),
            commands: Vec::new(),
            events: events.iter().filter_map(event).collect(),
            passages: passages.into_iter().map(passage).collect(),
            arrivals: Vec::new(),
            times: self.times,
            bytes_sent: self.bytes_sent,
        }
    }
}
