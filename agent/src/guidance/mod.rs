//! Where to fly next: distributed model-predictive guidance (paper §VII, thesis ch. 5).
//!
//! | module | what it holds |
//! |---|---|
//! | [`airspace`] | which increments are safe where buildings are higher than the UAVs fly |
//! | `footprint` | F(x^u) ∩ X_g, a run of cells per row |
//! | `shadow` | H^OEM(x^u), the ground that the boxes of the OEM would hide |
//! | `criterion` | what a criterion counts as seen, and its cost |
//! | `view_cache` | views by pose, and the cells that hide ground, shared by all agents with the same knowledge |
//! | [`PlannerRasters`] | the sets that the planner reads, as rasters |
//! | `nearest` | the distance to the nearest part of X^Δ that is not hidden |
//! | `rollout` | prediction: poses and X^Δ, block by block |
//! | `search` | the tree of yaw increments |
//! | `beam` | `str4` and `str5`: beam search |
//! | `connectivity` | what this UAV will hear from the others, for `str5` |
//! | `objective` | whose knowledge counts, for `str4` |
//! | `division` | the division of the region among the UAVs |
//! | `first_looks` | buildings that no UAV has looked at from nearby yet, for `str4` |
//! | `rounded_views` | views by rounded pose, for `str4` |
//! | `height_map` | the heights of the buildings of the map, for `str4` |
//! | `viewshed` | the cells that buildings hide from a cell, for `str4` |
//! | `turning` | motion with the delay of a turn, for `str4` |
//! | `route` | `circles` and `lawnmower`: no planning |
//! | `schedule` | when each UAV plans, and with which plans of the others |
//!
//! Guidance needs no guarantee, so its sets are rasters. A decision is a function of its arguments;
//! in `str4`, `str5` and `lawnmower` also of the arguments of earlier decisions.

use csat_proto::camera::{Pose, PoseError};
use csat_proto::ids::AgentId;
use csat_proto::raster::{Grid, Raster};

use crate::config::AgentConfig;
use crate::estimate::oem::Oem;

pub mod airspace;
mod beam;
mod connectivity;
mod criterion;
mod division;
mod first_looks;
mod footprint;
mod height_map;
mod nearest;
mod objective;
mod rasters;
mod rollout;
mod rounded_views;
mod route;
pub(crate) mod schedule;
mod search;
mod shadow;
mod turning;
mod view_cache;
mod viewshed;

use airspace::Ways;
use beam::Beam;
use criterion::{Sight, VisibilityModel, Weights};
use rollout::{Level, Surroundings, ViewOverlap};
use route::Route;
use search::Search;

pub use criterion::Terms;
pub use rasters::PlannerRasters;
pub use rollout::Motion;
pub use schedule::PlanError;
pub use view_cache::ViewCache;

/// The knowledge of an agent that its planner reads at a decision. All rasters are on
/// [`AgentConfig::raster_grid`].
#[derive(Debug, Clone, Copy)]
pub struct PlannerInput<'a> {
    /// X^Δ = X̄ ∪ ⋃ X_j (5.11).
    pub wanted: &'a Raster,
    /// X°.
    pub margin: &'a Raster,
    /// H^CVS of this step's own frame; only `str2` reads it.
    pub hidden_now: &'a Raster,
    /// The other UAVs whose plans are given to [`Planner::plan`], in the same order; only `str5` asks who they are.
    pub neighbours: &'a [AgentId],
    /// How old their plans are, decisions; only `str5` reads it.
    pub plan_ages: &'a [u32],
    /// The UAVs from which nothing was heard for some decisions; only `guidance.objective` = `fleet` asks who they are.
    pub silent: &'a [AgentId],
    /// H^CVS of this step of each neighbour, in the order of the neighbours given to
    /// [`Planner::plan`], where known (5.19); may be shorter. Only `str2` reads it.
    pub neighbours_hidden_now: &'a [Option<&'a Raster>],
    /// ⋃ H^CVS of all over the last h steps (5.30); only `str3` with κ > 0 weighs it.
    pub hidden_recent: &'a Raster,
    /// M; only `str3` to `str5` read it.
    pub oem: &'a Oem,
    /// The views of `wanted` given `oem` that agents with this knowledge, and with the same box about their poses, share;
    /// `str1` to `str3`.
    pub view_cache: Option<&'a ViewCache>,
    /// The half-widths of the box about each predicted pose, also of the other UAVs. Ground counts as seen from a pose if
    /// it is seen from all poses of the box about it.
    pub pose_error: PoseError,
    /// Which increments may be flown, at least one; `None` where buildings are below the flights.
    pub ways: Option<&'a Ways<'a>>,
}

