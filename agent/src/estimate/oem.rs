//! The occupancy-elevation map M_i (thesis §4.6, paper §VI-C).

use csat_proto::message::{OemCell, OemDelta};
use csat_proto::raster::Grid;

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
        let joined = cell.join(delta.state);
        std::mem::replace(cell, joined) != joined
    }

    /// The height of an occupied cell, metres.
    pub fn height_m(&self, column: u32, row: u32) -> Option<f64> {
        match self.cells[self.grid.index(column, row)] {
            OemCell::Occupied { height_dm } => Some(f64::from(height_dm) / 10.0),
            OemCell::Unexplored | OemCell::Empty => None,
        }
    }

    /// Every cell that is not Unexplored.
    pub fn known(&self) -> Vec<OemDelta> {
        let known = |(cell, &state): (usize, &OemCell)| {
            (state != OemCell::Unexplored).then_some(OemDelta { cell: cell as u32, state })
        };
        self.cells.iter().enumerate().filter_map(known).collect()
    }
}
