//! The nearest accepted cell of a set, by best-first search. The test of a cell may take a walk along
//! a line of sight, so only cells nearer than the result are tested.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use csat_proto::raster::{Grid, Raster};

/// A cell of the set, by its distance first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct RowCandidate {
    /// The bits of a length have the same order as the length.
    distance_bits: u64,
    row: u32,
    column: u32,
    side: Side,
}

/// The side on which the next cells of a row are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    East,
    West,
}

/// The distance from a point to the nearest centre of the cells of `set` that `accept` (column, row)
/// accepts, metres. `skipped` returns the columns of a row that are skipped.
pub(super) fn nearest_m(
    set: &Raster,
    from: [f64; 2],
    skipped: impl Fn(u32) -> Range<u32>,
    mut accept: impl FnMut(u32, u32) -> bool,
) -> Option<f64> {
    let grid = set.grid();
    let [column, row] = cell_at(grid, from);
    let candidate = |row: u32, column: u32, side: Side| {
        let column = next_cell(set.row(row), column, side, skipped(row))?;
        let centre = grid.centre(column, row);
        let distance_m = (centre[0] - from[0]).hypot(centre[1] - from[1]);
        Some(Reverse(RowCandidate { distance_bits: distance_m.to_bits(), row, column, side }))
    };
    let mut rows = rows_from(grid, row, from[1]).peekable();
    let mut found = BinaryHeap::new();
    loop {
        let may_beat_all = |gap_m: f64| {
            found.peek().is_none_or(|Reverse(best): &Reverse<RowCandidate>| {
                gap_m.to_bits() <= best.distance_bits
            })
        };
        if let Some((_, row)) = rows.next_if(|(gap_m, _)| may_beat_all(*gap_m)) {
            found.extend(candidate(row, column, Side::East));
            found.extend(candidate(row, column, Side::West));
            continue;
        }
        let Reverse(RowCandidate { distance_bits, row, column, side }) = found.pop()?;
        if accept(column, row) {
            return Some(f64::from_bits(distance_bits));
        }
        let beyond = if side == Side::East { column + 1 } else { column };
        found.extend(candidate(row, beyond, side));
    }
}

/// The cell of a point (column, row), or the nearest one for a point outside the grid.
fn cell_at(grid: &Grid, point: [f64; 2]) -> [u32; 2] {
    let (origin, counts) = (grid.origin(), [grid.columns, grid.rows]);
    [0, 1].map(|axis| {
        let cells = ((point[axis] - origin[axis]) / grid.cell_m).floor();
        cells.clamp(0.0, f64::from(counts[axis] - 1)) as u32
    })
}

/// All rows, the nearest to `y` first, with the distances of their centres from `y`, metres; `start`
/// is the row of `y`.
fn rows_from(grid: &Grid, start: u32, y: f64) -> impl Iterator<Item = (f64, u32)> {
    let gap_m = move |row: u32| (grid.centre(0, row)[1] - y).abs();
    (0..grid.rows).flat_map(move |offset| {
        let south = start.checked_sub(offset).map(|row| (gap_m(row), row));
        let north = (offset > 0).then_some(start + offset).filter(|row| *row < grid.rows);
        let mut both = [south, north.map(|row| (gap_m(row), row))];
        if both[0].zip(both[1]).is_some_and(|(south, north)| north.0 < south.0) {
            both.swap(0, 1);
        }
        both.into_iter().flatten()
    })
}

/// The first cell of a row from `column` on eastwards, or before it westwards, that is not skipped.
fn next_cell(words: &[u64], column: u32, side: Side, skipped: Range<u32>) -> Option<u32> {
    let next = |column| match side {
        Side::East => first_from(words, column),
        Side::West => last_before(words, column),
    };
    next(column).and_then(|found| match side {
        _ if !skipped.contains(&found) => Some(found),
        Side::East => next(skipped.end),
        Side::West => next(skipped.start),
    })
}

fn first_from(words: &[u64], column: u32) -> Option<u32> {
    let start = column as usize / 64;
    let inside = |(index, word): (usize, &u64)| {
        let word = if index == start { word & u64::MAX << (column % 64) } else { *word };
        (word != 0).then(|| index as u32 * 64 + word.trailing_zeros())
    };
    words.iter().enumerate().skip(start).find_map(inside)
}

fn last_before(words: &[u64], column: u32) -> Option<u32> {
    let end = column as usize / 64;
    let inside = |(index, word): (usize, &u64)| {
        let word = if index == end { word & !(u64::MAX << (column % 64)) } else { *word };
        (word != 0).then(|| index as u32 * 64 + 63 - word.leading_zeros())
    };
    words.iter().enumerate().take(end + 1).rev().find_map(inside)
}

#[cfg(test)]
mod tests {
    use csat_proto::model::Ground;

    use super::*;

    fn scattered() -> Raster {
        let grid = Grid::covering(&Ground { size_m: [300.0, 80.0] }, 2.0);
        let mut set = Raster::empty(grid);
        for i in 0..60u32 {
            set.set(i * 7919 % grid.columns, i * 104_729 % grid.rows);
        }
        set
    }

    const POINTS: [[f64; 2]; 5] =
        [[0.0, 0.0], [-151.0, 3.0], [400.0, -90.0], [17.3, 39.9], [-1.0, 500.0]];

    #[test]
    fn the_nearest_cell_is_the_nearest_of_all() {
        let set = scattered();
        let odd = |column: u32, row: u32| (column + row) % 2 == 1;
        let none = |_| 0..0;
        for from in POINTS {
            let distance = |(column, row): (u32, u32)| {
                let c = set.grid().centre(column, row);
                (c[0] - from[0]).hypot(c[1] - from[1])
            };
            let of_all = |accept: &dyn Fn(u32, u32) -> bool| {
                set.iter().filter(|&(c, r)| accept(c, r)).map(distance).min_by(f64::total_cmp)
            };
            assert_eq!(nearest_m(&set, from, none, |_, _| true), of_all(&|_, _| true));
            assert_eq!(nearest_m(&set, from, none, odd), of_all(&odd));
            assert_eq!(nearest_m(&set, from, none, |_, _| false), None);
            let skipped = |row: u32| 3 * row..3 * row + 70;
            let kept = |c: u32, r: u32| !skipped(r).contains(&c) && odd(c, r);
            assert_eq!(nearest_m(&set, from, skipped, odd), of_all(&kept));
        }
    }

    /// Every cell that is tested is nearer than the result.
    #[test]
    fn no_cell_is_asked_about_in_vain() {
        let set = scattered();
        for from in POINTS {
            let mut asked = Vec::new();
            let accept = |column: u32, row: u32| {
                let c = set.grid().centre(column, row);
                asked.push((c[0] - from[0]).hypot(c[1] - from[1]));
                row == 7
            };
            let found = nearest_m(&set, from, |_| 0..0, accept);
            assert!(asked.is_sorted() && asked.last().copied() == found, "{asked:?} {found:?}");
        }
    }
}
