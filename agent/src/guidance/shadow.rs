//! Predicted shadows H^OEM(x^u) (4.41)-(4.42), computed without polygons.
//!
//! A box of height h seen from height z hides, on the ground, the union of its base scaled about the
//! nadir (the point below the camera) by every factor from 1 to z/(z-h): that union is the convex
//! hull of the eight projected vertices. So along any ground ray from the nadir that crosses the base
//! between `enter` and `leave`, the box hides exactly [enter, leave·z/(z-h)], and everything beyond
//! `enter` when h ≥ z. Rays are spaced by slope, not by angle, so that the ray of a cell and the
//! position on it take one division and no trigonometry. The position is exact: only the slope is
//! rounded.

use csat_proto::oem::OemCell;
use csat_proto::raster::Grid;

use crate::estimate::oem::Oem;

/// The Occupied cells of an OEM, row by row.
#[derive(Debug)]
pub(super) struct OccupiedCells {
    cell_m: f64,
    origin: [f64; 2],
    /// (x, y, height) of the cells' centres, `world`, metres.
    occupied: Vec<[f64; 3]>,
    /// Where each row starts in `occupied`, and the end.
    row_starts: Vec<usize>,
}

impl OccupiedCells {
    /// The boxes (4.41) of `oem`.
    pub(super) fn of(oem: &Oem) -> Self {
        let grid = oem.grid();
        let (mut occupied, mut row_starts) = (Vec::new(), Vec::new());
        for (cells, row) in oem.cells().chunks(grid.columns as usize).zip(0..) {
            row_starts.push(occupied.len());
            for (cell, column) in cells.iter().zip(0..) {
                if let OemCell::Occupied { height_dm } = *cell {
                    let [x, y] = grid.centre(column, row);
                    occupied.push([x, y, f64::from(height_dm) / 10.0]);
                }
            }
        }
        row_starts.push(occupied.len());
        Self { cell_m: grid.cell_m, origin: grid.origin(), occupied, row_starts }
    }

    /// The occupied cells of the rows within `reach_m` of `y`.
    fn near_rows(&self, y: f64, reach_m: f64) -> &[[f64; 3]] {
        let rows = self.row_starts.len() - 1;
        let row = |y: f64| ((y - self.origin[1]) / self.cell_m).clamp(0.0, rows as f64);
        let (first, last) = (row(y - reach_m).floor(), row(y + reach_m).ceil());
        &self.occupied[self.row_starts[first as usize]..self.row_starts[last as usize]]
    }
}

/// Casts the shadows of [`OccupiedCells`] for one pose at a time.
#[derive(Debug, Clone)]
pub(super) struct ShadowCaster {
    cell_m: f64,
    origin: [f64; 2],
    reach_m: f64,
    /// Rays per quadrant; even, so that no ray has slope 0.
    rays: usize,
    /// Words per ray; bit b is the cell b cells away along the quadrant's axis.
    words: usize,
    bits: Vec<u64>,
    nadir: [f64; 2],
    /// The cell of the nadir, also outside the grid.
    nadir_cell: [i64; 2],
    /// The centre of that cell relative to the nadir.
    phase: [f64; 2],
}

impl ShadowCaster {
    /// A caster on `grid` for cameras with a range of `reach_m`. At that distance rays are at most
    /// one cell apart.
    pub(super) fn new(grid: &Grid, reach_m: f64) -> Self {
        let cells = (reach_m / grid.cell_m).ceil().max(1.0) as usize;
        let (rays, words) = (2 * cells, (cells + 2).div_ceil(64));
        Self {
            cell_m: grid.cell_m,
            origin: grid.origin(),
            reach_m,
            rays,
            words,
            bits: vec![0; 4 * rays * words],
            nadir: [0.0; 2],
            nadir_cell: [0; 2],
            phase: [0.0; 2],
        }
    }

