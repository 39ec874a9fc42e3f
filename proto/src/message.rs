//! What agents of the set-membership mission say (`spec/sets.md` §4).
//!
//! Facts and snapshots are stamped, self-contained and atomic: each is applied whole or not at all,
//! and applying them in any order, or twice, gives the same knowledge.

use serde::{Deserialize, Serialize};

use crate::camera::Pose;
use crate::ids::TargetId;
use crate::raster::Raster;
use crate::region::Region;
use crate::time::Step;

/// The state of a cell of the occupancy-elevation map.
///
/// Cells form a join-semilattice: Unexplored < Occupied(h) < Empty, Occupied joins by the greater
/// height (paper §VI-C); heights are decimetres so that equal knowledge is equal bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum OemCell {
    /// Nothing known.
    Unexplored,
    /// An obstacle at most this high was seen there, in decimetres.
    Occupied {
        /// Greatest possible height, decimetres.
        height_dm: u16,
    },
    /// Only ground was seen there.
    Empty,
}

impl OemCell {
    /// The least upper bound of two states.
    pub fn join(self, other: Self) -> Self {
        // The derived order *is* the lattice order: it is total.
        self.max(other)
    }

    /// A number that tells states apart and keeps their order, for hashes.
    pub fn code(self) -> u32 {
        match self {
            Self::Unexplored => 0,
            Self::Occupied { height_dm } => 1 + u32::from(height_dm),
            Self::Empty => u32::MAX,
        }
    }
}

/// A cell of the OEM that changed, by its row-major index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct OemDelta {
    /// Row-major index of the cell.
    pub cell: u32,
    /// Its state.
    pub state: OemCell,
}

/// An identified target in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TargetFact {
    /// j.
    pub target: TargetId,
    /// X^{t,m}_j (4.4), outer: contains the location of j.
    pub location: Region,
    /// X̲^{t,m}_j (4.17), inner: contains no other target's location.
    pub exclusion: Region,
}

/// What the sender measured in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fact {
    /// The step of the frame.
    pub step: Step,
    /// C (4.6), inner: no target location is in it.
    pub clear_ground: Region,
    /// S° (4.12), inner: near an obstacle, never a target location. Only what is new to the sender.
    pub obstacle_margin: Region,
    /// The identified targets, by increasing index.
    pub targets: Vec<TargetFact>,
    /// H^CVS (4.23): ground hidden in this frame.
    pub hidden: Raster,
    /// Ground seen in this frame, on the same grid: it ends being hidden (5.43).
    pub seen: Raster,
    /// Cells of the OEM that this frame changed for the sender.
    pub oem: Vec<OemDelta>,
}

/// What the sender knew at one step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// The step.
    pub step: Step,
    /// L and X_j, by increasing index, outer.
    pub targets: Vec<(TargetId, Region)>,
    /// X̄, outer: contains the location of every target not listed.
    pub unexplored: Region,
    /// X°, inner.
    pub obstacle_margin: Region,
    /// That step's H^CVS.
    pub hidden: Raster,
    /// Ground seen in that step.
    pub seen: Raster,
    /// All cells of the OEM that are not Unexplored.
    pub oem: Vec<OemDelta>,
}

/// Where the sender intends to fly (thesis §5.3.2).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The step of the decision.
    pub step: Step,
    /// 0 for the first pass, 1 for the loopback.
    pub pass: u8,
    /// Predicted poses, one at the end of each block of T_MPC.
    pub poses: Vec<Pose>,
}

/// The body of an envelope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// One frame's measurements.
    Fact(Fact),
    /// All knowledge.
    Snapshot(Snapshot),
    /// A flight plan.
    Plan(Plan),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oem_join_is_commutative_associative_and_idempotent() {
        let states = [
            OemCell::Unexplored,
            OemCell::Occupied { height_dm: 30 },
            OemCell::Occupied { height_dm: 200 },
            OemCell::Empty,
        ];
        for a in states {
            assert_eq!(a.join(a), a);
            for b in states {
                assert_eq!(a.join(b), b.join(a));
                for c in states {
                    assert_eq!(a.join(b).join(c), a.join(b.join(c)));
                }
            }
        }
        assert_eq!(OemCell::Occupied { height_dm: 450 }.join(OemCell::Empty), OemCell::Empty);
    }
}
