//! Convex hulls on the grid.

use csat_proto::region::{GridPoint, Ring};

use crate::region::turn;

/// The convex hull (counter-clockwise) of points, by Andrew's monotone chain; `None` without points.
/// Collinear points give a ring without area, which a dilation turns into a set. A single point
/// becomes a segment of one grid unit, so that it has an edge to dilate.
pub(super) fn convex_hull(mut points: Vec<GridPoint>) -> Option<Ring> {
    points.sort_unstable_by_key(|p| (p.x, p.y));
    points.dedup();
    if let [p] = points[..] {
        return Some(vec![p, GridPoint::new(p.x + 1, p.y)]);
    }
    if points.is_empty() {
        return None;
    }
    let mut hull: Ring = Vec::with_capacity(16);
    let mut chain = |points: &mut dyn Iterator<Item = GridPoint>| {
        let start = hull.len();
        for p in points {
            while hull.len() >= start + 2
                && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    };
    chain(&mut points.iter().copied());
    chain(&mut points.iter().rev().copied());
    Some(hull)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_of_points_segments_and_squares() {
        let p = GridPoint::new;
        assert_eq!(convex_hull(vec![]), None);
        assert_eq!(convex_hull(vec![p(1, 1), p(1, 1)]), Some(vec![p(1, 1), p(2, 1)]));
        assert_eq!(convex_hull(vec![p(0, 0), p(2, 2), p(1, 1)]), Some(vec![p(0, 0), p(2, 2)]));
        let square = convex_hull(vec![p(0, 0), p(2, 2), p(1, 1), p(2, 0), p(0, 2), p(1, 0)]);
        assert_eq!(square, Some(vec![p(0, 0), p(2, 0), p(2, 2), p(0, 2)]));
    }
}
