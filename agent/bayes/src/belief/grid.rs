//! A value for each cell of a regular grid.
//!
//! A likelihood differs from a constant only in a rectangle around the footprint, so an update touches those
//! cells only, and a belief of two million cells is updated as fast as its footprint is. Sums over the belief
//! are kept by blocks of cells; those of blocks that were not touched stay.

use std::sync::Arc;

use csat_proto::raster::Grid;

use super::region::CellSet;
use super::square::Square;
use crate::likelihood::Likelihood;
use crate::search_map::Gaussian;

/// Side of a block, cells.
const BLOCK: u32 = 32;
/// The least logarithm, relative to the greatest, that a cell of a target that moves keeps.
const LEAST_LN: f64 = -700.0;
/// How many bins the search for the threshold of a highest-density region has.
const BINS: usize = 1024;

/// p(x | z) on a grid; uniform at the start.
#[derive(Debug, Clone)]
pub struct GridBelief {
    grid: Grid,
    /// Of each cell, row by row from the south: ln of its density, up to a constant.
    ln: Vec<f64>,
    blocks: Vec<Block>,
    blocks_east: u32,
    is_stale: Vec<bool>,
}

/// Sums over the cells of a block. Their weights are exp(ln − `max`), places are relative to the middle of the grid.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    max: f64,
    min: f64,
    mass: f64,
    first: [f64; 2],
    /// Σ w x², Σ w x y, Σ w y².
    second: [f64; 3],
}

impl GridBelief {
    /// A uniform belief.
    pub fn new(grid: Grid) -> Self {
        let blocks_east = grid.columns.div_ceil(BLOCK);
        let count = (blocks_east * grid.rows.div_ceil(BLOCK)) as usize;
        let blocks = vec![Block::default(); count];
        let (ln, is_stale) = (vec![0.0; grid.cells()], vec![true; count]);
        let mut belief = Self { grid, ln, blocks, blocks_east, is_stale };
        belief.refresh();
        belief
    }

    /// The cells.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// ln of the density of the cell that contains a point, up to a constant, and the centre of that cell.
    pub fn at(&self, p: [f64; 2]) -> Option<([f64; 2], f64)> {
        let (column, row) = self.grid.cell_of(p)?;
        Some((self.grid.centre(column, row), self.ln[self.grid.index(column, row)]))
    }

    /// Multiplies the belief by likelihoods, (1a).
    pub fn update(&mut self, likelihoods: &[Arc<Likelihood>]) {
        for likelihood in likelihoods {
            let Some(bounds) = likelihood.bounds() else { continue };
            let columns = self.grid.columns_between(bounds.min[0], bounds.max[0]);
            for row in self.grid.rows_between(bounds.min[1], bounds.max[1]) {
                for column in columns.clone() {
                    let index = self.grid.index(column, row);
                    self.ln[index] += likelihood.ln_within(self.grid.centre(column, row));
                }
                self.touch(row, columns.clone());
            }
        }
        self.refresh();
    }

    /// Adds `weight` times a function to ln of the density, after `keep` times what there is.
    pub fn pool(&mut self, keep: f64, weight: f64, ln_density: impl Fn([f64; 2]) -> f64) {
        for row in 0..self.grid.rows {
            for column in 0..self.grid.columns {
                let value = &mut self.ln[self.grid.index(column, row)];
                *value = keep * *value + weight * ln_density(self.grid.centre(column, row));
            }
        }
        self.is_stale.fill(true);
        self.refresh();
    }

    /// The target moved by a normal displacement of this standard deviation per axis, (1b).
    pub fn diffuse(&mut self, sigma_m: f64) {
        let peak = self.peak();
        let weights: Vec<f64> = self.ln.iter().map(|ln| (ln - peak).exp()).collect();
        let weights = diffused(&self.grid, &weights, sigma_m);
        let ln = weights.into_iter().map(|weight| weight.ln().max(LEAST_LN));
        self.ln.iter_mut().zip(ln).for_each(|(cell, ln)| *cell = ln);
        self.is_stale.fill(true);
        self.refresh();
    }

    /// Mean and covariance; a cell counts as spread evenly.
    pub fn gaussian(&self) -> Gaussian {
        let peak = self.peak();
        let (mut mass, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
        for block in &self.blocks {
            let scale = (block.max - peak).exp();
            mass += scale * block.mass;
            (0..2).for_each(|i| first[i] += scale * block.first[i]);
            (0..3).for_each(|i| second[i] += scale * block.second[i]);
        }
        let mean = first.map(|sum| sum / mass);
        let [xx, xy, yy] = second.map(|sum| sum / mass);
        let within = self.grid.cell_m.powi(2) / 12.0;
        let covariance = [
            xx - mean[0] * mean[0] + within,
            xy - mean[0] * mean[1],
            yy - mean[1] * mean[1] + within,
        ];
        Gaussian { mean, covariance }
    }

    /// The sums over all blocks of cells, which differ if beliefs do.
    pub fn sums(&self) -> impl Iterator<Item = f64> + '_ {
        let of = |block: &Block| {
            let Block { max, min, mass, first: [x, y], second: [xx, xy, yy] } = *block;
            [max, min, mass, x, y, xx, xy, yy]
        };
        self.blocks.iter().flat_map(of)
    }

