//! The belief of a step ago, after the target has moved: the mean over a cell of the old density, convolved
//! with a normal displacement.

use csat_proto::raster::Grid;

use super::adaptive::Place;

/// Displacements of more standard deviations than this are left out.
const REACH_SIGMAS: f64 = 5.0;

/// A cell of the belief before.
#[derive(Debug, Clone, Copy)]
pub struct Leaf {
    /// Where it is.
    pub place: Place,
    /// Its density, up to a factor.
    pub density: f64,
}

/// A belief, convolved.
#[derive(Debug, Clone)]
pub struct Moved {
    base: Grid,
    deepest: u8,
    /// How many of the smallest cells a displacement may reach.
    reach: u32,
    /// The leaves in each cell of the coarse grid.
    leaves: Vec<Vec<Leaf>>,
    /// By the levels of a cell and of a leaf, and the distance of their lower ends in smallest cells: the mean over
    /// the cell of the probability of coming from the leaf, along one axis.
    overlaps: Vec<Vec<f64>>,
}

impl Moved {
    /// The belief of `leaves` after a displacement of standard deviation `sigma_m` per axis.
    pub fn new(base: Grid, deepest: u8, sigma_m: f64, leaves: impl Iterator<Item = Leaf>) -> Self {
        let mut by_cell: Vec<Vec<Leaf>> = vec![Vec::new(); base.cells()];
        for leaf in leaves {
            let Place { level, column, row } = leaf.place;
            by_cell[base.index(column >> level, row >> level)].push(leaf);
        }
        let smallest_m = base.cell_m / f64::from(1u32 << deepest);
        let sigma = sigma_m / smallest_m;
        let reach = (REACH_SIGMAS * sigma).ceil() as u32;
        let mut moved = Self { base, deepest, reach, leaves: by_cell, overlaps: Vec::new() };
        for of_cell in 0..=deepest {
            for of_leaf in 0..=deepest {
                let (cell, leaf) = (moved.side(of_cell), moved.side(of_leaf));
                let narrow = narrowed(f64::from(leaf), sigma);
                let distances = -i64::from(leaf + reach)..=i64::from(cell + reach);
                let overlap = |d: i64| overlap(f64::from(cell), f64::from(leaf), d as f64, narrow);
                moved.overlaps.push(distances.map(overlap).collect());
            }
        }
        moved
    }

    /// The side of a cell of a level, in smallest cells.
    fn side(&self, level: u8) -> u32 {
        1 << (self.deepest - level)
    }

    /// The mean density over a cell.
    pub fn density(&self, place: Place) -> f64 {
        let Place { level, column, row } = place;
        let side = self.side(level);
        let whole = self.side(0);
        let span = |index: u32, count: u32| {
            let first = (index * side).saturating_sub(self.reach) / whole;
            first..=((index * side + side + self.reach) / whole).min(count - 1)
        };
        let mut sum = 0.0;
        for near_row in span(row, self.base.rows) {
            for near_column in span(column, self.base.columns) {
                for leaf in &self.leaves[self.base.index(near_column, near_row)] {
                    sum += leaf.density * self.share(place, leaf.place);
                }
            }
        }
        sum
    }

    /// How much of a leaf's density a cell gets.
    fn share(&self, cell: Place, leaf: Place) -> f64 {
        let levels = usize::from(self.deepest) + 1;
        let table = &self.overlaps[usize::from(cell.level) * levels + usize::from(leaf.level)];
        let (of_cell, of_leaf) = (self.side(cell.level), self.side(leaf.level));
        let along = |a: u32, b: u32| {
            let distance = i64::from(b * of_leaf) - i64::from(a * of_cell);
            let place = distance + i64::from(of_leaf + self.reach);
            usize::try_from(place).ok().and_then(|place| table.get(place)).copied().unwrap_or(0.0)
        };
        match along(cell.column, leaf.column) {
            0.0 => 0.0,
            columns => columns * along(cell.row, leaf.row),
        }
    }
}

/// The standard deviation with which cells of side `side` exchange what a displacement of standard deviation
/// `sigma` exchanges. It is less: that a cell's probability counts as spread evenly adds to the variance in each
/// step.
fn narrowed(side: f64, sigma: f64) -> f64 {
    let variance = |narrow: f64| {
        let reach = (REACH_SIGMAS * sigma / side).ceil() as i32 + 1;
        let of = |k: i32| {
            let d = f64::from(k) * side;
            d * d * overlap(side, side, d, narrow)
        };
        (-reach..=reach).map(of).sum::<f64>()
    };
    let (mut low, mut high) = (1e-6 * sigma, sigma);
    for _ in 0..50 {
        let middle = f64::midpoint(low, high);
        if variance(middle) < sigma * sigma { low = middle } else { high = middle }
    }
    high
}

/// ∫ over the cell [0, a] and the leaf [d, d + b] of the normal density of their difference, divided by a.
fn overlap(a: f64, b: f64, d: f64, sigma: f64) -> f64 {
    // The second integral of the normal density.
    let g = |x: f64| {
        let t = x / sigma;
        sigma * (t * cdf(t) + (-0.5 * t * t).exp() / std::f64::consts::TAU.sqrt())
    };
    ((g(d + b) - g(d) - g(d + b - a) + g(d - a)) / a).max(0.0)
}

/// Φ(t).
fn cdf(t: f64) -> f64 {
    0.5 * libm::erfc(-t * std::f64::consts::FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_on_the_way() {
        for (a, b, sigma) in [(1.0, 1.0, 2.5), (32.0, 1.0, 2.5), (1.0, 32.0, 0.7)] {
            // All cells together get all of a leaf.
            let sum: f64 = (-200..200).map(|i| a * overlap(a, b, -f64::from(i) * a, sigma)).sum();
            assert!((sum - b).abs() < 1e-6, "{a} {b}: {sum}");
        }
    }
}
