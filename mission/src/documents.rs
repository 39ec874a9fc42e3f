//! From an agent's step to the documents of docs/topics.md: those that every agent has ([`OWN`]), and one
//! for each layer of its mission.
//!
//! All that it takes is what the agent's own process knows (its [`Flown`]), so a process shows its
//! own agent, and the recorder in the world's process shows them all, with the same words.

use std::collections::BTreeMap;

use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::Step;
use geojson::Feature;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::fleet::{Flown, Passage};
use crate::mission::{Mission, Report};
use crate::picture::{Content, Layer, to_millimetre};
use crate::shape;

/// The names of the documents that every agent has, besides those of its layers.
pub const OWN: [&str; 4] = ["pose", "plan", "stats", "links"];

/// The names of all documents of an agent.
pub fn names<M: Mission>() -> impl Iterator<Item = &'static str> {
    OWN.into_iter().chain(M::LAYERS.iter().map(|style| &*style.key))
}

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

/// All documents of an agent's step; `layers` is the [`Mission::picture`] of its report.
pub fn agent_documents<M: Mission>(
    mission: &M,
    step: &AgentStep<'_, M::Report>,
    layers: &[Layer],
) -> Vec<Document> {
    let own = [pose(mission, step), plan(step), stats(mission, step), links(step)];
    own.into_iter().chain(layers.iter().map(|layer| of_layer(step, layer))).collect()
}

/// A document with the head of its step.
fn headed<R>(step: &AgentStep<'_, R>, name: &str, body: impl Serialize) -> Document {
    Document::json(step.topic(name), &Headed { head: step.head(), body })
}

/// `pose`.
#[derive(Debug, Serialize)]
struct PoseBody {
    #[serde(flatten)]
    pose: Stance,
    footprint: Vec<[f64; 2]>,
}

/// `plan`.
#[derive(Debug, Serialize)]
struct PlanBody {
    poses: Vec<Stance>,
}

/// Where an agent is or will be.
#[derive(Debug, Serialize)]
struct Stance {
    p_world: [f64; 3],
    yaw_rad: f64,
    /// A level vehicle has neither.
    #[serde(skip_serializing_if = "is_zero")]
    pitch_rad: f64,
    #[serde(skip_serializing_if = "is_zero")]
    roll_rad: f64,
}

fn is_zero(angle: &f64) -> bool {
    *angle == 0.0
}

impl From<&Pose> for Stance {
    fn from(&Pose { p_world, yaw_rad, pitch_rad, roll_rad }: &Pose) -> Self {
        let p_world = p_world.map(to_millimetre);
        let [yaw_rad, pitch_rad, roll_rad] = [yaw_rad, pitch_rad, roll_rad].map(micro);
        Self { p_world, yaw_rad, pitch_rad, roll_rad }
    }
}

/// `stats`.
#[derive(Debug, Serialize)]
struct StatsBody<'a> {
    #[serde(flatten)]
    numbers: Map<String, Value>,
    bytes_sent: u64,
    rejected: &'a BTreeMap<String, u64>,
    withheld: u64,
}

fn pose<M: Mission>(mission: &M, step: &AgentStep<'_, M::Report>) -> Document {
    let (camera, pose) = (mission.camera(step.agent), step.report.pose());
    let footprint = camera.map_or_else(Vec::new, |camera| camera.at(pose).footprint());
    let footprint = footprint.into_iter().map(|p| p.map(to_millimetre)).collect();
    headed(step, "pose", PoseBody { pose: pose.into(), footprint })
}

fn plan<R: Report>(step: &AgentStep<'_, R>) -> Document {
    let poses = step.report.planned().iter().map(Stance::from).collect();
    headed(step, "plan", PlanBody { poses })
}

fn stats<M: Mission>(mission: &M, step: &AgentStep<'_, M::Report>) -> Document {
    let defined = mission.stats(step.report).into_iter().filter_map(|(name, value)| {
        let value = value?;
        Some((name.to_owned(), number(value)))
    });
    let tally = step.report.tally();
    let body = StatsBody {
        numbers: defined.collect(),
        bytes_sent: step.bytes_sent,
        rejected: &tally.rejected,
        withheld: tally.withheld,
    };
    headed(step, "stats", body)
}

/// A number as JSON: a count without decimals.
fn number(value: f64) -> Value {
    let is_count = value.fract() == 0.0 && value.abs() < 1e15;
    if is_count { (value as i64).into() } else { micro(value).into() }
}

/// The document of a layer: GeoJSON of areas and points, else JSON.
fn of_layer<R>(step: &AgentStep<'_, R>, layer: &Layer) -> Document {
    let features: Vec<Feature> = match &layer.content {
        Content::Cells(cells) => return headed(step, &layer.key, cells),
        Content::Heights(oem) => return headed(step, &layer.key, oem),
        Content::Heat(heat) => return headed(step, &layer.key, heat),
        Content::Areas(areas) => {
            let geometry = areas.iter().map(|area| shape::multi_polygon(&area.shapes));
            geometry.zip(layer.properties()).map(feature).collect()
        }
        Content::Points(marks) => {
            let geometry = marks.iter().map(|mark| shape::point(mark.point));
            geometry.zip(layer.properties()).map(feature).collect()
        }
    };
    Document::geojson(step.topic(&layer.key), shape::collection(features, &step.head()))
}

fn feature((geometry, properties): (geojson::GeometryValue, &Map<String, Value>)) -> Feature {
    shape::feature(geometry, Value::Object(properties.clone()))
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
    headed(step, "links", body)
}

/// A number to six decimals: documents are for people, and digits that mean nothing take room.
pub fn micro(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
