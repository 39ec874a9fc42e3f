//! The search for a target that was not detected yet: (8) of Tisdale et al. 2008 over a receding horizon.
//!
//! P(D) = 1 − Σ_x p(x) Π_k (1 − p(D, V | x, pose_k)). Three things are added to it:
//!
//! - **Discount.** What is detected t seconds from now is worth e^(−t/`discount_s`).
//! - **Edges.** Ground beside seen ground or beside the border is worth more, by up to `edge_worth`: left
//!   behind, it would need a flight of its own.
//! - **Attraction.** Probability at a distance d from the end of the plan adds e^(−d/`attraction_m`) times itself,
//!   as far as another aircraft is not nearer.

use csat_proto::camera::Pose;
use csat_proto::raster::Grid;

use super::beam::Objective;
use super::footprint::Footprints;
use super::route::distance;
use crate::config::GuidanceConfig;
use crate::search_map::SearchMap;

/// Cells per side of the blocks that attract.
const BLOCK: u32 = 4;
/// Half the side of the square in which the edges of seen ground are looked for, metres.
const EDGE_M: f64 = 56.0;
/// Attraction is measured from the place at which the aircraft is this much after the end of a plan, seconds.
pub(super) const LEAD_S: f64 = 3.5;
/// Over this difference of distances a place goes from one aircraft to the other, metres.
const SHARE_M: f64 = 100.0;
/// Attraction is tabulated in steps of this many metres.
const PULL_STEP_M: f64 = 8.0;

/// Tuning: parts of the objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// The time constant of the discount, seconds.
    pub discount_s: f64,
    /// What edges are worth.
    pub edge_worth: f64,
    /// The distance of attraction, metres.
    pub attraction_m: f64,
    /// The weight of attraction.
    pub attraction: f64,
}

impl From<&GuidanceConfig> for Weights {
    fn from(config: &GuidanceConfig) -> Self {
        Self {
            discount_s: config.discount_s,
            edge_worth: config.edge_worth,
            attraction_m: config.attraction_m,
            attraction: config.attraction,
        }
    }
}

/// The objective of an aircraft without a target.
pub struct Coverage<'a> {
    footprints: &'a Footprints,
    grid: Grid,
    lead_m: f64,
    /// What each cell is worth, at the start.
    worth: Vec<f32>,
    blocks: Blocks,
    /// e^(−t/τ) by second.
    discount: Vec<f64>,
    /// The attraction by distance.
    pull: Vec<f32>,
    scratch: Scratch,
}

/// What a plan leaves.
pub struct Left {
    worth: Vec<f32>,
    blocks: Vec<f32>,
    gained: f64,
}

/// Cells that a plan under evaluation has seen.
struct Scratch {
    /// The evaluation that wrote a cell last, and what it left there.
    cells: Vec<(u32, f32)>,
    evaluation: u32,
    blocks: Vec<f32>,
}

/// Squares of cells.
struct Blocks {
    centres: Vec<[f64; 2]>,
    /// How much of each is this aircraft's.
    shares: Vec<f32>,
    of_cell: Vec<u32>,
}

impl<'a> Coverage<'a> {
    /// The objective on a map from which the plans of others have been taken out. `own` is where this aircraft
    /// is going to be, `others` where others are.
    pub fn new(
        footprints: &'a Footprints,
        map: &SearchMap,
        weights: &Weights,
        [own, others]: [&[[f64; 2]]; 2],
        lead_m: f64,
    ) -> Self {
        let grid = map.grid;
        let worth = worth(map, weights.edge_worth);
        let blocks = Blocks::new(&grid, own, others);
        let [width, height] = [grid.columns, grid.rows].map(|n| f64::from(n) * grid.cell_m);
        // Plans may end far outside.
        let pulls = (3.0 * width.hypot(height) / PULL_STEP_M).ceil() as usize + 1;
        let pull = |index: usize| {
            let d = index as f64 * PULL_STEP_M;
            (weights.attraction * (-d / weights.attraction_m).exp()) as f32
        };
        let count = worth.len();
        Self {
            footprints,
            grid,
            lead_m,
            worth,
            discount: (0..512).map(|t| (-f64::from(t) / weights.discount_s).exp()).collect(),
            pull: (0..pulls).map(pull).collect(),
            scratch: Scratch {
                cells: vec![(0, 0.0); count],
                evaluation: 0,
                blocks: vec![0.0; blocks.centres.len()],
            },
            blocks,
        }
    }

    fn discount(&self, second: usize) -> f64 {
        self.discount[second.min(self.discount.len() - 1)]
    }

    fn attraction(&self, blocks: impl Iterator<Item = f32>, end: &Pose) -> f64 {
        let (sin, cos) = end.yaw_rad.sin_cos();
        let p = [end.p_world[0] + self.lead_m * cos, end.p_world[1] + self.lead_m * sin];
        let mut sum = 0.0f32;
        for ((left, centre), share) in blocks.zip(&self.blocks.centres).zip(&self.blocks.shares) {
            let index = (distance(*centre, p) / PULL_STEP_M) as usize;
            sum += left * share * self.pull[index.min(self.pull.len() - 1)];
        }
        f64::from(sum)
    }
}

