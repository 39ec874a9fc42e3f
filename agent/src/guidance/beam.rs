//! `str4` and `str5`: ground counts for as long as it stays unseen.
//!
//! The cost of a candidate is Σ_k φ(X^Δ_k) over the blocks k = 1..N_MPC of the horizon, where (5.27)
//! has φ(X^Δ) at the end of the horizon only: ground that is seen early stops growing early. First
//! looks at buildings count more ([`super::first_looks`]). The horizon is long enough to look all
//! around and to fly on and look elsewhere. It is too long to try every sequence, so the search is a
//! beam search: per block the best candidates are kept, at most one per rounded pose, so that the
//! beam does not fill with detours to the same pose. What ground counts depends on the objective
//! ([`super::objective`]). `str5` also counts lost contact with the other UAVs
//! ([`super::connectivity`]).

use std::collections::BTreeSet;

use csat_proto::camera::Pose;
use csat_proto::raster::{Grid, Raster};

use super::connectivity::Connectivity;
use super::criterion::Terms;
use super::first_looks::FirstLooks;
use super::objective::{FULL, GroundCost};
use super::rollout::{Motion, ViewOverlap};
use super::rounded_views::{RoundedPose, RoundedViews};
use super::turning::Turning;
use super::{BlockKind, Decision, PlannerInput};
use crate::config::AgentConfig;

/// Cells of the search, metres, unless the rasters of its input are coarser.
const CELL_M: f64 = 4.0;

/// The planner of `str4` and `str5`.
#[derive(Debug, Clone)]
pub(super) struct Beam {
    grid: Grid,
    rounded_views: RoundedViews,
    first_looks: FirstLooks,
    /// The bonus of a cell at the first look, blocks.
    first_look: i64,
    ground_cost: GroundCost,
    /// Where contact counts.
    connectivity: Option<Connectivity>,
    motion: Motion,
    overlap: ViewOverlap,
    turning: Turning,
    /// U, radians, in the order of preference among increments of equal cost.
    increments: Vec<f64>,
    blocks: usize,
    width: usize,
    /// v_max·T_MPC, metres.
    growth_m: f64,
    scratch: Raster,
}

/// A candidate: increments up to some block.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// Its index among the candidates of the block before.
    parent: usize,
    /// The last yaw increment, radians; `pose` is at its end.
    increment_rad: f64,
    pose: Pose,
    place: RoundedPose,
    /// X^Δ, summed over the blocks, less the bonus of first looks and with the cost of lost contact:
    /// units of 1 / [`FULL`] cells.
    cost: i64,
}

impl Beam {
    /// The search of `config.guidance.str4` among `increments`, radians.
    pub(super) fn new(config: &AgentConfig, increments: Vec<f64>) -> Self {
        let cell_m = CELL_M.max(config.estimator.raster_cell_m);
        let grid = Grid::covering(&config.ground, cell_m);
        Self {
            grid,
            rounded_views: RoundedViews::new(grid, config),
            first_looks: FirstLooks::new(grid, config),
            first_look: config.guidance.str4.first_look.into(),
            ground_cost: GroundCost::new(config, grid),
            connectivity: Connectivity::new(config, grid.cells()),
            motion: Motion::new(config),
            overlap: ViewOverlap::new(config),
            turning: Turning::new(config, &increments),
            increments,
            blocks: config.guidance.blocks(),
            width: usize::from(config.guidance.str4.beam.max(1)),
            growth_m: config.targets.v_max_m_s * config.guidance.period_s,
            scratch: Raster::empty(grid),
        }
    }

    /// See [`super::Planner::plan`].
    pub(super) fn plan(
        &mut self,
        input: &PlannerInput<'_>,
        pose: &Pose,
        neighbours: &[Vec<Pose>],
    ) -> Decision {
        self.rounded_views.expect(&input.pose_error);
        self.first_looks.expect(&input.pose_error);
        self.rounded_views.load(input.oem);
        self.ground_cost.load(input.silent);
        let margin = self.coarse(input.margin);
        let remaining = self.coarse(input.wanted);
        if self.first_look > 0 {
            self.first_looks.load(&remaining, &margin, self.rounded_views.height_map(), pose);
        }
        let others: Vec<Vec<Pose>> =
            neighbours.iter().map(|plan| self.motion.forecast(plan, 0, self.blocks)).collect();
        if let Some(connectivity) = &mut self.connectivity {
            connectivity.load(&others, self.blocks);
        }
        let place = RoundedPose::of(pose, &self.grid);
        let root = Candidate { parent: 0, increment_rad: 0.0, pose: *pose, place, cost: 0 };
        let (mut beams, mut sets, mut nodes) = (vec![vec![root]], vec![remaining], 0);
        for (block, mut kept) in self.seen_by_others(pose, &others).into_iter().enumerate() {
            kept.union_with(&margin);
            self.pass_block(&mut sets, &kept, self.spread_m(block));
            let mut children =
                self.children(input, &beams[block], &sets, block, BlockKind::at(block));
            if children.is_empty() {
                children = self.children(input, &beams[block], &sets, block, BlockKind::Hopeless);
            }
            nodes += children.len() as u32;
            let best = self.best(children);
            sets = best.iter().map(|child| self.after_look(child, &sets[child.parent])).collect();
            beams.push(best);
        }
        let cells = beams[self.blocks][0].cost as f64 / FULL as f64;
        let cost = cells * self.grid.cell_m.powi(2);
        let (increments_rad, poses) = first_of(&beams);
        Decision { increments_rad, poses, cost, terms: Terms::default(), nodes }
    }

