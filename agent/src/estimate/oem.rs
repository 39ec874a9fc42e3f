//! The occupancy-elevation map M_i (thesis §4.6, paper §VI-C).

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::Grid;
use csat_proto::time::Step;
use xxhash_rust::xxh3::xxh3_64;

use crate::mutant::{Mutant, is_on};

/// Cells along a side of a block, which is the unit of comparison and repair.
pub const BLOCK: usize = 16;

/// Square cells that are Unexplored, Occupied up to a height, or Empty. Merging is a join per cell,
/// so deltas may arrive in any order and more than once.
#[derive(Debug, Clone, PartialEq)]
pub struct Oem {
    grid: Grid,
    cells: Vec<OemCell>,
}

impl Oem {
    /// Every cell Unexplored.
    pub fn unexplored(grid: Grid) -> Self {
        Self { grid, cells: vec![OemCell::Unexplored; grid.cells()] }
    }

    /// The grid of cells.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The states, row-major.
    pub fn cells(&self) -> &[OemCell] {
        &self.cells
    }

    /// Joins a state into a cell; true if the cell changed. Cells outside the map are ignored.
    pub fn join(&mut self, delta: OemDelta) -> bool {
        let Some(cell) = self.cells.get_mut(delta.cell as usize) else { return false };
        let joined = joined(*cell, delta.state);
        std::mem::replace(cell, joined) != joined
    }

    /// What joining `deltas` would change: the cells by increasing index and their new states.
    pub fn changes(&self, deltas: &[OemDelta]) -> BTreeMap<u32, OemCell> {
        let mut changed = BTreeMap::new();
        for &OemDelta { cell, state } in deltas {
            let Some(&known) = self.cells.get(cell as usize) else { continue };
            let before = changed.get(&cell).copied().unwrap_or(known);
            let joined = joined(before, state);
            if joined != before {
                changed.insert(cell, joined);
            }
        }
        changed
    }

    /// The height of an occupied cell, metres.
    pub fn height_m(&self, column: u32, row: u32) -> Option<f64> {
        match self.cells[self.grid.index(column, row)] {
            OemCell::Occupied { height_dm } => Some(f64::from(height_dm) / 10.0),
            OemCell::Unexplored | OemCell::Empty => None,
        }
    }

    /// Every cell that is not Unexplored.
    pub fn known(&self) -> impl Iterator<Item = OemDelta> + '_ {
        self.cells.iter().enumerate().filter_map(known)
    }

    /// The cells of some blocks that are not Unexplored, by increasing index.
    pub fn known_in(&self, blocks: &BTreeSet<usize>) -> impl Iterator<Item = OemDelta> {
        self.known().filter(|delta| blocks.contains(&self.block_of(delta.cell as usize)))
    }

    /// Number of blocks of [`BLOCK`] x [`BLOCK`] cells, those at the border smaller.
    pub fn blocks(grid: &Grid) -> usize {
        (grid.columns as usize).div_ceil(BLOCK) * (grid.rows as usize).div_ceil(BLOCK)
    }

    /// A hash of each block of [`BLOCK`] x [`BLOCK`] cells, row-major.
    pub fn block_hashes(&self) -> BlockHashes {
        let columns = self.grid.columns as usize;
        let mut hashes = Vec::with_capacity(Self::blocks(&self.grid));
        let mut codes = Vec::new();
        for rows in self.cells.chunks(columns * BLOCK) {
            for start in (0..columns).step_by(BLOCK) {
                codes.clear();
                for row in rows.chunks(columns) {
                    let part = &row[start..columns.min(start + BLOCK)];
                    codes.extend(part.iter().flat_map(|state| state.code().to_le_bytes()));
                }
                hashes.push(xxh3_64(&codes));
            }
        }
        BlockHashes(hashes)
    }

    fn blocks_per_row(&self) -> usize {
        (self.grid.columns as usize).div_ceil(BLOCK)
    }

    fn block_of(&self, cell: usize) -> usize {
        let columns = self.grid.columns as usize;
        cell / columns / BLOCK * self.blocks_per_row() + cell % columns / BLOCK
    }
}

/// Hashes of the blocks of a map, row-major.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BlockHashes(Vec<u64>);

impl BlockHashes {
    /// The short hashes for a digest of `step`: those of equal blocks are equal, those of different
    /// blocks rarely are.
    ///
    /// Each step has its own short hashes. Otherwise two maps that no longer change could differ in a
    /// block for ever, and no digest would show it.
    pub fn told_at(&self, step: Step) -> Vec<u16> {
        let short = |hash: &u64| {
            let stamped = [hash.to_le_bytes(), u64::from(step.0).to_le_bytes()];
            xxh3_64(stamped.as_flattened()) as u16
        };
        self.0.iter().map(short).collect()
    }
}

fn joined(cell: OemCell, state: OemCell) -> OemCell {
    match is_on(Mutant::OemLastWriter) {
        true => state,
        false => cell.join(state),
    }
}

fn known((cell, &state): (usize, &OemCell)) -> Option<OemDelta> {
    (state != OemCell::Unexplored).then_some(OemDelta { cell: cell as u32, state })
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::model::Ground;

    #[test]
    fn a_block_hash_tells_of_its_own_cells() {
        // 40 x 21 cells: 3 x 2 blocks.
        let grid = Grid::covering(&Ground { size_m: [200.0, 105.0] }, 5.0);
        let start = Oem::unexplored(grid);
        let before = start.block_hashes();
        assert_eq!(before.0.len(), 6);
        for (column, row, block) in [(0, 0, 0), (15, 15, 0), (16, 0, 1), (39, 15, 2), (33, 20, 5)] {
            let mut oem = start.clone();
            let cell = grid.index(column, row) as u32;
            assert!(oem.join(OemDelta { cell, state: OemCell::Empty }));
            let after = oem.block_hashes();
            let changed: Vec<usize> = (0..6).filter(|&b| before.0[b] != after.0[b]).collect();
            assert_eq!(changed, [block]);
            assert_eq!(oem.known_in(&BTreeSet::from([block])).count(), 1);
            assert_eq!(oem.known_in(&BTreeSet::from([(block + 1) % 6])).count(), 0);
        }
    }

    #[test]
    fn blocks_that_look_equal_at_one_step_do_not_at_the_next() {
        let alike = |a: u64, b: u64, step| {
            let told = BlockHashes(vec![a, b]).told_at(Step(step));
            told[0] == told[1]
        };
        let twin = (1..).find(|&twin| alike(0, twin, 7)).unwrap();
        assert!(!alike(0, twin, 8));
        assert!((0..100).all(|step| alike(twin, twin, step)));
    }
}
