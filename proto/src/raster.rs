//! Planar sets as rows of bits. They carry no guarantee: hidden ground, planning, metrics.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::model::Ground;
use crate::region::{Region, metres};

/// A grid of square cells over the region of interest. Row 0 is the southernmost, column 0 the
/// westernmost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Number of columns (east).
    pub columns: u32,
    /// Number of rows (north).
    pub rows: u32,
}

impl Grid {
    /// The grid of cells of `cell_m` that covers `ground`; the last row and column may overhang.
    pub fn covering(ground: &Ground, cell_m: f64) -> Self {
        let cells = |size: f64| (size / cell_m - 1e-9).ceil().max(1.0) as u32;
        Self { cell_m, columns: cells(ground.size_m[0]), rows: cells(ground.size_m[1]) }
    }

    /// West and south border of the grid, metres; the grid is centred on the origin.
    pub fn origin(&self) -> [f64; 2] {
        [-0.5 * f64::from(self.columns) * self.cell_m, -0.5 * f64::from(self.rows) * self.cell_m]
    }

    /// The centre of a cell, metres.
    pub fn centre(&self, column: u32, row: u32) -> [f64; 2] {
        let [x, y] = self.origin();
        [x + (f64::from(column) + 0.5) * self.cell_m, y + (f64::from(row) + 0.5) * self.cell_m]
    }

    /// The cell that contains a point (`world`, metres), as (column, row); `None` off the grid.
    pub fn cell_of(&self, p: [f64; 2]) -> Option<(u32, u32)> {
        let [x, y] = self.origin();
        let (column, row) = ((p[0] - x) / self.cell_m, (p[1] - y) / self.cell_m);
        let inside = column >= 0.0
            && row >= 0.0
            && column < f64::from(self.columns)
            && row < f64::from(self.rows);
        inside.then_some((column as u32, row as u32))
    }

    /// The columns whose centres lie in [west, east), as a half-open range.
    pub fn columns_between(&self, west: f64, east: f64) -> std::ops::Range<u32> {
        half_open(west, east, self.origin()[0], self.cell_m, self.columns)
    }

    /// The rows whose centres lie in [south, north), as a half-open range.
    pub fn rows_between(&self, south: f64, north: f64) -> std::ops::Range<u32> {
        half_open(south, north, self.origin()[1], self.cell_m, self.rows)
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Position of a cell in row-major order.
    pub fn index(&self, column: u32, row: u32) -> usize {
        row as usize * self.columns as usize + column as usize
    }
}

fn half_open(from: f64, to: f64, origin: f64, cell_m: f64, count: u32) -> std::ops::Range<u32> {
    let first = |x: f64| ((x - origin) / cell_m - 0.5).ceil().clamp(0.0, f64::from(count)) as u32;
    let (start, end) = (first(from), first(to));
    start..end.max(start)
}

/// A set of cells of a [`Grid`].
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    grid: Grid,
    words_per_row: usize,
    words: Vec<u64>,
}

impl Raster {
    /// ∅ on `grid`.
    pub fn empty(grid: Grid) -> Self {
        let words_per_row = (grid.columns as usize).div_ceil(64);
        Self { grid, words_per_row, words: vec![0; words_per_row * grid.rows as usize] }
    }

