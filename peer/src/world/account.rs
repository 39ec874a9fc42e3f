//! What an agent's process tells the world at the end of a step: a [`Flown`] on the wire.

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

/// What an agent's process tells at the end of a step; `R` is the mission's report.
#[derive(Debug, Serialize, Deserialize)]
pub struct Account<R> {
    /// Whose, and of what.
    pub head: Head,
    /// The hash of the agent's state; 0 while it is down.
    pub digest: u64,
    /// What it knows; `None` while it is down, but for [`Asked::All`].
    pub report: Option<R>,
    times: StageTimes,
    bytes_sent: u64,
    /// What the links to it did so far.
    pub counters: Counters,
    /// The same, by link.
    pub links: Vec<(LinkId, LinkCounters)>,
    told: StepTold,
}

/// What a process tells of itself.
#[derive(Debug, Serialize, Deserialize)]
pub struct Head {
    /// Which process.
    pub process: u64,
    /// Of which step.
    pub step: Step,
    /// After which turn; 0 in real time.
    pub round: u32,
    /// What it was asked for.
    pub asked: Asked,
    /// How many frames it looked at so far.
    pub looked: u64,
    /// What it did not believe of what others said, by kind.
    pub refused: BTreeMap<String, u64>,
}

/// What an agent reported in a step, and what became of messages to it, up to now.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct StepTold {
    /// Each as JSON.
    events: Vec<String>,
    /// In the order of sending.
    passages: Vec<(Sent, Fate)>,
}

/// What the world asks of agents at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Asked {
    /// What the monitor and the metrics need.
    Brief,
    /// Maps, too.
    Full,
    /// At the end of the mission: maps, too, and also of those that are down.
    All,
}

impl Asked {
    /// How much that is.
    pub fn detail(self) -> Detail {
        if self == Self::Brief { Detail::Brief } else { Detail::Full }
    }
}

impl StepTold {
    /// Another step begins.
    pub fn clear(&mut self) {
        self.events.clear();
        self.passages.clear();
    }

    /// Adds what happened since it was asked last.
    pub fn add<M: Mission>(&mut self, flown: &Flown<M>) {
        let events = flown.events.iter();
        self.events.extend(events.filter_map(|event| serde_json::to_string(event).ok()));
        self.passages.extend(flown.passages.iter().map(|p| (p.sent, p.fate)));
    }
}

impl<R: Serialize + DeserializeOwned> Account<R> {
    /// What `flown` says, for the wire, with all that was told in this step. Commands have been told
    /// already.
    pub fn new<M: Mission<Report = R>>(
        head: Head,
        flown: Flown<M>,
        told: &StepTold,
        links: &Links,
    ) -> Self {
        Self {
            head,
            digest: flown.digest,
            report: flown.report,
            times: flown.times,
            bytes_sent: flown.bytes_sent,
            counters: links.counters().clone(),
            links: links.per_link().map(|(id, counters)| (id, counters.clone())).collect(),
            told: told.clone(),
        }
    }

    /// On the wire: postcard.
    pub fn encode(&self) -> Vec<u8> {
        postcard::to_stdvec(self).expect("an account always serialises")
    }

    /// The inverse of [`Self::encode`].
    ///
    /// # Errors
    /// When the bytes are no account of this version.
    pub fn decode(bytes: &[u8]) -> Result<Self, postcard::Error> {
        postcard::from_bytes(bytes)
    }

    /// What it says of the step. The report goes along: another call finds none.
    pub fn flown<M: Mission<Report = R>>(&mut self, agent: AgentId) -> Flown<M> {
        type Event<M> = <<M as Mission>::Agent as Agent>::Event;
        let event = |text: &String| serde_json::from_str::<Event<M>>(text).ok();
        let StepTold { events, passages } = std::mem::take(&mut self.told);
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
