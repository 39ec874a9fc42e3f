//! Where to fly next: distributed model-predictive guidance (paper §VII, thesis ch. 5).
//!
//! | module | what it holds |
//! |---|---|
//! | [`airspace`] | which increments may be flown where buildings are higher than the flights |
//! | `footprint` | F(x^u) ∩ X_g, a run of cells per row |
//! | `shadow` | H^OEM(x^u), what the boxes of the OEM would hide |
//! | [`criterion`] | what a criterion counts as seen, and its cost |
//! | `looks` | what is seen from where, found once for all agents that know the same |
//! | [`PlannerRasters`] | the sets that the planner reads, as rasters |
//! | `nearest` | how far it is to the nearest part of X^Δ in the open |
//! | [`rollout`] | prediction: poses and X^Δ, block by block |
//! | `search` | the tree of yaw increments |
//! | `beam` | `str4`: the best few candidates, block by block |
//! | `first_looks` | buildings that `str4` has not seen from nearby yet |
//! | `views` | what `str4` sees from where, remembered |
//! | `skyline` | the buildings of the map on the cells of `str4` |
//! | `viewshed` | what buildings hide from a cell, for `str4` |
//! | `turning` | motion with the delay of a turn, for `str4` |
//! | `route` | `circles` and `lawnmower`: no planning |
//! | [`schedule`] | who plans when, and with which plans of the others |
//!
//! Nothing here needs a guarantee: sets are rasters. Everything is a function of its arguments, and in
//! `str4` and `lawnmower` of those before.

use csat_proto::camera::Pose;
use csat_proto::raster::{Grid, Raster};

use crate::config::{AgentConfig, Criterion};
use crate::estimate::oem::Oem;

pub mod airspace;
mod beam;
pub mod criterion;
mod first_looks;
mod footprint;
mod looks;
mod nearest;
mod rasters;
pub mod rollout;
mod route;
pub mod schedule;
mod search;
mod shadow;
mod skyline;
mod turning;
mod views;
mod viewshed;

use airspace::Ways;
use beam::Beam;
use criterion::{Sight, Terms, Weights};
pub use looks::Looks;
pub use rasters::PlannerRasters;
use rollout::{Level, Meeting, Motion, Surroundings};
use route::Route;
use search::Search;

/// What an agent knows at a decision, as far as its planner cares. All rasters are on
/// [`AgentConfig::raster_grid`].
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// X^Δ = X̄ ∪ ⋃ X_j (5.11).
    pub wanted: &'a Raster,
    /// X°.
    pub margin: &'a Raster,
    /// H^CVS of this step's own frame; only `str2` reads it.
    pub hidden_now: &'a Raster,
    /// H^CVS of this step of each neighbour, in the order of the neighbours given to
    /// [`Planner::plan`], where known (5.19); may be shorter. Only `str2` reads it.
    pub neighbours_hidden_now: &'a [Option<&'a Raster>],
    /// ⋃ H^CVS of all over the last h steps (5.30); only `str3` with κ > 0 weighs it.
    pub hidden_recent: &'a Raster,
    /// M; only `str3` and `str4` read it.
    pub oem: &'a Oem,
    /// What was seen so far of `wanted` in the world of `oem`, by whomever; `str1` to `str3`.
    pub looks: Option<&'a Looks>,
    /// Which increments may be flown, at least one; `None` where buildings are below the flights.
    pub ways: Option<&'a Ways<'a>>,
}

/// Which block of a candidate is chosen for, where buildings are higher than the flights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Block {
    /// The one that is flown: it has to be safe.
    First,
    /// A later one, which keeps off what is known to stand in the way.
    Later,
    /// A later one where nothing else is left: it flies on, whatever stands there.
    Hopeless,
}

impl Block {
    /// That of this number.
    fn at(block: usize) -> Self {
        if block == 0 { Self::First } else { Self::Later }
    }
}

impl Picture<'_> {
    /// The increments of `increments` that may be flown in a block from `pose` on.
    fn choices(&self, increments: &[f64], pose: &Pose, block: Block) -> Vec<(usize, f64)> {
        let may_fly = |ways: &Ways<'_>, increment: f64| match block {
            Block::First => ways.is_safe(increment),
            Block::Later => ways.is_open(pose, increment),
            Block::Hopeless => true,
        };
        let all = increments.iter().copied().enumerate();
        all.filter(|(_, increment)| self.ways.is_none_or(|w| may_fly(w, *increment))).collect()
    }
}

/// What to fly, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The yaw increments, one per block, radians; the first is the command.
    pub increments_rad: Vec<f64>,
    /// The predicted poses at the ends of the blocks (5.35): the plan to announce.
    pub poses: Vec<Pose>,
    /// J⁰ + κ·J² + λ·J¹, m²; in `str4` Σ φ(X^Δ) over the blocks less what first
    /// looks are worth, m². 0 when nothing was planned.
    pub cost: f64,
    /// The terms of the cost of `str1` to `str3`.
    pub terms: Terms,
    /// How many poses were looked from, neighbours' not counted.
    pub nodes: u32,
}

/// How a criterion finds what to fly.
#[derive(Debug, Clone)]
enum Method {
    /// `str1` to `str3`: the whole tree.
    Tree,
    /// `str4`.
    Beam(Box<Beam>),
    /// `circles` and `lawnmower`.
    Route(Route),
}

