//! From an agent's step to the documents of docs/topics.md.
//!
//! All that it takes is what the agent's own process knows (its [`Flown`]), so a process shows its
//! own agent, and the recorder in the world's process shows them all, with the same words.

use std::collections::BTreeMap;

use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::Step;
use serde::Serialize;

use crate::fleet::{Flown, Passage};
use crate::mission::Mission;
use crate::picture::Knowledge;

/// One JSON document that people get to see.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Document {
    /// Its name below `csat/{run}/`, such as `view/0/pose`.
    pub topic: String,
    /// What kind of JSON it is.
    pub encoding: Encoding,
    /// The JSON.
    pub body: String,
}

/// What kind of JSON a document is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoding {
    /// JSON.
    Json,
    /// GeoJSON, with metres for coordinates.
    GeoJson,
}

impl Encoding {
    /// Its media type, which is Zenoh's name for it, too.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::GeoJson => "application/geo+json",
        }
    }

    /// The encoding of a media type that documents have.
    pub fn of_media_type(media_type: &str) -> Option<Self> {
        [Self::Json, Self::GeoJson].into_iter().find(|e| e.media_type() == media_type)
    }
}

impl Document {
    /// A document of a value that is JSON.
    pub fn json(topic: impl Into<String>, value: &impl Serialize) -> Self {
        let body = serde_json::to_string(value).expect("names and numbers are JSON");
        Self { topic: topic.into(), encoding: Encoding::Json, body }
    }

    /// A document of GeoJSON text.
    pub fn geojson(topic: impl Into<String>, body: String) -> Self {
        Self { topic: topic.into(), encoding: Encoding::GeoJson, body }
    }
}

/// One step of an agent that runs, as told to its observers.
#[derive(Debug, Clone, Copy)]
pub struct AgentStep<'a, R> {
    /// Whose.
    pub agent: AgentId,
    /// Its life.
    pub incarnation: Incarnation,
    /// k.
    pub step: Step,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// What it knows.
    pub report: &'a R,
    /// What became of messages; those to others do not count.
    pub passages: &'a [Passage],
    /// Bytes it sent in this step.
    pub bytes_sent: u64,
}

impl<'a, R> AgentStep<'a, R> {
    /// What an agent's own process knows of its step; `None` while the agent is down. Who has the
    /// passages elsewhere puts them in.
    pub fn of<M: Mission<Report = R>>(
        flown: &'a Flown<M>,
        incarnation: Incarnation,
        step: Step,
        time_s: f64,
    ) -> Option<Self> {
        let (report, passages) = (flown.report.as_ref()?, &flown.passages[..]);
        let (agent, bytes_sent) = (flown.agent, flown.bytes_sent);
        Some(Self { agent, incarnation, step, time_s, report, passages, bytes_sent })
    }

    /// The members that each of its documents has.
    pub fn head(&self) -> Head {
        let &Self { agent, incarnation, step, time_s, .. } = self;
        Head { agent, incarnation, step, time_s }
    }

    /// The name of one of its documents.
    pub fn topic(&self, name: &str) -> String {
        format!("view/{}/{name}", self.agent)
    }
}

/// The members that all documents of an agent have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Head {
    /// Whose.
    pub agent: AgentId,
    /// Its life.
    pub incarnation: Incarnation,
    /// k.
    pub step: Step,
    /// Simulated time, seconds.
    pub time_s: f64,
}

/// A head and the members of a body.
#[derive(Debug, Serialize)]
pub struct Headed<T> {
    /// Whose and when.
    #[serde(flatten)]
    pub head: Head,
    /// What.
    #[serde(flatten)]
    pub body: T,
}

/// All documents of an agent's step: the mission's own, and what became of messages to it. `known`
/// is the mission's [`Mission::view`] of the report.
pub fn agent_documents<M: Mission>(
    mission: &M,
    step: &AgentStep<'_, M::Report>,
    known: &Knowledge,
) -> Vec<Document> {
    let mut documents = mission.documents(step, known);
    documents.push(links(step));
    documents
}

/// What became of messages to an agent, counted.
#[derive(Debug, Serialize)]
struct Links {
    heard: Vec<Heard>,
}

/// What became of the messages of one sender on one radio, as far as it is the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Heard {
    src: AgentId,
    channel: ChannelId,
    /// `delivered`, `corrupted` or the reason of the loss.
    outcome: &'static str,
    count: u32,
    /// The mean, seconds; of what arrives.
    #[serde(skip_serializing_if = "Option::is_none")]
    delay_s: Option<f64>,
}

/// What became of messages to an agent, counted.
pub fn links<R>(step: &AgentStep<'_, R>) -> Document {
    let mut counts: BTreeMap<(AgentId, ChannelId, &'static str), (u32, f64)> = BTreeMap::new();
    for Passage { sent, fate, .. } in step.passages.iter().filter(|p| p.sent.dst == step.agent) {
        for copy in fate.copies() {
            let (outcome, delay_s) = match copy {
                Ok(delivery) => (
                    if delivery.corrupted { "corrupted" } else { "delivered" },
                    delivery.at.seconds_since(sent.time),
                ),
                Err(reason) => (reason.name(), 0.0),
            };
            let count = counts.entry((sent.src, sent.channel, outcome)).or_default();
            count.0 += 1;
            count.1 += delay_s;
        }
    }
    let heard = counts.into_iter().map(|((src, channel, outcome), (count, sum_s))| {
        let arrives = matches!(outcome, "delivered" | "corrupted");
        let delay_s = arrives.then(|| micro(sum_s / f64::from(count)));
        Heard { src, channel, outcome, count, delay_s }
    });
    let body = Links { heard: heard.collect() };
    Document::json(step.topic("links"), &Headed { head: step.head(), body })
}

/// A number to six decimals: documents are for people, and digits that mean nothing take room.
pub fn micro(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
