//! The exclusion X̲^t of an identified target (4.17): no other target is in it.

use std::f64::consts::PI;

use csat_proto::region::{Region, Ring, grid_point, metres};

use crate::region::{Inner, NUMERIC_MARGIN_M, Outer};

/// X̲^t (4.17), inner: the points within r_s^tt of every possible location of an identified target,
/// so no other target's location is in it. Empty when the location is too uncertain.
pub fn exclusion(location: &Outer, radius_m: f64, vertices: u16) -> Inner {
    // The discs about the vertices suffice: distance to a fixed point is greatest at a vertex of the
    // convex hull (A.8), and taking the other vertices too changes nothing.
    let points: Vec<[f64; 2]> = location.region().rings().flatten().map(|&p| metres(p)).collect();
    let ring = disc_intersection(&points, radius_m, vertices);
    Inner::within(ring.map_or(Region::EMPTY, |ring| Region::from_shapes(vec![vec![ring]])))
}

/// The intersection of the inscribed regular polygons of the discs of `radius_m` about `points`
/// (metres), as a counter-clockwise ring; `None` when it does not contain the points' centre.
///
/// They are smaller than the discs by the numeric margin, like every inner approximation that is
/// subtracted from an outer one: what is left around a target is wider than the rounding of Boolean
/// operations.
///
/// All polygons share their edge directions, so the intersection is bounded, in each direction, by
/// the edge of the rearmost one.
pub fn disc_intersection(points: &[[f64; 2]], radius_m: f64, vertices: u16) -> Option<Ring> {
    disc_intersection_of_moved(points, radius_m, vertices, |_| 0.0)
}

/// The same for points that may be moved, by no more than `moved_m` along each unit vector, metres.
pub(super) fn disc_intersection_of_moved(
    points: &[[f64; 2]],
    radius_m: f64,
    vertices: u16,
    moved_m: impl Fn([f64; 2]) -> f64,
) -> Option<Ring> {
    let n = vertices.max(4);
    let centre = centre_of_bounds(points)?;
    let apothem = radius_m * (PI / f64::from(n)).cos() - NUMERIC_MARGIN_M;
    let normals = (0..n).map(|k| (2.0 * PI * f64::from(k) / f64::from(n)).sin_cos());
    let half_planes: Vec<HalfPlane> = normals
        .map(|(y, x)| {
            let rearmost = points
                .iter()
                .map(|p| x * (p[0] - centre[0]) + y * (p[1] - centre[1]))
                .fold(f64::INFINITY, f64::min);
            HalfPlane { normal: [x, y], offset: rearmost + apothem - moved_m([x, y]) }
        })
        .collect();
    if half_planes.iter().any(|h| h.offset <= 0.0) {
        return None;
    }
    let mut polygon = square(2.0 * radius_m);
    for half_plane in &half_planes {
        polygon = half_plane.clip(&polygon);
    }
    (polygon.len() >= 3)
        .then(|| polygon.iter().map(|p| grid_point([p[0] + centre[0], p[1] + centre[1]])).collect())
}

/// The middle of the bounding box of `points`; `None` if there are none.
pub(super) fn centre_of_bounds(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let first = points.first()?;
    let (min, max) = points.iter().fold((*first, *first), |(min, max), p| {
        ([min[0].min(p[0]), min[1].min(p[1])], [max[0].max(p[0]), max[1].max(p[1])])
    });
    Some([(min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0])
}

fn square(half_side: f64) -> Vec<[f64; 2]> {
    let s = half_side;
    vec![[-s, -s], [s, -s], [s, s], [-s, s]]
}

/// {p : normal · p <= offset}.
pub(crate) struct HalfPlane {
    pub(crate) normal: [f64; 2],
    pub(crate) offset: f64,
}

impl HalfPlane {
    /// The part of a ring in it; winding numbers there stay as they are.
    pub(crate) fn clip(&self, polygon: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let excess = |p: [f64; 2]| self.normal[0] * p[0] + self.normal[1] * p[1] - self.offset;
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (ea, eb) = (excess(a), excess(b));
            if ea <= 0.0 {
                kept.push(a);
            }
            if (ea <= 0.0) != (eb <= 0.0) {
                let t = ea / (ea - eb);
                kept.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::region::twice_signed_area;

    #[test]
    fn every_corner_is_within_reach_of_every_point() {
        let points = [[0.0, 0.0], [3.0, 0.5], [1.0, -2.0]];
        let ring = disc_intersection(&points, 8.0, 16).unwrap();
        assert!(twice_signed_area(&ring) > 0);
        for corner in ring.iter().map(|&c| metres(c)) {
            for p in points {
                assert!((corner[0] - p[0]).hypot(corner[1] - p[1]) <= 8.0);
            }
        }
        let region = Region::from_shapes(vec![vec![ring]]);
        assert!(region.area_m2() > 80.0, "{}", region.area_m2());
    }

    #[test]
    fn points_too_far_apart_exclude_nothing() {
        assert_eq!(disc_intersection(&[[0.0, 0.0], [16.1, 0.0]], 8.0, 16), None);
        assert_eq!(disc_intersection(&[], 8.0, 16), None);
        assert!(exclusion(&Outer::default(), 8.0, 16).is_empty());
    }
}
