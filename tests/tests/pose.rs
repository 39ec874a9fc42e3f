//! What a frame proves within a box of poses, against single poses and against interval analysis.

use csat_agent::sense::Sensor;
use csat_experiments::reproduce::chapter6::camera::Footprint;
use csat_experiments::reproduce::chapter6::settings::uncertainties;
use csat_experiments::reproduce::chapter6::sivia::{Algorithm, area, ring};
use csat_proto::camera::{CameraModel, Pose, PoseError};
use csat_proto::frame::{Frame, Label};
use csat_proto::model::Ground;
use csat_proto::time::Step;
use csat_tests::geometry::points_in;
use csat_tests::replay::for_seeds;
use csat_tests::scenes::Case;
use csat_tests::truth::ROUNDING_M;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Poses of a box that are looked from.
const POSES: u32 = 100_000;

fn any_pose(frame: &Frame, rng: &mut ChaCha8Rng) -> Pose {
    let mut off = |half: f64| if half > 0.0 { rng.random_range(-half..=half) } else { 0.0 };
    let (pose, error) = (frame.pose, frame.pose_error);
    let [x, y, z] = pose.p_world;
    let [dx, dy, dz] = error.p_world;
    Pose {
        p_world: [x + off(dx), y + off(dy), z + off(dz)],
        yaw_rad: pose.yaw_rad + off(error.yaw_rad),
        pitch_rad: pose.pitch_rad + off(error.pitch_rad),
        roll_rad: pose.roll_rad + off(error.roll_rad),
    }
}

fn pixel(model: &CameraModel, [c, r]: [f64; 2]) -> Option<usize> {
    let is_inside =
        (0.0..f64::from(model.columns)).contains(&c) && (0.0..f64::from(model.rows)).contains(&r);
    is_inside.then(|| r as usize * usize::from(model.columns) + c as usize)
}

#[test]
fn what_is_clear_is_clear_from_every_pose_and_a_target_is_where_any_pose_has_it() {
    let (mut clear, mut places) = (0, 0);
    let name =
        ["pose", "what_is_clear_is_clear_from_every_pose_and_a_target_is_where_any_pose_has_it"];
    for_seeds(name, 0..60, |seed| {
        let case = Case::random(seed);
        let frame = case.uncertain_frame();
        let model = case.config.camera;
        let measured = Sensor::new(&case.config).measure(&frame);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let ground = points_in(measured.clear_ground.region(), 400, &mut rng);
        let lit: Vec<(usize, u16, u16)> = frame
            .detections
            .iter()
            .enumerate()
            .flat_map(|(j, d)| {
                let [rows, columns] = [d.pixels.rows, d.pixels.columns].map(|[a, b]| a..=b);
                let all = rows.flat_map(move |r| columns.clone().map(move |c| (j, c, r)));
                let index =
                    |c: u16, r: u16| usize::from(r) * usize::from(model.columns) + usize::from(c);
                let is_target =
                    |&(_, c, r): &(usize, u16, u16)| frame.labels[index(c, r)] == Label::Target;
                all.filter(is_target).collect::<Vec<_>>()
            })
            .collect();
        for number in 0..POSES / 50 {
            let view = model.at(&any_pose(&frame, &mut rng));
            if !ground.is_empty() {
                let [x, y] = ground[number as usize % ground.len()];
                let image = view.project(&Vector3::new(x, y, 0.0)).and_then(|p| pixel(&model, p));
                let label = image.map(|index| frame.labels[index]);
                assert_eq!(label, Some(Label::Ground), "({x}, {y}) from {:?}", view.centre_world());
                clear += 1;
            }
            if !lit.is_empty() {
                let (j, c, r) = lit[number as usize % lit.len()];
                let index = usize::from(r) * usize::from(model.columns) + usize::from(c);
                let [near, far] = model.depth_interval_m(frame.depth[index]);
                let ray = view.ray_world(f64::from(c) + 0.5, f64::from(r) + 0.5).normalize();
                let p = view.centre_world() + ray * rng.random_range(near..=far);
                let radius_m = case.config.targets.radius_m;
                let (sin, cos) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
                let p = [p.x + radius_m * cos, p.y + radius_m * sin];
                if case.config.ground.contains(p) {
                    let error_m = measured.targets[j].location.region().distance_m(p);
                    assert!(error_m <= ROUNDING_M, "{p:?} is {error_m} m out of X^tm");
                    places += 1;
                }
            }
        }
    });
    println!("{clear} points of clear ground, {places} places of targets");
    assert!(csat_tests::replay::is_replay() || (clear > 80_000 && places > 30_000));
}

