//! What the buildings of a map hide from a cell, for `str4`: as [`super::shadow`] has it, but on cells
//! and rays alone. It asks for so many views that what each costs must not depend on how many buildings
//! there are.
//!
//! Rays leave the middle of the eye's cell; they and the cells they pass are the same for every eye. On
//! its way out a ray carries how far the highest shadow reaches that it has met: a building of height h
//! that ends at distance d hides from height z what is nearer than d·z/(z-h). Cells take the ray that is
//! next to them.

use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::Grid;

use crate::estimate::oem::Oem;

/// Heights are rounded to multiples of this, decimetres, none of them to 0: a map that only grows more
/// exact changes little.
const STOREY_DM: u16 = 10;
/// Parts of 1 that stretches are told in.
const STRETCH: u64 = 1 << 10;
/// A stretch beyond all reach.
const FARTHEST: u64 = 1 << 32;

/// The buildings of a map on a planner's grid, in storeys; 0 where nothing is known to stand. Twice, so
/// that the cells along an axis lie side by side for rays of either axis.
///
/// They are taken to reach half a cell beyond their own. A cell whose centre was seen is Empty (4.40),
/// whatever stands in its corner: so far buildings may reach beyond the cells they occupy.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Skyline {
    /// Row by row.
    rows: Vec<u8>,
    /// Column by column.
    columns: Vec<u8>,
}

impl Skyline {
    /// What stands in `oem`, on `grid`.
    pub(super) fn of(oem: &Oem, grid: &Grid) -> Self {
        let mut rows = vec![0; grid.cells()];
        // Far enough to hold the centre of a cell, however large those are.
        let reach = oem.grid().cell_m.max(0.5 * grid.cell_m);
        for OemDelta { cell, state } in oem.known() {
            let OemCell::Occupied { height_dm } = state else { continue };
            let storeys = height_dm.saturating_add(STOREY_DM / 2) / STOREY_DM;
            let storeys = storeys.clamp(1, u8::MAX.into()) as u8;
            let [x, y] = oem.grid().centre(cell % oem.grid().columns, cell / oem.grid().columns);
            let columns = grid.columns_between(x - reach, x + reach);
            for row in grid.rows_between(y - reach, y + reach) {
                for column in columns.clone() {
                    let stands = &mut rows[grid.index(column, row)];
                    *stands = storeys.max(*stands);
                }
            }
        }
        let by_column = (0..grid.columns).flat_map(|c| (0..grid.rows).map(move |r| (c, r)));
        let columns = by_column.map(|(column, row)| rows[grid.index(column, row)]).collect();
        Self { rows, columns }
    }
}

/// What is known of a cell of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Look {
    /// Nothing: its ray was not cast since the eye moved.
    Unknown,
    Seen,
    Hidden,
}

/// Looks at a [`Skyline`] from one cell at a time.
#[derive(Debug, Clone)]
pub(super) struct Viewshed {
    grid: Grid,
    skyline: Skyline,
    /// How far rays go, cells along their quadrant's axis.
    reach: usize,
    /// The place in `rays` of every cell within reach, row by row from the far south-west.
    place_of: Vec<u32>,
    /// By ray of a quadrant and cell along its axis: how many cells it is off that axis.
    across: Vec<i32>,
    /// By storeys: what the distance of their far side is multiplied by to give their shadow's end, seen
    /// from `z_m`; in shares of [`STRETCH`].
    stretch: [u64; 256],
    z_m: f64,
    /// The eye's (column, row), also outside the grid.
    eye: [i32; 2],
    /// By ray and cell: first the rays to the east, then west, north, south; in each quadrant by slope.
    rays: Vec<Look>,
}

impl Viewshed {
    /// Of an empty map on `grid`, for looks no farther than `reach_m` on the ground.
    pub(super) fn new(grid: Grid, reach_m: f64) -> Self {
        let reach = (reach_m / grid.cell_m).ceil().max(1.0) as usize;
        let slope = |ray: usize| (ray as f64 + 0.5) * 2.0 / reach as f64 - 1.0;
        let off_axis = |ray, cell: usize| (slope(ray) * cell as f64).round() as i32;
        let across = (0..reach).flat_map(|ray| (0..=reach).map(move |cell| off_axis(ray, cell)));
        let span = -(reach as i32)..=reach as i32;
        let cells = span.clone().flat_map(|y| span.clone().map(move |x| [x, y]));
        Self {
            grid,
            skyline: Skyline::of(&Oem::unexplored(grid), &grid),
            reach,
            place_of: cells.map(|cell| place_of(cell, reach)).collect(),
            across: across.collect(),
            stretch: [0; 256],
            z_m: f64::NAN,
            eye: [0; 2],
            rays: vec![Look::Unknown; 4 * reach * (reach + 1)],
        }
    }