    /// The cells whose centres lie in `region`.
    pub fn of_region(grid: Grid, region: &Region) -> Self {
        let mut raster = Self::empty(grid);
        raster.fill_region(region);
        raster
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The words of all rows, from south to north.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// The words of all rows, for writing; bits past the last column must stay 0.
    pub fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// The words of one row, least significant bit westernmost.
    pub fn row(&self, row: u32) -> &[u64] {
        let start = row as usize * self.words_per_row;
        &self.words[start..start + self.words_per_row]
    }

    /// The words of one row, for writing; bits past the last column must stay 0.
    pub fn row_mut(&mut self, row: u32) -> &mut [u64] {
        let start = row as usize * self.words_per_row;
        &mut self.words[start..start + self.words_per_row]
    }

    /// Whether a cell is in the set.
    pub fn get(&self, column: u32, row: u32) -> bool {
        self.row(row)[column as usize / 64] >> (column % 64) & 1 == 1
    }

    /// Puts a cell into the set.
    pub fn set(&mut self, column: u32, row: u32) {
        self.row_mut(row)[column as usize / 64] |= 1 << (column % 64);
    }

    /// Takes a cell out of the set.
    pub fn clear(&mut self, column: u32, row: u32) {
        self.row_mut(row)[column as usize / 64] &= !(1 << (column % 64));
    }

    /// Puts a run of cells of one row into the set.
    pub fn set_run(&mut self, row: u32, columns: std::ops::Range<u32>) {
        let (mut start, end) = (columns.start as usize, columns.end as usize);
        let words = self.row_mut(row);
        while start < end {
            let (word, bit) = (start / 64, start % 64);
            let length = (64 - bit).min(end - start);
            let ones = if length == 64 { u64::MAX } else { (1 << length) - 1 };
            words[word] |= ones << bit;
            start += length;
        }
    }

    /// Adds the cells whose centres lie in `region`.
    pub fn fill_region(&mut self, region: &Region) {
        let rings: Vec<Vec<[f64; 2]>> =
            region.rings().map(|ring| ring.iter().map(|&p| metres(p)).collect()).collect();
        self.fill_rings(&rings);
    }

    /// Adds the cells whose centres lie inside rings given in metres, by the even-odd rule.
    pub fn fill_rings<R: AsRef<[[f64; 2]]>>(&mut self, rings: &[R]) {
        let mut crossings: Vec<(u32, f64)> = Vec::new();
        for ring in rings {
            let ring = ring.as_ref();
            for (i, &a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % ring.len()];
                let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
                let slope = (high[0] - low[0]) / (high[1] - low[1]);
                for row in self.grid.rows_between(low[1], high[1]) {
                    let y = self.grid.centre(0, row)[1];
                    crossings.push((row, low[0] + (y - low[1]) * slope));
                }
            }
        }
        crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for pair in crossings.chunks_exact(2) {
            let columns = self.grid.columns_between(pair[0].1, pair[1].1);
            self.set_run(pair[0].0, columns);
        }
    }

    /// Number of cells in the set.
    pub fn count(&self) -> u32 {
        self.words.iter().map(|w| w.count_ones()).sum()
    }

    /// Area of the set, square metres.
    pub fn area_m2(&self) -> f64 {
        f64::from(self.count()) * self.grid.cell_m * self.grid.cell_m
    }

    /// Number of cells in both sets.
    pub fn count_common(&self, other: &Raster) -> u32 {
        self.words.iter().zip(&other.words).map(|(a, b)| (a & b).count_ones()).sum()
    }

    /// self ∪= other.
    pub fn union_with(&mut self, other: &Raster) {
        self.combine(other, |a, b| a | b);
    }

    /// self ∩= other.
    pub fn intersect_with(&mut self, other: &Raster) {
        self.combine(other, |a, b| a & b);
    }

    /// self \= other.
    pub fn subtract(&mut self, other: &Raster) {
        self.combine(other, |a, b| a & !b);
    }

