//! What an agent of road clearing tells its observers.

use csat_clearing::agent::ClearingAgent;
pub use csat_clearing::agent::{Counters, Role};
use csat_clearing::bitmap::Bitmap;
use csat_mission::mission::{self, Tally};
use csat_mission::picture::Cells;
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
    pub role: Role,
    /// The pixels of its last image that it calls cleared; row 0 is north. `None` of an agent that did not look at it
    /// as a cleaner.
    pub claims: Option<Bitmap>,
    /// Pixels of its frontier.
    pub frontier_px: u32,
    /// From its frontier to the edge of the image, pixels; `None` without a frontier.
    pub frontier_to_edge_px: Option<u16>,
    /// Whether it says that it can neither move nor split its frontier.
    pub is_stalled: bool,
    /// Whether it says that a cleaner is lost.
    pub is_lost: bool,
    /// What happened to it in its life.
    pub counters: Counters,
    /// What it did not believe and did not say.
    pub tally: Tally,
    /// What there is to draw, where all that can be drawn was asked for.
    pub maps: Option<Maps>,
}

/// What there is to draw: masks of the last image, and what it cleared before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Maps {
    /// What it has called cleared so far: for observers, as agents remember their image only.
    pub trail: Cells,
    /// The frontier.
    pub frontier: Bitmap,
    /// Road that is known to be cleared and guarded by others.
    pub foreign: Bitmap,
    /// Road that is not known to be cleared.
    pub unknown: Bitmap,
}

impl Report {
    /// What `agent`, which is at `pose`, knows and does now; without maps.
    pub fn of(agent: &ClearingAgent, pose: &Pose) -> Self {
        let frontier = agent.frontier();
        // One that has just cleared the last of its frontier is a helper, and looked as a cleaner.
        let is_looking = agent.is_cleaner() || !agent.claims().is_empty();
        Self {
            agent: agent.config().id,
            incarnation: agent.incarnation(),
            step: agent.step(),
            pose: *pose,
            role: agent.role(),
            claims: is_looking.then(|| agent.claims().clone()),
            frontier_px: frontier.count(),
            frontier_to_edge_px: to_edge_px(frontier),
            is_stalled: agent.is_stalled(),
            is_lost: agent.has_lost(),
            counters: *agent.counters(),
            tally: Tally { rejected: agent.rejected().clone(), withheld: 0 },
            maps: None,
        }
    }
}

/// The least distance of a pixel to the edge of the image: 0 if one is in the first or last row or column.
fn to_edge_px(mask: &Bitmap) -> Option<u16> {
    let bounds = mask.bounds()?;
    let [rows, columns] = [(bounds.rows, mask.rows()), (bounds.columns, mask.columns())]
        .map(|([first, last], size)| first.min(size - 1 - last));
    Some(rows.min(columns))
}

impl Maps {
    /// What there is to draw of `agent`, which cleared `trail` so far.
    pub fn of(agent: &ClearingAgent, trail: Cells) -> Self {
        let masks = agent.masks();
        let frontier = agent.frontier().clone();
        let nothing = || Bitmap::new(frontier.rows(), frontier.columns());
        Self {
            trail,
            foreign: masks.map_or_else(nothing, |masks| masks.foreign().clone()),
            unknown: masks.map_or_else(nothing, |masks| masks.unknown().clone()),
            frontier,
        }
    }
}

impl mission::Report for Report {
    fn step(&self) -> Step {
        self.step
    }

    fn pose(&self) -> &Pose {
        &self.pose
    }

    /// An agent looks one step ahead.
    fn planned(&self) -> &[Pose] {
        &[]
    }

    fn tally(&self) -> &Tally {
        &self.tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_the_edge_is_that_of_the_nearest_pixel() {
        let mut mask = Bitmap::new(10, 10);
        assert_eq!(to_edge_px(&mask), None);
        mask.set(4, 5);
        assert_eq!(to_edge_px(&mask), Some(4));
        mask.set(7, 5);
        assert_eq!(to_edge_px(&mask), Some(2));
        mask.set(7, 9);
        assert_eq!(to_edge_px(&mask), Some(0));
    }
}
