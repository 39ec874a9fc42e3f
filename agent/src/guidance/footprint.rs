//! The predicted footprint F(x^u) ∩ X_g on the planner's grid.

use std::ops::Range;

use csat_proto::camera::CameraView;
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::metres;
use nalgebra::Vector3;

use crate::sense::exclusion::HalfPlane;
use crate::sense::pose_box::PoseBox;

/// The cells whose centres a camera would see without obstacles: the theoretical footprint (3.24)
/// within d_max, cut to X_g. It is convex, so every row holds one run.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Footprint {
    first_row: u32,
    runs: Vec<Range<u32>>,
    /// The footprint's corners, `world`, metres, before the cuts by d_max's circle and X_g.
    corners: Vec<[f64; 2]>,
}

impl Footprint {
    /// The footprint of `view`; empty when it sees no ground. From all `poses` if that is more than one: the
    /// borders are moved inward as far as they shift.
    pub(super) fn of(view: &CameraView, poses: &PoseBox, grid: &Grid) -> Self {
        let corners = match poses.is_exact() {
            true => ground_corners(view, &visible_corners(view)),
            false => common_corners(view, poses),
        };
        let (z, d_max) = (view.centre_world().z, view.model().d_max_m);
        let mut reach_squared = (d_max * d_max - z * z).max(0.0);
        if !poses.is_exact() {
            reach_squared = (reach_squared.sqrt() - poses.most_shift_m()).max(0.0).powi(2);
        }
        let south = corners.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        let north = corners.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
        let rows = grid.rows_between(south, north);
        let foot = view.centre_world();
        let run = |row: u32| {
            let y = grid.centre(0, row)[1];
            let [west, east] = crossings(&corners, y);
            let half = (reach_squared - (y - foot.y).powi(2)).max(0.0).sqrt();
            grid.columns_between(west.max(foot.x - half), east.min(foot.x + half))
        };
        Self { first_row: rows.start, runs: rows.clone().map(run).collect(), corners }
    }

    /// The corners on the ground, `world`, metres; convex, at most five; may lie outside X_g.
    pub(super) fn corners(&self) -> &[[f64; 2]] {
        &self.corners
    }

    /// The columns of a row that are in the footprint.
    pub(super) fn columns(&self, row: u32) -> Range<u32> {
        let run = row.checked_sub(self.first_row).and_then(|i| self.runs.get(i as usize));
        run.cloned().unwrap_or_default()
    }

    /// The footprint as rows and the columns in each.
    pub(super) fn rows(&self) -> impl Iterator<Item = (u32, Range<u32>)> + '_ {
        (self.first_row..).zip(self.runs.iter().cloned())
    }

    /// The footprint as (row, word of the row, bits).
    pub(super) fn words(&self) -> impl Iterator<Item = (u32, usize, u64)> + '_ {
        self.runs.iter().zip(self.first_row..).flat_map(|(run, row)| {
            let (start, end) = (run.start as usize, run.end as usize);
            let words = if run.is_empty() { 0..0 } else { start / 64..end.div_ceil(64) };
            words.map(move |word| {
                let low = start.saturating_sub(word * 64);
                let high = (end - word * 64).min(64);
                (row, word, (u64::MAX << low) & (u64::MAX >> (64 - high)))
            })
        })
    }

    /// The footprint as a set of cells.
    pub(super) fn raster(&self, grid: Grid) -> Raster {
        let mut raster = Raster::empty(grid);
        for (run, row) in self.runs.iter().zip(self.first_row..) {
            raster.set_run(row, run.clone());
        }
        raster
    }

    /// c(F ∩ X_g), `world`, metres. For a footprint outside X_g it is the centroid of its corners, so
    /// that (5.15) leads the UAV back; `None` when the camera sees no ground.
    pub(super) fn barycentre(&self, grid: &Grid) -> Option<[f64; 2]> {
        let (mut cells, mut x, mut y) = (0.0, 0.0, 0.0);
        for (run, row) in self.runs.iter().zip(self.first_row..).filter(|(run, _)| !run.is_empty())
        {
            let length = f64::from(run.end - run.start);
            let (first, last) = (grid.centre(run.start, row), grid.centre(run.end - 1, row));
            cells += length;
            x += length * 0.5 * (first[0] + last[0]);
            y += length * first[1];
        }
        if cells > 0.0 { Some([x / cells, y / cells]) } else { centroid(&self.corners) }
    }
}

