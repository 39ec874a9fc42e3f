//! Simplification by which outer approximations only grow and inner ones only shrink.
//!
//! Dropping a vertex v between a and b replaces the path a-v-b by a-b: the winding number changes by
//! one over the triangle (a, v, b) and nowhere else: up at a reflex vertex, down at a convex one. So
//! a set that is filled where the winding number is positive only grows when reflex vertices are
//! dropped, and only shrinks when convex ones are, whatever else lies in the triangle. So no
//! topological test is needed, only one resolving pass afterwards.
//!
//! Likewise, replacing an edge between two convex vertices by the point where its neighbours meet
//! adds the triangle between them, which is allowed for an outer approximation; replacing an edge
//! between two reflex vertices removes a triangle, which is allowed for an inner one.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use csat_proto::region::{GridPoint, Region, Ring, Shape, UNITS_PER_M, twice_signed_area};

use super::filled;
use super::vector::{Vector, turn};

/// The kind of approximation, which says how a set may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approximation {
    /// An outer approximation: it may grow.
    Outer,
    /// An inner approximation: it may shrink.
    Inner,
}

/// The bounds of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// The border may move by at most this, in units of the coordinates.
    pub height: f64,
    /// Along at most this length, in units of the coordinates.
    pub length: f64,
    /// Whether edges may be replaced by the point where their neighbours meet.
    pub meet: bool,
}

/// No move is longer than this many times its height tolerance.
const LENGTH_PER_HEIGHT: f64 = 100.0;

/// Meeting points are pushed out by this, in units, to compensate rounding to the grid.
const ROUNDING: f64 = 2.0;

/// Simplifies a region; each move shifts the border by at most `tolerance_m`.
pub(super) fn simplify_region(
    region: Region,
    approximation: Approximation,
    tolerance_m: f64,
) -> Region {
    let before = region.vertex_count();
    let rings = simplified_rings(region.rings(), approximation, tolerance_m);
    if rings.iter().map(Vec::len).sum::<usize>() == before {
        return region;
    }
    filled(&rings)
}

/// Simplifies every shape of a region by its own tolerance.
pub(super) fn simplify_shapes(
    region: &Region,
    approximation: Approximation,
    tolerance_m: impl Fn(&Shape) -> f64,
) -> Region {
    let shapes = region.shapes().iter();
    let rings: Vec<Ring> = shapes
        .flat_map(|shape| simplified_rings(shape, approximation, tolerance_m(shape)))
        .collect();
    filled(&rings)
}

/// The rings of a simplified region, not resolved: to be filled where their winding number is
/// positive.
pub(super) fn simplified_rings<'a>(
    rings: impl IntoIterator<Item = &'a Ring>,
    approximation: Approximation,
    tolerance_m: f64,
) -> Vec<Ring> {
    let height = tolerance_m * UNITS_PER_M;
    let tolerance = Tolerance { height, length: LENGTH_PER_HEIGHT * height, meet: true };
    rings
        .into_iter()
        .map(|ring| simplify_ring(ring, approximation, tolerance))
        .filter(|ring| ring.len() >= 3)
        .collect()
}

/// Simplifies one ring by the safe moves of `approximation`, cheapest first, as far as `tolerance`
/// allows; collinear vertices always go.
///
/// The ring may cross itself afterwards and is to be filled where its winding number is positive. It
/// may become empty: an outer ring of an inner approximation, or a hole of an outer one.
pub fn simplify_ring(
    ring: &[GridPoint],
    approximation: Approximation,
    tolerance: Tolerance,
) -> Ring {
    let mut chain = VertexList::new(ring, approximation, tolerance);
    while let Some(Reverse((bits, at, change))) = chain.queue.pop() {
        // Entries are stale after a change of a neighbour: the price is computed again before a move.
        if chain.alive[at] && chain.price(at, change).map(f64::to_bits) == Some(bits) {
            chain.apply(at, change);
            if chain.left < 3 {
                return Ring::new();
            }
        }
    }
    let points: Ring =
        (0..ring.len()).filter(|&i| chain.alive[i]).map(|i| chain.points[i]).collect();
    if twice_signed_area(&points) == 0 { Ring::new() } else { points }
}

/// A move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    /// Drop a vertex.
    Drop,
    /// Replace the edge from a vertex to the next by the point where the edges around it meet.
    Meet,
}