/// Plans for one agent, one decision after the other. Holds nothing between two plans but configuration and
/// scratch memory, for `str4` what was looked at, and for `lawnmower` the waypoint it flies to.
#[derive(Debug, Clone)]
pub struct Planner {
    grid: Grid,
    sight: Sight,
    motion: Motion,
    meeting: Meeting,
    weights: Weights,
    increments: Vec<f64>,
    growth_m: f64,
    levels: Vec<Level>,
    seen_by_others: Vec<Raster>,
    method: Method,
}

impl Planner {
    /// The planner of `config.guidance`. No increments means straight ahead; a horizon of 0 blocks
    /// means 1.
    pub fn new(config: &AgentConfig) -> Self {
        let (grid, guidance) = (config.raster_grid(), &config.guidance);
        let increments = guidance.gentlest_first_rad();
        let blocks = guidance.blocks();
        let method = match Route::new(config, &increments) {
            Some(route) => Method::Route(route),
            None if guidance.criterion == Criterion::Str4 => {
                Method::Beam(Box::new(Beam::new(config, increments.clone())))
            }
            None => Method::Tree,
        };
        Self {
            grid,
            sight: Sight::new(config),
            motion: Motion::new(config),
            meeting: Meeting::new(config),
            weights: Weights::new(config),
            increments,
            growth_m: config.targets.v_max_m_s * guidance.period_s,
            levels: vec![Level::new(grid); blocks],
            seen_by_others: vec![Raster::empty(grid); blocks],
            method,
        }
    }

    /// The best sequence of yaw increments from `pose` (`world`, metres; its yaw is the one the
    /// vehicle flies or was last told to): in `str1` to `str3` exhaustively.
    ///
    /// `neighbours` are each neighbour's predicted poses at the ends of the blocks from now on; what
    /// is missing is flown straight ahead, and a neighbour without a pose is ignored.
    pub fn plan(
        &mut self,
        picture: &Picture<'_>,
        pose: &Pose,
        neighbours: &[Vec<Pose>],
    ) -> Decision {
        match &mut self.method {
            Method::Tree => self.search_tree(picture, pose, neighbours),
            Method::Beam(beam) => beam.plan(picture, pose, neighbours),
            Method::Route(route) => route.plan(picture, pose),
        }
    }

    /// The best of all sequences.
    fn search_tree(
        &mut self,
        picture: &Picture<'_>,
        pose: &Pose,
        neighbours: &[Vec<Pose>],
    ) -> Decision {
        self.sight.load(picture.oem);
        let own = Looks::default();
        let looks = picture.looks.unwrap_or(&own);
        let looks = (looks, looks.grown(|| self.grown(picture.wanted)));
        self.look_for_others(picture, looks, pose, neighbours);
        if let Some(root) = self.levels.first_mut() {
            root.remaining.clone_from(picture.wanted);
        }
        let margin = self.sight.removes_margin().then_some(picture.margin);
        let mut search = Search {
            sight: &mut self.sight,
            motion: self.motion,
            weights: self.weights,
            increments: &self.increments,
            around: Surroundings {
                growth_m: self.growth_m,
                margin,
                seen_by_others: &self.seen_by_others,
                hidden_recent: picture.hidden_recent,
            },
            picture,
            looks,
            later: Block::Later,
            trail: Vec::with_capacity(self.levels.len()),
            best: None,
            nodes: 0,
        };
        search.descend(&mut self.levels, pose);
        if search.best.is_none() {
            search.later = Block::Hopeless;
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
        self.sight.footprint(pose).raster(self.grid)
    }

    /// H^OEM(x^u) ∩ F(x^u) ∩ X_g (4.42), for the OEM's metric (5.45); whatever the criterion.
    pub fn predicted_hidden(&mut self, oem: &Oem, pose: &Pose) -> Raster {
        self.sight.predicted_hidden(oem, pose)
    }

    /// All that X^Δ may cover within the horizon, whoever looks where.
    fn grown(&self, wanted: &Raster) -> Raster {
        self.levels.iter().fold(wanted.clone(), |set, _| set.dilated_disc(self.growth_m))
    }

    /// What the neighbours would see is the same in every node of a depth: it is found once.
    /// Whoever is too far away to see what this UAV might is left out: in a large fleet most are.
    fn look_for_others(
        &mut self,
        picture: &Picture<'_>,
        looks: (&Looks, &Raster),
        own: &Pose,
        neighbours: &[Vec<Pose>],
    ) {
        let blocks = self.levels.len();
        self.seen_by_others.fill(Raster::empty(self.grid));
        for (index, plan) in neighbours.iter().enumerate() {
            let hidden_now = picture.neighbours_hidden_now.get(index).copied().flatten();
            let poses = self.motion.forecast(plan, 0, blocks);
            for (pose, seen) in poses.iter().zip(&mut self.seen_by_others) {
                if self.meeting.may_see_the_same(own, pose) {
                    self.sight.look(pose, hidden_now, looks).add_to(seen);
                }
            }
        }
    }
}

#[cfg(test)]
mod brute_tests;
#[cfg(test)]
mod tests;