/// The corners of the image, pixels, cut where the depth along the optical axis reaches d_max: a
/// point farther along the axis is farther from the camera too, so no point within d_max is lost, and
/// the result is bounded. Depth is affine in 1/(c, r), so the cut is a straight line of the image.
fn visible_corners(view: &CameraView) -> Vec<[f64; 2]> {
    let z = view.centre_world().z;
    if z <= 0.0 {
        return Vec::new();
    }
    let (w, h) = (f64::from(view.model().columns), f64::from(view.model().rows));
    let least_descent = z / view.model().d_max_m;
    let excess = |p: [f64; 2]| -view.ray_world(p[0], p[1]).z - least_descent;
    let image = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]];
    let mut kept = Vec::with_capacity(5);
    for (i, &a) in image.iter().enumerate() {
        let b = image[(i + 1) % 4];
        let (at_a, at_b) = (excess(a), excess(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if (at_a >= 0.0) != (at_b >= 0.0) {
            let t = at_a / (at_a - at_b);
            kept.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        }
    }
    kept
}

/// The images on the ground of image points below the horizon, `world`, metres.
fn ground_corners(view: &CameraView, image: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let ground = |p: &[f64; 2]| {
        let ray: Vector3<f64> = view.ray_world(p[0], p[1]);
        let point = view.centre_world() - ray * (view.centre_world().z / ray.z);
        [point.x, point.y]
    };
    image.iter().map(ground).collect()
}

/// The same for the part that is in the image from all poses.
fn common_corners(view: &CameraView, poses: &PoseBox) -> Vec<[f64; 2]> {
    let image = visible_corners(view);
    let corners = ground_corners(view, &image);
    let count = corners.len();
    let places: Vec<_> = image.iter().map(|&[c, r]| poses.ground_place(c, r)).collect();
    (0..count).fold(corners.clone(), |kept, i| {
        let j = (i + 1) % count;
        let ends = [&places[i], &places[j]];
        let points = |end: usize| ends[end].iter().flatten().map(|&p| metres(p));
        // From (column, row) to (east, north) the orientation flips: the corners run clockwise.
        let outward = |[a, b]: [[f64; 2]; 2]| [a[1] - b[1], b[0] - a[0]];
        let along = |normal: [f64; 2], p: [f64; 2]| normal[0] * p[0] + normal[1] * p[1];
        // The innermost places of both ends, along the edge from the reported pose.
        let usual = outward([corners[i], corners[j]]);
        let innermost = |end: usize, corner: [f64; 2]| {
            let nearer = |a: &[f64; 2], b: &[f64; 2]| along(usual, *a).total_cmp(&along(usual, *b));
            points(end).min_by(nearer).unwrap_or(corner)
        };
        let normal = outward([innermost(0, corners[i]), innermost(1, corners[j])]);
        let all = points(0).chain(points(1)).chain([corners[i]]);
        let offset = all.map(|p| along(normal, p)).fold(f64::INFINITY, f64::min);
        HalfPlane { normal, offset }.clip(&kept)
    })
}

/// Where the horizontal line at `y` enters and leaves a convex ring; empty when it misses.
fn crossings(ring: &[[f64; 2]], y: f64) -> [f64; 2] {
    let mut span = [f64::INFINITY, f64::NEG_INFINITY];
    for (i, &a) in ring.iter().enumerate() {
        let b = ring[(i + 1) % ring.len()];
        if (a[1] <= y) != (b[1] <= y) {
            let x = a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]);
            span = [span[0].min(x), span[1].max(x)];
        }
    }
    span
}

/// The centroid of a simple ring.
fn centroid(ring: &[[f64; 2]]) -> Option<[f64; 2]> {
    let &origin = ring.first()?;
    let (mut area, mut x, mut y) = (0.0, 0.0, 0.0);
    for (i, a) in ring.iter().enumerate() {
        let b = ring[(i + 1) % ring.len()];
        let (a, b) = ([a[0] - origin[0], a[1] - origin[1]], [b[0] - origin[0], b[1] - origin[1]]);
        let cross = a[0] * b[1] - b[0] * a[1];
        area += cross;
        x += cross * (a[0] + b[0]);
        y += cross * (a[1] + b[1]);
    }
    let scale = 1.0 / (3.0 * area);
    scale.is_finite().then(|| [origin[0] + x * scale, origin[1] + y * scale])
}

#[cfg(test)]
mod tests {
    use csat_proto::camera::{CameraModel, Pose, PoseError};
    use csat_proto::model::Ground;

    use super::*;

    fn grid(size_m: f64) -> Grid {
        Grid::covering(&Ground { size_m: [size_m; 2] }, 2.0)
    }

    fn footprint(pose: Pose, grid: &Grid) -> Footprint {
        within(&PoseError::NONE, pose, grid)
    }

    fn within(error: &PoseError, pose: Pose, grid: &Grid) -> Footprint {
        let view = CameraModel::default().at(&pose);
        Footprint::of(&view, &PoseBox::new(&view, &pose, error), grid)
    }

