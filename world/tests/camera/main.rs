//! The renderer against the oracle, pixel by pixel, and the properties of frames.

mod check;
mod frames;
mod scenes;
mod views;

use check::{Check, Count};
use csat_proto::camera::{CameraModel, Pose};
use csat_world::camera::Renderer;
use csat_world::scene::Scene;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Checks one view; `k` as in [`Check::grid`].
pub fn check_view(name: String, scene: &Scene, model: CameraModel, pose: Pose, k: usize) -> Count {
    let mut renderer = Renderer::new(model);
    let seen = renderer.render(scene, &pose).clone();
    let check = Check::new(name, scene, &renderer, pose);
    check.edges(&seen, 1, 4);
    check.grid(&seen, k)
}

/// How a sweep draws the pose of the camera.
type Draw = fn(&mut ChaCha8Rng, &Scene) -> Pose;

fn sweep(seeds: std::ops::Range<u64>, draw: Draw, columns: u16, rows: u16, k: usize) -> Count {
    let mut total = Count::default();
    for seed in seeds {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let side = rng.random_range(1..6);
        let scene = scenes::town(&mut rng, side);
        if scene.prisms.is_empty() {
            continue;
        }
        let model = scenes::model(&mut rng, columns, rows);
        for _ in 0..2 {
            let pose = draw(&mut rng, &scene);
            total.add(check_view(format!("seed {seed}"), &scene, model, pose, k));
        }
    }
    println!(
        "{columns} x {rows}: {} pixels, {:.2} % known, {:.3} % needlessly Unknown, {:.4} % without \
         an explanation",
        total.pixels,
        100.0 * total.share(total.known),
        100.0 * total.share(total.conservative),
        100.0 * total.share(total.unexplained)
    );
    total
}

#[test]
fn small_images_agree_with_the_oracle() {
    let total = sweep(0..600, scenes::pose, 48, 36, 4);
    assert!(total.share(total.conservative) < 0.05, "{total:?}");
    assert!(total.share(total.unexplained) < 0.005, "{total:?}");
}

#[test]
fn full_images_agree_with_the_oracle() {
    let total = sweep(10_000..10_004, scenes::pose, 480, 360, 4);
    assert!(total.share(total.conservative) < 0.02, "{total:?}");
    assert!(total.share(total.unexplained) < 0.001, "{total:?}");
}

/// Some of the tops are above the camera.
#[test]
fn cameras_among_towers_agree_with_the_oracle() {
    let total = sweep(20_000..20_500, scenes::pose_among, 48, 36, 4);
    assert!(total.share(total.known) > 0.3, "{total:?}");
    assert!(total.share(total.conservative) < 0.06, "{total:?}");
    assert!(total.share(total.unexplained) < 0.006, "{total:?}");
    let full = sweep(30_000..30_003, scenes::pose_among, 480, 360, 4);
    assert!(full.share(full.conservative) < 0.02, "{full:?}");
}