    fn combine(&mut self, other: &Raster, op: impl Fn(u64, u64) -> u64) {
        debug_assert_eq!(self.grid, other.grid, "rasters of one grid");
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a = op(*a, *b);
        }
    }

    /// The cells in the set, by row and then column, as (column, row).
    pub fn iter(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.words.iter().enumerate().flat_map(move |(index, &word)| {
            let (row, first) = (index / self.words_per_row, index % self.words_per_row * 64);
            BitIter(word).map(move |bit| (first as u32 + bit, row as u32))
        })
    }

    /// out = the cells whose centres are at most `radius_m` from a cell of self, taken as a square:
    /// self ⊕ disc, sampled at the centres and cut at the border of the grid. The former content of
    /// `out` is overwritten.
    pub fn dilate_disc_into(&self, radius_m: f64, out: &mut Raster) {
        debug_assert_eq!(self.grid, out.grid, "rasters of one grid");
        out.words.fill(0);
        let reaches = disc_reaches(radius_m / self.grid.cell_m);
        let last_word = u64::MAX >> (self.words_per_row as u32 * 64 - self.grid.columns);
        let (mut spread, mut reached) = (self.words.clone(), 0);
        // The reach within a row decreases with its distance: `spread` grows from the farthest row
        // inward.
        for (offset, &reach) in reaches.iter().enumerate().rev() {
            if reach > reached {
                for row in spread.chunks_exact_mut(self.words_per_row) {
                    spread_bits(row, reach - reached);
                    row[self.words_per_row - 1] &= last_word;
                }
                reached = reach;
            }
            let away = (offset * self.words_per_row).min(spread.len());
            let kept = spread.len() - away;
            let add = |(out, spread): (&mut u64, &u64)| *out |= spread;
            out.words[..kept].iter_mut().zip(&spread[away..]).for_each(add);
            out.words[away..].iter_mut().zip(&spread[..kept]).for_each(add);
        }
    }

    /// self ⊕ disc: see [`Self::dilate_disc_into`].
    pub fn dilated_disc(&self, radius_m: f64) -> Raster {
        let mut out = Raster::empty(self.grid);
        self.dilate_disc_into(radius_m, &mut out);
        out
    }

    /// The lengths of the runs of absent and present cells in row-major order, absent first, without
    /// the last run, which ends with the grid.
    fn runs(&self) -> Vec<u32> {
        let mut runs = Vec::new();
        let (mut present, mut length) = (false, 0);
        for row in 0..self.grid.rows {
            let mut left = self.grid.columns;
            for &word in self.row(row) {
                let (mut word, mut bits) = (word, left.min(64));
                left -= bits;
                while bits > 0 {
                    // How many of the next cells belong to the current run.
                    let others = if present { !word } else { word };
                    let alike = others.trailing_zeros().min(bits);
                    length += alike;
                    bits -= alike;
                    if bits > 0 {
                        runs.push(length);
                        (present, length) = (!present, 0);
                        word >>= alike;
                    }
                }
            }
        }
        runs
    }
}

/// By row offset 0, 1, …: how many columns a disc of `radius` cells reaches from a square cell to
/// centres of that row. Non-increasing.
fn disc_reaches(radius: f64) -> Vec<u32> {
    // A centre exactly on the circle belongs to the disc, despite rounding.
    let radius = radius.max(0.0) + 1e-9;
    let reach = |offset: u32| {
        let gap = (f64::from(offset) - 0.5).max(0.0);
        let rest = radius * radius - gap * gap;
        (rest >= 0.0).then(|| (rest.sqrt() + 0.5) as u32)
    };
    (0..).map_while(reach).collect()
}

/// Spreads every bit of a row to `reach` neighbours on both sides.
fn spread_bits(words: &mut [u64], reach: u32) {
    let mut done = 0;
    while done < reach {
        // Each run has at least 2·done + 1 bits now, so a shift by that much leaves no gap.
        let shift = (2 * done + 1).min(reach - done).min(63);
        let mut before = 0;
        for i in 0..words.len() {
            let (word, after) = (words[i], words.get(i + 1).copied().unwrap_or(0));
            words[i] |=
                word << shift | before >> (64 - shift) | word >> shift | after << (64 - shift);
            before = word;
        }
        done += shift;
    }
}

struct BitIter(u64);

impl Iterator for BitIter {
    type Item = u32;
    fn next(&mut self) -> Option<u32> {
        (self.0 != 0).then(|| {
            let bit = self.0.trailing_zeros();
            self.0 &= self.0 - 1;
            bit
        })
    }
}

/// The most cells a raster may have on the wire: 4096 m by 4096 m in cells of 1 m.
const MAX_CELLS: u64 = 1 << 24;