/// Which increments a block of a candidate may have where buildings are higher than the UAVs fly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BlockKind {
    /// The first block, which is flown: increments that are safe.
    First,
    /// A later block: increments that keep clear of known buildings.
    Later,
    /// A later block without such an increment: all increments.
    Hopeless,
}

impl BlockKind {
    /// The kind of the block of this number.
    fn at(block: usize) -> Self {
        if block == 0 { Self::First } else { Self::Later }
    }
}

impl PlannerInput<'_> {
    /// The increments of `increments` that may be flown in a block from `pose` on.
    fn choices(&self, increments: &[f64], pose: &Pose, block: BlockKind) -> Vec<(usize, f64)> {
        let may_fly = |ways: &Ways<'_>, increment: f64| match block {
            BlockKind::First => ways.is_safe(increment),
            BlockKind::Later => ways.is_open(pose, increment),
            BlockKind::Hopeless => true,
        };
        let all = increments.iter().copied().enumerate();
        all.filter(|(_, increment)| self.ways.is_none_or(|w| may_fly(w, *increment))).collect()
    }
}

/// The result of planning.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The yaw increments, one per block, radians; the first is the command.
    pub increments_rad: Vec<f64>,
    /// The predicted poses at the ends of the blocks (5.35): the plan to send.
    pub poses: Vec<Pose>,
    /// J⁰ + κ·J² + λ·J¹, m²; in `str4` and `str5` Σ φ(X^Δ) over the blocks less the bonus of first
    /// looks, m². 0 without planning.
    pub cost: f64,
    /// The terms of the cost of `str1` to `str3`.
    pub terms: Terms,
    /// Number of own poses whose views were predicted.
    pub nodes: u32,
}

/// How a criterion finds its decision.
#[derive(Debug, Clone)]
enum Method {
    /// `str1` to `str3`: the whole tree.
    Tree,
    /// `str4` and `str5`.
    Beam(Box<Beam>),
    /// `circles` and `lawnmower`.
    Route(Route),
}

/// Plans for one agent, one decision after the other. Its state between two plans is scratch memory,
/// for `str4` also the first looks, for `str5` what the other UAVs would know, and for `lawnmower` the waypoint it flies to.
#[derive(Debug, Clone)]
pub struct Planner {
    grid: Grid,
    visibility: VisibilityModel,
    motion: Motion,
    overlap: ViewOverlap,
    weights: Weights,
    increments: Vec<f64>,
    growth_m: f64,
    levels: Vec<Level>,
    seen_by_others: Vec<Raster>,
    method: Method,
}

impl Planner {
    /// The planner of `config.guidance`. Without increments it flies straight ahead; a horizon of 0
    /// blocks is one of 1 block.
    pub fn new(config: &AgentConfig) -> Self {
        let (grid, guidance) = (config.raster_grid(), &config.guidance);
        let increments = guidance.gentlest_first_rad();
        let blocks = guidance.blocks();
        let method = match Route::new(config, &increments) {
            Some(route) => Method::Route(route),
            None if guidance.criterion.is_far_sighted() => {
                Method::Beam(Box::new(Beam::new(config, increments.clone())))
            }
            None => Method::Tree,
        };
        Self {
            grid,
            visibility: VisibilityModel::new(config),
            motion: Motion::new(config),
            overlap: ViewOverlap::new(config),
            weights: Weights::new(config),
            increments,
            growth_m: config.targets.v_max_m_s * guidance.period_s,
            levels: vec![Level::new(grid); blocks],
            seen_by_others: vec![Raster::empty(grid); blocks],
            method,
        }
    }