    /// Replaces the shadows by those for a camera at `p_world`. Only shadows that may fall into
    /// `footprint` (a convex ring, metres) are cast.
    pub(super) fn cast(
        &mut self,
        occupied: &OccupiedCells,
        p_world: [f64; 3],
        footprint: &[[f64; 2]],
    ) {
        let [x, y, z] = p_world;
        self.bits.fill(0);
        self.nadir = [x, y];
        for axis in 0..2 {
            let cell = ((self.nadir[axis] - self.origin[axis]) / self.cell_m).floor();
            self.nadir_cell[axis] = cell as i64;
            self.phase[axis] = self.origin[axis] + (cell + 0.5) * self.cell_m - self.nadir[axis];
        }
        let half = 0.5 * occupied.cell_m;
        // No point of a cell is farther from its centre than this.
        let margin = half * std::f64::consts::SQRT_2;
        let fan = Fan::around([x, y], footprint);
        for &[cell_x, cell_y, height] in occupied.near_rows(y, self.reach_m + half) {
            let d = [cell_x - x, cell_y - y];
            let out_of_reach = d[0].abs() > self.reach_m + half;
            if out_of_reach || fan.as_ref().is_some_and(|fan| !fan.meets(d, margin)) {
                continue;
            }
            let stretch = if height < z { z / (z - height) } else { f64::INFINITY };
            let (x, y) = ([d[0] - half, d[0] + half], [d[1] - half, d[1] + half]);
            let mirrored = |[low, high]: [f64; 2]| [-high, -low];
            self.mark(Quadrant::East, x, y, stretch);
            self.mark(Quadrant::West, mirrored(x), y, stretch);
            self.mark(Quadrant::North, y, x, stretch);
            self.mark(Quadrant::South, mirrored(y), x, stretch);
        }
    }

    /// Marks a box on the rays of one quadrant; `along` its axis and `across` it are relative to the
    /// nadir.
    fn mark(&mut self, quadrant: Quadrant, along: [f64; 2], across: [f64; 2], stretch: f64) {
        let (near, far) = (along[0].max(1e-9), along[1]);
        if far <= near {
            return;
        }
        let least = across[0] / if across[0] < 0.0 { near } else { far };
        let most = across[1] / if across[1] > 0.0 { near } else { far };
        let half_rays = 0.5 * self.rays as f64;
        let first = ceil((least + 1.0) * half_rays - 0.5);
        let end = ceil((most + 1.0) * half_rays - 0.5).min(self.rays);
        let phase = quadrant.sign() * self.phase[quadrant.axis()];
        let (per_ray, per_cell) = (1.0 / half_rays, 1.0 / self.cell_m);
        for ray in first..end {
            let per_slope = 1.0 / ((ray as f64 + 0.5) * per_ray - 1.0);
            let (a, b) = (across[0] * per_slope, across[1] * per_slope);
            let (enter, leave) = (near.max(a.min(b)), far.min(a.max(b)));
            let first_bin = ceil((enter - phase) * per_cell);
            // One past the last cell; a cell exactly at the end of the shadow counts as visible.
            let end_bin = ceil((leave * stretch - phase) * per_cell).min(self.words * 64);
            if enter <= leave && first_bin < end_bin {
                let start = (quadrant as usize * self.rays + ray) * self.words;
                set_bits(&mut self.bits[start..start + self.words], first_bin, end_bin - 1);
            }
        }
    }

    /// The cells of `bits`, in one word of one row, that are hidden from the last pose. The result is
    /// valid within the footprint of [`Self::cast`], and exact except for cells that the border of a
    /// shadow crosses.
    pub(super) fn hidden_bits(&self, row: u32, word: usize, bits: u64) -> u64 {
        let rows_away = i64::from(row) - self.nadir_cell[1];
        let y = rows_away as f64 * self.cell_m + self.phase[1];
        let (vertical, row_bin) =
            (if y < 0.0 { Quadrant::South } else { Quadrant::North }, rows_away.unsigned_abs());
        let per_y = 1.0 / y.abs();
        let half_rays = 0.5 * self.rays as f64;
        let (mut hidden, mut rest) = (0, bits);
        while rest != 0 {
            let bit = rest.trailing_zeros();
            rest &= rest - 1;
            let columns_away = word as i64 * 64 + i64::from(bit) - self.nadir_cell[0];
            let x = columns_away as f64 * self.cell_m + self.phase[0];
            let (quadrant, slope, bin) = if x.abs() < y.abs() {
                (vertical, x * per_y, row_bin)
            } else {
                let quadrant = if x < 0.0 { Quadrant::West } else { Quadrant::East };
                (quadrant, y / x.abs(), columns_away.unsigned_abs())
            };
            let ray = (((slope + 1.0) * half_rays) as usize).min(self.rays - 1);
            // Cells beyond the end of the rays are beyond d_max, so in no footprint.
            let bin = (bin as usize).min(self.words * 64 - 1);
            let start = (quadrant as usize * self.rays + ray) * self.words;
            hidden |= (self.bits[start + bin / 64] >> (bin % 64) & 1) << bit;
        }
        hidden
    }
}

