//! The sets of the knowledge that the planner reads, as rasters.

use csat_proto::raster::Raster;

use crate::estimate::state::Knowledge;

/// The sets that the planner reads, as rasters.
#[derive(Debug)]
pub struct PlannerRasters {
    /// X^Δ (5.11).
    pub wanted: Raster,
    /// X°.
    pub margin: Raster,
    /// The ground that was recently hidden to an agent (5.30).
    pub hidden_recently: Raster,
}

impl PlannerRasters {
    /// The sets of `knowledge`, whose X̄ is `unexplored`.
    pub fn of(knowledge: &Knowledge, unexplored: Raster) -> Self {
        let grid = *unexplored.grid();
        let mut wanted = unexplored;
        for set in knowledge.targets.values() {
            wanted.union_with(&Raster::of_region(grid, set.region()));
        }
        Self {
            wanted,
            margin: Raster::of_region(grid, knowledge.margin.region()),
            hidden_recently: knowledge.hidden_recently(),
        }
    }
}