    /// The best sequence of yaw increments from `pose` (`world`, metres; its yaw is the last
    /// commanded one); in `str1` to `str3` by exhaustive search.
    ///
    /// `neighbours` are the predicted poses of each other UAV at the ends of the blocks from now on.
    /// After its last pose a UAV flies straight ahead; a UAV without a pose is ignored.
    pub fn plan(
        &mut self,
        input: &PlannerInput<'_>,
        pose: &Pose,
        neighbours: &[Vec<Pose>],
    ) -> Decision {
        self.visibility.expect(&input.pose_error);
        match &mut self.method {
            Method::Tree => self.search_tree(input, pose, neighbours),
            Method::Beam(beam) => beam.plan(input, pose, neighbours),
            Method::Route(route) => route.plan(input, pose),
        }
    }

    /// The best of all sequences.
    fn search_tree(
        &mut self,
        input: &PlannerInput<'_>,
        pose: &Pose,
        neighbours: &[Vec<Pose>],
    ) -> Decision {
        let own = ViewCache::default();
        let views = input.view_cache.unwrap_or(&own);
        let sight = self.visibility.sight(views, input.oem, || self.grown(input.wanted));
        self.look_for_others(input, &sight, pose, neighbours);
        if let Some(root) = self.levels.first_mut() {
            root.remaining.clone_from(input.wanted);
        }
        let margin = self.visibility.removes_margin().then_some(input.margin);
        let mut search = Search {
            visibility: &mut self.visibility,
            motion: self.motion,
            weights: self.weights,
            increments: &self.increments,
            around: Surroundings {
                growth_m: self.growth_m,
                margin,
                seen_by_others: &self.seen_by_others,
                hidden_recent: input.hidden_recent,
            },
            input,
            sight,
            later: BlockKind::Later,
            trail: Vec::with_capacity(self.levels.len()),
            best: None,
            nodes: 0,
        };
        search.descend(&mut self.levels, pose);
        if search.best.is_none() {
            search.later = BlockKind::Hopeless;
            search.descend(&mut self.levels, pose);
        }
        let nodes = search.nodes;
        let (cost, terms, choices) =
            search.best.map_or_else(Default::default, |best| (best.cost, best.terms, best.choices));
        let (increments_rad, poses) = choices.into_iter().unzip();
        Decision { increments_rad, poses, cost, terms, nodes }
    }

    /// F(x^u) ∩ X_g (3.24).
    pub fn footprint(&self, pose: &Pose) -> Raster {
        self.visibility.footprint(pose).raster(self.grid)
    }

    /// H^OEM(x^u) ∩ F(x^u) ∩ X_g (4.42), for the metric of the OEM (5.45); for every criterion. `views` are those of
    /// `oem`, if there are any.
    pub fn predicted_hidden(
        &mut self,
        oem: &Oem,
        views: Option<&ViewCache>,
        pose: &Pose,
    ) -> Raster {
        let own = ViewCache::default();
        self.visibility.predicted_hidden(views.unwrap_or(&own).occupied(oem), pose)
    }

    /// All cells that X^Δ may cover within the horizon.
    fn grown(&self, wanted: &Raster) -> Raster {
        self.levels.iter().fold(wanted.clone(), |set, _| set.dilated_disc(self.growth_m))
    }

    /// Predicts what the other UAVs would see, which is the same for all nodes of a depth. UAVs whose
    /// views cannot overlap those of this UAV are left out: in a large fleet most are.
    fn look_for_others(
        &mut self,
        input: &PlannerInput<'_>,
        sight: &Sight<'_>,
        own: &Pose,
        neighbours: &[Vec<Pose>],
    ) {
        let blocks = self.levels.len();
        self.seen_by_others.fill(Raster::empty(self.grid));
        for (index, plan) in neighbours.iter().enumerate() {
            let hidden_now = input.neighbours_hidden_now.get(index).copied().flatten();
            let poses = self.motion.forecast(plan, 0, blocks);
            for (pose, seen) in poses.iter().zip(&mut self.seen_by_others) {
                if self.overlap.may_see_the_same(own, pose) {
                    self.visibility.look(pose, hidden_now, sight).add_to(seen);
                }
            }
        }
    }
}

#[cfg(test)]
mod brute_tests;
#[cfg(test)]
mod tests;
