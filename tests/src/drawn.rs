//! Random legal scenarios: each key has any value within its bounds, and often an extreme one.
//!
//! A draw is legal if `csat check` finds no error. A mission of which it warns may take long.

use csat_agent::config::{Criterion, ExchangeMode, Schedule};
use csat_agent::estimate::state::Knowledge;
use csat_experiments::scenario::{self, Loaded, Request, Scenario};
use csat_netem::config::{DelayConfig, LossConfig, OutageConfig, OutageKind, PartitionConfig};
use csat_proto::camera::Assumption;
use csat_proto::model::Station;
use csat_proto::region::Region;
use csat_world::map::MapKind;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The scenario of a seed, as `csat` loads it: the first legal one of its draws.
///
/// # Panics
/// When the file system fails.
pub fn scenario(seed: u64) -> Loaded {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    loop {
        let text = any(&mut rng).to_toml();
        let file = tempfile::NamedTempFile::with_suffix(".toml").expect("a temporary file");
        std::fs::write(file.path(), text).expect("a temporary file");
        if let Some(loaded) = load(file.path().to_str().expect("a plain name")) {
            return loaded;
        }
    }
}

/// A scenario file or a shipped scenario; `None` if it is not legal.
pub fn load(name: &str) -> Option<Loaded> {
    scenario::load(Request { scenario: Some(name), sets: &[], seed: None }).ok()
}

/// The vertices of the largest set of an agent's knowledge.
pub fn largest_set(knowledge: &Knowledge) -> usize {
    let targets = knowledge.targets.values().map(|set| set.region());
    let all = targets.chain([knowledge.unexplored.region(), knowledge.margin.region()]);
    all.map(Region::vertex_count).max().unwrap_or(0)
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, of: &[T]) -> T {
    *of.choose(rng).expect("some")
}

fn any(rng: &mut ChaCha8Rng) -> Scenario {
    let mut scenario = Scenario {
        name: "drawn".to_owned(),
        seed: rng.random_range(0..1 << 53),
        ..Scenario::default()
    };
    let run = &mut scenario.run;
    run.period_s = pick(rng, &[0.25, 0.5, 0.5, 1.0, 2.0]);
    run.duration_s = run.period_s * f64::from(rng.random_range(12..60));
    town(&mut scenario, rng);
    cars(&mut scenario, rng);
    fleet(&mut scenario, rng);
    camera(&mut scenario, rng);
    estimator(&mut scenario, rng);
    guidance(&mut scenario, rng);
    exchange(&mut scenario, rng);
    links(&mut scenario, rng);
    scenario
}

fn town(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let map = &mut scenario.map;
    if rng.random_bool(0.2) {
        map.kind = MapKind::GeoJson;
        map.file = Some(pick(rng, &["helsinki-05.geojson", "helsinki-17.geojson"]).into());
        map.size_m = [0; 2].map(|_| rng.random_range(150.0..540.0));
        return;
    }
    // Sometimes a strip, a yard or a whole district.
    let side = |rng: &mut ChaCha8Rng| match rng.random_range(0..6) {
        0 => rng.random_range(40.0..100.0),
        1 => rng.random_range(700.0..1500.0),
        _ => rng.random_range(100.0..500.0),
    };
    map.size_m = [side(rng), side(rng)];
    map.built_share = pick(rng, &[0.0, 0.05, 0.1, 0.2, 0.3]);
    map.min_height_m = rng.random_range(2.5..6.0);
    map.max_height_m = map.min_height_m + rng.random_range(0.1..40.0);
    map.road_spacing_m = rng.random_range(40.0..150.0);
}

