//! The outline of the Ground pixels, in the image.

use csat_proto::frame::Label;
use csat_proto::region::{GridPoint, Ring};

use crate::region::{Approximation, Tolerance, simplify_ring};

/// The directions of a walk along pixel borders: +column, +row, -column, -row.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// Coordinates of outlines are in this fraction of a pixel.
pub const UNITS_PER_PX: i32 = 256;

/// The borders of the union of the Ground pixels, one unit inward, as rings of image points (column,
/// row) in 1/[`UNITS_PER_PX`] pixels with the ground on the left: outer rings turn counter-clockwise
/// in the (column, row) plane, holes clockwise. Pixels that touch only at a corner are kept apart.
///
/// The unit is the numeric margin of the clear ground: about 0.4 mm where the ground is nearest,
/// more elsewhere, so that whatever is left around a target is wider than the rounding of Boolean
/// operations.
pub fn ground_outline(labels: &[Label], columns: usize, rows: usize) -> Vec<Ring> {
    let mask = Mask::new(labels, columns, rows);
    // A border between (column-1, row) and the Ground pixel (column, row), walked towards row 0.
    let mut walked = vec![false; mask.ground.len()];
    let mut rings = Vec::new();
    for row in 0..rows as i32 {
        for column in 0..columns as i32 {
            let starts = mask.at(column, row) && !mask.at(column - 1, row);
            if starts && !walked[mask.index(column, row)] {
                rings.push(walk(&mask, column, row, &mut walked));
            }
        }
    }
    rings
}

/// Which pixels are Ground, with a border of one pixel that is not.
struct Mask {
    ground: Vec<bool>,
    stride: usize,
}

impl Mask {
    fn new(labels: &[Label], columns: usize, rows: usize) -> Self {
        let stride = columns + 2;
        let mut ground = vec![false; stride * (rows + 2)];
        for (row, line) in labels.chunks_exact(columns).take(rows).enumerate() {
            let start = (row + 1) * stride + 1;
            for (cell, label) in ground[start..start + columns].iter_mut().zip(line) {
                *cell = *label == Label::Ground;
            }
        }
        Self { ground, stride }
    }

    fn index(&self, column: i32, row: i32) -> usize {
        (row + 1) as usize * self.stride + (column + 1) as usize
    }

    fn at(&self, column: i32, row: i32) -> bool {
        self.ground[self.index(column, row)]
    }
}

/// Walks one ring, starting at the border on the low-column side of a Ground pixel.
fn walk(mask: &Mask, column: i32, row: i32, walked: &mut [bool]) -> Ring {
    const TOWARDS_ROW_0: usize = 3;
    let start = (column, row + 1);
    let (mut x, mut y) = start;
    let mut direction = TOWARDS_ROW_0;
    let mut ring = Ring::new();
    loop {
        if direction == TOWARDS_ROW_0 {
            walked[mask.index(x, y - 1)] = true;
        }
        x += STEPS[direction].0;
        y += STEPS[direction].1;
        // The two pixels ahead, on either side of the walk.
        let (left, right) = match direction {
            0 => (mask.at(x, y), mask.at(x, y - 1)),
            1 => (mask.at(x - 1, y), mask.at(x, y)),
            2 => (mask.at(x - 1, y - 1), mask.at(x - 1, y)),
            _ => (mask.at(x, y - 1), mask.at(x - 1, y - 1)),
        };
        let next = match (left, right) {
            (false, _) => (direction + 1) % 4,
            (true, true) => (direction + 3) % 4,
            (true, false) => direction,
        };
        if next != direction {
            // Each of the two edges moves one unit to its left, into the ground.
            let (before, after) = (STEPS[(direction + 1) % 4], STEPS[(next + 1) % 4]);
            ring.push(GridPoint::new(
                x * UNITS_PER_PX + before.0 + after.0,
                y * UNITS_PER_PX + before.1 + after.1,
            ));
            direction = next;
        }
        if (x, y) == start && direction == TOWARDS_ROW_0 {
            return ring;
        }
    }
}

