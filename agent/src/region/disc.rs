//! Regular polygons that stand for discs.

use std::f64::consts::PI;

use csat_proto::region::{GridPoint, UNITS_PER_M};

use super::NUMERIC_MARGIN_M;

/// A regular polygon with fixed directions that contains a disc centred on the origin.
///
/// Fixed directions are what keeps vertex counts bounded: edges of repeatedly dilated sets stay
/// parallel and merge (`spec/sets.md` §5).
#[derive(Debug, Clone, PartialEq)]
pub struct Disc {
    corners: Vec<GridPoint>,
}

impl Disc {
    /// The circumscribed polygon of the disc of `radius_m` plus [`NUMERIC_MARGIN_M`], with
    /// `vertices` corners.
    pub fn circumscribed(radius_m: f64, vertices: u16) -> Self {
        let n = f64::from(vertices.max(4));
        // Two more units: rounding the corners may move an edge inward by one and a half.
        let apothem = (radius_m + NUMERIC_MARGIN_M) * UNITS_PER_M + 2.0;
        let circumradius = apothem / (PI / n).cos();
        let corner = |k: u16| {
            let (sin, cos) = (PI * f64::from(2 * k + 1) / n).sin_cos();
            GridPoint::new((circumradius * cos).round() as i32, (circumradius * sin).round() as i32)
        };
        Self { corners: (0..vertices.max(4)).map(corner).collect() }
    }

    /// The corners, counter-clockwise.
    pub fn corners(&self) -> &[GridPoint] {
        &self.corners
    }

    /// The index of the corner farthest along `normal`; of two equal ones the first in
    /// counter-clockwise order.
    pub(super) fn support(&self, normal: (i64, i64)) -> usize {
        let reach = |k: usize| {
            let q = self.corners[k];
            i128::from(normal.0) * i128::from(q.x) + i128::from(normal.1) * i128::from(q.y)
        };
        let n = self.corners.len();
        let best = (1..n).fold(0, |best, k| if reach(k) > reach(best) { k } else { best });
        let before = (best + n - 1) % n;
        if reach(before) == reach(best) { before } else { best }
    }
}
