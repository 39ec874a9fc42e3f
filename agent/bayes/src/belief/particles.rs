//! A sampling importance resampling (SIR) particle filter (Gordon et al. 1993), as in Tisdale et al. 2008, §IV.B:
//! resampled after every step, with a random walk (9) because resampling needs process noise.
//!
//! Particles are in single precision, and those that are near each other are near in memory: they begin in order, strip
//! by strip, and resampling keeps it. So a block of them is weighed by vector instructions or, out of sight, not at all.

use std::sync::Arc;

use csat_proto::model::Ground;
use csat_proto::time::Step;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::region::{CellSet, Piece, densest};
use super::square::Square;
use crate::likelihood::Likelihood;
use crate::likelihood::many::{BLOCK, Weigher};
use crate::search_map::Gaussian;
use normal::NORMAL;

mod normal;
mod resampling;
#[cfg(test)]
mod tests;

/// A square with more particles is divided to estimate their density.
const MOST_IN_SQUARE: usize = 24;
/// The smallest squares are this part of the region's longer side.
const DEEPEST: u8 = 11;

/// p(x | z) as equally probable points; uniform at the start.
#[derive(Debug, Clone)]
pub struct Particles {
    ground: Ground,
    /// Coordinates, `world`, metres.
    x: Vec<f32>,
    y: Vec<f32>,
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
    /// Particles spread evenly at random: each in a part of its own of a strip of the region. `key` tells one agent's
    /// random numbers from another's.
    pub fn new(ground: Ground, count: u32, key: [u8; 32]) -> Self {
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(u64::MAX);
        // A block of particles should be as wide as it is deep.
        let strips = (count / BLOCK as u32).isqrt().max(1);
        let first = |strip: u32| (u64::from(strip) * u64::from(count) / u64::from(strips)) as u32;
        let mut along = |axis: usize, part: u32, parts: u32| {
            let share = (f64::from(part) + rng.random::<f64>()) / f64::from(parts);
            ((share - 0.5) * ground.size_m[axis]) as f32
        };
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for strip in 0..strips {
            let members = first(strip + 1) - first(strip);
            for member in 0..members {
                x.push(along(0, member, members));
                y.push(along(1, strip, strips));
            }
        }
        Self { ground, x, y, key, updates: 0, step: Step(0) }
    }

    /// A step begins: every particle takes a normal step of this standard deviation per axis, (1b) and (9). At the
    /// border of the region it turns back.
    pub fn walk(&mut self, step: Step, sigma_m: f64) {
        (self.step, self.updates) = (step, 0);
        let mut rng = self.stream(Purpose::Walk);
        let [width, depth] = self.ground.size_m.map(|size| size as f32 / 2.0);
        let (sigma_m, normal) = (sigma_m as f32, &*NORMAL);
        let mut bits = [0; 4 * BLOCK];
        for (x, y) in self.x.chunks_mut(BLOCK).zip(self.y.chunks_mut(BLOCK)) {
            rng.fill_bytes(&mut bits);
            let (mut along_x, mut along_y) = ([0.0; BLOCK], [0.0; BLOCK]);
            let steps = along_x.iter_mut().zip(&mut along_y);
            for ((along_x, along_y), bits) in steps.zip(bits.as_chunks().0) {
                let bits = u32::from_le_bytes(*bits) as usize;
                (*along_x, *along_y) =
                    (normal[bits % normal.len()], normal[(bits >> 16) % normal.len()]);
            }
            shift(x, &along_x, sigma_m, width);
            shift(y, &along_y, sigma_m, depth);
        }
    }

    /// Weighs the particles by likelihoods and resamples them, (1a).
    pub fn update(&mut self, likelihoods: &[Arc<Likelihood>]) {
        let mut weights = vec![1.0f32; self.x.len()];
        let mut are_equal = true;
        for weigher in likelihoods.iter().filter_map(|likelihood| Weigher::new(likelihood)) {
            weigher.weigh(&self.x, &self.y, &mut weights);
            // Many factors at once must not leave the range of numbers.
            let [least, most] = extremes(&weights);
            weights.iter_mut().for_each(|weight| *weight *= 1.0 / most);
            are_equal &= least == most;
        }
        if are_equal {
            return;
        }
        self.updates += 1;
        let shift: u32 = self.stream(Purpose::Resampling).random();
        resampling::systematic(&weights, shift, [&mut self.x, &mut self.y]);
    }

    /// Mean and covariance.
    pub fn gaussian(&self) -> Gaussian {
        let [mx, my] = [self.mean(|x, _| x), self.mean(|_, y| y)];
        let covariance = [
            self.mean(|x, _| (x - mx) * (x - mx)),
            self.mean(|x, y| (x - mx) * (y - my)),
            self.mean(|_, y| (y - my) * (y - my)),
        ];
        Gaussian { mean: [mx, my], covariance }
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
        CellSet { cell_m, origin_m: [-self.side_m() / 2.0; 2], rects }
    }

