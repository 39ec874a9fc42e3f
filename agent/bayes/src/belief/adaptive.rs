//! Cells that split where probability gathers: a quadtree over the cells of a coarse grid.
//!
//! The value of a cell is the whole evidence at its centre, however long ago the cell was split, so for a target
//! that stands the belief is a function of the set of factors. Which cells are split is decided anew after each
//! update, from the top down: a cell that holds more than `MAX_SHARE` of the probability is split, and so are
//! the eight around it, because the probability at the centre of a cell says little of a peak at its border.

use std::sync::Arc;

use csat_proto::raster::Grid;

use super::moved::{Leaf, Moved};
use super::region::{CellSet, Piece, densest};
use super::square::Square;
use crate::likelihood::{Likelihood, Rect};
use crate::search_map::Gaussian;
use crate::tiles::Tiles;

/// A cell with a greater share of the probability is split, unless it is one of the smallest.
const MAX_SHARE: f64 = 1.0 / 256.0;
/// The same for a target that moves: each step spreads what a cell holds evenly over it.
const MAX_SHARE_MOVING: f64 = 1.0 / 1024.0;
/// The least ln density, relative to the greatest, of a target that moves.
const LEAST_LN: f64 = -700.0;

/// p(x | z) on cells of several sizes; uniform at the start.
#[derive(Debug, Clone)]
pub struct AdaptiveBelief {
    base: Grid,
    deepest: u8,
    /// All cells whose values are known: those of the coarse grid first, in its order.
    cells: Vec<Cell>,
    /// The cells that are not split, coarse ones first.
    leaves: Vec<u32>,
    prior: Option<Moved>,
    evidence: Vec<Evidence>,
    /// Counts how often the tree was made.
    generation: u32,
}

/// A cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    ln: f64,
    place: Place,
    /// The first of its four children; 0 if they are not known.
    children: u32,
    /// The tree in which it was split last.
    split_in: u32,
}

/// Where a cell is: the column and the row in the grid of its level, whose cells have a side of 2^-level of
/// those of level 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// How often the coarse grid was halved.
    pub level: u8,
    /// From the west.
    pub column: u32,
    /// From the south.
    pub row: u32,
}

/// A function that is added to ln of the density, times `weight`.
#[derive(Debug, Clone)]
struct Evidence {
    weight: f64,
    what: What,
}

#[derive(Debug, Clone)]
enum What {
    Frame(Arc<Likelihood>),
    /// The belief of another agent, and the grid of its tiles of level 0.
    Belief(Arc<Tiles>, Grid),
    /// What was known when the target moved last.
    Prior,
}

impl AdaptiveBelief {
    /// A uniform belief over the cells of `base`; the smallest cells are not larger than `min_cell_m`.
    pub fn new(base: Grid, min_cell_m: f64) -> Self {
        let deepest = (base.cell_m / min_cell_m).log2().ceil().clamp(0.0, 12.0) as u8;
        let places = (0..base.rows)
            .flat_map(|row| (0..base.columns).map(move |column| Place { level: 0, column, row }));
        let cell = |place| Cell { ln: 0.0, place, children: 0, split_in: 0 };
        let cells: Vec<Cell> = places.map(cell).collect();
        let leaves = (0..cells.len() as u32).collect();
        // No cell was split in the first tree.
        let generation = 1;
        Self { base, deepest, cells, leaves, prior: None, evidence: Vec::new(), generation }
    }

    /// Multiplies the belief by likelihoods, (1a).
    pub fn update(&mut self, likelihoods: &[Arc<Likelihood>]) {
        for likelihood in likelihoods {
            let Some(bounds) = likelihood.bounds() else { continue };
            self.change(&bounds, |ln, x| ln + likelihood.ln_ratio(x));
            self.evidence.push(Evidence { weight: 1.0, what: What::Frame(likelihood.clone()) });
        }
        self.refine();
    }

