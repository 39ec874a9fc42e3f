//! What the fleet calls cleared, on the raster of the roads.

use csat_clearing::bitmap::Bitmap;
use csat_proto::ids::AgentId;
use csat_world::contamination::Square;
use csat_world::road_area::RoadArea;

/// Which cells of road are called cleared, and by whom first.
pub struct Claims {
    roads: RoadArea,
    /// By cell: who claimed it first.
    by: Vec<Option<AgentId>>,
    /// Cells of road that are not claimed: a bit for each cell, rows of whole words.
    open: Vec<u64>,
    words: usize,
    count: u64,
}

impl Claims {
    /// No claims on these roads.
    pub fn new(roads: &RoadArea) -> Self {
        let words = roads.columns().div_ceil(64);
        let mut open = vec![0; words * roads.rows()];
        for cell in roads.cells() {
            let [column, row] = place(roads, cell);
            open[row * words + column / 64] |= 1 << (column % 64);
        }
        let by = vec![None; roads.columns() * roads.rows()];
        Self { roads: roads.clone(), by, open, words, count: 0 }
    }

    /// How many cells are claimed.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Who claimed a cell first, if it is claimed.
    pub fn claimant(&self, cell: u32) -> Option<AgentId> {
        self.by.get(cell as usize).copied().flatten()
    }

    /// Claims the cells of road whose middle lies in a pixel of `mask`, the pixels of the image over `square`; row 0
    /// is north, column 0 west. Gives the cells that were not claimed before.
    pub fn claim(&mut self, agent: AgentId, square: &Square, mask: &Bitmap) -> Vec<u32> {
        let side_m = square.side_m / f64::from(mask.columns());
        let [west, north] =
            [square.middle[0] - square.side_m / 2.0, square.middle[1] + square.side_m / 2.0];
        let mut new = Vec::new();
        for row in self.rows_of(square) {
            for column in self.open_in(row, square) {
                let cell = (row * self.roads.columns() + column) as u32;
                let [x, y] = self.roads.middle(cell);
                let [right, down] = [(x - west) / side_m, (north - y) / side_m];
                if right < 0.0 || down < 0.0 {
                    continue;
                }
                let (right, down) = (right as u16, down as u16);
                if down < mask.rows() && right < mask.columns() && mask.get(down, right) {
                    new.push(cell);
                }
            }
        }
        for &cell in &new {
            let [column, row] = place(&self.roads, cell);
            self.open[row * self.words + column / 64] &= !(1 << (column % 64));
            self.by[cell as usize] = Some(agent);
        }
        self.count += new.len() as u64;
        new
    }

    /// Withdraws the claim on a cell.
    pub fn withdraw(&mut self, cell: u32) {
        if self.by[cell as usize].take().is_some() {
            let [column, row] = place(&self.roads, cell);
            self.open[row * self.words + column / 64] |= 1 << (column % 64);
            self.count -= 1;
        }
    }

    /// Withdraws every claim.
    pub fn withdraw_all(&mut self) {
        *self = Self::new(&self.roads);
    }

    /// Rows of cells whose middles may lie in a square.
    fn rows_of(&self, square: &Square) -> std::ops::Range<usize> {
        self.range(1, square, self.roads.rows())
    }

    fn range(&self, axis: usize, square: &Square, count: usize) -> std::ops::Range<usize> {
        let start_m = square.middle[axis] + self.roads.ground().size_m[axis] / 2.0;
        let index = |along_m: f64| (along_m / self.roads.cell_m()).floor().max(0.0) as usize;
        let (from, to) =
            (index(start_m - square.side_m / 2.0), index(start_m + square.side_m / 2.0));
        from.min(count)..(to + 1).min(count)
    }

    /// Columns of a row whose cells are road, not claimed, and may lie in a square.
    fn open_in(&self, row: usize, square: &Square) -> Vec<usize> {
        let columns = self.range(0, square, self.roads.columns());
        let first = columns.start / 64;
        let mut found = Vec::new();
        for word in first..columns.end.div_ceil(64) {
            let mut bits = self.open[row * self.words + word];
            while bits != 0 {
                found.push(word * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
        found.retain(|column| columns.contains(column));
        found
    }
}

fn place(roads: &RoadArea, cell: u32) -> [usize; 2] {
    let columns = roads.columns().max(1);
    [cell as usize % columns, cell as usize / columns]
}