    /// The particles as squares without extent.
    pub fn squares(&self) -> Vec<Square> {
        self.points().map(|p| Square { centre: p, side_m: 0.0, mass: 1.0 }).collect()
    }

    /// The particles, `world`, metres.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        self.x.iter().zip(&self.y).map(|(x, y)| [f64::from(*x), f64::from(*y)])
    }

    /// A stream of its own for each step, purpose and update.
    fn stream(&self, purpose: Purpose) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::from_seed(self.key);
        let of_step = u64::from(self.step.0) << 16 | u64::from(self.updates.min(0x7FFF)) << 1;
        rng.set_stream(of_step | purpose as u64);
        rng
    }

    /// The mean of a function of the coordinates, by sums that do not wait for each other.
    fn mean(&self, value: impl Fn(f64, f64) -> f64) -> f64 {
        let mut sums = [0.0; 8];
        let ((x, last_x), (y, last_y)) = (self.x.as_chunks::<8>(), self.y.as_chunks::<8>());
        for (x, y) in x.iter().zip(y) {
            for i in 0..8 {
                sums[i] += value(f64::from(x[i]), f64::from(y[i]));
            }
        }
        let last = last_x.iter().zip(last_y).map(|(x, y)| value(f64::from(*x), f64::from(*y)));
        (sums.iter().sum::<f64>() + last.sum::<f64>()) / self.x.len() as f64
    }

    fn side_m(&self) -> f64 {
        self.ground.size_m[0].max(self.ground.size_m[1])
    }

    /// Squares that cover the region, with the number of particles in each.
    fn parts(&self) -> Vec<Part> {
        let mut codes = self.codes();
        codes.sort_unstable();
        let mut parts = Vec::new();
        let mut stack =
            vec![(Part { level: 0, column: 0, row: 0, count: codes.len() }, &codes[..])];
        while let Some((part, mut members)) = stack.pop() {
            if part.count <= MOST_IN_SQUARE || part.level == DEEPEST {
                parts.push(part);
                continue;
            }
            let level = part.level + 1;
            for index in 0..4 {
                let shift = 2 * (DEEPEST - level);
                let count = members.partition_point(|code| code >> shift & 3 == index);
                let (quarter, others) = members.split_at(count);
                let (column, row) = (2 * part.column + index % 2, 2 * part.row + index / 2);
                stack.push((Part { level, column, row, count }, quarter));
                members = others;
            }
        }
        parts
    }

    /// The smallest square that each particle is in: the bits of its column and its row in turn, the greatest first.
    fn codes(&self) -> Vec<u32> {
        let half_m = self.side_m() as f32 / 2.0;
        let per_m = (1u32 << DEEPEST) as f32 / self.side_m() as f32;
        let last = (1 << DEEPEST) - 1;
        let spread = |x: &f32| {
            let bits = (((x + half_m) * per_m) as u32).min(last);
            let bits = (bits | bits << 8) & 0x00FF_00FF;
            let bits = (bits | bits << 4) & 0x0F0F_0F0F;
            let bits = (bits | bits << 2) & 0x3333_3333;
            (bits | bits << 1) & 0x5555_5555
        };
        self.x.iter().zip(&self.y).map(|(x, y)| spread(x) | spread(y) << 1).collect()
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

/// The least and the greatest of numbers that are not negative.
fn extremes(numbers: &[f32]) -> [f32; 2] {
    let (mut least, mut most) = ([f32::INFINITY; BLOCK], [0.0; BLOCK]);
    for block in numbers.chunks(BLOCK) {
        for ((least, most), x) in least.iter_mut().zip(&mut most).zip(block) {
            *least = if *x < *least { *x } else { *least };
            *most = if *x > *most { *x } else { *most };
        }
    }
    [least.into_iter().fold(f32::INFINITY, f32::min), most.into_iter().fold(0.0, f32::max)]
}

/// Adds steps times `sigma_m` to coordinates, reflected at ±`half`.
fn shift(coordinates: &mut [f32], steps: &[f32; BLOCK], sigma_m: f32, half: f32) {
    let mut beyond = 0;
    for (x, step) in coordinates.iter_mut().zip(steps) {
        *x += sigma_m * step;
        beyond += u32::from(x.abs() > half);
    }
    if beyond > 0 {
        coordinates.iter_mut().for_each(|x| *x = reflected(*x, half));
    }
}

/// A coordinate that left [−half, half], reflected at the border.
fn reflected(x: f32, half: f32) -> f32 {
    if x.abs() <= half {
        return x;
    }
    let place = (x + half).rem_euclid(4.0 * half);
    (if place > 2.0 * half { 4.0 * half - place } else { place }) - half
}