    /// Adds `weight` times the density of another belief to ln of the density, after `keep` times what there is.
    pub fn pool(&mut self, keep: f64, weight: f64, coarse: &Grid, tiles: &Arc<Tiles>) {
        for index in 0..self.cells.len() {
            let centre = self.centre(self.cells[index].place);
            let cell = &mut self.cells[index];
            cell.ln = keep * cell.ln + weight * tiles.ln_density(coarse, centre);
        }
        self.evidence.iter_mut().for_each(|evidence| evidence.weight *= keep);
        self.evidence.retain(|evidence| evidence.weight.abs() > 1e-9);
        self.evidence.push(Evidence { weight, what: What::Belief(tiles.clone(), *coarse) });
        self.refine();
    }

    /// The target moved by a normal displacement of this standard deviation per axis, (1b).
    pub fn diffuse(&mut self, sigma_m: f64) {
        let peak = self.peak();
        let leaves = self.leaves.iter().map(|leaf| {
            let Cell { ln, place, .. } = self.cells[*leaf as usize];
            Leaf { place, density: (ln - peak).exp() }
        });
        self.prior = Some(Moved::new(self.base, self.deepest, sigma_m, leaves));
        self.evidence = vec![Evidence { weight: 1.0, what: What::Prior }];
        self.cells.truncate(self.base.cells());
        for index in 0..self.cells.len() {
            let place = self.cells[index].place;
            let ln = self.evaluate(place);
            self.cells[index] = Cell { ln, place, children: 0, split_in: 0 };
        }
        self.refine();
    }

    /// ln of the density of the cell that contains a point, up to a constant, and the centre of that cell.
    pub fn at(&self, p: [f64; 2]) -> Option<([f64; 2], f64)> {
        let (column, row) = self.base.cell_of(p)?;
        let mut index = self.base.index(column, row) as u32;
        loop {
            let cell = self.cells[index as usize];
            let centre = self.centre(cell.place);
            if cell.split_in != self.generation {
                return Some((centre, cell.ln));
            }
            let child = u32::from(p[0] >= centre[0]) + 2 * u32::from(p[1] >= centre[1]);
            index = cell.children + child;
        }
    }

    /// Mean and covariance; a cell counts as spread evenly.
    pub fn gaussian(&self) -> Gaussian {
        let peak = self.peak();
        let (mut mass, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
        // About the densest cell: far from it, products of coordinates would swallow small deviations.
        let about = self.densest_centre();
        for leaf in &self.leaves {
            let cell = &self.cells[*leaf as usize];
            let side = self.side_m(cell.place.level);
            let weight = (cell.ln - peak).exp() * side * side;
            let centre = self.centre(cell.place);
            let [x, y] = [0, 1].map(|axis| centre[axis] - about[axis]);
            let within = side * side / 12.0;
            mass += weight;
            first[0] += weight * x;
            first[1] += weight * y;
            second[0] += weight * (x * x + within);
            second[1] += weight * x * y;
            second[2] += weight * (y * y + within);
        }
        let [x, y] = first.map(|sum| sum / mass);
        let [xx, xy, yy] = second.map(|sum| sum / mass);
        Gaussian {
            mean: [about[0] + x, about[1] + y],
            covariance: [xx - x * x, xy - x * y, yy - y * y],
        }
    }

    /// −Σ p ln p of the density, in nats of square metres.
    pub fn entropy(&self) -> f64 {
        let peak = self.peak();
        let (mut mass, mut weighted) = (0.0, 0.0);
        for leaf in &self.leaves {
            let cell = &self.cells[*leaf as usize];
            let weight = (cell.ln - peak).exp() * self.side_m(cell.place.level).powi(2);
            mass += weight;
            weighted += weight * (cell.ln - peak);
        }
        mass.ln() - weighted / mass
    }

    /// The cells as squares with their probabilities.
    pub fn squares(&self) -> Vec<Square> {
        let peak = self.peak();
        let square = |leaf: &u32| {
            let cell = &self.cells[*leaf as usize];
            let side_m = self.side_m(cell.place.level);
            let mass = (cell.ln - peak).exp() * side_m * side_m;
            Square { centre: self.centre(cell.place), side_m, mass }
        };
        self.leaves.iter().map(square).collect()
    }

    /// The densest cells that hold `share` of the probability. Of cells of equal density, large ones are taken
    /// first, and then row by row from the south.
    pub fn highest_density(&self, share: f64) -> CellSet {
        let peak = self.peak();
        let piece = |(index, leaf): (usize, &u32)| {
            let cell = &self.cells[*leaf as usize];
            let mass = (cell.ln - peak).exp() * self.side_m(cell.place.level).powi(2);
            Piece { ln_density: cell.ln, mass, index: index as u32 }
        };
        let pieces = self.leaves.iter().enumerate().map(piece).collect();
        let rect = |index: u32| {
            let place = self.cells[self.leaves[index as usize] as usize].place;
            let side = 1 << (self.deepest - place.level);
            [place.column * side, place.row * side, side, side]
        };
        let rects = densest(pieces, share).into_iter().map(rect).collect();
        let cell_m = self.side_m(self.deepest);
        CellSet { cell_m, origin_m: self.base.origin(), rects }
    }

    /// The values of all cells.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.leaves.iter().map(|leaf| self.cells[*leaf as usize].ln)
    }

