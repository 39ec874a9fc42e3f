//! What there is to draw of an agent's knowledge, in metres of `world`.

use csat_proto::oem::OemCell;
use csat_proto::raster::{Grid, Raster};
use serde::{Deserialize, Serialize};

/// A closed ring; the last point is not repeated.
pub type Ring = Vec<[f64; 2]>;
/// Shapes, each an outer ring and its holes.
pub type Shapes = Vec<Vec<Ring>>;

/// What one agent knows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Knowledge {
    /// X̄.
    pub unexplored: Shapes,
    /// X_j with j.
    pub targets: Vec<(u16, Shapes)>,
    /// X°.
    pub obstacle_margin: Shapes,
    /// X^h.
    pub hidden: Cells,
    /// The OEM.
    pub oem: Oem,
}

/// A raster.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Cells {
    /// Side of a cell.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0).
    pub origin_m: [f64; 2],
    /// Runs of cells: row, first column, column after the last.
    pub runs: Vec<[u32; 3]>,
}

/// An occupancy-elevation map.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Oem {
    /// Side of a cell.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0).
    pub origin_m: [f64; 2],
    /// Occupied cells: column, row, height in decimetres.
    pub occupied: Vec<(u32, u32, u16)>,
    /// Empty cells.
    pub empty: Cells,
}

/// A length to the nearest millimetre.
pub fn to_millimetre(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}

/// A raster as runs.
pub fn cells(raster: &Raster) -> Cells {
    runs(raster.grid(), raster.iter())
}

/// An OEM from the states of its cells in row-major order.
pub fn oem(grid: &Grid, states: &[OemCell]) -> Oem {
    let place = |index: usize| (index as u32 % grid.columns, index as u32 / grid.columns);
    let of = |wanted: fn(&OemCell) -> bool| {
        states.iter().enumerate().filter(move |(_, s)| wanted(s)).map(move |(i, _)| place(i))
    };
    let occupied = states.iter().enumerate().filter_map(|(i, state)| match state {
        OemCell::Occupied { height_dm } => Some((place(i).0, place(i).1, *height_dm)),
        _ => None,
    });
    Oem {
        cell_m: grid.cell_m,
        origin_m: grid.origin(),
        occupied: occupied.collect(),
        empty: runs(grid, of(|s| *s == OemCell::Empty)),
    }
}

fn runs(grid: &Grid, cells: impl Iterator<Item = (u32, u32)>) -> Cells {
    let mut runs: Vec<[u32; 3]> = Vec::new();
    for (column, row) in cells {
        match runs.last_mut() {
            Some([last_row, _, end]) if *last_row == row && *end == column => *end += 1,
            _ => runs.push([row, column, column + 1]),
        }
    }
    Cells { cell_m: grid.cell_m, origin_m: grid.origin(), runs }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::model::Ground;

    #[test]
    fn rasters_and_oems_become_runs() {
        let grid = Grid::covering(&Ground { size_m: [20.0, 10.0] }, 5.0);
        let mut raster = Raster::empty(grid);
        raster.set_run(0, 1..4);
        raster.set(0, 1);
        assert_eq!(cells(&raster).runs, [[0, 1, 4], [1, 0, 1]]);
        let mut states = vec![OemCell::Unexplored; 8];
        states[2] = OemCell::Empty;
        states[3] = OemCell::Empty;
        states[4] = OemCell::Occupied { height_dm: 123 };
        let oem = oem(&grid, &states);
        assert_eq!(oem.occupied, [(0, 1, 123)]);
        assert_eq!(oem.empty.runs, [[0, 2, 4]]);
        assert_eq!(oem.origin_m, [-10.0, -5.0]);
    }
}