impl Objective for Coverage<'_> {
    type State = Left;

    fn start(&self) -> Left {
        let mut blocks = vec![0.0; self.blocks.centres.len()];
        for (worth, block) in self.worth.iter().zip(&self.blocks.of_cell) {
            blocks[*block as usize] += worth;
        }
        Left { worth: self.worth.clone(), blocks, gained: 0.0 }
    }

    fn value(&mut self, left: &Left, second: usize, poses: &[Pose]) -> f64 {
        let mut scratch = std::mem::replace(&mut self.scratch, Scratch::none());
        scratch.evaluation += 1;
        scratch.blocks.copy_from_slice(&left.blocks);
        let mut gained = left.gained;
        for (index, pose) in poses.iter().enumerate() {
            let mut gain = 0.0f32;
            self.footprints.cells(&self.grid, pose, |cell, missed| {
                let (evaluation, before) = scratch.cells[cell];
                let before =
                    if evaluation == scratch.evaluation { before } else { left.worth[cell] };
                let after = before * missed;
                scratch.cells[cell] = (scratch.evaluation, after);
                scratch.blocks[self.blocks.of_cell[cell] as usize] -= before - after;
                gain += before - after;
            });
            gained += f64::from(gain) * self.discount(second + index + 1);
        }
        let end = poses.last().map_or(0.0, |end| {
            let blocks = scratch.blocks.iter().copied();
            self.discount(second + poses.len()) * self.attraction(blocks, end)
        });
        self.scratch = scratch;
        gained + end
    }

    fn after(&mut self, left: &Left, second: usize, poses: &[Pose]) -> Left {
        let mut worth = left.worth.clone();
        let mut blocks = left.blocks.clone();
        let mut gained = left.gained;
        for (index, pose) in poses.iter().enumerate() {
            let mut gain = 0.0f32;
            self.footprints.cells(&self.grid, pose, |cell, missed| {
                let lost = worth[cell] * (1.0 - missed);
                worth[cell] -= lost;
                blocks[self.blocks.of_cell[cell] as usize] -= lost;
                gain += lost;
            });
            gained += f64::from(gain) * self.discount(second + index + 1);
        }
        Left { worth, blocks, gained }
    }
}

impl Scratch {
    fn none() -> Self {
        Self { cells: Vec::new(), evaluation: 0, blocks: Vec::new() }
    }
}

impl Blocks {
    fn new(grid: &Grid, own: &[[f64; 2]], others: &[[f64; 2]]) -> Self {
        let columns = grid.columns.div_ceil(BLOCK);
        let rows = grid.rows.div_ceil(BLOCK);
        let [west, south] = grid.origin();
        let side = f64::from(BLOCK) * grid.cell_m;
        let centre = |index: u32| {
            let (column, row) = (index % columns, index / columns);
            [west + (f64::from(column) + 0.5) * side, south + (f64::from(row) + 0.5) * side]
        };
        let centres: Vec<_> = (0..columns * rows).map(centre).collect();
        let nearest = |from: &[[f64; 2]], p: [f64; 2]| {
            from.iter().map(|q| distance(*q, p)).fold(f64::INFINITY, f64::min)
        };
        let share = |p: &[f64; 2]| {
            let nearer = nearest(own, *p) - nearest(others, *p);
            (1.0 / (1.0 + (nearer / SHARE_M).exp())) as f32
        };
        let shares = centres.iter().map(share).collect();
        let block = |cell: u32| cell / grid.columns / BLOCK * columns + cell % grid.columns / BLOCK;
        let of_cell = (0..grid.columns * grid.rows).map(block).collect();
        Self { centres, shares, of_cell }
    }
}

/// What the cells of a map are worth: their probability, and more at edges.
fn worth(map: &SearchMap, edge_worth: f64) -> Vec<f32> {
    let [columns, rows] = [map.grid.columns as usize, map.grid.rows as usize];
    // Sums over all cells to the south and west.
    let width = columns + 1;
    let mut sums = vec![0.0f64; width * (rows + 1)];
    for row in 0..rows {
        let mut sum = 0.0;
        for column in 0..columns {
            sum += map.mass[row * columns + column];
            sums[(row + 1) * width + column + 1] = sums[row * width + column + 1] + sum;
        }
    }
    let reach = (EDGE_M / map.grid.cell_m).round().max(1.0) as usize;
    let area = ((2 * reach + 1) * (2 * reach + 1)) as f64;
    let span = |at: usize, count: usize| (at.saturating_sub(reach), (at + reach + 1).min(count));
    let mut worth = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        let (south, north) = span(row, rows);
        for column in 0..columns {
            let (west, east) = span(column, columns);
            let sum = sums[north * width + east]
                - sums[south * width + east]
                - sums[north * width + west]
                + sums[south * width + west];
            let mass = map.mass[row * columns + column];
            let edge = (1.0 - sum / area / mass.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            worth.push((mass * (1.0 + edge_worth * edge)) as f32);
        }
    }
    worth
}