    /// Poses of the box, at its corners and inside: their footprints have the common one in common.
    #[test]
    fn the_footprint_of_a_box_is_in_that_of_each_of_its_poses() {
        let grid = grid(600.0);
        let mut error = PoseError {
            p_world: [5.0, 3.0, 0.5],
            yaw_rad: 0.08,
            pitch_rad: 0.004,
            roll_rad: 0.006,
        };
        let pose = Pose::level([13.1, -7.2, 52.0], 2.3);
        let common = within(&error, pose, &grid).raster(grid);
        let mut all = footprint(pose, &grid).raster(grid);
        let alone = all.count();
        for corner in 0..64 {
            let sign = |axis: u32| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
            let [x, y, z] = pose.p_world;
            let [dx, dy, dz] = error.p_world;
            let other = Pose {
                p_world: [x + sign(0) * dx, y + sign(1) * dy, z + sign(2) * dz],
                yaw_rad: pose.yaw_rad + sign(3) * error.yaw_rad,
                pitch_rad: sign(4) * error.pitch_rad,
                roll_rad: sign(5) * error.roll_rad,
            };
            all.intersect_with(&footprint(other, &grid).raster(grid));
        }
        let mut lost = all.clone();
        lost.subtract(&common);
        let mut wrong = common.clone();
        wrong.subtract(&all);
        assert_eq!(wrong.count(), 0, "cells that a pose does not see");
        let counts = [common.count(), lost.count(), alone];
        assert!(counts[0] * 3 > counts[2] && counts[1] * 5 < counts[0], "{counts:?}");
        error.yaw_rad = 0.2;
        assert!(within(&error, pose, &grid).raster(grid).count() < common.count());
    }

    /// Every cell, against the camera itself: inside the image and within d_max.
    #[test]
    fn holds_the_cells_the_camera_projects_into_its_image() {
        let grid = grid(800.0);
        for (z, yaw_rad, pitch_rad) in
            [(52.0, 0.3, 0.0), (61.0, 2.0, 0.1), (100.0, -1.2, 0.0), (52.0, 4.0, -0.4)]
        {
            let pose = Pose { pitch_rad, ..Pose::level([13.1, -7.2, z], yaw_rad) };
            let view = CameraModel::default().at(&pose);
            let cells = footprint(pose, &grid).raster(grid);
            let mut wrong = 0;
            for (row, column) in (0..grid.rows).flat_map(|r| (0..grid.columns).map(move |c| (r, c)))
            {
                let [x, y] = grid.centre(column, row);
                let p = Vector3::new(x, y, 0.0);
                let in_image = view
                    .project(&p)
                    .is_some_and(|[c, r]| (0.0..480.0).contains(&c) && (0.0..360.0).contains(&r));
                let seen = in_image && (p - view.centre_world()).norm() <= 300.0;
                wrong += u32::from(seen != cells.get(column, row));
            }
            assert_eq!(wrong, 0, "cells that differ at z {z}");
            assert!(cells.count() > 1000);
        }
    }

    #[test]
    fn area_words_and_barycentre_agree_with_the_polygon() {
        let grid = grid(1000.0);
        let pose = Pose::level([0.0, 0.0, 52.0], 0.7);
        let footprint = footprint(pose, &grid);
        let ring = CameraModel::default().at(&pose).footprint();
        let twice: f64 = (0..ring.len())
            .map(|i| (ring[i], ring[(i + 1) % ring.len()]))
            .map(|(a, b)| a[0] * b[1] - b[0] * a[1])
            .sum();
        let cells = footprint.raster(grid);
        assert!((cells.area_m2() - 0.5 * twice).abs() < 0.005 * twice);
        let mut from_words = Raster::empty(grid);
        for (row, word, bits) in footprint.words() {
            from_words.row_mut(row)[word] |= bits;
        }
        assert_eq!(from_words, cells);
        assert!(cells.iter().all(|(column, row)| footprint.columns(row).contains(&column)));
        let (c, centre) = (centroid(&ring).unwrap(), footprint.barycentre(&grid).unwrap());
        assert!((c[0] - centre[0]).hypot(c[1] - centre[1]) < 0.5, "{c:?} {centre:?}");
    }

    #[test]
    fn a_footprint_outside_the_region_still_has_a_barycentre() {
        let grid = grid(500.0);
        let outside = footprint(Pose::level([-400.0, 0.0, 52.0], std::f64::consts::PI), &grid);
        assert_eq!(outside.words().count(), 0);
        let centre = outside.barycentre(&grid).unwrap();
        assert!(centre[0] < -500.0 && centre[1].abs() < 1.0, "{centre:?}");
        let skyward =
            footprint(Pose { pitch_rad: -1.5, ..Pose::level([0.0, 0.0, 52.0], 0.0) }, &grid);
        assert_eq!((skyward.words().count(), skyward.barycentre(&grid)), (0, None));
    }
}