fn cars(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let targets = &mut scenario.targets;
    targets.count = pick(rng, &[0, 1, 2, 4, 8, 15, 30]);
    targets.v_max_m_s = pick(rng, &[0.0, 0.5, 1.0, 1.0, 3.0, 20.0, 50.0, 100.0]);
    targets.obstacle_distance_m = pick(rng, &[0.0, 0.5, 2.5, 5.0]);
    targets.body_m = pick(rng, &[[4.6, 1.8, 1.5], [4.2, 0.8, 0.6], [3.0, 3.0, 2.0]]);
    let [length, width, height] = targets.body_m;
    targets.radius_m = 0.5 * length.hypot(width) + pick(rng, &[1e-3, 0.1, 1.0]);
    targets.cylinder_height_m = height + pick(rng, &[0.0, 0.5]);
    targets.target_distance_m = 2.0 * targets.radius_m + pick(rng, &[0.01, 3.0, 10.0]);
}

fn fleet(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let floor_m = scenario.map.max_height_m + 2.5;
    let size_m = scenario.map.size_m;
    let station = |rng: &mut ChaCha8Rng| {
        let [x_m, y_m] = size_m.map(|side_m| rng.random_range(-0.5..0.5) * side_m);
        Station { x_m, y_m, z_m: pick(rng, &[0.0, 2.0, 30.0]) }
    };
    let stations = pick(rng, &[0, 0, 0, 1, 3]);
    scenario.stations = (0..stations).map(|_| station(rng)).collect();
    let agents = &mut scenario.agents;
    agents.avoid_buildings = rng.random_bool(0.1);
    agents.count = pick(rng, &[1, 2, 4, 4, 6, 9, 12]);
    agents.speed_m_s = pick(rng, &[1.0, 5.0, 5.0, 15.0, 60.0, 300.0]);
    agents.altitude_m = pick(rng, &[floor_m, floor_m + 5.0, 52.0, 61.0, 90.0, 150.0]);
    agents.altitude_step_m = pick(rng, &[0.5, 3.0]);
    agents.altitude_band_m = pick(rng, &[0.5, 5.0, 24.0]);
    agents.start_offset_m = pick(rng, &[0.0, 10.0, 150.0]);
    agents.yaw_settling_s = pick(rng, &[0.01, 1.2, 10.0]);
}

fn camera(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let camera = &mut scenario.camera;
    (camera.columns, camera.rows) =
        pick(rng, &[(48, 36), (160, 120), (240, 180), (320, 240), (480, 360), (480, 360)]);
    camera.aperture_deg = pick(rng, &[20.0, 45.0, 45.0, 70.0, 110.0, 150.0]);
    camera.tilt_deg = pick(rng, &[5.0, 20.0, 30.0, 45.0, 90.0]);
    camera.d_max_m = pick(rng, &[100.0, 300.0, 300.0, 2000.0, 5000.0, 1e6]);
    let noise = [[0.0, 0.0], [-0.01, 0.01], [-0.01, 0.01], [-0.1, 0.2], [0.0, 1.5]];
    camera.depth_noise = pick(rng, &noise);
    camera.min_pixels = pick(rng, &[1, 2, 8]);
    camera.box_error_px = pick(rng, &[0, 0, 3]);
    let assumptions = [Assumption::EveryRay, Assumption::SomeRay, Assumption::CentreRay];
    camera.assumption = pick(rng, &assumptions);
}

fn estimator(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let estimator = &mut scenario.estimator;
    estimator.disc_vertices = pick(rng, &[4, 6, 8, 16, 32, 64]);
    estimator.simplify_m = pick(rng, &[0.0, 0.0, 0.05, 0.15, 1.0]);
    estimator.simplify_margin_m = pick(rng, &[0.0, 0.25, 1.0, 5.0]);
    estimator.outline_tolerance_px = pick(rng, &[0.0, 0.0, 1.0, 3.0]);
    estimator.raster_cell_m = pick(rng, &[1.0, 2.0, 2.0, 5.0]);
    estimator.oem_cell_m = pick(rng, &[2.0, 5.0, 20.0]);
}

