//! What an agent's process tells the world at the end of a step: a [`Flown`] on the wire.

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::fate::{Fate, Sent};
use csat_netem::link::{LinkId, Links};
use csat_proto::agent::Agent;
use csat_proto::ids::AgentId;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::fleet::{Flown, Passage};
use crate::plug::Mission;
use crate::timing::StageTimes;

/// What an agent's process tells at the end of a step; `R` is the mission's report.
#[derive(Debug, Serialize, Deserialize)]
pub struct Account<R> {
    /// Which process.
    pub process: u64,
    /// The hash of the agent's state; 0 while it is down.
    pub digest: u64,
    /// What it knows; `None` while it is down.
    pub report: Option<R>,
    /// What it reported, each as JSON.
    events: Vec<String>,
    /// What became of messages to it, in the order of sending.
    passages: Vec<(Sent, Fate)>,
    times: StageTimes,
    bytes_sent: u64,
    /// How many frames it looked at so far.
    pub looked: u64,
    /// What the links to it did so far.
    pub counters: Counters,
    /// The same, by link.
    pub links: Vec<(LinkId, LinkCounters)>,
}

impl<R: Serialize + DeserializeOwned> Account<R> {
    /// What `flown` says, for the wire, and that `looked` frames were looked at. Commands have been told
    /// already.
    pub fn new<M: Mission<Report = R>>(
        process: u64,
        flown: Flown<M>,
        looked: u64,
        links: &Links,
    ) -> Self {
        let events = flown.events.iter();
        Self {
            process,
            digest: flown.digest,
            report: flown.report,
            events: events.filter_map(|event| serde_json::to_string(event).ok()).collect(),
            passages: flown.passages.into_iter().map(|p| (p.sent, p.fate)).collect(),
            times: flown.times,
            bytes_sent: flown.bytes_sent,
            looked,
            counters: links.counters().clone(),
            links: links.per_link().map(|(id, counters)| (id, counters.clone())).collect(),
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
        let passages = std::mem::take(&mut self.passages).into_iter();
        Flown {
            agent,
            digest: self.digest,
            report: self.report.take(),
            commands: Vec::new(),
            events: self.events.iter().filter_map(event).collect(),
            passages: passages
                .map(|(sent, fate)| Passage { sent, bytes: [].into(), fate })
                .collect(),
            arrivals: Vec::new(),
            times: self.times,
            bytes_sent: self.bytes_sent,
        }
    }
}
