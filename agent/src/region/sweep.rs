//! Minkowski sums and erosions by a convex polygon, as one raw path per ring.
//!
//! Let P be a region and Q a convex polygon around the origin. Each edge e of P, pushed outward by
//! the corner q(e) of Q that is farthest along e's outward normal, sweeps a parallelogram; at a
//! convex vertex v the corners of Q between the two edges' normals sweep a fan about v; at a reflex
//! vertex the path returns through v. So the winding number of the raw path is that of P plus one
//! for each swept piece over a point: filled where positive it is exactly P ∪ (pieces).
//!
//! That union is P ⊕ Q. Take x in P ⊕ Q but not in P and the least t in (0, 1] for which the convex
//! set x - tQ touches P. It touches either inside an edge e with the corner q(e), and then x lies
//! in e's parallelogram, or at a convex vertex with a corner between the normals, and then x lies
//! in that fan; it cannot touch at a reflex vertex alone. Where an edge of Q is parallel to e the
//! first of the two farthest corners is taken: its other end is the first corner of the fan that
//! follows.

use csat_proto::region::{GridPoint, Ring};

use super::Disc;

/// The raw path of `ring ⊕ disc`; to be filled where the winding number is positive.
pub(super) fn dilated_path(ring: &[GridPoint], disc: &Disc) -> Ring {
    let corners = disc.corners();
    let edge = |i: usize| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y))
    };
    let support = |d: (i64, i64)| disc.support((d.1, -d.0));
    let mut path = Ring::with_capacity(ring.len() * 2 + corners.len());
    let mut incoming = edge(ring.len() - 1);
    let mut from = support(incoming);
    for (i, &v) in ring.iter().enumerate() {
        let outgoing = edge(i);
        let to = support(outgoing);
        let (turn, along) = cross_and_dot(incoming, outgoing);
        let reverses = turn == 0 && along < 0;
        path.push(v + corners[from]);
        if turn > 0 || reverses {
            while from != to {
                from = (from + 1) % corners.len();
                path.push(v + corners[from]);
            }
        } else if from != to {
            path.push(v);
            path.push(v + corners[to]);
        }
        (incoming, from) = (outgoing, to);
    }
    path
}

/// The raw path of `ring ⊖ disc`: the complement, dilated.
pub(super) fn eroded_path(ring: &[GridPoint], disc: &Disc) -> Ring {
    let reversed: Ring = ring.iter().rev().copied().collect();
    let mut path = dilated_path(&reversed, disc);
    path.reverse();
    path
}

fn cross_and_dot(u: (i64, i64), w: (i64, i64)) -> (i128, i128) {
    let (ux, uy, wx, wy) = (i128::from(u.0), i128::from(u.1), i128::from(w.0), i128::from(w.1));
    (ux * wy - uy * wx, ux * wx + uy * wy)
}
