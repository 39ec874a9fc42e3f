//! Minkowski sums and erosions by a convex polygon, as one raw path per ring.
//!
//! Let P be a region and Q a convex polygon around the origin. Each edge e of P, pushed outward by
//! the corner q(e) of Q that is farthest along e's outward normal, sweeps a parallelogram; at a
//! convex vertex v the corners of Q between the two edges' normals sweep a fan about v; at a reflex
//! vertex the path returns through v. So the winding number of the raw path is that of P plus one
//! for each swept piece over a point: filled where positive it is exactly P ∪ (pieces).
//!
//! That union is P ⊕ Q. Take x in P ⊕ Q but not in P and the least t in (0, 1] for which the convex
//! set x - tQ touches P. It touches an edge e with the corner q(e), and then x lies in e's
//! parallelogram, or a convex vertex with a corner between the normals, and then x lies in that fan.
//! (Touching a reflex vertex v alone, x - tQ lies beyond both of v's edges and touches their lines
//! in v: it touches each edge with its corner.) Where an edge of Q is parallel to e the first of the
//! two farthest corners is taken: its other end is the first corner of the fan that follows.

use csat_proto::region::{GridPoint, Ring};

use super::Disc;
use super::vector::Vector;
use crate::work::note_swept;

/// The raw path of `ring ⊕ disc`; to be filled where the winding number is positive. The disc must
/// [fit](Disc::fits) about every point of the ring, which may repeat points, or be just one.
pub(super) fn dilated_path(ring: &[GridPoint], disc: &Disc) -> Ring {
    note_swept(ring.len(), disc.reach_m());
    let corners = disc.corners();
    let mut path = Ring::with_capacity(ring.len() * 3 + corners.len());
    let n = ring.len();
    // Edges without length have no normal.
    let Some(last) = (0..n).rev().find(|&i| ring[i] != ring[(i + 1) % n]) else {
        path.extend(ring.first().iter().flat_map(|&&v| corners.iter().map(move |&q| v + q)));
        return path;
    };
    let mut incoming = Vector::between(ring[last], ring[(last + 1) % n]);
    let mut from = disc.support(incoming.outward());
    for i in (0..n).filter(|&i| ring[i] != ring[(i + 1) % n]) {
        let v = ring[i];
        let outgoing = Vector::between(v, ring[(i + 1) % n]);
        let to = disc.support(outgoing.outward());
        let turn = incoming.cross(outgoing);
        path.push(v + corners[from]);
        if turn > 0 || (turn == 0 && incoming.dot(outgoing) < 0) {
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
