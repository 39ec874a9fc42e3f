//! S° (4.7), (4.12) and exclusions (4.17): intersections of discs, point by point.

use csat_agent::sense::Sensor;
use csat_agent::sense::exclusion::disc_intersection;
use csat_agent::sense::pyramid::ground_corners;
use csat_proto::frame::{Frame, Label};
use csat_proto::region::Region;
use csat_tests::geometry::{Point, distance_m, points_in};
use csat_tests::replay::{for_seeds, is_replay};
use csat_tests::scenes::Case;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn farthest_m(points: &[Point], p: Point) -> f64 {
    points.iter().map(|&q| distance_m(p, q)).fold(0.0, f64::max)
}

#[test]
fn an_intersection_of_discs_lies_between_the_inscribed_and_the_whole() {
    let (mut in_whole, mut in_inscribed, mut none) = (0, 0, 0);
    let name = ["measured", "an_intersection_of_discs_lies_between_the_inscribed_and_the_whole"];
    for_seeds(name, 0..4000, |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (radius_m, n) = (rng.random_range(1.0..9.0), [8u16, 16, 24][seed as usize % 3]);
        let spread_m = radius_m * rng.random_range(0.0..2.5);
        let at = [rng.random_range(-70.0..70.0), rng.random_range(-70.0..70.0)];
        let count = rng.random_range(1..12);
        let points: Vec<Point> = (0..count)
            .map(|_| at.map(|x: f64| x + rng.random_range(-0.5..0.5) * spread_m))
            .collect();
        let ring = disc_intersection(&points, radius_m, n);
        // Discs of this radius fit into the inscribed polygons, rounding included.
        let inscribed_m = radius_m * (std::f64::consts::PI / f64::from(n)).cos() - 2e-5;
        none += u32::from(ring.is_none());
        let region = ring.map_or(Region::EMPTY, |r| Region::from_shapes(vec![vec![r]]));
        for _ in 0..60 {
            let p = at.map(|x| x + rng.random_range(-1.1..1.1) * radius_m);
            let inside = region.contains(p);
            if inside {
                in_whole += 1;
                assert!(farthest_m(&points, p) <= radius_m, "{p:?} of {points:?}");
            }
            // An intersection that does not contain the middle of its points may be left out.
            if !region.is_empty() && farthest_m(&points, p) < inscribed_m {
                in_inscribed += 1;
                assert!(inside, "{p:?} of {points:?}, {radius_m} m");
            }
        }
        if region.is_empty() {
            let middle = |axis: usize| {
                let values = points.iter().map(|p| p[axis]);
                values.clone().fold(f64::INFINITY, f64::min) / 2.0
                    + values.fold(f64::NEG_INFINITY, f64::max) / 2.0
            };
            assert!(farthest_m(&points, [middle(0), middle(1)]) >= inscribed_m, "{points:?}");
        }
    });
    println!("{in_whole} points inside, {in_inscribed} must be, {none} intersections empty");
    assert!(is_replay() || (in_inscribed > 20_000 && none > 100));
}

/// The points of the ground under the hull of a pyramid that no Ground pixel shows, sampled densely
/// along and across the direction away from the camera.
fn unseen(case: &Case, frame: &Frame, corners: &[Point]) -> Vec<Point> {
    const ALONG: usize = 40;
    let model = &case.config.camera;
    let view = model.at(&case.pose);
    let is_seen = |p: &Point| {
        view.project(&Vector3::new(p[0], p[1], 0.0)).is_some_and(|[c, r]| {
            let inside = c >= 0.0 && r >= 0.0 && c < model.columns.into() && r < model.rows.into();
            inside
                && frame.labels[r as usize * usize::from(model.columns) + c as usize]
                    == Label::Ground
        })
    };
    // Corners come in pairs: the near end and the far end of a ray.
    let ends: Vec<[Point; 2]> = corners.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    let along = |[near, far]: [Point; 2], i: usize| {
        let share = i as f64 / ALONG as f64;
        [0, 1].map(|axis| near[axis] + share * (far[axis] - near[axis]))
    };
    let on_rays = ends.iter().flat_map(|&ends| (0..=ALONG).map(move |i| along(ends, i)));
    on_rays.filter(|p| !is_seen(p)).collect()
}

