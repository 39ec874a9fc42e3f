//! Whether a camera has enough pixels on a car (docs/concepts/frame.md).
//!
//! Assumption 4 labels a pixel Target only when *every* ray through it meets the car, and a car is
//! identified by `min_pixels` such pixels. So the number that counts is that of pixels wholly inside
//! the outline of the car, at the worst heading, place and alignment with the pixels.

use csat_proto::camera::{CameraModel, CameraView, Pose};
use nalgebra::Vector3;

/// Pixels wholly on a car, at the worst and at the best, at a ground distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarPixels {
    /// Horizontal distance from the UAV, metres.
    pub ground_m: f64,
    /// Distance from the camera, metres.
    pub slant_m: f64,
    /// Fewest pixels over headings and alignments.
    pub worst: u32,
    /// Most pixels.
    pub best: u32,
}

/// What the camera makes of a car over the whole footprint.
#[derive(Debug, Clone, PartialEq)]
pub struct CarCoverage {
    /// Altitude that this is for, metres.
    pub altitude_m: f64,
    /// From the nearest to the farthest ground in the footprint.
    pub distances: Vec<CarPixels>,
}

impl CarCoverage {
    /// The ground distance up to which every car has `min_pixels`; `None` when nowhere.
    pub fn sure_up_to_m(&self, min_pixels: u32) -> Option<f64> {
        let sure = self.distances.iter().take_while(|d| d.worst >= min_pixels);
        sure.last().map(|d| d.ground_m)
    }

    /// The fewest pixels on a car in the footprint.
    pub fn worst(&self) -> Option<&CarPixels> {
        self.distances.iter().min_by_key(|d| d.worst)
    }

    /// The most pixels on a car in the footprint.
    pub fn best(&self) -> Option<&CarPixels> {
        self.distances.iter().max_by_key(|d| d.best)
    }
}

const DISTANCES: u32 = 24;
const HEADINGS: u32 = 8;
/// Shifts of the car by fractions of a pixel, per axis.
const SHIFTS: u32 = 3;

/// Counts the pixels on a car of `body_m` seen from `altitude_m`; `None` when no ground is seen.
pub fn car_coverage(
    camera: &CameraModel,
    altitude_m: f64,
    body_m: [f64; 3],
) -> Option<CarCoverage> {
    let view = camera.at(&Pose::level([0.0, 0.0, altitude_m], 0.0));
    let footprint = view.footprint();
    let reach = footprint.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
    let near = footprint.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min).max(0.0);
    if footprint.len() < 3 || reach <= near {
        return None;
    }
    let distances = (0..DISTANCES)
        .map(|i| {
            // The border itself cuts a car in two: stay a car's length inside.
            let [from, to] = [near + body_m[0], (reach - body_m[0]).max(near + body_m[0])];
            let ground_m = from + (to - from) * f64::from(i) / f64::from(DISTANCES - 1);
            car_pixels(&view, ground_m, body_m)
        })
        .filter(|d| d.best > 0 || d.ground_m < camera.d_max_m)
        .collect();
    Some(CarCoverage { altitude_m, distances })
}

fn car_pixels(view: &CameraView, ground_m: f64, body_m: [f64; 3]) -> CarPixels {
    let slant_m = ground_m.hypot(view.centre_world().z);
    let (mut worst, mut best) = (u32::MAX, 0);
    let metres_per_pixel = slant_m / view.model().focal_px();
    for heading in 0..HEADINGS {
        let heading_rad = std::f64::consts::PI * f64::from(heading) / f64::from(HEADINGS);
        for (dx, dy) in (0..SHIFTS * SHIFTS).map(|i| (i % SHIFTS, i / SHIFTS)) {
            let shift = |d: u32| metres_per_pixel * f64::from(d) / f64::from(SHIFTS);
            let centre = [ground_m + shift(dx), shift(dy)];
            let count = pixels_inside(&outline(view, centre, heading_rad, body_m));
            worst = worst.min(count);
            best = best.max(count);
        }
    }
    CarPixels { ground_m, slant_m, worst, best }
}