    /// The cells that hold a cell of `set`.
    fn coarse(&self, set: &Raster) -> Raster {
        let mut coarse = Raster::empty(self.grid);
        for (column, row) in set.iter() {
            if let Some((column, row)) = self.grid.cell_of(set.grid().centre(column, row)) {
                coarse.set(column, row);
            }
        }
        coarse
    }

    /// What the other UAVs would see from their poses at the end of each block, as far as their views
    /// may overlap the own ones.
    fn seen_by_others(&mut self, own: &Pose, others: &[Vec<Pose>]) -> Vec<Raster> {
        let mut seen = vec![Raster::empty(self.grid); self.blocks];
        for poses in others {
            for (pose, seen) in poses.iter().zip(&mut seen) {
                if self.overlap.may_see_the_same(own, pose) {
                    let place = RoundedPose::of(pose, &self.grid);
                    self.rounded_views.look(place).add_to(seen);
                    self.first_looks.look(place).add_to(seen);
                }
            }
        }
        seen
    }

    /// The radius by which X^Δ spreads in a block, metres. A cell is about as long as the way of a
    /// target in a block, so one cell is added in some blocks and none in others. Rounded up in every
    /// block, sets would grow by a third too fast.
    fn spread_m(&self, block: usize) -> f64 {
        let cells = |blocks: usize| (blocks as f64 * self.growth_m / self.grid.cell_m).round();
        // Half a cell less reaches the centres of exactly that many cells.
        ((cells(block + 1) - cells(block) - 0.5) * self.grid.cell_m).max(0.0)
    }

    /// Advances every X^Δ by a block, before the own look: it grows by f^t (4.24) and loses `kept`,
    /// where no target can be or another UAV looks.
    fn pass_block(&mut self, sets: &mut [Raster], kept: &Raster, spread_m: f64) {
        for set in sets {
            set.dilate_disc_into(spread_m, &mut self.scratch);
            self.scratch.subtract(kept);
            std::mem::swap(set, &mut self.scratch);
        }
    }

    /// The children of `beam` in a block; `sets` are X^Δ before the own look.
    fn children(
        &mut self,
        input: &PlannerInput<'_>,
        beam: &[Candidate],
        sets: &[Raster],
        block: usize,
        kind: BlockKind,
    ) -> Vec<Candidate> {
        let mut children = Vec::with_capacity(beam.len() * self.increments.len());
        for (parent, (candidate, set)) in beam.iter().zip(sets).enumerate() {
            let cost = candidate.cost + self.ground_cost.of(set);
            let choices = input.choices(&self.increments, &candidate.pose, kind);
            for (choice, increment_rad) in choices {
                let pose = self.turning.advance(&candidate.pose, choice);
                let place = RoundedPose::of(&pose, &self.grid);
                let seen = self.ground_cost.seen(self.rounded_views.look(place), set);
                let first = self.ground_cost.seen(self.first_looks.look(place), set);
                let links = self.connectivity.as_ref();
                let apart = links.map_or(0, |links| links.cost(block, pose.p_world));
                let cost = cost - seen - self.first_look * first + FULL * apart;
                children.push(Candidate { parent, increment_rad, pose, place, cost });
            }
        }
        children
    }

    /// The candidates that are kept, the best first.
    fn best(&self, mut children: Vec<Candidate>) -> Vec<Candidate> {
        // The sort is stable: at equal cost the child of the better parent comes first, then the
        // gentler turn.
        children.sort_by_key(|child| child.cost);
        let mut taken = BTreeSet::new();
        children.retain(|child| taken.len() < self.width && taken.insert(child.place));
        children
    }

    /// `set` after the last look of `candidate`.
    fn after_look(&mut self, candidate: &Candidate, set: &Raster) -> Raster {
        let mut set = set.clone();
        self.rounded_views.look(candidate.place).take_from(&mut set);
        self.first_looks.look(candidate.place).take_from(&mut set);
        set
    }
}

/// The increments and poses of the first candidate of the last beam.
fn first_of(beams: &[Vec<Candidate>]) -> (Vec<f64>, Vec<Pose>) {
    let mut at = 0;
    let mut way: Vec<(f64, Pose)> = beams[1..]
        .iter()
        .rev()
        .map(|beam| {
            let Candidate { parent, increment_rad, pose, .. } = beam[at];
            at = parent;
            (increment_rad, pose)
        })
        .collect();
    way.reverse();
    way.into_iter().unzip()
}

#[cfg(test)]
#[path = "beam_tests.rs"]
mod tests;
