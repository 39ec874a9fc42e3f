//! Where an identified target may be.

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label, PixelBox};
use csat_proto::region::{GridPoint, Region, Ring, grid_point};

use super::pyramid::ground_corners;
use crate::region::{Disc, Outer, turn};

/// The longest run of pixels of one row whose hull is taken at once.
const MAX_RUN: usize = 16;

/// X^{t,m} (4.4), outer: the ground projections of the pyramids of all Target pixels in the box,
/// dilated by r^t (`cylinder`), in X_g.
///
/// By (3.53) at least one of those pixels shows the target, but not which. Neighbouring pixels of a
/// row are covered by the convex hull of their pyramids together, which contains each.
pub fn location(
    view: &CameraView,
    frame: &Frame,
    pixels: PixelBox,
    cylinder: &Disc,
    ground: &Region,
) -> Outer {
    let model = view.model();
    let mut hulls: Vec<Ring> = Vec::new();
    let last_row = pixels.rows[1].min(model.rows.saturating_sub(1));
    let last_column = pixels.columns[1].min(model.columns.saturating_sub(1));
    for row in pixels.rows[0]..=last_row {
        let mut run: Vec<GridPoint> = Vec::new();
        let mut length = 0;
        for column in pixels.columns[0]..=last_column {
            let index = usize::from(row) * usize::from(model.columns) + usize::from(column);
            if frame.labels[index] == Label::Target {
                let depth_m = model.depth_interval_m(frame.depth[index]);
                run.extend(ground_corners(view, column, row, depth_m).into_iter().map(grid_point));
                length += 1;
            }
            if frame.labels[index] != Label::Target || length == MAX_RUN || column == last_column {
                hulls.extend(convex_hull(std::mem::take(&mut run)));
                length = 0;
            }
        }
    }
    Outer::around(&hulls, cylinder, ground)
}

/// The convex hull (counter-clockwise) of points, by Andrew's monotone chain; `None` without points.
/// Collinear points give a ring without area, which a dilation turns into a set; so that a single
/// point has an edge to dilate, it becomes a segment of one grid unit.
fn convex_hull(mut points: Vec<GridPoint>) -> Option<Ring> {
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
