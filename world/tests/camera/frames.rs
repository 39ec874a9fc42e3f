//! What a frame promises: noise bounds, detections, determinism.

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::frame::{Detection, Frame, Label, PixelBox};
use csat_proto::ids::{AgentId, TargetId};
use csat_proto::time::Step;
use csat_world::camera::Renderer;
use csat_world::camera::oracle::{Hit, Oracle};
use csat_world::scene::{Entity, Scene};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scenes::{self, Town};

const MODEL: CameraModel = CameraModel {
    columns: 96,
    rows: 72,
    aperture_deg: 45.0,
    tilt_deg: 30.0,
    d_max_m: 150.0,
    depth_noise: [-0.01, 0.01],
    min_pixels: 3,
    box_error_px: 0,
    assumption: csat_proto::camera::Assumption::EveryRay,
    misidentify: 0.0,
};

fn town(seed: u64) -> (Scene, Pose) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scene = scenes::town(&mut rng, 4);
    let mut pose = scenes::pose(&mut rng, &scene);
    // From just outside the town, looking at its middle.
    let [x, y, _] = pose.p_world;
    pose = Pose { yaw_rad: f64::atan2(-y, -x), ..pose };
    (scene, pose)
}

fn frame(
    model: CameraModel,
    scene: &Scene,
    pose: &Pose,
    step: u32,
    seed: u64,
    agent: u16,
) -> Frame {
    Renderer::new(model).frame(scene, pose, Step(step), seed, AgentId(agent))
}

#[test]
fn true_distance_is_in_the_depth_interval() {
    let mut pixels = 0;
    for depth_noise in [[-0.01, 0.01], [0.0, 0.0], [-0.2, 0.05]] {
        let model = CameraModel { depth_noise, ..MODEL };
        let mut relative = [f64::INFINITY, f64::NEG_INFINITY];
        for seed in 0..12 {
            let (scene, pose) = town(seed);
            let oracle = Oracle::new(&scene);
            let view = model.at(&pose);
            let frame = frame(model, &scene, &pose, 3, seed, 1);
            for (pixel, label) in frame.labels.iter().enumerate() {
                if *label == Label::Unknown {
                    assert_eq!(frame.depth[pixel], 0);
                    continue;
                }
                let (c, r) = ((pixel % 96) as f64 + 0.5, (pixel / 96) as f64 + 0.5);
                let (hit, rho_m) = oracle.cast_image(&view, c, r).expect("not sky");
                assert_eq!(hit.label(), *label, "seed {seed}, pixel {pixel}");
                let [low, high] = model.depth_interval_m(frame.depth[pixel]);
                assert!(low <= rho_m && rho_m <= high, "seed {seed}: {rho_m} m in [{low}, {high}]");
                let w = f64::from(frame.depth[pixel]) * model.depth_step_m() / rho_m - 1.0;
                relative = [relative[0].min(w), relative[1].max(w)];
                pixels += 1;
            }
        }
        // The whole interval of noise is used.
        let [low, high] = depth_noise;
        let slack = 0.01 * (high - low) + 1e-3;
        assert!(relative[0] < low + slack && relative[1] > high - slack, "{relative:?}");
    }
    assert!(pixels > 50_000, "{pixels}");
}

#[test]
fn noise_beyond_d_max_makes_unknown() {
    let scene = Scene::default();
    let pose = Pose::level([0.0, 0.0, 40.0], 0.0);
    let model = CameraModel { depth_noise: [-0.05, 0.05], ..MODEL };
    let clean = Renderer::new(model).render(&scene, &pose).clone();
    let noisy = frame(model, &scene, &pose, 0, 7, 0);
    let mut lost = 0;
    for (pixel, label) in noisy.labels.iter().enumerate() {
        if *label != clean.labels()[pixel] {
            assert_eq!(*label, Label::Unknown);
            assert!(clean.rho_m(pixel) * 1.05 > MODEL.d_max_m);
            lost += 1;
        }
    }
    assert!(lost > 10, "{lost}");
}

#[test]
fn frames_depend_on_arguments_alone() {
    let (scene, pose) = town(5);
    let one = frame(MODEL, &scene, &pose, 3, 11, 1);
    let mut used = Renderer::new(MODEL);
    let (other, elsewhere) = town(6);
    used.frame(&other, &elsewhere, Step(2), 11, AgentId(0));
    assert_eq!(used.frame(&scene, &pose, Step(3), 11, AgentId(1)), one);
    for (step, seed, agent) in [(4, 11, 1), (3, 12, 1), (3, 11, 2)] {
        let differs = frame(MODEL, &scene, &pose, step, seed, agent);
        assert_ne!(differs.depth, one.depth, "step {step}, seed {seed}, agent {agent}");
    }
}

