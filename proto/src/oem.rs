//! Cells of the occupancy-elevation map, and their wire format.

use serde::{Deserialize, Serialize};

/// The state of a cell of the occupancy-elevation map.
///
/// Cells form a join-semilattice: Unexplored < Occupied(h) < Empty, Occupied joins by the greater
/// height (paper §VI-C); heights are decimetres so that equal knowledge is equal bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum OemCell {
    /// Nothing is known of the cell.
    Unexplored,
    /// An obstacle at most this high was seen there, in decimetres.
    Occupied {
        /// Greatest possible height, decimetres.
        height_dm: u16,
    },
    /// Only ground was seen there.
    Empty,
}

impl OemCell {
    /// The least upper bound of two states.
    pub fn join(self, other: Self) -> Self {
        // The derived order *is* the lattice order: it is total.
        self.max(other)
    }

    /// A number per state that keeps the order of the states, for hashes.
    pub fn code(self) -> u32 {
        match self {
            Self::Unexplored => 0,
            Self::Occupied { height_dm } => 1 + u32::from(height_dm),
            Self::Empty => u32::MAX,
        }
    }
}

/// A cell of the OEM that changed, by its row-major index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct OemDelta {
    /// Row-major index of the cell.
    pub cell: u32,
    /// Its state.
    pub state: OemCell,
}

/// Cells of the OEM with their states, by increasing index.
///
/// A run of equal neighbours is one entry, because most of a map is empty ground. A patch that was
/// received may claim any number of cells: check [`Self::end`] before iterating over them.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct OemPatch {
    runs: Vec<CellRun>,
}

/// Neighbouring cells of one state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct CellRun {
    /// Cells between the end of the run before and the start of this one.
    gap: u32,
    length: u32,
    state: OemCell,
}

impl OemPatch {
    /// A patch of cells in the order of strictly increasing indexes.
    pub fn of(deltas: impl IntoIterator<Item = OemDelta>) -> Self {
        let mut runs: Vec<CellRun> = Vec::new();
        let mut end = 0;
        for OemDelta { cell, state } in deltas {
            match runs.last_mut() {
                Some(run) if run.state == state && cell == end => run.length += 1,
                _ => runs.push(CellRun { gap: cell - end, length: 1, state }),
            }
            end = cell + 1;
        }
        Self { runs }
    }

    /// One past the last cell.
    pub fn end(&self) -> u64 {
        self.runs.iter().map(|run| u64::from(run.gap) + u64::from(run.length)).sum()
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// The cells. Indexes past the largest `u32` are left out.
    pub fn deltas(&self) -> impl Iterator<Item = OemDelta> + '_ {
        let mut end = 0u64;
        self.runs.iter().flat_map(move |run| {
            let start = end + u64::from(run.gap);
            end = start + u64::from(run.length);
            let cells = (start..end).map_while(|cell| u32::try_from(cell).ok());
            cells.map(|cell| OemDelta { cell, state: run.state })
        })
    }

    /// The first runs of the patch, at most `count` of them.
    pub fn first_runs(&self, count: usize) -> Self {
        Self { runs: self.runs.iter().take(count).copied().collect() }
    }

    /// Number of runs, which determines the size of the patch on the wire.
    pub fn runs(&self) -> usize {
        self.runs.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oem_join_is_commutative_associative_and_idempotent() {
        let states = [
            OemCell::Unexplored,
            OemCell::Occupied { height_dm: 30 },
            OemCell::Occupied { height_dm: 200 },
            OemCell::Empty,
        ];
        for a in states {
            assert_eq!(a.join(a), a);
            for b in states {
                assert_eq!(a.join(b), b.join(a));
                for c in states {
                    assert_eq!(a.join(b).join(c), a.join(b.join(c)));
                }
            }
        }
        assert_eq!(OemCell::Occupied { height_dm: 450 }.join(OemCell::Empty), OemCell::Empty);
    }

    #[test]
    fn the_wire_keeps_every_cell_and_is_short() {
        let state = |cell: u32| match cell % 100 {
            0..70 => OemCell::Empty,
            70..75 => OemCell::Occupied { height_dm: 50 + cell as u16 % 7 },
            _ => OemCell::Unexplored,
        };
        let cells = (3..5000).map(|cell| OemDelta { cell, state: state(cell) });
        let deltas: Vec<OemDelta> = cells.filter(|d| d.state != OemCell::Unexplored).collect();
        let bytes = postcard::to_stdvec(&OemPatch::of(deltas.iter().copied())).unwrap();
        let patch: OemPatch = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(patch.deltas().collect::<Vec<_>>(), deltas);
        assert_eq!(patch.end(), 4975);
        assert!(bytes.len() < deltas.len() / 2, "{} bytes", bytes.len());
    }

    #[test]
    fn a_patch_that_claims_any_number_of_cells_says_so() {
        let run = CellRun { gap: u32::MAX, length: u32::MAX, state: OemCell::Empty };
        let patch = OemPatch { runs: vec![run; 2] };
        assert_eq!(patch.end(), 4 * u64::from(u32::MAX));
        assert_eq!(patch.deltas().count(), 1);
    }
}