/// Cuts corners of the Ground outline that stick out by at most `tolerance_px`: the staircase of a
/// slanted border becomes its inner chords. The result is contained in the outline where filled by
/// positive winding; its rings may cross.
pub fn simplified_inward(outline: &[Ring], tolerance_px: f64) -> Vec<Ring> {
    // The length is unlimited, because an image is small. Meeting points are off: they would not lie
    // on the grid of pixels.
    let height = tolerance_px * f64::from(UNITS_PER_PX);
    let tolerance = Tolerance { height, length: f64::INFINITY, meet: false };
    outline
        .iter()
        .map(|ring| simplify_ring(ring, Approximation::Inner, tolerance))
        .filter(|ring| ring.len() >= 3)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::region::{Region, twice_signed_area};

    fn labels(picture: &[&str]) -> (Vec<Label>, usize, usize) {
        let label = |c| if c == '#' { Label::Ground } else { Label::Unknown };
        let columns = picture[0].len();
        (picture.iter().flat_map(|l| l.chars().map(label)).collect(), columns, picture.len())
    }

    /// Number of pixels whose centre the rings enclose, checked against the labels one by one.
    fn enclosed(rings: &[Ring], labels: &[Label], columns: usize) -> usize {
        let region = Region::from_shapes(vec![rings.to_vec()]);
        let scale = f64::from(UNITS_PER_PX) / csat_proto::region::UNITS_PER_M;
        let inside = |i: usize| {
            let centre = [(i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5];
            region.contains(centre.map(|x| x * scale))
        };
        (0..labels.len()).filter(|&i| assert_eq_label(labels[i], inside(i))).count()
    }

    fn assert_eq_label(label: Label, inside: bool) -> bool {
        assert_eq!(label == Label::Ground, inside);
        inside
    }

    #[test]
    fn rings_enclose_exactly_the_ground_pixels() {
        let (labels, columns, rows) =
            labels(&["####.", "#..##", "#.#.#", "#..##", "####.", ".#..#"]);
        let rings = ground_outline(&labels, columns, rows);
        assert_eq!(enclosed(&rings, &labels, columns), 19);
        // The frame, its island, and the pixel that touches it at a corner only; one hole.
        let holes = rings.iter().filter(|r| twice_signed_area(r) < 0).count();
        assert_eq!((rings.len() - holes, holes), (3, 1), "{rings:?}");
    }

    #[test]
    fn all_ground_is_one_rectangle_and_none_is_none() {
        let (all, ..) = labels(&["###", "###"]);
        let rings = ground_outline(&all, 3, 2);
        let (width, height) = (3 * UNITS_PER_PX - 2, 2 * UNITS_PER_PX - 2);
        assert_eq!(rings.len(), 1);
        assert_eq!(rings[0].len(), 4);
        assert_eq!(twice_signed_area(&rings[0]), i128::from(2 * width * height));
        assert!(ground_outline(&[Label::Unknown; 6], 3, 2).is_empty());
    }

    #[test]
    fn a_staircase_becomes_its_inner_chord() {
        let picture: Vec<String> = (0..20).map(|i| "#".repeat(20 - i) + &".".repeat(i)).collect();
        let lines: Vec<&str> = picture.iter().map(String::as_str).collect();
        let (labels, columns, rows) = labels(&lines);
        let outline = ground_outline(&labels, columns, rows);
        let simple = simplified_inward(&outline, 1.0);
        assert_eq!(outline[0].len(), 42);
        assert!(simple[0].len() <= 6, "{simple:?}");
        let area_px = twice_signed_area(&simple[0]) as f64 / 2.0 / f64::from(UNITS_PER_PX).powi(2);
        // The staircase encloses 210 pixels, its inner chords 10 less.
        assert!((195.0..205.0).contains(&area_px), "{area_px}");
    }
}
