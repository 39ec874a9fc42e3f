//! The buildings of a map as `str4` sees them: a height per cell of its search.

use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::{Grid, Raster};

use crate::estimate::oem::Oem;

/// Heights are rounded to multiples of this, metres, none of them to 0: a map that only grows more exact
/// changes little.
pub(super) const STOREY_M: f64 = 1.0;

/// The buildings of a map on a planner's grid, in storeys; 0 where nothing is known to stand.
///
/// They are taken to reach half a cell beyond their own. A cell whose centre was seen is Empty (4.40),
/// whatever stands in its corner: so far buildings may reach beyond the cells they occupy.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Skyline {
    grid: Grid,
    /// How far eyes may be outside the grid and then look, cells. Rows have so many empty cells on both
    /// sides: what lies beyond the end of a row is the margin of another.
    margin: i32,
    storeys: Vec<u8>,
}

impl Skyline {
    /// What stands in `oem`, on `grid`.
    pub(super) fn of(oem: &Oem, grid: &Grid, margin: i32) -> Self {
        let mut skyline = Self { grid: *grid, margin, storeys: Vec::new() };
        skyline.storeys = vec![0; (grid.rows as i32 * skyline.stride()) as usize];
        // Far enough to hold the centre of a cell, however large those are.
        let reach = oem.grid().cell_m.max(0.5 * grid.cell_m);
        for OemDelta { cell, state } in oem.known() {
            let OemCell::Occupied { height_dm } = state else { continue };
            let storeys = (f64::from(height_dm) / 10.0 / STOREY_M).round();
            let storeys = storeys.clamp(1.0, f64::from(u8::MAX)) as u8;
            let [x, y] = oem.grid().centre(cell % oem.grid().columns, cell / oem.grid().columns);
            let columns = grid.columns_between(x - reach, x + reach);
            for row in grid.rows_between(y - reach, y + reach) {
                for column in columns.clone() {
                    let index = skyline.index([column as i32, row as i32]);
                    skyline.storeys[index] = storeys.max(skyline.storeys[index]);
                }
            }
        }
        skyline
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Columns and rows of the grid.
    pub(super) fn sides(&self) -> [i32; 2] {
        [self.grid.columns, self.grid.rows].map(|cells| cells as i32)
    }

    /// Cells from row to row.
    fn stride(&self) -> i32 {
        self.grid.columns as i32 + 2 * self.margin
    }

    /// The place of a (column, row) in `storeys`; outside it for rows outside the grid.
    fn index(&self, [column, row]: [i32; 2]) -> usize {
        (row * self.stride() + self.margin + column) as usize
    }

    /// Of a (column, row), also outside the grid.
    #[inline]
    pub(super) fn storeys(&self, cell: [i32; 2]) -> u8 {
        self.storeys.get(self.index(cell)).copied().unwrap_or(0)
    }

    /// The cells whose centres are at most `distance_m` from something of so many storeys or more.
    pub(super) fn near(&self, storeys: u8, distance_m: f64) -> Raster {
        let mut high = Raster::empty(self.grid);
        let cells = (0..self.grid.rows).flat_map(|r| (0..self.grid.columns).map(move |c| (c, r)));
        cells
            .filter(|&(column, row)| self.storeys([column as i32, row as i32]) >= storeys)
            .for_each(|(column, row)| high.set(column, row));
        high.dilated_disc(distance_m)
    }

    /// The most storeys of all.
    pub(super) fn highest(&self) -> u8 {
        self.storeys.iter().copied().max().unwrap_or(0)
    }

    /// Whether something may be seen from a (column, row).
    pub(super) fn is_in_reach_of(&self, eye: [i32; 2]) -> bool {
        let sides = self.sides();
        [0, 1].iter().all(|&i| (-self.margin..sides[i] + self.margin).contains(&eye[i]))
    }
}
