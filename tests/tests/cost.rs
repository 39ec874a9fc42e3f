//! The work of a mission is bounded for every legal scenario, by counts instead of a clock.

use csat_agent::work::{self, Work};
use csat_experiments::scenario::Loaded;
use csat_tests::drawn::{self, largest_set};
use csat_tests::flight::Flight;

/// Edges that an agent may hand to Boolean operations in a step, per vertex that a set may have.
const EDGES_PER_VERTEX: u64 = 40;
/// Edges times metres that it may sweep in a step, per vertex that a set may have.
const SWEPT_M_PER_VERTEX: f64 = 20.0;

/// Flies the first `steps` and checks that the work of every step of the fleet is within the bounds
/// for its number of sets and vertices. Returns the most work in a step.
fn fly(name: &str, loaded: Loaded, steps: u32) -> Work {
    let Loaded { scenario, world, .. } = loaded;
    let steps = steps.min(scenario.steps());
    let mut flight = Flight::in_world(&scenario, world);
    let (mut most, mut largest) = (Work::default(), 0);
    work::take();
    for _ in 0..=steps {
        flight.step();
        flight.check_guarantee();
        most = most.max(work::take());
        let agents = flight.pair.agents.iter();
        largest = largest.max(agents.map(|agent| largest_set(agent.knowledge())).max().unwrap());
    }
    println!("{name}: {most:?} in a step, {largest} vertices");
    let budget = scenario.estimator.max_vertices;
    // Sets that were cut after they grew may have more vertices.
    assert!(largest <= 3 * budget as usize, "{name}: a set of {largest} vertices");
    let agents = u64::from(scenario.agents.count);
    let bound = EDGES_PER_VERTEX * u64::from(budget) * agents;
    assert!(most.edges <= bound, "{name}: {most:?}, at most {bound} edges");
    let bound_m = SWEPT_M_PER_VERTEX * f64::from(budget) * agents as f64;
    assert!(most.swept_m <= bound_m, "{name}: {most:?}, at most {bound_m} m");
    most
}

fn slow(name: &str) -> Loaded {
    let file = format!("{}/fixtures/slow/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    drawn::load(&file).unwrap_or_else(|| panic!("{name} is legal"))
}

/// 20 m/s and two seconds between frames: sets grow by 40 m at once.
#[test]
fn sets_that_grow_far_at_once_are_swept_in_stages() {
    let most = fly("long-reach", slow("long-reach"), 19);
    // In one stage it would be 40 m times all vertices.
    assert!(most.swept_m < 130_000.0, "{most:?}");
}

/// 50 m/s, raw outlines of images of 150° and a clock skew of 5 s.
#[test]
fn fast_cars_under_wide_cameras() {
    fly("fast-cars", slow("fast-cars"), 20);
}

#[test]
fn wide_images_to_the_horizon() {
    fly("wide-images", slow("wide-images"), 25);
}

#[test]
fn twelve_uavs_over_a_dense_quarter() {
    fly("dense-quarter", slow("dense-quarter"), 20);
}

/// Cars of thousands of pixels.
#[test]
fn cars_that_fill_the_image() {
    let most = fly("low-flight", slow("low-flight"), 25);
    assert!(most.edges < 40_000, "{most:?}");
}

#[test]
fn a_camera_that_sees_a_thousand_kilometres() {
    fly("far-sight", slow("far-sight"), 6);
}

/// A few steps of random scenarios; `cargo run -p csat-tests --example drawn` flies whole ones.
#[test]
fn drawn_scenarios() {
    for seed in 0..12 {
        fly(&format!("seed {seed}"), drawn::scenario(seed), 6);
    }
}