/// The smallest box around the Target pixels of `target`, and their number.
fn true_box(frame: &Frame, scene: &Scene, target: TargetId) -> Option<(PixelBox, u32)> {
    let oracle = Oracle::new(scene);
    let view = MODEL.at(&frame.pose);
    let mut found: Option<(PixelBox, u32)> = None;
    for (pixel, _) in frame.labels.iter().enumerate().filter(|(_, l)| **l == Label::Target) {
        let (column, row) = ((pixel % 96) as u16, (pixel / 96) as u16);
        let hit = oracle.cast_image(&view, f64::from(column) + 0.5, f64::from(row) + 0.5);
        if hit.is_none_or(|(hit, _)| hit != Hit::Solid(Entity::Target(target))) {
            continue;
        }
        let (pixels, count) =
            found.get_or_insert((PixelBox { columns: [column; 2], rows: [row; 2] }, 0));
        pixels.columns = [pixels.columns[0].min(column), pixels.columns[1].max(column)];
        pixels.rows = [pixels.rows[0].min(row), pixels.rows[1].max(row)];
        *count += 1;
    }
    found
}

fn car_park() -> Scene {
    let mut town = Town::default();
    for j in 0..8 {
        let j = f64::from(j);
        town.add_car([25.0 + 8.0 * j, 12.0 * (0.5 * j).sin()], 0.7 * j);
    }
    town.scene
}

#[test]
fn detections_are_the_boxes_of_what_has_enough_pixels() {
    let scene = car_park();
    let model = CameraModel { min_pixels: 6, ..MODEL };
    let (mut detected, mut missed) = (0, 0);
    for k in 0..20 {
        let pose = Pose::level([f64::from(k) - 10.0, 0.0, 30.0], 0.02 * f64::from(k));
        let frame = frame(model, &scene, &pose, k, 1, 0);
        let expected: Vec<Detection> = (0..8)
            .filter_map(|j| true_box(&frame, &scene, TargetId(j)).map(|(p, n)| (j, p, n)))
            .inspect(|(_, _, n)| missed += u32::from(*n < 6))
            .filter(|(_, _, n)| *n >= 6)
            .map(|(j, pixels, _)| Detection { target: TargetId(j), pixels })
            .collect();
        assert_eq!(frame.detections, expected, "step {k}");
        detected += expected.len();
    }
    assert!(detected > 40 && missed > 5, "{detected} detected, {missed} too small");
}

/// (3.53) under displacement: at least one Target pixel of the target stays in its box.
#[test]
fn displaced_boxes_still_meet_their_target() {
    let scene = car_park();
    let mut moved = 0;
    for error in [1, 3, 40, u16::MAX] {
        let model = CameraModel { box_error_px: error, ..MODEL };
        for k in 0..40 {
            let pose = Pose::level([f64::from(k % 20) - 10.0, 0.0, 30.0], 0.02 * f64::from(k));
            let frame = frame(model, &scene, &pose, k, 1, 0);
            let exact = self::frame(MODEL, &scene, &pose, k, 1, 0);
            assert_eq!(exact.labels, frame.labels, "boxes do not change labels");
            assert_eq!(exact.detections.len(), frame.detections.len());
            let oracle = Oracle::new(&scene);
            let view = model.at(&pose);
            for (found, exact) in frame.detections.iter().zip(&exact.detections) {
                moved += u32::from(found != exact);
                let PixelBox { columns, rows } = found.pixels;
                assert!(columns[0] <= columns[1] && columns[1] < 96, "{found:?}");
                assert!(rows[0] <= rows[1] && rows[1] < 72, "{found:?}");
                for (side, true_side) in
                    [(columns, exact.pixels.columns), (rows, exact.pixels.rows)]
                {
                    let shift = (0..2).map(|i| side[i].abs_diff(true_side[i])).max();
                    assert!(shift <= Some(error), "{found:?} of {exact:?}");
                }
                let own = |column: u16, row: u16| {
                    let pixel = usize::from(row) * 96 + usize::from(column);
                    let hit =
                        oracle.cast_image(&view, f64::from(column) + 0.5, f64::from(row) + 0.5);
                    frame.labels[pixel] == Label::Target
                        && hit
                            .is_some_and(|(hit, _)| hit == Hit::Solid(Entity::Target(found.target)))
                };
                let mut inside = (rows[0]..=rows[1])
                    .flat_map(|row| (columns[0]..=columns[1]).map(move |column| (column, row)));
                assert!(inside.any(|(column, row)| own(column, row)), "step {k}: {found:?}");
            }
        }
    }
    assert!(moved > 100, "{moved}");
}