    /// The cells as squares with their probabilities; those with next to none are left out.
    pub fn squares(&self) -> Vec<Square> {
        const LEAST: f64 = -60.0;
        let peak = self.peak();
        let columns = self.grid.columns as usize;
        let mut squares = Vec::new();
        for index in (0..self.blocks.len()).filter(|index| self.blocks[*index].max > peak + LEAST) {
            for cell in self.cells_of(index).filter(|cell| self.ln[*cell] > peak + LEAST) {
                let centre = self.grid.centre((cell % columns) as u32, (cell / columns) as u32);
                let mass = (self.ln[cell] - peak).exp();
                squares.push(Square { centre, side_m: self.grid.cell_m, mass });
            }
        }
        squares
    }

    /// −Σ p ln p over the cells.
    pub fn entropy(&self) -> f64 {
        let peak = self.peak();
        let (mut mass, mut weighted) = (0.0, 0.0);
        for ln in self.ln.iter().map(|ln| ln - peak) {
            let weight = ln.exp();
            mass += weight;
            weighted += weight * ln;
        }
        mass.ln() - weighted / mass
    }

    /// The densest cells that hold `share` of the probability. Cells of equal density are taken row by row from
    /// the south.
    pub fn highest_density(&self, share: f64) -> CellSet {
        let peak = self.peak();
        let total: f64 = self.blocks.iter().map(|b| (b.max - peak).exp() * b.mass).sum();
        let wanted = share * total;
        let mut depth = 0.5;
        let threshold = loop {
            match self.threshold(peak, depth, wanted) {
                Some(threshold) => break threshold,
                None => depth *= 2.0,
            }
        };
        self.densest(peak, wanted, threshold)
    }

    /// The bounds of the bin of densities in which the threshold is, relative to the greatest density; `None` if
    /// the cells down to `depth` do not hold the wanted mass. Last comes the mass above the bin.
    fn threshold(&self, peak: f64, depth: f64, wanted: f64) -> Option<[f64; 3]> {
        let mut bins = vec![0.0; BINS];
        let bin_of = |ln: f64| ((peak - ln) / depth * BINS as f64) as usize;
        for (index, block) in self.blocks.iter().enumerate() {
            if block.max < peak - depth {
                continue;
            }
            if block.min == block.max {
                if let Some(bin) = bins.get_mut(bin_of(block.max)) {
                    *bin += (block.max - peak).exp() * block.mass;
                }
                continue;
            }
            for ln in self.cells_of(index).map(|cell| self.ln[cell]) {
                if let Some(bin) = bins.get_mut(bin_of(ln)) {
                    *bin += (ln - peak).exp();
                }
            }
        }
        let mut above = 0.0;
        for (index, mass) in bins.iter().enumerate() {
            if above + mass >= wanted * (1.0 - 1e-12) {
                let at = |index: usize| peak - depth * index as f64 / BINS as f64;
                return Some([at(index), at(index + 1), above]);
            }
            above += mass;
        }
        None
    }

    /// All cells above the bin, and as many of the bin as it takes.
    fn densest(&self, peak: f64, wanted: f64, [high, low, above]: [f64; 3]) -> CellSet {
        let mut is_in = vec![false; self.ln.len()];
        let mut border = Vec::new();
        // Rounding must not put a cell of the bin elsewhere.
        let slack = 1e-9 * (high - low);
        for (index, block) in self.blocks.iter().enumerate() {
            if block.max < low - slack {
                continue;
            }
            for cell in self.cells_of(index) {
                let ln = self.ln[cell];
                if ln > high + slack {
                    is_in[cell] = true;
                } else if ln >= low - slack {
                    border.push((ln, cell));
                }
            }
        }
        border.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut sum = above;
        for (ln, cell) in border {
            if sum >= wanted {
                break;
            }
            is_in[cell] = true;
            sum += (ln - peak).exp();
        }
        let mut rects = Vec::new();
        for (row, line) in is_in.chunks(self.grid.columns as usize).enumerate() {
            let mut column = 0;
            for same in line.chunk_by(|a, b| a == b) {
                if same[0] {
                    rects.push([column, row as u32, same.len() as u32, 1]);
                }
                column += same.len() as u32;
            }
        }
        CellSet { cell_m: self.grid.cell_m, origin_m: self.grid.origin(), rects }
    }

