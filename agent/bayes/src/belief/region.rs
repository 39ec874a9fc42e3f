//! Sets of cells: the highest-density region of a belief.

use serde::{Deserialize, Serialize};

/// A set of rectangles of cells.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CellSet {
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0), `world`, metres.
    pub origin_m: [f64; 2],
    /// First column, first row, number of columns, number of rows of each rectangle; none overlap.
    pub rects: Vec<[u32; 4]>,
}

impl CellSet {
    /// Whether a point, `world`, metres, is in one of the cells.
    pub fn contains(&self, p: [f64; 2]) -> bool {
        let [x, y] = [0, 1].map(|axis| ((p[axis] - self.origin_m[axis]) / self.cell_m).floor());
        self.rects.iter().any(|&[column, row, columns, rows]| {
            let within = |value: f64, first: u32, count: u32| {
                value >= f64::from(first) && value < f64::from(first) + f64::from(count)
            };
            within(x, column, columns) && within(y, row, rows)
        })
    }

    /// Its area, m².
    pub fn area_m2(&self) -> f64 {
        let cells = self.rects.iter().map(|r| f64::from(r[2]) * f64::from(r[3]));
        cells.sum::<f64>() * self.cell_m * self.cell_m
    }
}

/// A piece of a belief: its density relative to others, its probability, and where it is in an order that
/// decides between pieces of equal density.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// ln of the density, up to a constant.
    pub ln_density: f64,
    /// Its probability, up to a factor.
    pub mass: f64,
    /// Its number.
    pub index: u32,
}

/// The numbers of the densest pieces that hold `share` of all probability together: the piece that reaches it
/// is the last one.
pub fn densest(mut pieces: Vec<Piece>, share: f64) -> Vec<u32> {
    pieces
        .sort_unstable_by(|a, b| b.ln_density.total_cmp(&a.ln_density).then(a.index.cmp(&b.index)));
    let wanted = share * pieces.iter().map(|piece| piece.mass).sum::<f64>();
    let mut sum = 0.0;
    let taken = pieces.iter().take_while(|piece| {
        let is_needed = sum < wanted;
        sum += piece.mass;
        is_needed
    });
    taken.map(|piece| piece.index).collect()
}
