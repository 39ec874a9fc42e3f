//! X^{t,m} (4.4): it contains every location of the cylinder that explains a pixel, and little else.

use csat_agent::sense::Sensor;
use csat_proto::camera::Assumption;
use csat_proto::frame::{Detection, Frame, Label};
use csat_tests::geometry::{Pinhole, Point, distance_to_segment_m, points_in};
use csat_tests::replay::{for_seeds, is_replay};
use csat_tests::scenes::Case;
use csat_tests::truth::ROUNDING_M;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The Target pixels of a detection's box, as (column, row, depth interval).
fn pixels(case: &Case, frame: &Frame, seen: &Detection) -> Vec<(u16, u16, [f64; 2])> {
    let model = &case.config.camera;
    let [rows, columns] = [seen.pixels.rows, seen.pixels.columns].map(|[a, b]| a..=b);
    let all = rows.flat_map(|row| columns.clone().map(move |column| (column, row)));
    let index = |c: u16, r: u16| usize::from(r) * usize::from(model.columns) + usize::from(c);
    all.filter(|&(c, r)| frame.labels[index(c, r)] == Label::Target)
        .map(|(c, r)| (c, r, model.depth_interval_m(frame.depth[index(c, r)])))
        .collect()
}

/// Ground projections of points that may have lit a pixel, sampled: `k` x `k` rays and depths along
/// each.
fn lit(case: &Case, pixel: &(u16, u16, [f64; 2]), k: usize) -> Vec<Point> {
    let camera = Pinhole::new(&case.config.camera, &case.pose);
    let (column, row, [near, far]) = *pixel;
    let centre_only = case.config.camera.assumption == Assumption::CentreRay;
    let part = |i: usize| if centre_only { 0.5 } else { i as f64 / (k - 1) as f64 };
    let mut points = Vec::new();
    for (i, j, d) in (0..k * k * k).map(|n| (n % k, n / k % k, n / k / k)) {
        let q = [f64::from(column) + part(i), f64::from(row) + part(j)];
        let distance_m = near + (far - near) * d as f64 / (k - 1) as f64;
        let p = camera.point_at(q, distance_m);
        points.push([p.x, p.y]);
    }
    points
}

#[test]
fn every_placement_that_explains_a_pixel_is_in_the_target_set() {
    let mut checked = 0;
    let name = ["measured", "every_placement_that_explains_a_pixel_is_in_the_target_set"];
    for_seeds(name, 0..1500, |seed| {
        let mut case = Case::random(seed);
        case.pose.roll_rad = 0.0;
        let frame = case.frame();
        let measured = Sensor::new(&case.config).measure(&frame);
        let radius_m = case.config.targets.radius_m;
        for (seen, detection) in measured.targets.iter().zip(&frame.detections) {
            let pixels = pixels(&case, &frame, detection);
            for pixel in pixels.iter().step_by(pixels.len().div_ceil(6)) {
                for (i, lit) in lit(&case, pixel, 3).into_iter().enumerate() {
                    // The location is within r^t of the lit point: check the circle.
                    for k in 0..5 {
                        let (sin, cos) = (f64::from(k) * 1.2566 + i as f64).sin_cos();
                        let p = [lit[0] + radius_m * cos, lit[1] + radius_m * sin];
                        if case.config.ground.contains(p) {
                            let error_m = seen.location.region().distance_m(p);
                            assert!(error_m <= ROUNDING_M, "{p:?}: {error_m} m\n{case:?}");
                            checked += 1;
                        }
                    }
                }
            }
        }
    });
    println!("{checked} placements");
    assert!(is_replay() || checked > 200_000);
}

/// Distance from a point to the hull of the pyramid of a pixel on the ground, by the segments between
/// all of its corners.
fn distance_to_lit_m(corners: &[Point], p: Point) -> f64 {
    let pairs = corners.iter().flat_map(|&a| corners.iter().map(move |&b| [a, b]));
    pairs.map(|segment| distance_to_segment_m(p, segment)).fold(f64::INFINITY, f64::min)
}

/// How far the hull of a row of pixels may exceed the pyramid of one pixel, metres: the difference of
/// their depths.
fn row_slack_m(pixels: &[(u16, u16, [f64; 2])]) -> f64 {
    let spread = |row: u16, end: usize| {
        let depths = pixels.iter().filter(|p| p.1 == row).map(|p| p.2[end]);
        let [low, high] =
            depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], d| [l.min(d), h.max(d)]);
        high - low
    };
    pixels.iter().map(|p| spread(p.1, 0).max(spread(p.1, 1))).fold(0.0, f64::max)
}

#[test]
fn a_target_set_reaches_no_farther_than_it_must() {
    let (mut vertices, mut sampled, mut needless) = (0, 0, 0);
    let mut worst = f64::NEG_INFINITY;
    for_seeds(["measured", "a_target_set_reaches_no_farther_than_it_must"], 0..1000, |seed| {
        let mut case = Case::random(seed);
        case.pose.roll_rad = 0.0;
        case.config.estimator.simplify_m = [0.0, 0.15][seed as usize % 2];
        case.config.estimator.disc_vertices = 16;
        let frame = case.frame();
        let measured = Sensor::new(&case.config).measure(&frame);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (seen, detection) in measured.targets.iter().zip(&frame.detections) {
            let pixels = pixels(&case, &frame, detection);
            let pyramids: Vec<Vec<Point>> =
                pixels.iter().map(|pixel| lit(&case, pixel, 2)).collect();
            let nearest = |p: Point| {
                pyramids.iter().map(|c| distance_to_lit_m(c, p)).fold(f64::INFINITY, f64::min)
            };
            let disc_m = 1.05 * case.config.targets.radius_m;
            let limit_m = disc_m + 3.0 * case.config.estimator.simplify_m + row_slack_m(&pixels);
            for v in seen.location.region().rings().flatten() {
                let p = csat_proto::region::metres(*v);
                let excess_m = nearest(p) - limit_m;
                assert!(excess_m <= 0.05, "{p:?} reaches {excess_m} m too far\n{case:?}");
                worst = worst.max(excess_m);
                vertices += 1;
            }
            for p in points_in(seen.location.region(), 40, &mut rng) {
                // Inside a pyramid counts as near: its half-width is far below r^t.
                needless += u32::from(nearest(p) > case.config.targets.radius_m);
                sampled += 1;
            }
        }
    });
    let share = 100.0 * f64::from(needless) / f64::from(sampled);
    println!("{vertices} corners, excess at most {worst:.3} m; {share:.2} % of the area needless");
    assert!(is_replay() || (vertices > 5000 && share < 10.0), "{share} %");
}
