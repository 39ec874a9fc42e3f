//! The q-relaxed intersection: what lies in all of several sets but q.

use csat_proto::region::{GridBox, GridPoint, Region, Ring, Shape};

use super::outer::shapes_meeting;
use super::{Disc, Outer, RULE, overlay};

/// Sets that come closer than this may have a point in common that rounding has lost, metres.
const LOST_M: f64 = 1e-3;
/// Corners of the disc that stands for it.
const CORNERS: u16 = 8;
/// How many corners of a set are looked at before its intersection is computed.
const LOOKS: usize = 8;

impl Outer {
    /// The points of self that lie in all of `sets` but at most `q`.
    ///
    /// One operation: each set adds 1 to the winding number of its points, and n - q - 1 boxes about
    /// self, wound the other way, subtract 1 each. So the number is positive in n - q sets or more.
    pub fn in_all_but(self, q: usize, sets: &[&Outer]) -> Outer {
        let Some(bounds) = self.region().bounds() else { return self };
        // A set that contains all of self changes nothing but the count.
        let sets: Vec<&Outer> =
            sets.iter().copied().filter(|set| !is_box_around(set.region(), &bounds)).collect();
        if sets.len() <= q {
            return self;
        }
        if q == 0 {
            return sets.iter().fold(self, |left, set| left.intersection(set));
        }
        let rings: Vec<&Ring> = sets
            .iter()
            .flat_map(|set| shapes_meeting(std::iter::once(set.region()), &bounds))
            .flatten()
            .collect();
        let less = clockwise(&bounds);
        let all = rings.into_iter().chain(std::iter::repeat_n(&less, sets.len() - q - 1));
        Outer::containing(overlay(all, self.region().rings(), RULE::Intersect))
    }

    /// Whether two sets in `bounds` have no point in common, with certainty: none that rounding may
    /// have lost.
    pub fn misses(&self, other: &Outer, bounds: &Region) -> bool {
        let (small, large) = match self.region().vertex_count() < other.region().vertex_count() {
            true => (self, other),
            false => (other, self),
        };
        let mut corners = small.region().shapes().iter().filter_map(|shape| shape[0].first());
        let is_common = |p: &GridPoint| large.region().contains(csat_proto::region::metres(*p));
        if corners.by_ref().take(LOOKS).any(is_common) || !self.intersection(other).is_empty() {
            return false;
        }
        let disc = Disc::circumscribed(LOST_M, CORNERS);
        small.dilated(&disc, bounds).intersection(large).is_empty()
    }
}

/// Whether a region is a rectangle, along the axes, that contains a box.
pub(super) fn is_box_around(region: &Region, inner: &GridBox) -> bool {
    let [shape] = region.shapes() else { return false };
    let Some(b) = GridBox::around(shape.iter().flatten()) else { return false };
    let is_corner =
        |p: &GridPoint| (p.x == b.min.x || p.x == b.max.x) && (p.y == b.min.y || p.y == b.max.y);
    let is_rectangle = is_single_ring_of_four(shape) && shape[0].iter().all(is_corner);
    is_rectangle && b.contains(inner.min) && b.contains(inner.max)
}

fn is_single_ring_of_four(shape: &Shape) -> bool {
    shape.len() == 1 && shape[0].len() == 4
}

fn clockwise(b: &GridBox) -> Ring {
    let (min, max) = (b.min, b.max);
    vec![min, GridPoint::new(min.x, max.y), max, GridPoint::new(max.x, min.y)]
}