    /// How many cells there are.
    pub fn count(&self) -> usize {
        self.leaves.len()
    }

    /// Side of the cells of a level, metres.
    fn side_m(&self, level: u8) -> f64 {
        self.base.cell_m / f64::from(1u32 << level)
    }

    fn centre(&self, Place { level, column, row }: Place) -> [f64; 2] {
        let (side, [x, y]) = (self.side_m(level), self.base.origin());
        [x + (f64::from(column) + 0.5) * side, y + (f64::from(row) + 0.5) * side]
    }

    fn peak(&self) -> f64 {
        let lns = self.leaves.iter().map(|leaf| self.cells[*leaf as usize].ln);
        lns.fold(f64::NEG_INFINITY, f64::max)
    }

    fn densest_centre(&self) -> [f64; 2] {
        let peak = self.peak();
        let is_densest = |leaf: &&u32| self.cells[**leaf as usize].ln == peak;
        let leaf = self.leaves.iter().find(is_densest).copied().unwrap_or_default();
        self.centre(self.cells[leaf as usize].place)
    }

    /// Changes the values of all cells whose centres may be in a rectangle.
    fn change(&mut self, bounds: &Rect, with: impl Fn(f64, [f64; 2]) -> f64) {
        let half = self.base.cell_m / 2.0;
        let columns = self.base.columns_between(bounds.min[0] - half, bounds.max[0] + half);
        let mut stack = Vec::new();
        for row in self.base.rows_between(bounds.min[1] - half, bounds.max[1] + half) {
            stack.extend(columns.clone().map(|column| self.base.index(column, row) as u32));
        }
        while let Some(index) = stack.pop() {
            let centre = self.centre(self.cells[index as usize].place);
            let cell = &mut self.cells[index as usize];
            cell.ln = with(cell.ln, centre);
            if cell.children != 0 {
                stack.extend(cell.children..cell.children + 4);
            }
        }
    }

    /// The whole evidence at the centre of a cell.
    fn evaluate(&self, place: Place) -> f64 {
        let centre = self.centre(place);
        let ln = |what: &What| match what {
            What::Frame(likelihood) => likelihood.ln_ratio(centre),
            What::Belief(tiles, coarse) => tiles.ln_density(coarse, centre),
            What::Prior => {
                let density = self.prior.as_ref().map_or(1.0, |prior| prior.density(place));
                density.ln().max(LEAST_LN)
            }
        };
        self.evidence.iter().map(|evidence| evidence.weight * ln(&evidence.what)).sum()
    }