/// The pyramids of all Obstacle pixels.
fn pyramids(case: &Case, frame: &Frame) -> Vec<Vec<Point>> {
    let view = case.config.camera.at(&case.pose);
    let columns = usize::from(case.config.camera.columns);
    let obstacle = |pixel: &usize| frame.labels[*pixel] == Label::Obstacle;
    let pixels = (0..frame.labels.len()).filter(obstacle);
    let corners = |pixel: usize| {
        let depth_m = case.config.camera.depth_interval_m(frame.depth[pixel]);
        ground_corners(&view, (pixel % columns) as u16, (pixel / columns) as u16, depth_m)
    };
    pixels.map(corners).collect()
}

#[test]
fn every_point_of_the_margin_is_near_all_that_may_have_lit_some_pixel() {
    let (mut checked, mut reached, mut possible) = (0, 0, 0);
    let name = ["measured", "every_point_of_the_margin_is_near_all_that_may_have_lit_some_pixel"];
    for_seeds(name, 0..800, |seed| {
        let case = Case::random(seed);
        let frame = case.frame();
        let pyramids = pyramids(&case, &frame);
        let mut sensor = Sensor::new(&case.config);
        let margin = sensor.measure(&frame).obstacle_margin;
        let radius_m = case.config.targets.obstacle_distance_m;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for p in points_in(margin.region(), 60, &mut rng) {
            let near =
                |points: &Vec<Point>| !points.is_empty() && farthest_m(points, p) <= radius_m;
            let near_unseen = |corners: &Vec<Point>| near(&unseen(&case, &frame, corners));
            let is_near = pyramids.iter().any(near) || pyramids.iter().any(near_unseen);
            assert!(is_near, "{p:?} is near no pixel's pyramid\n{case:?}");
            checked += 1;
        }
        // The set is not too small either: it contains most of what the inscribed discs prove.
        for corners in pyramids.iter().step_by(20) {
            let sum = corners.iter().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
            let middle = sum.map(|x: f64| x / corners.len() as f64);
            if case.config.ground.contains(middle) && farthest_m(corners, middle) < 0.4 * radius_m {
                possible += 1;
                reached += u32::from(margin.region().contains(middle));
            }
        }
    });
    println!(
        "{checked} points of S°; {reached} of {possible} well-seen pixels have their middle in it"
    );
    assert!(is_replay() || (checked > 5000 && possible > 500));
    assert!(is_replay() || reached * 100 > possible * 95, "{reached} of {possible}");
}

#[test]
fn an_exclusion_is_near_all_of_its_target_set() {
    let (mut checked, mut exclusions, mut farther) = (0, 0, 0);
    let name = ["measured", "an_exclusion_is_near_all_of_its_target_set"];
    for_seeds(name, 0..1500, |seed| {
        let case = Case::random(seed);
        let measured = Sensor::new(&case.config).measure(&case.frame());
        let radius_m = case.config.targets.target_distance_m;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for seen in &measured.targets {
            let places = points_in(seen.location.region(), 60, &mut rng).into_iter();
            let (in_the_open, locations): (Vec<Point>, Vec<Point>) =
                places.partition(|&p| measured.clear_ground.region().contains(p));
            exclusions += u32::from(!seen.exclusion.is_empty());
            for p in points_in(seen.exclusion.region(), 30, &mut rng) {
                let distance_m = farthest_m(&locations, p);
                assert!(distance_m <= radius_m, "{p:?} is {distance_m} m away\n{case:?}");
                checked += 1;
                farther += u32::from(farthest_m(&in_the_open, p) > radius_m);
            }
        }
    });
    println!("{checked} points of {exclusions} exclusions, {farther} thanks to clear ground");
    assert!(is_replay() || (checked > 10_000 && exclusions > 300 && farther > 1000));
}