/// The clear ground of a frame whose pixels are Ground in a window of the image and Unknown elsewhere.
fn clear_window(error: &PoseError, pose: Pose, window: [[u16; 2]; 2]) -> csat_agent::region::Inner {
    let mut config = Case::random(0).config;
    config.camera = CameraModel::default();
    config.ground = Ground { size_m: [2000.0; 2] };
    config.estimator.outline_tolerance_px = 0.0;
    config.estimator.raster_cell_m = 10.0;
    let CameraModel { columns, rows, .. } = config.camera;
    let [[c0, c1], [r0, r1]] = window;
    let label = |r: u16, c: u16| match (r0..r1).contains(&r) && (c0..c1).contains(&c) {
        true => Label::Ground,
        false => Label::Unknown,
    };
    let labels: Vec<Label> =
        (0..rows).flat_map(|r| (0..columns).map(move |c| label(r, c))).collect();
    let depth = vec![0; labels.len()];
    let frame =
        Frame { labels, depth, pose_error: *error, ..Frame::of_detector(Step(0), pose, None) };
    Sensor::new(&config).measure(&frame).clear_ground
}

/// Thick SIVIA proves of boxes of ground whether some pose does not see them: none of these is in ours, and ours has
/// no less than the boxes that it proves to be seen from all poses.
#[test]
fn clear_ground_agrees_with_interval_analysis() {
    let camera = CameraModel::default();
    let pose = Pose { pitch_rad: 0.01, roll_rad: -0.02, ..Pose::level([0.0, 0.0, 50.0], 0.0) };
    let whole = [[0, camera.columns], [0, camera.rows]];
    for uncertainty in uncertainties() {
        for window in [whole, [[200, 280], [60, 140]], [[0, 60], [250, 300]]] {
            let ours = clear_window(&uncertainty.error, pose, window);
            let oracle = Footprint::of_window(&camera, window, &pose, &uncertainty.error);
            let paving = oracle.pave([0.0, -130.0], 260.0, 1.0);
            for [x, y] in paving.penumbra.iter().chain(&paving.outside) {
                let middle = [x.middle(), y.middle()];
                assert!(
                    !ours.region().contains(middle),
                    "{middle:?} is not seen from all poses: {} {window:?}",
                    uncertainty.name
                );
            }
            let (ours_m2, theirs_m2) = (ours.region().area_m2(), area(&paving.inside));
            println!("{} {window:?}: {ours_m2:.0} m2, proved {theirs_m2:.0} m2", uncertainty.name);
            assert!(ours_m2 >= 0.99 * theirs_m2, "{} {window:?}", uncertainty.name);
        }
    }
}

/// The counts of boxes of thesis figures A.6, A.7, A.9 and A.10. Those of the border are of halves there.
#[test]
fn set_inversion_makes_the_boxes_of_the_thesis() {
    let counts = |half, algorithm| {
        let paving = ring(half, algorithm);
        let all = [&paving.inside, &paving.penumbra, &paving.outside, &paving.border];
        let sum: f64 = all.map(|cells| area(cells)).iter().sum();
        assert!((sum - 100.0).abs() < 1e-9, "all of the square is paved");
        [paving.inside.len(), paving.penumbra.len(), 2 * paving.border.len()]
    };
    assert_eq!(counts(0.0, Algorithm::Sivia), [304, 0, 920]);
    assert_eq!(counts(0.5, Algorithm::Sivia), [236, 0, 8672]);
    assert_eq!(counts(0.5, Algorithm::ThickOuter), [0, 272, 912]);
    assert_eq!(counts(0.5, Algorithm::ThickInner)[0], 236);
}