    /// Decides anew which cells are split.
    fn refine(&mut self) {
        self.forget_unused();
        self.generation += 1;
        let mut levels: Vec<Vec<u32>> = vec![Vec::new(); usize::from(self.deepest) + 1];
        levels[0] = (0..self.base.cells() as u32).collect();
        let most = if self.prior.is_some() { MAX_SHARE_MOVING } else { MAX_SHARE };
        for level in 0..self.deepest {
            let (peak, total) = self.total(&levels);
            let side = self.side_m(level);
            let mut next = 0;
            // Splitting cells around may add cells of this level.
            while next < levels[usize::from(level)].len() {
                let cell = self.cells[levels[usize::from(level)][next] as usize];
                next += 1;
                if (cell.ln - peak).exp() * side * side > most * total {
                    self.split_around(cell.place, &mut levels);
                }
            }
        }
        let is_leaf = |index: &u32| self.cells[*index as usize].split_in != self.generation;
        self.leaves = levels.into_iter().flatten().filter(is_leaf).collect();
    }

    /// The greatest ln density of the cells that are not split, and their sum relative to it.
    fn total(&self, levels: &[Vec<u32>]) -> (f64, f64) {
        let cells = || levels.iter().flatten().map(|index| &self.cells[*index as usize]);
        let leaves = || cells().filter(|cell| cell.split_in != self.generation);
        let peak = leaves().map(|cell| cell.ln).fold(f64::NEG_INFINITY, f64::max);
        let area = |cell: &Cell| self.side_m(cell.place.level).powi(2);
        (peak, leaves().map(|cell| (cell.ln - peak).exp() * area(cell)).sum())
    }

    /// Splits a cell and the eight around it.
    fn split_around(&mut self, place: Place, levels: &mut [Vec<u32>]) {
        let Place { level, column, row } = place;
        let (columns, rows) = (self.base.columns << level, self.base.rows << level);
        for row in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
            for column in column.saturating_sub(1)..=(column + 1).min(columns - 1) {
                let cell = self.reach(Place { level, column, row }, levels);
                self.split(cell, levels);
            }
        }
    }

    /// The cell of a place; cells around it are split as far as it takes.
    fn reach(&mut self, place: Place, levels: &mut [Vec<u32>]) -> u32 {
        let Place { level, column, row } = place;
        let mut index = self.base.index(column >> level, row >> level) as u32;
        for above in (0..level).rev() {
            let children = self.split(index, levels);
            index = children + (column >> above & 1) + 2 * (row >> above & 1);
        }
        index
    }

    /// Splits a cell of the tree, if it is not split yet. Gives the first of its children.
    fn split(&mut self, index: u32, levels: &mut [Vec<u32>]) -> u32 {
        let Cell { place, children, split_in, .. } = self.cells[index as usize];
        if split_in == self.generation {
            return children;
        }
        let children = if children == 0 { self.make_children(place) } else { children };
        let cell = &mut self.cells[index as usize];
        (cell.children, cell.split_in) = (children, self.generation);
        levels[usize::from(place.level) + 1].extend(children..children + 4);
        children
    }

    fn make_children(&mut self, Place { level, column, row }: Place) -> u32 {
        let first = self.cells.len() as u32;
        for child in 0..4 {
            let (column, row) = (2 * column + child % 2, 2 * row + child / 2);
            let place = Place { level: level + 1, column, row };
            let ln = self.evaluate(place);
            self.cells.push(Cell { ln, place, children: 0, split_in: 0 });
        }
        first
    }

    /// Forgets cells that are no longer in the tree when they are many.
    fn forget_unused(&mut self) {
        let used = self.leaves.len() + self.leaves.len() / 3;
        if self.cells.len() <= 2 * used + 1024 {
            return;
        }
        let old = std::mem::take(&mut self.cells);
        self.cells = old[..self.base.cells()].to_vec();
        let mut index = 0;
        while index < self.cells.len() {
            let cell = self.cells[index];
            if cell.split_in == self.generation {
                let first = cell.children as usize;
                self.cells[index].children = self.cells.len() as u32;
                self.cells.extend_from_slice(&old[first..first + 4]);
            } else {
                self.cells[index].children = 0;
            }
            index += 1;
        }
    }
}