/// On the wire a raster is its grid and its run lengths.
impl Serialize for Raster {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.grid, self.runs()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Raster {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let (grid, runs) = <(Grid, Vec<u32>)>::deserialize(deserializer)?;
        let cells = u64::from(grid.columns) * u64::from(grid.rows);
        // Rows are whole words: a narrow grid takes up to 64 times the memory of its cells.
        let room = u64::from(grid.columns).next_multiple_of(64) * u64::from(grid.rows);
        if !(grid.cell_m.is_finite() && grid.cell_m > 0.0) || cells == 0 || room > MAX_CELLS {
            return Err(D::Error::custom("raster grid of an impossible size"));
        }
        if runs.iter().map(|&r| u64::from(r)).sum::<u64>() > cells {
            return Err(D::Error::custom("raster runs longer than the grid"));
        }
        let mut raster = Raster::empty(grid);
        let mut position = 0u64;
        for pair in runs.chunks(2) {
            // An odd number of runs ends with present cells up to the end of the grid.
            let start = position + u64::from(pair[0]);
            let end = pair.get(1).map_or(cells, |&length| start + u64::from(length));
            raster.set_linear(start, end);
            position = end;
        }
        Ok(raster)
    }
}

impl Raster {
    fn set_linear(&mut self, mut start: u64, end: u64) {
        let columns = u64::from(self.grid.columns);
        while start < end {
            let (row, column) = (start / columns, start % columns);
            let stop = end.min((row + 1) * columns);
            self.set_run(row as u32, column as u32..(column + stop - start) as u32);
            start = stop;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::grid_point;

    fn grid() -> Grid {
        Grid::covering(&Ground { size_m: [150.0, 90.0] }, 1.0)
    }

    #[test]
    fn a_region_fills_the_cells_whose_centres_it_contains() {
        let ring =
            [[-70.2, -40.0], [60.0, -33.3], [10.0, 41.0]].iter().map(|&p| grid_point(p)).collect();
        let region = Region::from_shapes(vec![vec![ring]]);
        let raster = Raster::of_region(grid(), &region);
        for row in 0..90 {
            for column in 0..150 {
                let inside = region.contains(grid().centre(column, row));
                assert_eq!(raster.get(column, row), inside, "cell {column} {row}");
            }
        }
        assert_eq!(raster.iter().count() as u32, raster.count());
        assert!((raster.area_m2() - region.area_m2()).abs() < 100.0);
    }

    /// Against the definition, over word borders and grid borders.
    #[test]
    fn a_dilation_adds_the_centres_within_the_radius() {
        let mut raster = Raster::empty(grid());
        for (column, row) in [(0, 0), (63, 40), (64, 41), (149, 89), (130, 2), (70, 60)] {
            raster.set(column, row);
        }
        for radius_m in [0.0, 0.4, 1.5, 3.0, 7.3, 80.0] {
            let dilated = raster.dilated_disc(radius_m);
            for (row, column) in (0..90).flat_map(|row| (0..150).map(move |column| (row, column))) {
                let gap = |a: u32, b: u32| (f64::from(a.abs_diff(b)) - 0.5).max(0.0);
                let near =
                    |(c, r): (u32, u32)| gap(c, column).hypot(gap(r, row)) <= radius_m + 1e-9;
                let expected = raster.iter().any(near);
                assert_eq!(dilated.get(column, row), expected, "{radius_m} m: {column} {row}");
            }
            assert_eq!(
                dilated.iter().count() as u32,
                dilated.count(),
                "no bits past the last column"
            );
        }
    }

    #[test]
    fn the_wire_keeps_every_cell() {
        let mut raster = Raster::empty(grid());
        raster.set_run(0, 0..70);
        raster.set_run(44, 63..65);
        for full_end in [false, true] {
            if full_end {
                raster.set_run(89, 3..150);
            }
            let bytes = postcard::to_stdvec(&raster).unwrap();
            assert_eq!(postcard::from_bytes::<Raster>(&bytes).unwrap(), raster);
        }
    }

    #[test]
    fn impossible_grids_are_refused() {
        for (columns, cell_m, run) in
            [(0, 1.0, 0), (3, f64::NAN, 0), (3, 1.0, 10), (u32::MAX, 1.0, 0)]
        {
            let wire = (Grid { cell_m, columns, rows: 3 }, vec![run]);
            let bytes = postcard::to_stdvec(&wire).unwrap();
            assert!(postcard::from_bytes::<Raster>(&bytes).is_err());
        }
    }
}
