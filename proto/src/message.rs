//! The messages of the set-membership mission (docs/links.md, "What agents say").
//!
//! Facts and snapshots are stamped, self-contained and atomic: each is applied whole or not at all,
//! and applying them in any order, or twice, gives the same knowledge.

use serde::{Deserialize, Serialize};

use crate::grid_pose::{GridPose, path};
use crate::ids::{AgentId, Incarnation, TargetId};
use crate::oem::OemPatch;
use crate::raster::Raster;
use crate::region::Region;
use crate::time::Step;

/// An identified target in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TargetFact {
    /// j.
    pub target: TargetId,
    /// X^{t,m}_j (4.4), outer: contains the location of j.
    pub location: Region,
    /// X̲^t_j (4.17), inner: contains no other target's location.
    pub exclusion: Region,
}

/// How many facts of one incarnation of an agent the sender holds, without gaps from the first fact on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct HeldFacts {
    /// The agent that stated the facts.
    pub origin: AgentId,
    /// Its incarnation.
    pub incarnation: Incarnation,
    /// The facts numbered 0 to `count` - 1 are held.
    pub count: u32,
}

/// What the sender holds, from which receivers see which facts it is missing (docs/links.md, "What
/// agents say"). Empty in modes without repair.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Digest {
    /// Facts that its knowledge contains, by increasing origin and incarnation; empty if the sender
    /// does not tell.
    pub facts: Vec<HeldFacts>,
    /// A hash of each block of its OEM, row-major.
    pub oem: Vec<u16>,
}

/// What the sender measured in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fact {
    /// The step of the frame.
    pub step: Step,
    /// How many facts this incarnation of the sender stated before.
    pub number: u32,
    /// What the sender held before this frame.
    pub held: Digest,
    /// C (4.6), inner: no target location is in it.
    pub clear_ground: Region,
    /// S° (4.12), inner: near an obstacle, never a target location. Only what is new to the sender.
    pub obstacle_margin: Region,
    /// The identified targets, by increasing index.
    pub targets: Vec<TargetFact>,
    /// H^CVS (4.23): ground hidden in this frame.
    pub hidden: Raster,
    /// Ground seen in this frame, on the same grid: it is no longer hidden (5.43).
    pub seen: Raster,
    /// Cells of the OEM by increasing index: those that this frame changed for the sender, and those
    /// that other agents are missing.
    pub oem: OemPatch,
}

/// What the sender knew before a frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// The step of this knowledge: the step before the frame, or the step of the frame if it was the
    /// first.
    pub step: Step,
    /// L and X_j, by increasing index, outer.
    pub targets: Vec<(TargetId, Region)>,
    /// X̄, outer: contains the location of every target not listed.
    pub unexplored: Region,
    /// X°, inner.
    pub obstacle_margin: Region,
}

/// One frame's measurements and everything that was known before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// The fact of the frame. [`Fact::held`] lists the facts that `known` contains, unless `known` was
    /// simplified too much to replace them.
    pub fact: Fact,
    /// What was known before.
    pub known: Known,
}

/// Where the sender intends to fly (thesis §5.3.2).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The step of the decision.
    pub step: Step,
    /// 0 for the first pass, 1 for the loopback.
    pub pass: u8,
    /// Predicted poses, one at the end of each block of T_MPC.
    #[serde(with = "path")]
    pub poses: Vec<GridPose>,
}

/// The plan of another UAV.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RelayedPlan {
    /// Whose plan it is.
    pub uav: AgentId,
    /// The plan.
    pub plan: Plan,
}

/// Plans of other UAVs, which the sender passes on to those that do not hear them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Relay {
    /// The step of the decision of the sender.
    pub step: Step,
    /// The newest plan of each, by increasing UAV.
    pub plans: Vec<RelayedPlan>,
}

/// The body of an envelope.
#[expect(clippy::large_enum_variant, reason = "a message is decoded, applied and gone")]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// One frame's measurements.
    Fact(Fact),
    /// One frame's measurements and all knowledge.
    Snapshot(Box<Snapshot>),
    /// A flight plan.
    Plan(Plan),
    /// Flight plans of others.
    Relay(Relay),
}
