//! The belief p(x | z): one density in three representations.
//!
//! | module | what it holds |
//! |---|---|
//! | [`grid`] | a value for each cell of a regular grid |
//! | [`particles`] | a sampling importance resampling filter |
//! | [`adaptive`] | cells that split where probability gathers |
//! | [`region`] | highest-density regions |
//! | [`square`] | a belief as squares: maps and messages |

use std::sync::Arc;

use csat_proto::raster::Grid;
use csat_proto::time::Step;

use crate::config::{AgentConfig, BeliefKind, Fusion};
use crate::likelihood::Likelihood;
use crate::mutant::{Mutant, is_on};
use crate::search_map::{CELL_M, Gaussian, SearchMap};
use crate::tiles::Tiles;
use adaptive::AdaptiveBelief;
use grid::GridBelief;
use particles::Particles;
use region::CellSet;

pub mod adaptive;
pub mod grid;
mod moved;
pub mod particles;
pub mod region;
pub mod square;
#[cfg(test)]
mod tests;

/// What an agent believes of the place of the target.
#[derive(Debug, Clone)]
pub struct Belief {
    representation: Representation,
    /// Standard deviation of the target's displacement per step and axis, metres.
    walk_m: f64,
    /// The grid of tiles of level 0, and of search maps.
    coarse: Grid,
}

#[derive(Debug, Clone)]
enum Representation {
    Grid(GridBelief),
    Particles(Particles, f64),
    Adaptive(AdaptiveBelief),
}

use Representation as R;

/// The weights of another agent's belief that fusion chooses from, besides 0. An agent keeps half of its own belief:
/// whoever took the surest belief for all that is known would believe the one that is wrong and sure, and fewer than
/// 95 % of targets would be in 95 % regions.
const WEIGHTS: [f64; 2] = [0.25, 0.5];

impl Belief {
    /// The belief before the first frame: uniform over the region.
    pub fn new(config: &AgentConfig) -> Self {
        let AgentConfig { ground, belief, walk_m, .. } = *config;
        let cells = Grid::covering(&ground, belief.cell_m);
        let representation = match belief.kind {
            BeliefKind::Grid => R::Grid(GridBelief::new(cells)),
            BeliefKind::Adaptive => R::Adaptive(AdaptiveBelief::new(cells, belief.min_cell_m)),
            BeliefKind::Particles => R::Particles(
                Particles::new(ground, belief.particles, key(config)),
                belief.process_noise_m.hypot(walk_m),
            ),
        };
        Self { representation, walk_m, coarse: Grid::covering(&ground, CELL_M) }
    }

    /// A step begins: the target may have moved since the last one, (1b).
    pub fn predict(&mut self, step: Step) {
        match &mut self.representation {
            R::Particles(particles, sigma_m) => particles.walk(step, *sigma_m),
            R::Grid(grid) if self.walk_m > 0.0 => grid.diffuse(self.walk_m),
            R::Adaptive(cells) if self.walk_m > 0.0 => cells.diffuse(self.walk_m),
            R::Grid(_) | R::Adaptive(_) => {}
        }
    }

    /// Multiplies the belief by likelihoods, (1a).
    pub fn update(&mut self, likelihoods: &[Arc<Likelihood>]) {
        if likelihoods.is_empty() {
            return;
        }
        match &mut self.representation {
            R::Grid(grid) => grid.update(likelihoods),
            R::Particles(particles, _) => particles.update(likelihoods),
            R::Adaptive(cells) => cells.update(likelihoods),
        }
    }

    /// Fuses the belief of another agent with this one. Particles cannot be fused; they stay.
    ///
    /// Chernoff fusion takes the weighted geometric mean p^(1−ω) q^ω, with the ω of the least entropy: evidence that
    /// both have counts once at most. The product counts it twice.
    pub fn fuse(&mut self, other: &Arc<Tiles>, fusion: Fusion) {
        if fusion == Fusion::Product || is_on(Mutant::SnapshotByProduct) {
            self.representation.pool(&self.coarse, 1.0, 1.0, other);
            return;
        }
        let mut best = None;
        let mut least = self.representation.entropy();
        for weight in WEIGHTS {
            let mut fused = self.representation.clone();
            fused.pool(&self.coarse, 1.0 - weight, weight, other);
            let entropy = fused.entropy();
            if entropy < least {
                least = entropy;
                best = Some(fused);
            }
        }
        if let Some(fused) = best {
            self.representation = fused;
        }
    }

    /// Mean and covariance.
    pub fn gaussian(&self) -> Gaussian {
        match &self.representation {
            R::Grid(grid) => grid.gaussian(),
            R::Particles(particles, _) => particles.gaussian(),
            R::Adaptive(cells) => cells.gaussian(),
        }
    }

    /// The densest part of the region that holds `share` of the probability.
    pub fn highest_density(&self, share: f64) -> CellSet {
        match &self.representation {
            R::Grid(grid) => grid.highest_density(share),
            R::Particles(particles, _) => particles.highest_density(share),
            R::Adaptive(cells) => cells.highest_density(share),
        }
    }

    /// ln of the density at the centre of the cell that contains a point, up to a constant, and that centre; `None`
    /// for particles and outside of the region.
    pub fn at(&self, p: [f64; 2]) -> Option<([f64; 2], f64)> {
        match &self.representation {
            R::Grid(grid) => grid.at(p),
            R::Adaptive(cells) => cells.at(p),
            R::Particles(..) => None,
        }
    }

    /// The probability of each cell of a coarse raster.
    pub fn map(&self) -> SearchMap {
        square::map(self.coarse, &self.representation.squares())
    }

    /// The belief as it is told other agents.
    pub fn tiles(&self) -> Tiles {
        square::tiles(&self.coarse, &self.representation.squares())
    }

    /// Hands over numbers that differ if beliefs do, for a hash.
    pub fn numbers(&self, add: &mut dyn FnMut(f64)) {
        match &self.representation {
            R::Grid(grid) => grid.sums().for_each(add),
            R::Particles(particles, _) => particles.points().flatten().for_each(add),
            R::Adaptive(cells) => cells.values().for_each(add),
        }
    }

    /// The particles, if it has any, `world`, metres.
    pub fn particles(&self) -> Vec<[f64; 2]> {
        match &self.representation {
            R::Particles(particles, _) => particles.points().collect(),
            R::Grid(_) | R::Adaptive(_) => Vec::new(),
        }
    }
}

impl Representation {
    fn squares(&self) -> Vec<square::Square> {
        match self {
            R::Grid(grid) => grid.squares(),
            R::Particles(particles, _) => particles.squares(),
            R::Adaptive(cells) => cells.squares(),
        }
    }

    fn pool(&mut self, coarse: &Grid, keep: f64, weight: f64, other: &Arc<Tiles>) {
        match self {
            R::Grid(grid) => grid.pool(keep, weight, |x| other.ln_density(coarse, x)),
            R::Adaptive(cells) => cells.pool(keep, weight, coarse, other),
            R::Particles(..) => {}
        }
    }

    fn entropy(&self) -> f64 {
        match self {
            R::Grid(grid) => grid.entropy(),
            R::Adaptive(cells) => cells.entropy(),
            R::Particles(..) => 0.0,
        }
    }
}

/// What an agent's random numbers belong to.
fn key(config: &AgentConfig) -> [u8; 32] {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&config.seed.to_le_bytes());
    key[8..10].copy_from_slice(&config.id.0.to_le_bytes());
    key[10..14].copy_from_slice(&config.incarnation.0.to_le_bytes());
    key[14..].copy_from_slice(b"csat particles v1 ");
    key
}
