//! Limits the number of vertices of a set.
//!
//! Each round doubles a length. It simplifies the border by that length and drops what is narrower
//! than a few times that length (holes of an outer approximation, shapes of an inner one). If that
//! does not suffice, it grows or shrinks the set by that length, which closes gaps. In the end an
//! outer approximation fills its bounds and an inner one is empty, so the rounds end for every set.
//! Outer approximations only grow and inner ones only shrink.

use csat_proto::region::{GridBox, Region, Ring, Shape, UNITS_PER_M};

use super::{Disc, Inner, Outer};
use crate::mutant::{Mutant, is_on};

/// The length of the first round, metres.
const FINEST_M: f64 = 1.0 / 16.0;
/// Holes and shapes narrower than this many lengths are dropped.
const NARROW: f64 = 4.0;
/// From this length on sets grow or shrink, metres.
const CLOSING_M: f64 = 0.5;
/// Corners of the disc by which sets grow or shrink.
const CORNERS: u16 = 8;

impl Outer {
    /// self, which lies in `bounds`, if it has at most `vertices` vertices, and else a superset in
    /// `bounds` that has no more. Bounds of more vertices than that are not simplified.
    pub fn limited(self, vertices: usize, bounds: &Region) -> Outer {
        if self.region().vertex_count() <= vertices {
            return self;
        }
        if is_on(Mutant::OuterShrunkForVertices) {
            return Outer::containing(
                Inner::within(self.into_region()).limited(vertices).into_region(),
            );
        }
        let mut set = self;
        let mut length_m = FINEST_M;
        while length_m < widest_m(bounds) {
            set = set.simplified(length_m).without_holes(length_m);
            if length_m >= CLOSING_M && set.region().vertex_count() > vertices {
                set = set.dilated(&Disc::circumscribed(length_m, CORNERS), bounds);
            }
            // Points where edges were extended to meet may lie outside.
            let within = set.intersection(&Outer::containing(bounds.clone()));
            if within.region().vertex_count() <= vertices {
                return within;
            }
            length_m *= 2.0;
        }
        Outer::containing(bounds.clone())
    }

    /// Without the holes that are narrower than a few lengths.
    fn without_holes(self, length_m: f64) -> Outer {
        let filled = |shape: Shape| -> Shape {
            let mut rings = shape.into_iter();
            let outside = rings.next();
            outside.into_iter().chain(rings.filter(|hole| !is_narrow(hole, length_m))).collect()
        };
        let shapes = self.into_region().into_shapes().into_iter().map(filled);
        Outer::containing(Region::from_shapes(shapes.collect()))
    }
}

impl Inner {
    /// self if it has at most `vertices` vertices, and else a subset that has no more.
    pub fn limited(self, vertices: usize) -> Inner {
        let width_m = widest_m(self.region());
        if is_on(Mutant::InnerGrownForVertices) && self.region().vertex_count() > vertices {
            let grown =
                Outer::containing(self.into_region()).simplified(FINEST_M.max(0.1 * width_m));
            return Inner::within(grown.into_region());
        }
        let mut set = self;
        let mut length_m = FINEST_M;
        while set.region().vertex_count() > vertices {
            if length_m >= width_m {
                return Inner::default();
            }
            set = set.simplified(length_m).without_shapes(length_m);
            if length_m >= CLOSING_M && set.region().vertex_count() > vertices {
                set = set.eroded(&Disc::circumscribed(length_m, CORNERS));
            }
            length_m *= 2.0;
        }
        set
    }

    /// Without the shapes that are narrower than a few lengths.
    fn without_shapes(self, length_m: f64) -> Inner {
        let mut shapes = self.into_region().into_shapes();
        shapes.retain(|shape| !is_narrow(&shape[0], length_m));
        Inner::within(Region::from_shapes(shapes))
    }
}

fn is_narrow(ring: &Ring, length_m: f64) -> bool {
    GridBox::around(ring).is_none_or(|b| {
        let side = |min: i32, max: i32| f64::from(max) - f64::from(min);
        let least = side(b.min.x, b.max.x).min(side(b.min.y, b.max.y));
        least < NARROW * length_m * UNITS_PER_M
    })
}

/// The longer side of the box around a region, metres.
fn widest_m(region: &Region) -> f64 {
    region.bounds().map_or(0.0, |b| {
        let side = |min: i32, max: i32| (f64::from(max) - f64::from(min)) / UNITS_PER_M;
        side(b.min.x, b.max.x).max(side(b.min.y, b.max.y))
    })
}