    /// The next looks are at `oem`; false if it looks as before.
    pub(super) fn load(&mut self, oem: &Oem) -> bool {
        let skyline = Skyline::of(oem, &self.grid);
        let is_new = skyline != self.skyline;
        self.skyline = skyline;
        is_new
    }

    /// The next bits are those seen from `z_m` above the centre of a cell.
    pub(super) fn look_from(&mut self, eye: [i32; 2], z_m: f64) {
        self.eye = eye;
        self.rays.fill(Look::Unknown);
        if self.z_m != z_m {
            self.z_m = z_m;
            let storey_m = f64::from(STOREY_DM) / 10.0;
            for (stretch, storeys) in self.stretch.iter_mut().zip(0..) {
                let height = f64::from(storeys) * storey_m;
                // What is as high as the eye hides all that lies behind.
                let factor = if height < z_m { z_m / (z_m - height) } else { f64::INFINITY };
                *stretch = (factor * STRETCH as f64).min(FARTHEST as f64) as u64;
            }
            self.stretch[0] = 0;
        }
    }

    /// Those of `bits`, cells of one word of one row within reach, that are not hidden.
    pub(super) fn seen(&mut self, row: u32, word: usize, bits: u64) -> u64 {
        let reach = self.reach as i32;
        let [x, y] = [word as i32 * 64 - self.eye[0], row as i32 - self.eye[1]];
        let first = (y + reach) * (2 * reach + 1) + x + reach;
        let (mut seen, mut rest) = (0, bits);
        while rest != 0 {
            let lowest = rest & rest.wrapping_neg();
            rest ^= lowest;
            let place = self.place_of[(first + lowest.trailing_zeros() as i32) as usize] as usize;
            if self.rays[place] == Look::Unknown {
                self.cast_ray(place / (self.reach + 1));
            }
            if self.rays[place] == Look::Seen {
                seen |= lowest;
            }
        }
        seen
    }

    /// Finds which cells of a ray are hidden.
    fn cast_ray(&mut self, ray: usize) {
        let (quadrant, ray_of_quadrant, cells) =
            (ray / self.reach, ray % self.reach, self.reach + 1);
        let (step, along) = (if quadrant % 2 == 0 { 1 } else { -1 }, quadrant / 2);
        let (from, axis) = (self.eye[along], self.eye[1 - along]);
        let length = [self.grid.columns, self.grid.rows][along] as i32;
        let skyline = [&self.skyline.rows, &self.skyline.columns][along];
        let inside = inside(from, step, length, cells);
        let across = &self.across[ray_of_quadrant * cells..][inside.clone()];
        let rays = &mut self.rays[ray * cells..][inside.clone()];
        // In halves of a cell and shares of STRETCH.
        let mut end = 0;
        for ((look, across), cell) in rays.iter_mut().zip(across).zip(inside.start as i32..) {
            // Across the axis a ray may leave the map, too.
            let index = (axis + across) * length + from + step * cell;
            let storeys = skyline.get(index as usize).copied().unwrap_or(0);
            end = end.max((2 * cell as u64 + 1) * self.stretch[usize::from(storeys)]);
            let is_hidden = 2 * cell as u64 * STRETCH < end;
            *look = if is_hidden { Look::Hidden } else { Look::Seen };
        }
    }
}

/// Which of the `cells` cells from `from` on, `step` by `step`, are among the first `length` of all.
fn inside(from: i32, step: i32, length: i32, cells: usize) -> std::ops::Range<usize> {
    let (first, end) =
        if step > 0 { (-from, length - from) } else { (from - length + 1, from + 1) };
    let clamp = |cell: i32| (cell.max(0) as usize).min(cells);
    clamp(first)..clamp(end).max(clamp(first))
}

/// The place, among the cells of all rays, of a cell that is so far east and north of the eye.
fn place_of([x, y]: [i32; 2], reach: usize) -> u32 {
    let (quadrant, along, across) = match (x.abs() >= y.abs(), x >= 0, y >= 0) {
        (true, true, _) => (0, x, y),
        (true, false, _) => (1, -x, y),
        (false, _, true) => (2, y, x),
        (false, _, false) => (3, -y, x),
    };
    let slope = f64::from(across) / f64::from(along.max(1));
    let ray = ((slope + 1.0) * 0.5 * reach as f64) as usize;
    ((quadrant * reach + ray.min(reach - 1)) * (reach + 1)) as u32 + along as u32
}

#[cfg(test)]
#[path = "viewshed_tests.rs"]
mod tests;
