//! What an agent of road clearing tells its observers.

use csat_clearing::agent::ClearingAgent;
use csat_clearing::bitmap::Bitmap;
use csat_clearing::formation::RoleName;
use csat_mission::mission::{self, Detail, Tally};
use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

/// What an agent knows and does at the end of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Whose.
    pub agent: AgentId,
    /// Its life.
    pub incarnation: Incarnation,
    /// The step of its last frame.
    pub step: Step,
    /// Where it is, in truth, `world`: the agent does not know.
    pub pose: Pose,
    /// What it does.
    pub role: RoleName,
    /// The pixels of its last image that it calls cleared; row 0 is north. `None` of an agent that claims nothing.
    pub claims: Option<Bitmap>,
    /// Pixels of its frontier.
    pub frontier_px: u32,
    /// From its frontier to the edge of the image, pixels; `None` without a frontier.
    pub frontier_to_edge_px: Option<u16>,
    /// Whether it says that it can neither move nor split its frontier.
    pub is_stalled: bool,
    /// Whether it says that a cleaner is lost.
    pub is_lost: bool,
    /// What it counted in its life.
    pub counts: Counts,
    /// The path that it has flown, by its odometry, metres.
    pub path_m: f64,
    /// What it did not believe and did not say.
    pub tally: Tally,
    /// What there is to draw, where [`Detail::Full`] was asked for.
    pub maps: Option<Maps>,
}

/// What an agent counted in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Sub-frontiers that it took over.
    pub splits: u64,
    /// Times that its frontier shrank because another cleaner had cleared the road beyond.
    pub encounters: u64,
    /// Times that it joined a formation as a helper.
    pub merges: u64,
    /// Bytes said on the channel of short range.
    pub hbsr_bytes: u64,
    /// Bytes said on the channel of long range.
    pub lblr_bytes: u64,
}

/// What there is to draw: masks of the last image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Maps {
    /// The frontier.
    pub frontier: Bitmap,
    /// Road that is known to be cleared and guarded by others.
    pub foreign: Bitmap,
    /// Road that is not known to be cleared.
    pub unknown: Bitmap,
}
