//! A sampling importance resampling (SIR) particle filter (Gordon et al. 1993), as in Tisdale et al. 2008, §IV.B:
//! resampled after every step, with a random walk (9) because resampling needs process noise.

use std::sync::Arc;

use csat_proto::model::Ground;
use csat_proto::time::Step;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::region::{CellSet, Piece, densest};
use super::square::Square;
use crate::likelihood::Likelihood;
use crate::search_map::Gaussian;

/// A square with more particles is divided to estimate their density.
const MOST_IN_SQUARE: usize = 24;
/// The smallest squares are this part of the region's longer side.
const DEEPEST: u8 = 11;

/// p(x | z) as equally probable points; uniform at the start.
#[derive(Debug, Clone)]
pub struct Particles {
    ground: Ground,
    /// `world`, metres.
    points: Vec<[f64; 2]>,
    /// What the random numbers belong to: seed, agent and incarnation in one.
    key: [u8; 32],
    /// How often likelihoods were applied in the present step.
    updates: u32,
    step: Step,
}

/// Streams of random numbers, per step.
#[derive(Debug, Clone, Copy)]
enum Purpose {
    Walk = 0,
    Resampling = 1,
}

impl Particles {
    /// Particles spread evenly at random. `key` tells one agent's random numbers from another's.
    pub fn new(ground: Ground, count: u32, key: [u8; 32]) -> Self {
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(u64::MAX);
        let mut along = |axis: usize| (rng.random::<f64>() - 0.5) * ground.size_m[axis];
        let points = (0..count).map(|_| [along(0), along(1)]).collect();
        Self { ground, points, key, updates: 0, step: Step(0) }
    }

    /// A step begins: every particle takes a normal step of this standard deviation per axis, (1b) and (9). At the
    /// border of the region it turns back.
    pub fn walk(&mut self, step: Step, sigma_m: f64) {
        (self.step, self.updates) = (step, 0);
        let mut rng = self.stream(Purpose::Walk);
        let half = self.ground.size_m.map(|size| size / 2.0);
        for point in &mut self.points {
            for axis in 0..2 {
                let normal: f64 = rng.sample(StandardNormal);
                let moved = point[axis] + sigma_m * normal;
                point[axis] = reflected(moved, half[axis]);
            }
        }
    }

    /// Weighs the particles by likelihoods and resamples them, (1a).
    pub fn update(&mut self, likelihoods: &[Arc<Likelihood>]) {
        let mut weights = vec![1.0; self.points.len()];
        for likelihood in likelihoods {
            let Some(bounds) = likelihood.bounds() else { continue };
            for (weight, point) in weights.iter_mut().zip(&self.points) {
                if bounds.contains(*point) {
                    *weight *= likelihood.ratio_within(*point);
                }
            }
            // Many factors at once must not leave the range of numbers.
            let most = weights.iter().copied().fold(0.0, f64::max);
            weights.iter_mut().for_each(|weight| *weight /= most);
        }
        if weights.iter().all(|weight| *weight == weights[0]) {
            return;
        }
        self.updates += 1;
        let shift: f64 = self.stream(Purpose::Resampling).random();
        self.points = resampled(&self.points, &weights, shift);
    }

    /// Mean and covariance.
    pub fn gaussian(&self) -> Gaussian {
        let count = self.points.len() as f64;
        let mean = [0, 1].map(|axis| self.points.iter().map(|p| p[axis]).sum::<f64>() / count);
        let of = |i: usize, j: usize| {
            self.points.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>() / count
        };
        Gaussian { mean, covariance: [of(0, 0), of(0, 1), of(1, 1)] }
    }

