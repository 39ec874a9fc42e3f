//! C (4.6): the outline's homography against the pixels' quadrangles.

use csat_agent::sense::clear::clear_ground;
use csat_agent::sense::outline::{ground_outline, simplified_inward};
use csat_proto::camera::{Assumption, CameraModel};
use csat_proto::frame::{Frame, Label};
use csat_proto::region::{Region, Ring};
use csat_tests::geometry::{Pinhole, Point, points_in};
use csat_tests::replay::{for_seeds, is_replay};
use csat_tests::scenes::Case;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn outline(frame: &Frame, model: &CameraModel) -> Vec<Ring> {
    ground_outline(&frame.labels, model.columns.into(), model.rows.into())
}

fn clear(case: &Case, frame: &Frame, tolerance_px: f64, bounds: &Region) -> Region {
    let rings = simplified_inward(&outline(frame, &case.config.camera), tolerance_px);
    clear_ground(&case.config.camera.at(&case.pose), &rings, bounds).into_region()
}

/// Disjoint quadrangles: their areas add up, without any Boolean operation.
fn quadrangles_m2(case: &Case, frame: &Frame) -> f64 {
    let camera = Pinhole::new(&case.config.camera, &case.pose);
    let columns = usize::from(case.config.camera.columns);
    let ground = |pixel: &usize| frame.labels[*pixel] == Label::Ground;
    let quadrangle = |pixel: usize| {
        let (c, r) = ((pixel % columns) as f64, (pixel / columns) as f64);
        let corners = [[c, r], [c + 1.0, r], [c + 1.0, r + 1.0], [c, r + 1.0]];
        let p = corners.map(|q| camera.ground(q).expect("a Ground pixel sees the ground"));
        let twice: f64 = (0..4).map(|i| cross(p[0], p[i], p[(i + 1) % 4])).sum();
        twice.abs() / 2.0
    };
    (0..frame.labels.len()).filter(ground).map(quadrangle).sum()
}

fn cross(o: Point, a: Point, b: Point) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

#[test]
fn clear_ground_is_the_union_of_the_pixels_quadrangles() {
    let everywhere = Region::rectangle([2000.0; 2]);
    let (mut worst, mut compared) = (0.0f64, 0);
    let name = ["measured", "clear_ground_is_the_union_of_the_pixels_quadrangles"];
    for_seeds(name, 0..1500, |seed| {
        let case = Case::level(seed, Assumption::EveryRay);
        let frame = case.frame();
        let (got, expected) =
            (clear(&case, &frame, 0.0, &everywhere).area_m2(), quadrangles_m2(&case, &frame));
        if expected > 0.0 {
            // Corners are rounded to 4 µm: that is all that may be missing.
            let error = (got - expected).abs() / expected;
            assert!(error < 1e-6, "{got} m², expected {expected} m²\n{case:?}");
            (worst, compared) = (worst.max(error), compared + 1);
        }
    });
    println!("area of C in {compared} frames: relative error at most {worst:.1e}");
    assert!(is_replay() || compared > 1000);
}

/// Also clipped by the region, and without its measures: where is it?
#[test]
fn a_point_is_clear_if_its_pixel_is_ground() {
    let (mut inside, mut outside) = (0, 0);
    for_seeds(["measured", "a_point_is_clear_if_its_pixel_is_ground"], 0..400, |seed| {
        let case = Case::level(seed, Assumption::EveryRay);
        let frame = case.frame();
        let model = &case.config.camera;
        let camera = Pinhole::new(model, &case.pose);
        let ground = Region::rectangle(case.config.ground.size_m);
        let got = clear(&case, &frame, 0.0, &ground);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..300 {
            let q = [model.columns, model.rows].map(|n| rng.random_range(0.0..f64::from(n)));
            // Within a hair of a pixel's border, rounding decides.
            let near_border = q.iter().any(|x| (x - x.round()).abs() < 1e-4);
            let Some(p) = camera.ground(q) else { continue };
            if near_border || !case.config.ground.contains(p) {
                continue;
            }
            let pixel = q[1] as usize * usize::from(model.columns) + q[0] as usize;
            let expected = frame.labels[pixel] == Label::Ground;
            assert_eq!(got.contains(p), expected, "{p:?} at {q:?}\n{case:?}");
            *(if expected { &mut inside } else { &mut outside }) += 1;
        }
    });
    println!("{inside} points were clear, {outside} were not");
    assert!(is_replay() || (inside > 10_000 && outside > 10_000));
}

#[test]
fn cutting_corners_only_loses_ground_and_little_of_it() {
    let mut lost_pct = [Vec::new(), Vec::new()];
    let mut corners = [0, 0, 0];
    let name = ["measured", "cutting_corners_only_loses_ground_and_little_of_it"];
    for_seeds(name, 0..600, |seed| {
        let case = Case::level(seed, Assumption::EveryRay);
        let frame = case.frame();
        let ground = Region::rectangle(case.config.ground.size_m);
        let exact = clear(&case, &frame, 0.0, &ground);
        corners[0] += exact.vertex_count();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (i, tolerance_px) in [1.0, 2.0].into_iter().enumerate() {
            let cut = clear(&case, &frame, tolerance_px, &ground);
            for p in points_in(&cut, 100, &mut rng) {
                assert!(exact.distance_m(p) < 1e-5, "{p:?} at {tolerance_px} px\n{case:?}");
            }
            assert!(cut.area_m2() <= exact.area_m2() * (1.0 + 1e-6), "{case:?}");
            corners[i + 1] += cut.vertex_count();
            if exact.area_m2() > 100.0 {
                lost_pct[i].push(100.0 * (1.0 - cut.area_m2() / exact.area_m2()));
            }
        }
    });
    let means = lost_pct.map(|lost| {
        let count = lost.len();
        println!(
            "{count} frames lose {:.2} % on average, {:.1} % at most",
            lost.iter().sum::<f64>() / count as f64,
            lost.iter().copied().fold(0.0, f64::max)
        );
        lost.iter().sum::<f64>() / count as f64
    });
    println!("corners at 0, 1 and 2 px: {corners:?}");
    if !is_replay() {
        assert!(means[0] < 3.0 && means[1] < 8.0, "{means:?} %");
        assert!(2 * corners[1] < corners[0], "{corners:?}");
    }
}
