//! The outline of the Ground pixels, in the image.

use csat_proto::frame::Label;
use csat_proto::region::{GridPoint, Ring};

use crate::region::{Kind, Tolerance, simplify_ring};

/// The directions of a walk along pixel borders: +column, +row, -column, -row.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The borders of the union of the Ground pixels, as rings of image points (column, row) in whole
/// pixels with the ground on the left: outer rings turn counter-clockwise in the (column, row)
/// plane, holes clockwise. Pixels that touch only at a corner are kept apart.
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
        // The two pixels ahead, on either side of the line of march.
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
            ring.push(GridPoint::new(x, y));
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
    // However long: an image is small enough. Meeting points would have to lie on the pixel grid.
    let tolerance = Tolerance { height: tolerance_px, length: f64::INFINITY, meet: false };
    outline
        .iter()
        .map(|ring| simplify_ring(ring, Kind::Inner, tolerance))
        .filter(|ring| ring.len() >= 3)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::region::twice_signed_area;

    fn labels(picture: &[&str]) -> (Vec<Label>, usize, usize) {
        let label = |c| if c == '#' { Label::Ground } else { Label::Unknown };
        let columns = picture[0].len();
        (picture.iter().flat_map(|l| l.chars().map(label)).collect(), columns, picture.len())
    }

    #[test]
    fn rings_enclose_exactly_the_ground_pixels() {
        let (labels, columns, rows) =
            labels(&["####.", "#..##", "#.#.#", "#..##", "####.", ".#..#"]);
        let rings = ground_outline(&labels, columns, rows);
        let area: i128 = rings.iter().map(|r| twice_signed_area(r)).sum::<i128>() / 2;
        assert_eq!(area, labels.iter().filter(|&&l| l == Label::Ground).count() as i128);
        let holes = rings.iter().filter(|r| twice_signed_area(r) < 0).count();
        assert_eq!((rings.len() - holes, holes), (5, 1), "{rings:?}");
    }

    #[test]
    fn all_ground_is_one_rectangle_and_none_is_none() {
        let (all, ..) = labels(&["###", "###"]);
        let rings = ground_outline(&all, 3, 2);
        assert_eq!(rings.len(), 1);
        assert_eq!((rings[0].len(), twice_signed_area(&rings[0])), (4, 12));
        assert!(ground_outline(&[Label::Unknown; 6], 3, 2).is_empty());
    }

    #[test]
    fn a_staircase_becomes_its_inner_chord() {
        let picture: Vec<String> = (0..20).map(|i| "#".repeat(20 - i) + &".".repeat(i)).collect();
        let lines: Vec<&str> = picture.iter().map(String::as_str).collect();
        let (labels, columns, rows) = labels(&lines);
        let outline = ground_outline(&labels, columns, rows);
        let simple = simplified_inward(&outline, 1.0);
        assert_eq!(outline[0].len(), 40);
        assert!(simple[0].len() <= 6, "{simple:?}");
        assert!(twice_signed_area(&simple[0]) >= 2 * 171);
    }
}