    /// The densest squares that hold `share` of the particles. A square is divided as long as it holds more than a few,
    /// so that it is small where particles are dense.
    pub fn highest_density(&self, share: f64) -> CellSet {
        let parts = self.parts();
        let piece = |(index, part): (usize, &Part)| {
            let side = f64::from(1u32 << (DEEPEST - part.level));
            let mass = part.count as f64;
            Piece { ln_density: (mass / (side * side)).ln(), mass, index: index as u32 }
        };
        let pieces = parts.iter().enumerate().filter(|(_, part)| part.count > 0).map(piece);
        let rect = |index: u32| {
            let Part { level, column, row, .. } = parts[index as usize];
            let side = 1 << (DEEPEST - level);
            [column * side, row * side, side, side]
        };
        let rects = densest(pieces.collect(), share).into_iter().map(rect).collect();
        let cell_m = self.side_m() / f64::from(1u32 << DEEPEST);
        CellSet { cell_m, origin_m: self.origin_m(), rects }
    }

    /// The particles as squares without extent.
    pub fn squares(&self) -> Vec<Square> {
        self.points.iter().map(|p| Square { centre: *p, side_m: 0.0, mass: 1.0 }).collect()
    }

    /// The particles, `world`, metres.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// A stream of its own for each step, purpose and update.
    fn stream(&self, purpose: Purpose) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::from_seed(self.key);
        let of_step = u64::from(self.step.0) << 16 | u64::from(self.updates.min(0x7FFF)) << 1;
        rng.set_stream(of_step | purpose as u64);
        rng
    }

    fn side_m(&self) -> f64 {
        self.ground.size_m[0].max(self.ground.size_m[1])
    }

    fn origin_m(&self) -> [f64; 2] {
        [-self.side_m() / 2.0; 2]
    }

    /// Squares that cover the region, with the number of particles in each.
    fn parts(&self) -> Vec<Part> {
        let all: Vec<u32> = (0..self.points.len() as u32).collect();
        let mut parts = Vec::new();
        let mut stack = vec![(Part { level: 0, column: 0, row: 0, count: all.len() }, all)];
        while let Some((part, members)) = stack.pop() {
            if part.count <= MOST_IN_SQUARE || part.level == DEEPEST {
                parts.push(part);
                continue;
            }
            let half = self.side_m() / f64::from(2u32 << part.level);
            let [x, y] = self.origin_m();
            let middle =
                [x + f64::from(2 * part.column + 1) * half, y + f64::from(2 * part.row + 1) * half];
            let mut quarters: [Vec<u32>; 4] = Default::default();
            for member in members {
                let p = self.points[member as usize];
                let (east, north) =
                    (usize::from(p[0] >= middle[0]), usize::from(p[1] >= middle[1]));
                quarters[east + 2 * north].push(member);
            }
            for (index, quarter) in (0..).zip(quarters) {
                let (column, row) = (2 * part.column + index % 2, 2 * part.row + index / 2);
                let count = quarter.len();
                stack.push((Part { level: part.level + 1, column, row, count }, quarter));
            }
        }
        parts
    }
}

/// A square of the region.
#[derive(Debug, Clone, Copy)]
struct Part {
    level: u8,
    column: u32,
    row: u32,
    count: usize,
}

/// As many points as before, in proportion to their weights (systematic resampling).
fn resampled(points: &[[f64; 2]], weights: &[f64], shift: f64) -> Vec<[f64; 2]> {
    let step = weights.iter().sum::<f64>() / points.len() as f64;
    let mut chosen = Vec::with_capacity(points.len());
    let (mut sum, mut index) = (weights[0], 0);
    for i in 0..points.len() {
        let wanted = (i as f64 + shift) * step;
        while sum < wanted && index + 1 < points.len() {
            index += 1;
            sum += weights[index];
        }
        chosen.push(points[index]);
    }
    chosen
}

/// A coordinate that left [−half, half], reflected at the border.
fn reflected(x: f64, half: f64) -> f64 {
    if x.abs() <= half {
        return x;
    }
    let place = (x + half).rem_euclid(4.0 * half);
    (if place > 2.0 * half { 4.0 * half - place } else { place }) - half
}
