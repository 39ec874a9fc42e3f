//! Simplification that only goes the safe way.
//!
//! Dropping a vertex v between a and b replaces the path a-v-b by a-b: the winding number changes by
//! one over the triangle (a, v, b) and nowhere else: up at a reflex vertex, down at a convex one. So
//! a set that is filled where the winding number is positive only grows when reflex vertices are
//! dropped, and only shrinks when convex ones are, *whatever else lies in the triangle*: no
//! topological test is needed, only one resolving pass afterwards.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use csat_proto::region::{GridPoint, Region, Ring, UNITS_PER_M};

use super::{RULE, overlay};

/// Which way a set may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// It may grow.
    Outer,
    /// It may shrink.
    Inner,
}

/// Simplifies a region; each move changes the area by at most `tolerance_m2`.
pub(super) fn simplify_region(region: Region, kind: Kind, tolerance_m2: f64) -> Region {
    let tolerance = tolerance_m2 * UNITS_PER_M * UNITS_PER_M;
    let cost = |a, v, b| twice_triangle(a, v, b).unsigned_abs() as f64 / 2.0 / tolerance;
    let before = region.vertex_count();
    let rings: Vec<Ring> = region
        .rings()
        .map(|ring| simplify_ring(ring, kind, cost))
        .filter(|ring| ring.len() >= 3)
        .collect();
    if rings.iter().map(Vec::len).sum::<usize>() == before {
        return region;
    }
    overlay(&rings, [], RULE::Subject)
}

/// Twice the signed area of the triangle (a, v, b): positive when v is a convex (left) turn.
fn twice_triangle(a: GridPoint, v: GridPoint, b: GridPoint) -> i128 {
    let (ux, uy) = (i128::from(v.x) - i128::from(a.x), i128::from(v.y) - i128::from(a.y));
    let (wx, wy) = (i128::from(b.x) - i128::from(v.x), i128::from(b.y) - i128::from(v.y));
    ux * wy - uy * wx
}

/// Drops vertices of one ring, cheapest first, while `cost(previous, vertex, next)` is at most 1.
/// Outer sets lose reflex vertices, inner sets convex ones; collinear vertices always go.
///
/// The ring may cross itself afterwards and is to be filled where its winding number is positive. It
/// may shrink to fewer than 3 vertices, which is ∅ (only inner sets' rings and outer sets' holes).
pub fn simplify_ring(
    ring: &[GridPoint],
    kind: Kind,
    cost: impl Fn(GridPoint, GridPoint, GridPoint) -> f64,
) -> Ring {
    let n = ring.len();
    let mut links: Vec<(usize, usize)> = (0..n).map(|i| ((i + n - 1) % n, (i + 1) % n)).collect();
    let mut alive = vec![true; n];
    let price = |links: &[(usize, usize)], i: usize| -> Option<f64> {
        let (a, v, b) = (ring[links[i].0], ring[i], ring[links[i].1]);
        let turn = twice_triangle(a, v, b);
        let safe = match kind {
            Kind::Outer => turn <= 0,
            Kind::Inner => turn >= 0,
        };
        let price = if turn == 0 { 0.0 } else { cost(a, v, b) };
        (safe && price <= 1.0).then_some(price)
    };
    // Entries go stale when a neighbour is dropped: the price is asked again before acting on one.
    let mut queue: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::with_capacity(n);
    let push = |queue: &mut BinaryHeap<Reverse<(u64, usize)>>, price: Option<f64>, i: usize| {
        // Prices are not negative, so the order of their bits is their order.
        if let Some(price) = price {
            queue.push(Reverse((price.to_bits(), i)));
        }
    };
    for i in 0..n {
        push(&mut queue, price(&links, i), i);
    }
    let mut left = n;
    while let Some(Reverse((bits, i))) = queue.pop() {
        if !alive[i] || price(&links, i).map(f64::to_bits) != Some(bits) {
            continue;
        }
        alive[i] = false;
        left -= 1;
        if left < 3 {
            return Ring::new();
        }
        let (before, after) = links[i];
        links[before].1 = after;
        links[after].0 = before;
        push(&mut queue, price(&links, before), before);
        push(&mut queue, price(&links, after), after);
    }
    (0..n).filter(|&i| alive[i]).map(|i| ring[i]).collect()
}
