//! C (4.6): the homography of the outline against the quadrangles of the pixels, up to the inset of
//! the outline.

use csat_agent::sense::clear::clear_ground;
use csat_agent::sense::outline::{UNITS_PER_PX, ground_outline, simplified_inward};
use csat_proto::camera::{Assumption, CameraModel};
use csat_proto::frame::{Frame, Label};
use csat_proto::region::{Region, Ring, metres};
use csat_tests::geometry::{Pinhole, Point, distance_m, edges, points_in};
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

/// The inset of the outline within the border of the Ground pixels, pixels.
const INSET_PX: f64 = 1.0 / UNITS_PER_PX as f64;

/// Rectangles [c0, r0, c1, r1] of the image whose signed areas are one Ground pixel without the inset
/// along its border to other pixels: the pixel without these sides, minus the corners where only the
/// diagonal neighbour is not Ground.
fn parts(frame: &Frame, model: &CameraModel, pixel: usize) -> Vec<([f64; 4], f64)> {
    let (columns, rows) = (i32::from(model.columns), i32::from(model.rows));
    let (c, r) = (pixel as i32 % columns, pixel as i32 / columns);
    let is_ground = |dc: i32, dr: i32| {
        let (c, r) = (c + dc, r + dr);
        (0..columns).contains(&c)
            && (0..rows).contains(&r)
            && frame.labels[(r * columns + c) as usize] == Label::Ground
    };
    let inset = |dc: i32, dr: i32| if is_ground(dc, dr) { 0.0 } else { INSET_PX };
    let (west, south) = (f64::from(c), f64::from(r));
    let (east, north) = (west + 1.0, south + 1.0);
    let whole =
        [west + inset(-1, 0), south + inset(0, -1), east - inset(1, 0), north - inset(0, 1)];
    let mut parts = vec![(whole, 1.0)];
    for (dc, dr) in [(-1, -1), (1, -1), (1, 1), (-1, 1)] {
        if is_ground(dc, 0) && is_ground(0, dr) && !is_ground(dc, dr) {
            let c0 = if dc < 0 { west } else { east - INSET_PX };
            let r0 = if dr < 0 { south } else { north - INSET_PX };
            parts.push(([c0, r0, c0 + INSET_PX, r0 + INSET_PX], -1.0));
        }
    }
    parts
}

/// The sum of the areas of disjoint quadrangles, without Boolean operations.
fn quadrangles_m2(case: &Case, frame: &Frame) -> f64 {
    let model = &case.config.camera;
    let camera = Pinhole::new(model, &case.pose);
    let quadrangle = |([c0, r0, c1, r1], sign): ([f64; 4], f64)| {
        let corners = [[c0, r0], [c1, r0], [c1, r1], [c0, r1]];
        let p = corners.map(|q| camera.ground(q).expect("a Ground pixel sees the ground"));
        let twice: f64 = (0..4).map(|i| cross(p[0], p[i], p[(i + 1) % 4])).sum();
        sign * twice.abs() / 2.0
    };
    let ground = (0..frame.labels.len()).filter(|&pixel| frame.labels[pixel] == Label::Ground);
    ground.flat_map(|pixel| parts(frame, model, pixel)).map(quadrangle).sum()
}

fn perimeter_m(region: &Region) -> f64 {
    let rings = region.rings().map(|ring| ring.iter().map(|&p| metres(p)).collect::<Vec<_>>());
    rings.map(|ring| edges(&ring).map(|[a, b]| distance_m(a, b)).sum::<f64>()).sum()
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
        let region = clear(&case, &frame, 0.0, &everywhere);
        let (got, expected) = (region.area_m2(), quadrangles_m2(&case, &frame));
        // Corners are rounded to 4 µm: no edge moves more than that.
        let rounding_m2 = 4e-6 * perimeter_m(&region) + 1e-9 * expected;
        let error_m2 = (got - expected).abs();
        assert!(error_m2 <= rounding_m2, "{got} m², expected {expected} m²\n{case:?}");
        if expected > 100.0 {
            let error = error_m2 / expected;
            assert!(error < 1e-6, "{got} m², expected {expected} m²\n{case:?}");
            (worst, compared) = (worst.max(error), compared + 1);
        }
    });
    println!("area of C in {compared} frames: relative error at most {worst:.1e}");
    assert!(is_replay() || compared > 1000);
}

/// The same by points instead of areas, also where the region clips it.
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
            // Within the inset, and slightly beyond it where rounding decides.
            let near_border = q.iter().any(|x| (x - x.round()).abs() < INSET_PX + 1e-4);
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

/// The loss of area by cutting corners, over many frames.
#[derive(Default)]
struct Loss {
    exact_m2: f64,
    cut_m2: f64,
    exact_corners: usize,
    cut_corners: usize,
}

impl Loss {
    fn add(&mut self, case: &Case, frame: &Frame, tolerance_px: f64) {
        let ground = Region::rectangle(case.config.ground.size_m);
        let exact = clear(case, frame, 0.0, &ground);
        let cut = clear(case, frame, tolerance_px, &ground);
        let mut rng = ChaCha8Rng::seed_from_u64(case.seed);
        for p in points_in(&cut, 100, &mut rng) {
            assert!(exact.distance_m(p) < 1e-5, "{p:?} at {tolerance_px} px\n{case:?}");
        }
        self.exact_m2 += exact.area_m2();
        self.cut_m2 += cut.area_m2();
        self.exact_corners += exact.vertex_count();
        self.cut_corners += cut.vertex_count();
    }

    fn pct(&self) -> f64 {
        100.0 * (1.0 - self.cut_m2 / self.exact_m2)
    }

    fn report(&self, what: &str) {
        let (pct, exact, cut) = (self.pct(), self.exact_corners, self.cut_corners);
        println!("{what}: {pct:.2} % of the ground lost, {exact} corners become {cut}");
    }
}

#[test]
fn cutting_corners_only_loses_ground_and_little_of_it() {
    let (mut one, mut two, mut full) = (Loss::default(), Loss::default(), Loss::default());
    let name = ["measured", "cutting_corners_only_loses_ground_and_little_of_it"];
    for_seeds(name, 0..600, |seed| {
        let mut case = Case::level(seed, Assumption::EveryRay);
        let frame = case.frame();
        one.add(&case, &frame, 1.0);
        two.add(&case, &frame, 2.0);
        if seed % 30 == 0 {
            (case.config.camera.columns, case.config.camera.rows) = (480, 360);
            full.add(&case, &case.frame(), 1.0);
        }
    });
    one.report("about 64 x 48 pixels, 1 px");
    two.report("about 64 x 48 pixels, 2 px");
    full.report("480 x 360 pixels, 1 px");
    if !is_replay() {
        assert!(one.pct() < 6.0 && two.pct() < 10.0 && full.pct() < 1.2);
        assert!(2 * one.cut_corners < one.exact_corners);
        assert!(5 * full.cut_corners < full.exact_corners);
    }
}
