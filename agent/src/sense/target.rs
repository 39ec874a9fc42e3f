//! The location X^{t,m} of an identified target (4.4).

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label, PixelBox};
use csat_proto::region::{Region, Ring, grid_point, metres};

use super::hull::convex_hull;
use super::pose_box::{Extent, PoseBox};
use super::pyramid::{self, ground_corners};
use crate::mutant::{Mutant, is_on};
use crate::region::{Disc, Outer};

/// The most pixels of a row that share one hull.
const MAX_RUN: usize = 16;
/// Up to this many runs, each run has a hull of its own.
const MAX_HULLS: usize = 160;
/// The most tiles of the box, along either side, for more runs.
const MAX_TILES: usize = 8;

/// X^{t,m} (4.4), outer, from all poses of the box (6.9): the ground projections of the pyramids of all Target pixels in the box,
/// dilated by r^t (`cylinder`), in X_g.
///
/// By (3.53) at least one of these pixels shows the target; which one is unknown. Neighbouring pixels
/// of a row are covered by the common convex hull of their pyramids. All dilated hulls of a target
/// overlap, and the time of their union is quadratic in their number. So a target with more than
/// `MAX_HULLS` runs, which is seen from nearby, is covered by the hulls of the tiles of its box.
pub fn location(
    pixels: &TargetPixels<'_>,
    poses: &PoseBox,
    cylinder: &Disc,
    ground: &Region,
) -> Outer {
    let runs = pixels.runs();
    let windows = if runs.len() <= MAX_HULLS { runs } else { pixels.tiles() };
    let hulls: Vec<Ring> = windows.iter().filter_map(|window| pixels.hull(window, poses)).collect();
    Outer::around(&hulls, cylinder, ground)
}

/// The Target pixels in a detection's box.
pub struct TargetPixels<'a> {
    view: &'a CameraView,
    frame: &'a Frame,
    /// The part of the box that is in the image; empty where a first index is greater than the last.
    pixels: PixelBox,
}

impl<'a> TargetPixels<'a> {
    /// Those of `frame`, seen by `view`, in the box `pixels`.
    pub fn new(view: &'a CameraView, frame: &'a Frame, pixels: PixelBox) -> Self {
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

    /// The Target pixels in a window.
    fn of(&self, window: &PixelBox) -> impl Iterator<Item = (u16, u16)> {
        let [columns, rows] = [window.columns, window.rows].map(|[first, last]| first..=last);
        let all = rows.flat_map(move |row| columns.clone().map(move |column| (column, row)));
        all.filter(|&(column, row)| self.is_target(column, row))
    }

    /// The interval of the distance of a pixel, metres.
    fn depth_m(&self, column: u16, row: u16) -> [f64; 2] {
        self.view.model().depth_interval_m(self.frame.depth[self.index(column, row)])
    }

    /// A convex set that contains the ground projections of the pyramids of the Target pixels in a window, from all
    /// poses of the box: their convex hull if it is one pose.
    fn hull(&self, window: &PixelBox, poses: &PoseBox) -> Option<Ring> {
        let corners = self.of(window).flat_map(|(column, row)| {
            ground_corners(self.view, column, row, self.depth_m(column, row))
        });
        let hull = convex_hull(corners.map(grid_point).collect())?;
        if poses.is_exact() || is_on(Mutant::TargetFromOnePose) {
            return Some(hull);
        }
        let extents =
            self.of(window).map(|(c, r)| pyramid::extent(self.view, c, r, self.depth_m(c, r)));
        let extent = extents.fold(Extent::default(), Extent::or);
        let hull: Vec<[f64; 2]> = hull.into_iter().map(metres).collect();
        Some(poses.moved(poses.tilt(extent).about(&hull)))
    }
}
