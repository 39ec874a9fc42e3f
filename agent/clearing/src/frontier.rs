//! The runs of a frontier, and the sides of the image that they touch.

use crate::bitmap::{Bitmap, Rect};

/// The sides of the image, in the order in which the paper's rule gives them away.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Row 0.
    North,
    /// The last column.
    East,
    /// The last row.
    South,
    /// Column 0.
    West,
}

impl Side {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::North, Self::East, Self::South, Self::West];

    /// The displacement towards it: east and north.
    pub fn direction(self) -> [i8; 2] {
        match self {
            Self::North => [0, 1],
            Self::East => [1, 0],
            Self::South => [0, -1],
            Self::West => [-1, 0],
        }
    }

    /// How far a rectangle is from it in an image of this size, pixels.
    pub fn distance(self, rect: &Rect, size: u16) -> u16 {
        match self {
            Self::North => rect.rows[0],
            Self::East => size - 1 - rect.columns[1],
            Self::South => size - 1 - rect.rows[1],
            Self::West => rect.columns[0],
        }
    }
}

/// Which sides are touched, in the order of [`Side::ALL`].
pub type Sides = [bool; 4];

/// A sub-frontier: pixels of a frontier that belong together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// The rectangle around it.
    pub rect: Rect,
    /// The number of its pixels.
    pub pixels: u32,
    /// The sides that it touches.
    pub sides: Sides,
}

/// Pixels of a frontier that are at most twice this far apart belong together.
const JOIN_PX: u16 = 2;
/// What is at most so much farther from a side than the margin touches it.
const TOUCH_PX: u16 = 4;

/// The runs of a frontier in an image of this size, by their first pixels. Cleared ground grows up to `margin`.
pub fn runs(frontier: &Bitmap, margin: u16) -> Vec<Run> {
    if frontier.is_empty() {
        return Vec::new();
    }
    let joined = frontier.dilated(JOIN_PX).components();
    let run = |joined: Bitmap| {
        let mask = joined.and(frontier);
        let rect = mask.bounds()?;
        Some(Run { rect, pixels: mask.count(), sides: sides(&rect, frontier.rows(), margin) })
    };
    joined.into_iter().filter_map(run).collect()
}

fn sides(rect: &Rect, size: u16, margin: u16) -> Sides {
    let distances = Side::ALL.map(|side| side.distance(rect, size));
    let touch = margin + TOUCH_PX;
    let nearest = distances.into_iter().min().unwrap_or_default();
    // A run away from all sides counts for the nearest one.
    distances.map(|distance| distance <= touch.max(nearest))
}

/// The sides that some of the runs touch.
pub fn sides_of<'a>(runs: impl Iterator<Item = &'a Run>) -> Sides {
    runs.fold([false; 4], |all, run| [0, 1, 2, 3].map(|side| all[side] || run.sides[side]))
}

/// The rectangle around all of the runs; `None` without runs.
pub fn rect_of<'a>(runs: impl Iterator<Item = &'a Run>) -> Option<Rect> {
    runs.map(|run| run.rect).reduce(|a, b| Rect {
        rows: [a.rows[0].min(b.rows[0]), a.rows[1].max(b.rows[1])],
        columns: [a.columns[0].min(b.columns[0]), a.columns[1].max(b.columns[1])],
    })
}