/// A ring under simplification: a circular linked list with a queue of possible moves.
struct VertexList {
    points: Vec<GridPoint>,
    links: Vec<(usize, usize)>,
    alive: Vec<bool>,
    left: usize,
    approximation: Approximation,
    tolerance: Tolerance,
    queue: BinaryHeap<Reverse<(u64, usize, Change)>>,
}

impl VertexList {
    fn new(ring: &[GridPoint], approximation: Approximation, tolerance: Tolerance) -> Self {
        let n = ring.len();
        let mut chain = Self {
            points: ring.to_vec(),
            links: (0..n).map(|i| ((i + n - 1) % n, (i + 1) % n)).collect(),
            alive: vec![true; n],
            left: n,
            approximation,
            tolerance,
            queue: BinaryHeap::with_capacity(n),
        };
        (0..n).for_each(|i| chain.offer(i));
        chain
    }

    fn before(&self, i: usize) -> usize {
        self.links[i].0
    }

    fn after(&self, i: usize) -> usize {
        self.links[i].1
    }

    /// Puts the possible moves at a vertex into the queue.
    fn offer(&mut self, i: usize) {
        for change in [Change::Drop, Change::Meet] {
            // Prices are not negative, so the order of their bits is their order.
            if let Some(price) = self.price(i, change) {
                self.queue.push(Reverse((price.to_bits(), i, change)));
            }
        }
    }

    /// The share of the tolerance that a move takes; `None` when it is unsafe or exceeds the tolerance.
    fn price(&self, i: usize, change: Change) -> Option<f64> {
        let price = match change {
            Change::Drop => self.price_of_drop(i),
            Change::Meet if self.tolerance.meet && self.left > 3 => self.meeting(i).map(|m| m.1),
            Change::Meet => None,
        }?;
        (price <= 1.0).then_some(price)
    }

    fn price_of_drop(&self, i: usize) -> Option<f64> {
        let (a, v, b) = (self.points[self.before(i)], self.points[i], self.points[self.after(i)]);
        let turn = turn(a, v, b);
        match (self.approximation, turn) {
            (_, 0) => Some(0.0),
            (Approximation::Outer, 1..) | (Approximation::Inner, ..0) => None,
            _ => {
                let base = Vector::between(a, b).length();
                // The height of the triangle over a-b; of a needle, its length.
                let height = (turn.unsigned_abs() as f64 / base.max(1.0)).max(if base < 1.0 {
                    Vector::between(a, v).length()
                } else {
                    0.0
                });
                Some(self.share(height, base))
            }
        }
    }

    /// Where the edges around the edge i → next meet, and the price.
    fn meeting(&self, i: usize) -> Option<(GridPoint, f64)> {
        let (b, c) = (self.points[i], self.points[self.after(i)]);
        let (a, d) = (self.points[self.before(i)], self.points[self.after(self.after(i))]);
        let [u, e, w] = [(a, b), (b, c), (c, d)].map(|(p, q)| Vector::between(p, q));
        let (at_b, at_c, between) = (u.cross(e), e.cross(w), u.cross(w));
        let sign = if self.approximation == Approximation::Outer { 1 } else { -1 };
        if at_b * sign <= 0 || at_c * sign <= 0 || between * sign <= 0 || u.dot(w) <= 0 {
            return None;
        }
        // b + t·u = c - s·w, so t = (e × w) / (u × w).
        let t = at_c as f64 / between as f64;
        let base = e.length();
        let height = t * at_b.unsigned_abs() as f64 / base;
        let price = self.share(height, base);
        let out = e.outward();
        let out = [out.x, out.y].map(|x| x as f64 / base * ROUNDING * sign as f64);
        let x = f64::from(b.x) + t * u.x as f64 + out[0];
        let y = f64::from(b.y) + t * u.y as f64 + out[1];
        (price <= 1.0).then(|| (GridPoint::new(x.round() as i32, y.round() as i32), price))
    }

    fn share(&self, height: f64, length: f64) -> f64 {
        (height / self.tolerance.height).max(length / self.tolerance.length)
    }

    fn apply(&mut self, i: usize, change: Change) {
        if change == Change::Meet {
            let Some((point, _)) = self.meeting(i) else { return };
            self.points[i] = point;
            self.unlink(self.after(i));
            self.offer(i);
        } else {
            self.unlink(i);
        }
        let (before, after) = self.links[i];
        for near in [self.before(before), before, after, self.after(after)] {
            self.offer(near);
        }
    }

    fn unlink(&mut self, i: usize) {
        let (before, after) = self.links[i];
        self.links[before].1 = after;
        self.links[after].0 = before;
        self.alive[i] = false;
        self.left -= 1;
    }
}
