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
//!
//! # Reflex vertices
//!
//! Where two edges e and f meet in a reflex vertex v, their pushed copies may cross in a point c. The path
//! then goes through c, instead of through v + q(e), v and v + q(f), if c lies in the half of each copy
//! that is nearer to v. So crossings on a copy are in order, and what is left of e's parallelogram is a
//! quadrilateral, counter-clockwise like it: winding numbers are still that of P plus one for each piece
//! over a point.
//!
//! Missing is the triangle of v, v + q(e) and c, and the same for f. Take x in the triangle of e that the
//! sets x - sQ with s < t do not touch P, and x = p + t q(e) with p on e. Let x = g + s q(f) with g on f's
//! line. As q(f) is farthest along f's normal, and c is equally far from both, s <= t. If v + q(e) lies over
//! f (its g is on f, and its s >= 0), so do v and c and all of the triangle. Then x - sQ touches P in g, so
//! s = t, and x is on the side from v to c, which the quadrilateral contains. Where v + q(e) does not lie
//! over f, or v + q(f) not over e, the path returns through v.

use csat_proto::region::{GridPoint, Ring};

use super::Disc;
use super::vector::Vector;
use crate::work::note_swept;

/// The raw path of `ring ⊕ disc`; to be filled where the winding number is positive. The disc must
/// [fit](Disc::fits) about every point of the ring, which may repeat points, or be just one. With the other
/// rings of its set it must not wind negatively about any point.
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
        if turn > 0 || (turn == 0 && incoming.dot(outgoing) < 0) {
            path.push(v + corners[from]);
            while from != to {
                from = (from + 1) % corners.len();
                path.push(v + corners[from]);
            }
        } else if from == to {
            path.push(v + corners[from]);
        } else if let Some(c) = crossing([incoming, outgoing], [corners[from], corners[to]]) {
            path.push(v + c);
        } else {
            path.extend([v + corners[from], v, v + corners[to]]);
        }
        (incoming, from) = (outgoing, to);
    }
    path
}

/// Where the copies of two edges, pushed by their corners, cross, from the reflex vertex between them;
/// `None` where the path has to go through the vertex.
fn crossing([e, f]: [Vector; 2], corners: [GridPoint; 2]) -> Option<GridPoint> {
    let [q, r] = corners.map(|corner| Vector::between(GridPoint::ZERO, corner));
    let between = Vector::between(corners[1], corners[0]);
    // v + q - along_e e = v + r + along_f f; each of these is divided by e x f, which is negative.
    let (turn, along_e, along_f) = (e.cross(f), between.cross(f), -between.cross(e));
    let is_near = |along: i128| along <= 0 && 2 * along >= turn;
    // q = s r + g f, and r = s q - g e.
    let (e_width, f_width, apart) = (e.cross(q), f.cross(r), q.cross(r));
    let is_over = apart <= 0 && apart >= f_width.max(e_width) && f.cross(q).max(e.cross(r)) <= 0;
    if turn == 0 || !is_near(along_e) || !is_near(along_f) || !is_over {
        return None;
    }
    let share = along_e as f64 / turn as f64;
    let place = |q: i64, e: i64| (q as f64 - share * e as f64).round() as i32;
    Some(GridPoint::new(place(q.x, e.x), place(q.y, e.y)))
}

/// The raw path of `ring ⊖ disc`: the complement, dilated. The ring must be one of a resolved set.
pub(super) fn eroded_path(ring: &[GridPoint], disc: &Disc) -> Ring {
    let reversed: Ring = ring.iter().rev().copied().collect();
    let mut path = dilated_path(&reversed, disc);
    path.reverse();
    path
}
