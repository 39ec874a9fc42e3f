//! Whose knowledge counts: `guidance.objective`, for `str4`.
//!
//! Under `own` all ground of X^Δ counts: perhaps nobody ever tells this UAV what the others see. Under `fleet` it matters
//! what all UAVs know together. UAVs that hear each other plan together under either. Where a silent UAV flies is not
//! known, but it has the same planner. So each UAV answers for its share of the region ([`Share`]), and ground in the
//! shares of silent UAVs counts `guidance.str4.silent` of what other ground counts.

use csat_proto::ids::AgentId;
use csat_proto::raster::{Grid, Raster};

use super::division::Share;
use super::rounded_views::VisibleCells;
use crate::config::{AgentConfig, Objective};

/// What cells cost, in units of 1 / [`FULL`] cells.
#[derive(Debug, Clone)]
pub(super) struct GroundCost {
    /// The shares of the UAVs by index, in a region of this size, metres; none under `own`.
    shares: Vec<Share>,
    size_m: [f64; 2],
    /// The cost of a cell in the share of a silent UAV.
    silent: i64,
    /// The cells of these shares; `None` when no UAV is silent.
    left: Option<Raster>,
    grid: Grid,
}

/// The cost of a cell that counts in full.
pub(super) const FULL: i64 = 1 << 20;

impl GroundCost {
    /// Of `config.guidance`, on a grid.
    pub(super) fn new(config: &AgentConfig, grid: Grid) -> Self {
        let uavs = match config.guidance.objective {
            Objective::Own => 0,
            Objective::Fleet => config.fleet.count,
        };
        Self {
            shares: (0..uavs).map(|id| Share::of(config, AgentId(id))).collect(),
            size_m: config.ground.size_m,
            silent: (config.guidance.str4.silent * FULL as f64).round() as i64,
            left: None,
            grid,
        }
    }

    /// Begins a decision, in which these UAVs are silent.
    pub(super) fn load(&mut self, silent: &[AgentId]) {
        let shares: Vec<&Share> =
            silent.iter().filter_map(|id| self.shares.get(usize::from(id.0))).collect();
        self.left = (!shares.is_empty()).then(|| {
            let mut left = Raster::empty(self.grid);
            shares.iter().for_each(|share| share.add_to(&mut left, self.size_m));
            left
        });
    }

    /// The cost of the cells of a set.
    pub(super) fn of(&self, set: &Raster) -> i64 {
        self.cost(set.count(), |left| set.count_common(left))
    }

    /// The cost of the cells of a set that are seen.
    pub(super) fn seen(&self, view: &VisibleCells, set: &Raster) -> i64 {
        self.cost(view.count_in(set), |left| view.count_in_both(set, left))
    }

    fn cost(&self, cells: u32, of_left: impl Fn(&Raster) -> u32) -> i64 {
        let left = self.left.as_ref().map_or(0, |left| i64::from(of_left(left)));
        FULL * i64::from(cells) - (FULL - self.silent) * left
    }
}