/// The convex outline of a car in the image, counter-clockwise. The image is taken to go on beyond
/// its borders: what matters here is the scale.
fn outline(
    view: &CameraView,
    centre: [f64; 2],
    heading_rad: f64,
    body_m: [f64; 3],
) -> Vec<[f64; 2]> {
    let (s, c) = heading_rad.sin_cos();
    let mut points: Vec<[f64; 2]> = (0..8u8)
        .filter_map(|corner| {
            let side = |bit: u8, length: f64| if corner & bit == 0 { -length } else { length };
            let (x, y) = (side(1, body_m[0] / 2.0), side(2, body_m[1] / 2.0));
            let z = if corner & 4 == 0 { 0.0 } else { body_m[2] };
            let p = Vector3::new(centre[0] + c * x - s * y, centre[1] + s * x + c * y, z);
            view.project(&p)
        })
        .collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut hull = half_hull(points.iter());
    hull.extend(half_hull(points.iter().rev()));
    hull
}

/// Andrew's monotone chain, without its last point.
fn half_hull<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Vec<[f64; 2]> {
    let mut chain: Vec<[f64; 2]> = Vec::new();
    for &p in points {
        while let [.., a, b] = chain[..]
            && (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) <= 0.0
        {
            chain.pop();
        }
        chain.push(p);
    }
    chain.pop();
    chain
}

/// The number of unit squares wholly inside a convex outline.
fn pixels_inside(outline: &[[f64; 2]]) -> u32 {
    let rows = outline.iter().map(|p| p[1]);
    let (low, high) =
        rows.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
    if outline.len() < 3 || !(high - low).is_finite() {
        return 0;
    }
    let mut count = 0.0;
    let mut row = low.ceil();
    // A count that no image has room for says it all.
    while row + 1.0 <= high && count < f64::from(u32::MAX) {
        // Inside a convex outline: both the upper and the lower edge of the row of pixels.
        if let (Some(a), Some(b)) = (chord(outline, row), chord(outline, row + 1.0)) {
            count += (a[1].min(b[1]).floor() - a[0].max(b[0]).ceil()).max(0.0);
        }
        row += 1.0;
    }
    count as u32
}

/// Where a horizontal line crosses a convex outline.
fn chord(outline: &[[f64; 2]], y: f64) -> Option<[f64; 2]> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for (i, a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        if (a[1] - y) * (b[1] - y) <= 0.0 && a[1] != b[1] {
            let x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            (left, right) = (left.min(x), right.max(x));
        }
    }
    (left <= right).then_some([left, right])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAR: [f64; 3] = [4.6, 1.8, 1.5];

    #[test]
    fn unit_squares_in_outlines_are_counted() {
        assert_eq!(pixels_inside(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]), 12);
        assert_eq!(pixels_inside(&[[0.5, 0.5], [4.5, 0.5], [4.5, 3.5], [0.5, 3.5]]), 6);
        assert_eq!(pixels_inside(&[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]), 6);
        assert_eq!(pixels_inside(&[]), 0);
    }

    #[test]
    fn fewer_pixels_farther_away_and_none_for_a_toy_camera() {
        let camera = CameraModel::default();
        let near = car_coverage(&camera, 52.0, CAR).unwrap();
        let (first, last) = (near.distances[0], near.distances[DISTANCES as usize - 1]);
        assert!(first.worst > 5 * last.worst && last.worst <= last.best, "{first:?} {last:?}");
        let toy = CameraModel { columns: 24, rows: 18, ..camera };
        assert_eq!(car_coverage(&toy, 52.0, CAR).unwrap().worst().unwrap().worst, 0);
    }

    #[test]
    fn a_camera_that_looks_up_has_no_coverage() {
        let camera = CameraModel { tilt_deg: -60.0, ..CameraModel::default() };
        assert_eq!(car_coverage(&camera, 52.0, CAR), None);
    }
}
