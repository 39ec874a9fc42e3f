//! The location X^{t,m} of an identified target (4.4).

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label, PixelBox};
use csat_proto::region::{GridPoint, Region, Ring, grid_point};

use super::pyramid::ground_corners;
use crate::region::{Disc, Outer, turn};

/// The most pixels of a row that share one hull.
const MAX_RUN: usize = 16;
/// Up to this many runs, each run has a hull of its own.
const MAX_HULLS: usize = 160;
/// The most tiles of the box, along either side, for more runs.
const MAX_TILES: usize = 8;

/// X^{t,m} (4.4), outer: the ground projections of the pyramids of all Target pixels in the box,
/// dilated by r^t (`cylinder`), in X_g.
///
/// By (3.53) at least one of these pixels shows the target; which one is unknown. Neighbouring pixels
/// of a row are covered by the common convex hull of their pyramids. All dilated hulls of a target
/// overlap, and the time of their union is quadratic in their number. So a target with more than
/// `MAX_HULLS` runs, which is seen from nearby, is covered by the hulls of the tiles of its box.
pub fn location(
    view: &CameraView,
    frame: &Frame,
    pixels: PixelBox,
    cylinder: &Disc,
    ground: &Region,
) -> Outer {
    let pixels = TargetPixels::new(view, frame, pixels);
    let runs = pixels.runs();
    let windows = if runs.len() <= MAX_HULLS { runs } else { pixels.tiles() };
    let hulls: Vec<Ring> = windows.iter().filter_map(|window| pixels.hull(window)).collect();
    Outer::around(&hulls, cylinder, ground)
}

/// The Target pixels in a detection's box.
struct TargetPixels<'a> {
    view: &'a CameraView,
    frame: &'a Frame,
    /// The part of the box that is in the image; empty where a first index is greater than the last.
    pixels: PixelBox,
}

impl<'a> TargetPixels<'a> {
    fn new(view: &'a CameraView, frame: &'a Frame, pixels: PixelBox) -> Self {
        let model = view.model();
        let clipped =
            |[first, last]: [u16; 2], length: u16| [first, last.min(length.saturating_sub(1))];
        let columns = clipped(pixels.columns, model.columns);
        let rows = clipped(pixels.rows, model.rows);
        Self { view, frame, pixels: PixelBox { columns, rows } }
    }

    fn index(&self, column: u16, row: u16) -> usize {
        usize::from(row) * usize::from(self.view.model().columns) + usize::from(column)
    }

    fn is_target(&self, column: u16, row: u16) -> bool {
        self.frame.labels[self.index(column, row)] == Label::Target
    }

    /// The runs of Target pixels, none longer than [`MAX_RUN`], row by row.
    fn runs(&self) -> Vec<PixelBox> {
        let PixelBox { columns: [first, last], rows: [bottom, top] } = self.pixels;
        let mut runs: Vec<PixelBox> = Vec::new();
        for row in bottom..=top {
            let mut length = 0;
            for column in first..=last {
                if !self.is_target(column, row) {
                    length = 0;
                    continue;
                }
                match runs.last_mut() {
                    Some(run) if length > 0 => run.columns[1] = column,
                    _ => runs.push(PixelBox { columns: [column; 2], rows: [row; 2] }),
                }
                length = (length + 1) % MAX_RUN;
            }
        }
        runs
    }

    /// The box, cut into tiles.
    fn tiles(&self) -> Vec<PixelBox> {
        let cut = |[first, last]: [u16; 2]| {
            let side = usize::from(last - first + 1).div_ceil(MAX_TILES);
            (first..=last)
                .step_by(side)
                .map(move |start| [start, last.min(start.saturating_add(side as u16 - 1))])
        };
        let rows = cut(self.pixels.rows);
        rows.flat_map(|rows| {
            cut(self.pixels.columns).map(move |columns| PixelBox { columns, rows })
        })
        .collect()
    }

    /// The convex hull of the ground projections of the pyramids of the Target pixels in a window.
    fn hull(&self, window: &PixelBox) -> Option<Ring> {
        let [columns, rows] = [window.columns, window.rows].map(|[first, last]| first..=last);
        let targets = rows.flat_map(|row| columns.clone().map(move |column| (column, row)));
        let corners = targets.filter(|&(column, row)| self.is_target(column, row)).flat_map(
            |(column, row)| {
                let depth_m =
                    self.view.model().depth_interval_m(self.frame.depth[self.index(column, row)]);
                ground_corners(self.view, column, row, depth_m)
            },
        );
        convex_hull(corners.map(grid_point).collect())
    }
}

/// The convex hull (counter-clockwise) of points, by Andrew's monotone chain; `None` without points.
/// Collinear points give a ring without area, which a dilation turns into a set. A single point
/// becomes a segment of one grid unit, so that it has an edge to dilate.
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
