//! Regular polygons that contain discs.

use std::f64::consts::PI;

use csat_proto::region::{GridBox, GridPoint, Region, Ring, UNITS_PER_M};

use super::NUMERIC_MARGIN_M;
use super::vector::{Vector, turn};

/// The largest coordinate that `i_overlay` computes with, in grid units.
const LIMIT: i32 = (1 << 30) - 1;

/// A regular polygon with fixed directions that contains a disc centred on the origin.
///
/// Fixed directions keep the number of vertices bounded: edges of repeatedly dilated sets stay
/// parallel and merge.
#[derive(Debug, Clone, PartialEq)]
pub struct Disc {
    corners: Ring,
    /// The largest coordinate of a corner; [`LIMIT`] when the disc is too large for the grid.
    reach: i32,
}

impl Disc {
    /// The circumscribed polygon of the disc of `radius_m` plus [`NUMERIC_MARGIN_M`], with
    /// `vertices` corners, or fewer where corners coincide on the grid.
    ///
    /// A disc too large for the grid (or whose radius is not a number) is the whole plane: a set
    /// dilated by it fills its bounds, a set eroded by it is empty.
    pub fn circumscribed(radius_m: f64, vertices: u16) -> Self {
        let count = vertices.max(4);
        let n = f64::from(count);
        // Two more units: rounding the corners may move an edge inward by almost one.
        let apothem = (radius_m.max(0.0) + NUMERIC_MARGIN_M) * UNITS_PER_M + 2.0;
        let circumradius = apothem / (PI / n).cos();
        let corner = |k: u16| {
            let (sin, cos) = (PI * f64::from(2 * u32::from(k) + 1) / n).sin_cos();
            GridPoint::new((circumradius * cos).round() as i32, (circumradius * sin).round() as i32)
        };
        let corners = convex((0..count).map(corner));
        let fits = !radius_m.is_nan() && circumradius < f64::from(LIMIT);
        let reach = if fits { circumradius.ceil() as i32 } else { LIMIT };
        Self { corners, reach }
    }

    /// The corners, counter-clockwise; no three of them are collinear.
    pub fn corners(&self) -> &[GridPoint] {
        &self.corners
    }

    /// Its radius with the corners, metres.
    pub(super) fn reach_m(&self) -> f64 {
        f64::from(self.reach) / UNITS_PER_M
    }

    /// Whether the disc about every point of `region` has valid coordinates.
    pub(super) fn fits(&self, region: &Region) -> bool {
        region.bounds().is_none_or(|bounds| self.fits_about(&bounds))
    }

    /// Whether the disc about every point of a box has valid coordinates.
    pub(super) fn fits_about(&self, bounds: &GridBox) -> bool {
        let room = LIMIT - self.reach;
        let farthest = |p: GridPoint| p.x.unsigned_abs().max(p.y.unsigned_abs());
        farthest(bounds.min).max(farthest(bounds.max)) <= room as u32
    }

    /// The index of the corner farthest along `normal` (of two equal ones the first in
    /// counter-clockwise order), given that the disc fits about the edge of that normal.
    pub(super) fn support(&self, normal: Vector) -> usize {
        let reach = |q: GridPoint| normal.x * i64::from(q.x) + normal.y * i64::from(q.y);
        let (mut best, mut most) = (0, reach(self.corners[0]));
        for (k, &q) in self.corners.iter().enumerate().skip(1) {
            let reach = reach(q);
            if reach > most {
                (best, most) = (k, reach);
            }
        }
        let last = self.corners.len() - 1;
        if best == 0 && reach(self.corners[last]) == most { last } else { best }
    }
}

/// The corners of the convex hull of points that go round the origin once, rounded to the grid.
fn convex(points: impl Iterator<Item = GridPoint>) -> Ring {
    let mut ring: Ring = points.collect();
    loop {
        let n = ring.len();
        let kept = |i: &usize| turn(ring[(i + n - 1) % n], ring[*i], ring[(i + 1) % n]) > 0;
        // One at a time: dropping neighbours together could cut into the hull.
        match (0..n).find(|i| !kept(i)) {
            Some(i) if n > 3 => ring.remove(i),
            _ => return ring,
        };
    }
}