    /// The greatest ln density.
    fn peak(&self) -> f64 {
        self.blocks.iter().map(|block| block.max).fold(f64::NEG_INFINITY, f64::max)
    }

    fn touch(&mut self, row: u32, columns: std::ops::Range<u32>) {
        if columns.is_empty() {
            return;
        }
        let first = row / BLOCK * self.blocks_east;
        for block in columns.start / BLOCK..=(columns.end - 1) / BLOCK {
            self.is_stale[(first + block) as usize] = true;
        }
    }

    /// The columns and rows of a block.
    fn part(&self, block: usize) -> (std::ops::Range<u32>, std::ops::Range<u32>) {
        let (east, north) = (block as u32 % self.blocks_east, block as u32 / self.blocks_east);
        let part = |first: u32, count: u32| first * BLOCK..((first + 1) * BLOCK).min(count);
        (part(east, self.grid.columns), part(north, self.grid.rows))
    }

    /// The indexes of the cells of a block.
    fn cells_of(&self, block: usize) -> impl Iterator<Item = usize> + use<> {
        let grid = self.grid;
        let (columns, rows) = self.part(block);
        rows.flat_map(move |row| columns.clone().map(move |column| grid.index(column, row)))
    }

    /// Makes the sums of all stale blocks anew.
    fn refresh(&mut self) {
        for index in 0..self.blocks.len() {
            if std::mem::take(&mut self.is_stale[index]) {
                self.blocks[index] = self.sums_of(index);
            }
        }
    }

    fn sums_of(&self, block: usize) -> Block {
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for cell in self.cells_of(block) {
            min = min.min(self.ln[cell]);
            max = max.max(self.ln[cell]);
        }
        let mut sums = Block { min, max, ..Block::default() };
        let (columns, rows) = self.part(block);
        for row in rows {
            let y = self.grid.centre(0, row)[1];
            for column in columns.clone() {
                let weight = (self.ln[self.grid.index(column, row)] - max).exp();
                let x = self.grid.centre(column, row)[0];
                sums.mass += weight;
                sums.first[0] += weight * x;
                sums.first[1] += weight * y;
                sums.second[0] += weight * x * x;
                sums.second[1] += weight * x * y;
                sums.second[2] += weight * y * y;
            }
        }
        sums
    }
}

/// The values of cells after a normal displacement of this standard deviation per axis; at the border of the grid
/// it turns back. Their sum stays.
pub(crate) fn diffused(grid: &Grid, values: &[f64], sigma_m: f64) -> Vec<f64> {
    let kernel = kernel(sigma_m / grid.cell_m);
    let (columns, rows) = (grid.columns as usize, grid.rows as usize);
    let mut across = vec![0.0; values.len()];
    for (line, out) in values.chunks(columns).zip(across.chunks_mut(columns)) {
        smooth(&kernel, columns, |i| line[i], |i, value| out[i] = value);
    }
    let mut both = vec![0.0; values.len()];
    for column in 0..columns {
        let at = |row: usize| across[row * columns + column];
        smooth(&kernel, rows, at, |row, value| both[row * columns + column] = value);
    }
    both
}

/// The weights of a cell's neighbours at 0, 1, 2 … cells for a normal displacement of `sigma` cells. Their
/// variance is sigma², however coarse the cells are.
fn kernel(sigma: f64) -> Vec<f64> {
    if sigma < 0.6 {
        let side = sigma * sigma / 2.0;
        return vec![1.0 - 2.0 * side, side];
    }
    let reach = (5.0 * sigma).ceil() as usize;
    let weight = |i: usize| {
        let x = i as f64;
        (-0.5 * (x / sigma).powi(2)).exp()
    };
    let mut weights: Vec<f64> = (0..=reach).map(weight).collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    weights.iter_mut().for_each(|w| *w /= sum);
    weights
}

/// Convolves a line of cells; what would leave it is reflected at its ends.
fn smooth(
    kernel: &[f64],
    count: usize,
    at: impl Fn(usize) -> f64,
    mut set: impl FnMut(usize, f64),
) {
    let last = count as i64 - 1;
    let reflected = |i: i64| {
        let period = 2 * count as i64;
        let place = i.rem_euclid(period);
        if place > last { (period - 1 - place) as usize } else { place as usize }
    };
    for i in 0..count {
        let mut sum = kernel[0] * at(i);
        for (distance, weight) in kernel.iter().enumerate().skip(1) {
            let (i, distance) = (i as i64, distance as i64);
            let (before, after) = if i >= distance && i + distance <= last {
                (at((i - distance) as usize), at((i + distance) as usize))
            } else {
                (at(reflected(i - distance)), at(reflected(i + distance)))
            };
            sum += weight * (before + after);
        }
        set(i, sum);
    }
}