/// The four quadrants of directions about the nadir, each within 45° of its axis.
#[derive(Debug, Clone, Copy)]
enum Quadrant {
    East,
    West,
    North,
    South,
}

impl Quadrant {
    fn axis(self) -> usize {
        usize::from(matches!(self, Self::North | Self::South))
    }

    fn sign(self) -> f64 {
        if matches!(self, Self::East | Self::North) { 1.0 } else { -1.0 }
    }
}

/// ⌈x⌉, but 0 for negative x. `f64::ceil` is a function call on targets without an instruction for it.
fn ceil(x: f64) -> usize {
    let whole = x as usize;
    whole.saturating_add(usize::from(x > whole as f64))
}

/// Sets the bits first..=last.
fn set_bits(words: &mut [u64], first: usize, last: usize) {
    for (index, word) in words.iter_mut().enumerate().take(last / 64 + 1).skip(first / 64) {
        let low = first.saturating_sub(index * 64);
        let high = (last - index * 64).min(63);
        *word |= (u64::MAX << low) & (u64::MAX >> (63 - high));
    }
}

/// The directions from the nadir to a convex ring that does not contain it.
#[derive(Debug)]
struct Fan {
    right: [f64; 2],
    left: [f64; 2],
}

impl Fan {
    /// `None` when the nadir is inside the ring, so that every direction counts.
    fn around(nadir: [f64; 2], ring: &[[f64; 2]]) -> Option<Self> {
        let mut directions = ring.iter().filter_map(|p| {
            let d = [p[0] - nadir[0], p[1] - nadir[1]];
            let length = d[0].hypot(d[1]);
            (length > 0.0).then(|| [d[0] / length, d[1] / length])
        });
        let first = directions.next()?;
        let mut fan = Self { right: first, left: first };
        for d in directions {
            // If the nadir is inside, the ring surrounds it: a corner is beyond both sides.
            match (cross(fan.right, d) < 0.0, cross(d, fan.left) < 0.0) {
                (true, true) => return None,
                (true, false) => fan.right = d,
                (false, true) => fan.left = d,
                (false, false) => {}
            }
            if cross(fan.right, fan.left) < 0.0 {
                return None;
            }
        }
        Some(fan)
    }

    /// Whether a disc about `d`, relative to the nadir, may touch the fan.
    fn meets(&self, d: [f64; 2], radius: f64) -> bool {
        cross(self.right, d) >= -radius && cross(d, self.left) >= -radius
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Whether the ground point `p` is hidden from a camera at `p_world` by a box of the OEM (4.42): the
/// cells under the line of sight, one after the other. It is for single points, also outside
/// footprints.
pub(super) fn hides_point(oem: &Oem, p_world: [f64; 3], p: [f64; 2]) -> bool {
    let (grid, z) = (oem.grid(), p_world[2]);
    let (origin, cell) = (grid.origin(), grid.cell_m);
    let from = [0, 1].map(|axis| (p_world[axis] - origin[axis]) / cell);
    let to = [0, 1].map(|axis| (p[axis] - origin[axis]) / cell);
    let delta = [to[0] - from[0], to[1] - from[1]];
    let mut at = from.map(|v| v.floor() as i64);
    let step = delta.map(|d| if d < 0.0 { -1 } else { 1 });
    // `next`: the share of the way at which the next column and row begin; `share`: the length of one.
    let share = delta.map(|d| if d == 0.0 { f64::INFINITY } else { 1.0 / d.abs() });
    let mut next = [0, 1].map(|axis| {
        let border = at[axis] as f64 + if step[axis] > 0 { 1.0 } else { 0.0 };
        if delta[axis] == 0.0 { f64::INFINITY } else { (border - from[axis]).abs() * share[axis] }
    });
    loop {
        let leave = next[0].min(next[1]).min(1.0);
        let inside = (0..i64::from(grid.columns)).contains(&at[0])
            && (0..i64::from(grid.rows)).contains(&at[1]);
        let height = if inside { oem.height_m(at[0] as u32, at[1] as u32) } else { None };
        if height.is_some_and(|h| h >= z || leave * z >= z - h) {
            return true;
        }
        if leave >= 1.0 {
            return false;
        }
        let axis = usize::from(next[1] < next[0]);
        at[axis] += step[axis];
        next[axis] += share[axis];
    }
}

#[cfg(test)]
#[path = "shadow_tests.rs"]
pub(super) mod tests;
