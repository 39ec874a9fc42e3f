//! `str4` and `str5`: ground counts for as long as it stays unseen.
//!
//! The cost of a candidate is Σ_k φ(X^Δ_k) over the blocks k = 1..N_MPC of the horizon, where (5.27)
//! has φ(X^Δ) at the end of the horizon only: ground that is seen early stops growing early. First
//! looks at buildings count more ([`super::first_looks`]). The horizon is long enough to look all
//! around and to fly on and look elsewhere. It is too long to try every sequence, so the search is a
//! beam search: per block the best candidates are kept, at most one per rounded pose, so that the
//! beam does not fill with detours to the same pose. What ground counts depends on the objective
//! ([`super::objective`]). Ground that another UAV sees is seen to this one at once; to `str5`, where radios have a range,
//! when it hears of it ([`super::connectivity`]).

use std::borrow::Cow;
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
    /// Where it matters who hears what.
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
    /// X^Δ before its last look, among the [`Before`] of its block.
    before: usize,
    /// X^Δ, summed over the blocks, less the bonus of first looks: units of 1 / [`FULL`] cells.
    cost: i64,
}

/// X^Δ at the end of a block before the own look, after a parent and for the children that hear the same.
#[derive(Debug, Clone)]
struct Before<'a> {
    /// The groups that tell what they have seen ([`Connectivity::heard`]).
    heard: Vec<usize>,
    set: Cow<'a, Raster>,
    /// Of the set, units of 1 / [`FULL`] cells.
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
            connectivity: Connectivity::new(config),
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
        self.predict_others(input, pose, &others, &remaining, &margin);
        let place = RoundedPose::of(pose, &self.grid);
        let root =
            Candidate { parent: 0, increment_rad: 0.0, pose: *pose, place, before: 0, cost: 0 };
        let (mut beams, mut sets, mut nodes) = (vec![vec![root]], vec![remaining], 0);
        for (block, mut kept) in self.seen_by_others(pose, &others).into_iter().enumerate() {
            kept.union_with(&margin);
            let spread_m = self.spread_m(block);
            sets.iter_mut().for_each(|set| pass_block(set, &kept, spread_m, &mut self.scratch));
            let kind = BlockKind::at(block);
            let (mut children, mut befores) =
                self.children(input, &beams[block], &sets, block, kind);
            if children.is_empty() {
                (children, befores) =
                    self.children(input, &beams[block], &sets, block, BlockKind::Hopeless);
            }
            nodes += children.len() as u32;
            let best = self.best(children);
            sets = best.iter().map(|child| self.after_look(child, &befores)).collect();
            beams.push(best);
        }
        self.connectivity.iter_mut().for_each(Connectivity::unload);
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

    /// Where it matters who hears what, predicts what the other UAVs would tell.
    fn predict_others(
        &mut self,
        input: &PlannerInput<'_>,
        own: &Pose,
        others: &[Vec<Pose>],
        remaining: &Raster,
        margin: &Raster,
    ) {
        let spreads_m: Vec<f64> = (0..self.blocks).map(|block| self.spread_m(block)).collect();
        let Self { connectivity, rounded_views, first_looks, scratch, grid, .. } = self;
        let Some(connectivity) = connectivity else { return };
        connectivity.load(input, own, others, remaining, |block, pose, set| {
            pass_block(set, margin, spreads_m[block], scratch);
            if let Some(pose) = pose {
                let place = RoundedPose::of(pose, grid);
                rounded_views.look(place).take_from(set);
                first_looks.look(place).take_from(set);
            }
        });
    }

    /// What the other UAVs would see from their poses at the end of each block, as far as their views
    /// may overlap the own ones. Nothing where it matters who hears what.
    fn seen_by_others(&mut self, own: &Pose, others: &[Vec<Pose>]) -> Vec<Raster> {
        let mut seen = vec![Raster::empty(self.grid); self.blocks];
        if self.connectivity.is_some() {
            return seen;
        }
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

    /// The children of `beam` in a block, and X^Δ before their looks; `sets` are those of their parents, without what
    /// others tell.
    fn children<'a>(
        &mut self,
        input: &PlannerInput<'_>,
        beam: &[Candidate],
        sets: &'a [Raster],
        block: usize,
        kind: BlockKind,
    ) -> (Vec<Candidate>, Vec<Before<'a>>) {
        let mut children = Vec::with_capacity(beam.len() * self.increments.len());
        let mut befores: Vec<Before<'_>> = Vec::with_capacity(beam.len());
        for (parent, (candidate, set)) in beam.iter().zip(sets).enumerate() {
            let first_before = befores.len();
            let choices = input.choices(&self.increments, &candidate.pose, kind);
            for (choice, increment_rad) in choices {
                let pose = self.turning.advance(&candidate.pose, choice);
                let place = RoundedPose::of(&pose, &self.grid);
                let links = self.connectivity.as_ref();
                let heard = links.map_or_else(Vec::new, |links| links.heard(block, pose.p_world));
                let same = befores[first_before..].iter().position(|b| b.heard == heard);
                let before = same.map_or(befores.len(), |index| first_before + index);
                if same.is_none() {
                    befores.push(self.before(block, heard, set));
                }
                let Before { set, cost, .. } = &befores[before];
                let seen = self.ground_cost.seen(self.rounded_views.look(place), set);
                let first = self.ground_cost.seen(self.first_looks.look(place), set);
                let cost = candidate.cost + cost - seen - self.first_look * first;
                children.push(Candidate { parent, increment_rad, pose, place, before, cost });
            }
        }
        (children, befores)
    }

    /// X^Δ before the own look, for children that hear these groups; `set` is that of their parent.
    fn before<'a>(&self, block: usize, heard: Vec<usize>, set: &'a Raster) -> Before<'a> {
        let mut set = Cow::Borrowed(set);
        if let Some(connectivity) = self.connectivity.as_ref().filter(|_| !heard.is_empty()) {
            connectivity.tell(block, &heard, set.to_mut());
        }
        let cost = self.ground_cost.of(&set);
        Before { heard, set, cost }
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

    /// X^Δ after the last look of `candidate`.
    fn after_look(&mut self, candidate: &Candidate, befores: &[Before<'_>]) -> Raster {
        let mut set = Raster::clone(&befores[candidate.before].set);
        self.rounded_views.look(candidate.place).take_from(&mut set);
        self.first_looks.look(candidate.place).take_from(&mut set);
        set
    }
}

/// Advances an X^Δ by a block, before the own look: it grows by f^t (4.24) and loses `kept`, where no target can be or
/// another UAV looks.
fn pass_block(set: &mut Raster, kept: &Raster, spread_m: f64, scratch: &mut Raster) {
    set.dilate_disc_into(spread_m, scratch);
    scratch.subtract(kept);
    std::mem::swap(set, scratch);
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
