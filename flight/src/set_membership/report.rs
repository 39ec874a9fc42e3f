//! What an agent of the set-membership mission tells its observers.

use csat_agent::agent::SetMembershipAgent;
use csat_proto::camera::{Pose, PoseError};
use csat_proto::ids::{AgentId, TargetId};
use csat_proto::model::Ground;
use csat_proto::oem::{OemCell, OemPatch};
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::Region;
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

use csat_mission::mission::{self, Detail, Tally};

/// What an agent knows at the end of a step. Sets are on the grid of `proto::region`, bit by bit
/// the agent's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The step that its knowledge is of.
    pub step: Step,
    /// The pose of its last frame, or where a ground station stands.
    pub pose: Pose,
    /// L and X_j, by increasing index, outer.
    pub targets: Vec<(TargetId, Region)>,
    /// X̄, outer.
    pub unexplored: Region,
    /// X°, inner.
    pub obstacle_margin: Region,
    /// C of its last frame, inner; `None` before the first one, and of a ground station.
    pub clear_ground: Option<Region>,
    /// D: whom its last frame identifies.
    pub detected: Vec<TargetId>,
    /// Where it intends to be at the ends of the blocks of T_MPC.
    pub planned: Vec<Pose>,
    /// φ(X̄ ∩ X^h), per cent of the ground.
    pub hidden_pct: f64,
    /// (5.45), per cent; `None` where nothing is hidden.
    pub oem_iou_pct: Option<f64>,
    /// How old its news of the other UAVs are, mean over them, seconds; `None` where there are none.
    pub news_age_s: Option<f64>,
    /// The greater half-width of the box of its position over the ground, metres; `None` where it is exact.
    pub pose_error_m: Option<f64>,
    /// The agents that it has proven to have said something false, by index.
    pub liars: Vec<AgentId>,
    /// What it did not believe and did not say.
    pub tally: Tally,
    /// Its maps, where [`Detail::Full`] was asked for.
    pub maps: Option<Maps>,
}

/// The rasters of an agent's knowledge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Maps {
    /// X^h, hidden ground.
    pub hidden: Raster,
    /// The grid of the OEM.
    pub oem_grid: Grid,
    /// All cells of the OEM that are known.
    pub oem: OemPatch,
}

impl Report {
    /// What `agent` knows now.
    pub fn of(agent: &mut SetMembershipAgent, detail: Detail) -> Self {
        let expected = agent.predicted_hidden();
        let agent = &*agent;
        let knowledge = agent.knowledge();
        let ground = Ground { size_m: agent.config().ground.size_m };
        let measured = agent.measured();
        let unexplored = knowledge.unexplored.region();
        let hidden_cells = knowledge.unexplored_cells().count_common(&knowledge.hidden);
        let hidden_m2 = f64::from(hidden_cells) * knowledge.hidden.grid().cell_m.powi(2);
        let rejected = agent.rejected().iter().map(|(reason, n)| ((*reason).to_owned(), *n));
        let maps = || Maps {
            hidden: knowledge.hidden.clone(),
            oem_grid: *knowledge.oem.grid(),
            oem: OemPatch::of(knowledge.oem.known()),
        };
        let targets = knowledge.targets.iter();
        Self {
            step: knowledge.step,
            pose: *agent.pose(),
            targets: targets.map(|(&j, set)| (j, set.region().clone())).collect(),
            unexplored: unexplored.clone(),
            obstacle_margin: knowledge.margin.region().clone(),
            clear_ground: measured.map(|m| m.clear_ground.region().clone()),
            detected: measured.into_iter().flat_map(|m| &m.targets).map(|t| t.target).collect(),
            planned: agent.planned().to_vec(),
            hidden_pct: percent_of(&ground, hidden_m2),
            oem_iou_pct: measured.and_then(|m| oem_iou_pct(&m.hidden, &expected)),
            news_age_s: agent.news_age_s(),
            pose_error_m: pose_error_m(agent.pose_error()),
            liars: agent.liars().collect(),
            tally: Tally { rejected: rejected.collect(), withheld: agent.withheld() },
            maps: (detail == Detail::Full).then(maps),
        }
    }

    /// The set that contains a target: its own when it is identified, else X̄.
    pub fn set_of(&self, target: TargetId) -> &Region {
        let own = self.targets.iter().find(|(j, _)| *j == target);
        own.map_or(&self.unexplored, |(_, set)| set)
    }

    /// How many corners all sets have together.
    pub fn vertices(&self) -> u32 {
        let sets = self.targets.iter().map(|(_, set)| set);
        let sets = sets.chain([&self.unexplored, &self.obstacle_margin]);
        sets.map(|set| set.vertex_count() as u32).sum()
    }
}

fn pose_error_m(error: &PoseError) -> Option<f64> {
    let [x, y, _] = error.p_world;
    (!error.is_none()).then_some(x.max(y))
}

impl mission::Report for Report {
    fn step(&self) -> Step {
        self.step
    }

    fn pose(&self) -> &Pose {
        &self.pose
    }

    fn planned(&self) -> &[Pose] {
        &self.planned
    }

    fn tally(&self) -> &Tally {
        &self.tally
    }
}

impl Maps {
    /// Every cell of the OEM, row by row.
    pub fn oem_cells(&self) -> Vec<OemCell> {
        let mut cells = vec![OemCell::Unexplored; self.oem_grid.cells()];
        for delta in self.oem.deltas() {
            if let Some(cell) = cells.get_mut(delta.cell as usize) {
                *cell = delta.state;
            }
        }
        cells
    }
}

/// An area in per cent of the ground.
pub fn percent_of(ground: &Ground, area_m2: f64) -> f64 {
    100.0 * area_m2 / ground.area_m2()
}

/// One UAV's term of (5.45): intersection over union of the ground that is hidden, H^CVS, and the
/// ground expected to be, H^OEM ∩ F, in per cent; `None` when both are empty.
pub fn oem_iou_pct(hidden: &Raster, expected: &Raster) -> Option<f64> {
    let common = hidden.count_common(expected);
    let union = hidden.count() + expected.count() - common;
    (union > 0).then(|| 100.0 * f64::from(common) / f64::from(union))
}
