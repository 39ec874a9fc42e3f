//! Rectangles of cells.

use std::ops::Range;

use super::Square;
use crate::road_area::RoadArea;

/// The cells from a first one up to but without an end, by axis; empty where the end is not beyond the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rectangle {
    pub first: [usize; 2],
    pub end: [usize; 2],
}

impl Rectangle {
    /// The cells of a raster that lie wholly in a square.
    pub fn within(square: &Square, roads: &RoadArea) -> Self {
        let (size_m, count) = (roads.ground().size_m, [roads.columns(), roads.rows()]);
        // Cells from the western or southern border to a side of the square.
        let cells = |axis: usize, side: f64| {
            let at_m = square.middle[axis] + side * square.side_m / 2.0;
            (at_m + size_m[axis] / 2.0) / roads.cell_m()
        };
        // Conversions saturate.
        let first = [0, 1].map(|axis| cells(axis, -1.0).ceil() as usize);
        let end = [0, 1].map(|axis| (cells(axis, 1.0).floor() as usize).min(count[axis]));
        Self { first, end }
    }

    pub fn is_empty(&self) -> bool {
        (0..2).any(|axis| self.end[axis] <= self.first[axis])
    }

    pub fn rows(&self) -> Range<usize> {
        self.first[1]..self.end[1]
    }

    /// First column and end.
    pub fn span(&self) -> [usize; 2] {
        [self.first[0], self.end[0]]
    }

    /// Its cells, column and row.
    pub fn cells(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [first, end] = self.span();
        self.rows().flat_map(move |row| (first..end).map(move |column| [column, row]))
    }

    pub fn contains(&self, cell: [usize; 2]) -> bool {
        (0..2).all(|axis| (self.first[axis]..self.end[axis]).contains(&cell[axis]))
    }

    /// What none of the others contains, as disjoint rectangles that are not empty.
    pub fn without(&self, others: &[Self]) -> Vec<Self> {
        let mut pieces = vec![*self];
        pieces.retain(|piece| !piece.is_empty());
        for other in others {
            pieces = pieces.iter().flat_map(|piece| piece.minus(other)).collect();
        }
        pieces
    }

    /// What the other one does not contain: below it, above it, and to its left and right between them.
    fn minus(&self, other: &Self) -> impl Iterator<Item = Self> + use<> {
        let first = [0, 1].map(|axis| self.first[axis].max(other.first[axis]));
        let end = [0, 1].map(|axis| self.end[axis].min(other.end[axis]));
        let meets = !Self { first, end }.is_empty();
        let pieces = if meets {
            let (low, high) = (self.first, self.end);
            [
                Self { first: low, end: [high[0], first[1]] },
                Self { first: [low[0], end[1]], end: high },
                Self { first: [low[0], first[1]], end: [first[0], end[1]] },
                Self { first: [end[0], first[1]], end: [high[0], end[1]] },
            ]
        } else {
            let none = Self { first: [0; 2], end: [0; 2] };
            [*self, none, none, none]
        };
        pieces.into_iter().filter(|piece| !piece.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rectangle() -> impl Strategy<Value = Rectangle> {
        ([0..12usize, 0..12usize], [0..12usize, 0..12usize])
            .prop_map(|(first, end)| Rectangle { first, end })
    }

    proptest! {
        #[test]
        fn the_pieces_are_what_is_left_once_each(
            one in rectangle(), others in prop::collection::vec(rectangle(), 0..5),
        ) {
            let pieces = one.without(&others);
            for cell in (0..144).map(|i| [i % 12, i / 12]) {
                let is_left = one.contains(cell) && !others.iter().any(|o| o.contains(cell));
                let count = pieces.iter().filter(|piece| piece.contains(cell)).count();
                prop_assert_eq!(count, usize::from(is_left), "{:?}", cell);
            }
            let cells: usize = pieces.iter().map(|piece| piece.cells().count()).sum();
            prop_assert_eq!(cells, one.cells().filter(|c| pieces.iter().any(|p| p.contains(*c))).count());
        }
    }
}
