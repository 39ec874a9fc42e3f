//! Towns with buildings higher than the UAVs fly.

use csat_agent::config::Criterion;
use csat_agent::guidance::airspace::Airspace;
use csat_experiments::scenario::{Request, Scenario, load};
use csat_experiments::set_membership::SetMembership;
use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use csat_proto::model::FLIGHT_CLEARANCE_M;
use csat_proto::time::Step;
use csat_tests::missions::{fly, fly_mission, small, world_of};
use csat_tests::replay::{for_seeds, is_replay};
use csat_world::camera::Renderer;
use csat_world::obstacle::Walls;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Flights at 34 m to 40 m in a town of 15 m to 90 m.
fn tall(seed: u64) -> Scenario {
    let mut scenario = small(seed, 200.0, 3);
    scenario.map.min_height_m = 15.0;
    scenario.map.max_height_m = 90.0;
    scenario.agents.avoid_buildings = true;
    scenario
}

/// All airspace that a frame proves to be free is free, with the clearance below.
#[test]
fn no_building_reaches_into_airspace_that_was_seen_to_be_free() {
    let mut cells = 0;
    for_seeds(["airspace", "no_building_reaches_into_airspace"], 0..40, |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let scenario = tall(seed);
        let world = world_of(&scenario).unwrap();
        let walls = Walls::new(world.obstacles());
        let mut renderer = Renderer::new(scenario.camera);
        for _ in 0..4 {
            let mut airspace = Airspace::new(&scenario.agent_config()).unwrap();
            let [x, y] = [0; 2].map(|_| rng.random_range(-95.0..95.0));
            let [z, yaw_rad] = [rng.random_range(15.0..80.0), rng.random_range(-4.0..4.0)];
            let [pitch_rad, roll_rad] = [0; 2].map(|_| rng.random_range(-0.3..0.3));
            let level = rng.random_bool(0.6);
            let pose = Pose { pitch_rad, roll_rad, ..Pose::level([x, y, z], yaw_rad) };
            let pose = if level { Pose::level(pose.p_world, yaw_rad) } else { pose };
            let frame = renderer.frame(&world.scene(), &pose, Step(1), seed, AgentId(0));
            let before = airspace.unknown().clone();
            airspace.see(&scenario.camera.at(&pose), &frame);
            let grid = *before.grid();
            for (column, row) in before.iter().filter(|&(c, r)| !airspace.unknown().get(c, r)) {
                let floor_m = z - FLIGHT_CLEARANCE_M;
                let half_m = 0.5 * grid.cell_m;
                let near = walls.nearest_above(floor_m, grid.centre(column, row), half_m);
                assert_eq!(near, None, "{pose:?}: cell {column}, {row} of {grid:?}");
                cells += 1;
            }
        }
    });
    assert!(is_replay() || cells > 200_000, "{cells}");
}

/// Missions among towers: the guarantee holds, and no UAV comes nearer to a building than 2 m.
#[test]
fn whoever_flies_around_buildings_hits_none() {
    let criteria = [
        Criterion::Str1,
        Criterion::Str2NoHidden,
        Criterion::Str2,
        Criterion::Str3,
        Criterion::Str4,
        Criterion::Str5,
        Criterion::Circles,
        Criterion::Lawnmower,
    ];
    for_seeds(["airspace", "whoever_flies_around_buildings"], 0..16, |seed| {
        let mut scenario = tall(seed);
        scenario.guidance.criterion = criteria[seed as usize % criteria.len()];
        scenario.guidance.str4.beam = 8;
        let outcome = fly(&scenario, 240);
        outcome.check(&format!("seed {seed}, {:?}", scenario.guidance.criterion));
        assert_eq!(outcome.no_way_out, 0, "seed {seed}");
    });
}

/// The same towns with agents that do not avoid buildings: the monitor detects it.
#[test]
fn whoever_does_not_look_hits_some() {
    let hit = |seed: &u64| {
        let scenario = tall(*seed);
        let mut blind = scenario.clone();
        blind.agents.avoid_buildings = false;
        let outcome = fly_mission(SetMembership::new(&blind), &scenario, 240);
        let hits = outcome.violations.iter().filter(|v| v.contains("BuildingDistance"));
        let hits = hits.count();
        assert_eq!(hits, outcome.violations.len(), "{:?}", outcome.violations);
        hits > 0
    };
    let count = (0..7).filter(hit).count();
    assert!(count >= 4, "{count} of 7");
}

/// Real towns: Helsinki, its heights trebled.
#[test]
fn helsinki_with_towers_is_flown_around() {
    for_seeds(["airspace", "helsinki_with_towers"], 0..2, |seed| {
        let sets = ["agents.avoid_buildings=true", "agents.altitude_m=20"].map(str::to_owned);
        let request = Request { scenario: Some("helsinki-17"), sets: &sets, seed: Some(seed) };
        let loaded = load(request).unwrap();
        let heights = loaded.world.obstacles().iter().map(|o| o.height_m);
        assert!(heights.fold(0.0, f64::max) > 22.0, "some reach the flights");
        let mission = SetMembership::new(&loaded.scenario);
        let outcome = csat_tests::missions::fly_in(mission, loaded.world, &loaded.scenario, 200);
        outcome.check(&format!("seed {seed}"));
        assert_eq!(outcome.no_way_out, 0, "seed {seed}");
    });
}

/// Walls between UAVs obstruct radio; where no building reaches the UAVs, none does.
#[test]
fn walls_between_uavs_are_heard() {
    let dropped = |seed: u64, is_tall: bool, db: f64| {
        let mut scenario = if is_tall { tall(seed) } else { small(seed, 200.0, 3) };
        let propagation = csat_netem::config::PropagationConfig {
            obstruction_db: db,
            exponent: 3.0,
            ..Default::default()
        };
        scenario.netem.radio.propagation = Some(propagation);
        fly(&scenario, 160).dropped
    };
    let total = |is_tall, db| (0..4).map(|seed| dropped(seed, is_tall, db)).sum::<u64>();
    let (open, walled) = (total(true, 0.0), total(true, 40.0));
    println!("{open} messages dropped with 0 dB, {walled} with 40 dB");
    assert!(walled > open + 100, "{open} {walled}");
    assert_eq!(total(false, 0.0), total(false, 40.0), "walls below the flights obstruct no radio");
}
