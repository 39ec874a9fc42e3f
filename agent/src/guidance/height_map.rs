//! The heights of the buildings of a map on the cells of the search of `str4`.

use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::{Grid, Raster};

use crate::estimate::oem::Oem;

/// Heights are rounded to multiples of this, metres, and at least to one multiple. So more exact
/// heights in the OEM change the height map rarely.
pub(super) const STOREY_M: f64 = 1.0;

/// The buildings of a map on a planner's grid, in storeys; 0 where no building is known.
///
/// Buildings extend half a cell beyond their cells. A cell whose centre was seen is Empty (4.40),
/// even if a building stands in its corner: a building may extend that far beyond the cells that it
/// occupies.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HeightMap {
    grid: Grid,
    /// The range of cameras outside the grid, cells. Each row has this many empty cells on both
    /// sides, so that an index beyond the end of a row is in the margin of another row.
    margin: i32,
    storeys: Vec<u8>,
}

impl HeightMap {
    /// The heights of `oem` on `grid`.
    pub(super) fn of(oem: &Oem, grid: &Grid, margin: i32) -> Self {
        let mut height_map = Self { grid: *grid, margin, storeys: Vec::new() };
        height_map.storeys = vec![0; (grid.rows as i32 * height_map.layout().stride) as usize];
        // Far enough to contain the centre of a cell of `grid`, for cells of any size.
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

    /// The layout of cells in `storeys`; indexes of rows outside the grid are outside `storeys`.
    pub(super) fn layout(&self) -> Layout {
        let stride = self.grid.columns as i32 + 2 * self.margin;
        Layout { stride, origin: self.margin }
    }

    /// The storeys of a cell (column, row), also outside the grid.
    pub(super) fn storeys(&self, cell: [i32; 2]) -> u8 {
        self.storeys_at(self.layout().index(cell))
    }

    /// The storeys of the cell with this index.
    #[inline]
    pub(super) fn storeys_at(&self, index: i32) -> u8 {
        self.storeys.get(index as usize).copied().unwrap_or(0)
    }

    /// The cells whose centres are at most `distance_m` from a cell of at least that many storeys.
    pub(super) fn near(&self, storeys: u8, distance_m: f64) -> Raster {
        let mut high = Raster::empty(self.grid);
        let cells = (0..self.grid.rows).flat_map(|r| (0..self.grid.columns).map(move |c| (c, r)));
        cells
            .filter(|&(column, row)| self.storeys([column as i32, row as i32]) >= storeys)
            .for_each(|(column, row)| high.set(column, row));
        high.dilated_disc(distance_m)
    }

    /// The greatest number of storeys.
    pub(super) fn highest(&self) -> u8 {
        self.storeys.iter().copied().max().unwrap_or(0)
    }

    /// Whether the grid is in range of a camera above a cell (column, row).
    pub(super) fn is_in_reach_of(&self, eye: [i32; 2]) -> bool {
        let sides = self.sides();
        [0, 1].iter().all(|&i| (-self.margin..sides[i] + self.margin).contains(&eye[i]))
    }
}

/// The layout of the cells of a raster in memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// The step from row to row.
    pub(super) stride: i32,
    /// The index of column 0 in row 0.
    pub(super) origin: i32,
}

impl Layout {
    /// The index of a cell (column, row).
    pub(super) fn index(&self, [column, row]: [i32; 2]) -> i32 {
        row * self.stride + column + self.origin
    }

    /// Indexes of cells in coordinates along two axes from `from`.
    pub(super) fn walk(&self, from: [i32; 2], axes: [[i32; 2]; 2]) -> Walk {
        Walk { from: self.index(from), strides: axes.map(|[x, y]| y * self.stride + x) }
    }
}

/// Indexes of the cells of a raster in coordinates relative to one of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    from: i32,
    strides: [i32; 2],
}

impl Walk {
    /// The index of the cell at these coordinates along the two axes.
    #[inline]
    pub(super) fn index(&self, first: i32, second: i16) -> i32 {
        self.from + first * self.strides[0] + i32::from(second) * self.strides[1]
    }
}
