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
pub(super) struct HeightMap {
    grid: Grid,
    /// How far eyes may be outside the grid and then look, cells. Rows have so many empty cells on both
    /// sides: what lies beyond the end of a row is the margin of another.
    margin: i32,
    storeys: Vec<u8>,
}

impl HeightMap {
    /// What stands in `oem`, on `grid`.
    pub(super) fn of(oem: &Oem, grid: &Grid, margin: i32) -> Self {
        let mut height_map = Self { grid: *grid, margin, storeys: Vec::new() };
        height_map.storeys = vec![0; (grid.rows as i32 * height_map.layout().stride) as usize];
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
                    let index = height_map.layout().index([column as i32, row as i32]) as usize;
                    height_map.storeys[index] = storeys.max(height_map.storeys[index]);
                }
            }
        }
        height_map
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Columns and rows of the grid.
    pub(super) fn sides(&self) -> [i32; 2] {
        [self.grid.columns, self.grid.rows].map(|cells| cells as i32)
    }

    /// Where cells are in `storeys`; outside it for rows outside the grid.
    pub(super) fn layout(&self) -> Layout {
        let stride = self.grid.columns as i32 + 2 * self.margin;
        Layout { stride, origin: self.margin }
    }

    /// Of a (column, row), also outside the grid.
    pub(super) fn storeys(&self, cell: [i32; 2]) -> u8 {
        self.storeys_at(self.layout().index(cell))
    }

    /// Of the cell with that index.
    #[inline]
    pub(super) fn storeys_at(&self, index: i32) -> u8 {
        self.storeys.get(index as usize).copied().unwrap_or(0)
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

/// Where the cells of a raster are in memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// From row to row.
    pub(super) stride: i32,
    /// Of column 0 in row 0.
    pub(super) origin: i32,
}

impl Layout {
    /// The index of a (column, row).
    pub(super) fn index(&self, [column, row]: [i32; 2]) -> i32 {
        row * self.stride + column + self.origin
    }

    /// The cells so far along two axes from `from`.
    pub(super) fn walk(&self, from: [i32; 2], axes: [[i32; 2]; 2]) -> Walk {
        Walk { from: self.index(from), strides: axes.map(|[x, y]| y * self.stride + x) }
    }
}

/// Cells of a raster as they are seen from one of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    from: i32,
    strides: [i32; 2],
}

impl Walk {
    /// The index of the cell so far along the first axis and the second.
    #[inline]
    pub(super) fn index(&self, first: i32, second: i16) -> i32 {
        self.from + first * self.strides[0] + i32::from(second) * self.strides[1]
    }
}