fn guidance(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let period_s = scenario.run.period_s;
    let guidance = &mut scenario.guidance;
    guidance.criterion = pick(
        rng,
        &[
            Criterion::Str1,
            Criterion::Str2NoHidden,
            Criterion::Str2,
            Criterion::Str3,
            Criterion::Str4,
            Criterion::Str5,
            Criterion::Circles,
            Criterion::Lawnmower,
        ],
    );
    guidance.kappa = pick(rng, &[0.0, 1.0, 100.0]);
    guidance.n_mpc = pick(rng, &[1, 2, 3]);
    guidance.period_s = period_s * pick(rng, &[1.0, 2.0, 6.0]);
    guidance.increments_deg =
        pick(rng, &[&[0.0][..], &[-60.0, 0.0, 60.0], &[-60.0, -30.0, 0.0, 30.0, 60.0]]).to_vec();
    let schedules = [Schedule::Sequential, Schedule::SequentialLoopback, Schedule::Asynchronous];
    guidance.schedule = pick(rng, &schedules);
    guidance.plan_timeout_s = 0.5 * period_s;
    guidance.str4.n_mpc = pick(rng, &[1, 5, 20]);
    guidance.str4.beam = pick(rng, &[1, 20, 200]);
}

fn exchange(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let exchange = &mut scenario.exchange;
    exchange.mode = pick(
        rng,
        &[
            ExchangeMode::None,
            ExchangeMode::Facts,
            ExchangeMode::FactsRepair,
            ExchangeMode::FactsRepair,
            ExchangeMode::Snapshot,
        ],
    );
    exchange.snapshot_period_s = pick(rng, &[0.5, 3.0, 10.0]);
    exchange.repair_period_s = pick(rng, &[0.5, 2.0, 5.0]);
    exchange.repair_delay_s = pick(rng, &[0.0, 2.0, 20.0]);
    exchange.budget_bytes_s = pick(rng, &[f64::INFINITY, f64::INFINITY, 1000.0, 20_000.0]);
    exchange.max_age_s = pick(rng, &[1.0, 60.0]);
    exchange.clock_skew_s = pick(rng, &[0.0, 0.0, 5.0]);
    exchange.max_vertices = pick(rng, &[200, 1000, 50_000]);
}

fn links(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let (count, end_s) = (scenario.agent_count(), scenario.run.duration_s);
    let netem = &mut scenario.netem;
    netem.radio.range_m = pick(rng, &[f64::INFINITY, 50.0, 250.0]);
    netem.radio.loss = match rng.random_range(0..4) {
        0 => LossConfig::GilbertElliott { p: rng.random_range(0.0..0.5), r: 0.3, h: 0.1, k: 1.0 },
        _ => LossConfig::Iid { p: pick(rng, &[0.0, 0.0, 0.4, 0.8]) },
    };
    netem.radio.delay = match rng.random_range(0..3) {
        0 => {
            DelayConfig::Pareto { mean_s: rng.random_range(0.1..3.0), shape: 2.5, correlation: 0.0 }
        }
        _ => DelayConfig::Constant { mean_s: 0.0 },
    };
    netem.radio.duplication = pick(rng, &[0.0, 0.1, 1.0]);
    if count > 1 && rng.random_bool(0.2) {
        let cut = rng.random_range(1..count);
        let (groups, one_way) = (vec![(0..cut).collect(), (cut..count).collect()], false);
        let from_s = rng.random_range(0.0..end_s);
        netem.partition.push(PartitionConfig { from_s, until_s: end_s, groups, one_way });
    }
    for agent in 0..count {
        if !rng.random_bool(0.2) {
            continue;
        }
        let from_s = rng.random_range(0.0..end_s);
        let kind = pick(rng, &[OutageKind::Crash, OutageKind::Radio]);
        let until_s = from_s + rng.random_range(0.5..end_s);
        netem.outage.push(OutageConfig { agent, from_s, until_s, kind });
    }
}
