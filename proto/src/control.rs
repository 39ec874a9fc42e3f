//! What a world and the processes of its agents say to each other (docs/simulator.md).
//!
//! All of it is JSON but the pixels of a frame ([`crate::frame_wire`]) and the report for the
//! monitor, so that a simulator in any language can take the world's side. None of it passes through
//! `netem`, and none of it is told to the agents themselves.

use serde::{Deserialize, Serialize};

use crate::camera::Pose;
use crate::command::YawCommand;
use crate::frame::Detection;
use crate::ids::{AgentId, Incarnation, RunId};
use crate::time::{SimTime, Step};

/// The version of this protocol: processes of another one are refused.
pub const PROTOCOL: u32 = 1;

/// An agent's process wants to take part: the payload of its query.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Join {
    /// Its [`PROTOCOL`].
    pub protocol: u32,
    /// Its program and version, for people.
    pub program: String,
    /// Which agent.
    pub agent: AgentId,
    /// A number that no other process has.
    pub process: u64,
}

/// The world's reply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    /// Its [`PROTOCOL`].
    pub protocol: u32,
    /// The run.
    pub run: RunId,
    /// The scenario's name.
    pub name: String,
    /// The scenario in full, TOML.
    pub scenario: String,
    /// The GeoJSON of its imported town, if the scenario's `map.file` is one; only the links need it.
    pub map: Option<String>,
    /// How time passes.
    pub pace: Pace,
}

/// How time passes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// Everybody waits for everybody: the same result as in one process.
    Lockstep,
    /// Nobody waits: this many simulated seconds pass in a second.
    Realtime(f64),
}

/// An agent's process has heard others: sent again when that changes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ready {
    /// Which process.
    pub process: u64,
    /// Whose probes it has heard, with their processes.
    pub heard: Vec<(AgentId, u64)>,
}

/// A sign of life on the way that messages take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Probe {
    /// Whose.
    pub process: u64,
    /// Whether it wants to be answered.
    pub answer: bool,
}

/// The attachment of a frame: all but its pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameHeader {
    /// k.
    pub step: Step,
    /// The instant of the frame.
    pub time: SimTime,
    /// The instant of the next one.
    pub next: SimTime,
    /// Where the UAV is.
    pub pose: Pose,
    /// The agent's life, `None` while it is down: then there are no pixels.
    pub incarnation: Option<Incarnation>,
    /// The identified targets, by increasing index.
    pub detections: Vec<Detection>,
    /// What everybody said before this step: whoever joins now need not wait for that.
    pub said: Vec<SaidSoFar>,
}

/// What the world says to all, on `clock`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "order", rename_all = "kebab-case")]
pub enum Order {
    /// Lockstep: wait for what others said, let arrive what is due, and say what there is to say.
    Turn {
        /// k.
        step: Step,
        /// Counts the turns of a step, from 1.
        round: u32,
        /// Simulated time.
        now: SimTime,
        /// What everybody said so far.
        said: Vec<SaidSoFar>,
    },
    /// The step is over: report.
    Close {
        /// k.
        step: Step,
        /// Whether maps are wanted, too.
        full: bool,
    },
    /// Lockstep or not: tell everything once more, though the step is over.
    Show,
    /// The mission is over.
    End {
        /// Why.
        reason: String,
    },
}

/// How far an agent's messages are numbered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SaidSoFar {
    /// Whose.
    pub agent: AgentId,
    /// Of which life.
    pub incarnation: Incarnation,
    /// By channel, the number that the next message will have.
    pub next: Vec<u64>,
}

/// An agent's answer to a frame (round 0) or a turn, on `uav/{i}/command`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Which process.
    pub process: u64,
    /// k.
    pub step: Step,
    /// Which turn, 0 for the frame.
    pub round: u32,
    /// What it said so far; `None` while it is down.
    pub said: Option<SaidSoFar>,
    /// When something is to be done next; `None` if nothing is.
    pub due: Option<SimTime>,
    /// What the UAV is to do.
    pub commands: Vec<YawCommand>,
}
