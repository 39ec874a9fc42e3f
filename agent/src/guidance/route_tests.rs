use csat_proto::ids::AgentId;
use csat_proto::raster::Raster;

use super::super::Planner;
use super::super::tests::{Scene, default_config};
use super::*;

fn config(criterion: Criterion, id: u16, count: u16, size_m: [f64; 2]) -> AgentConfig {
    let mut config = default_config();
    config.guidance.criterion = criterion;
    config.id = AgentId(id);
    config.fleet.count = count;
    config.ground.size_m = size_m;
    config
}

/// The poses of 600 s by (5.35), one per block, from the common start.
fn flight(config: &AgentConfig) -> Vec<Pose> {
    let scene = Scene::new(config);
    let (mut planner, motion) = (Planner::new(config), Motion::new(config));
    let mut pose = Pose::level([-0.5 * config.ground.size_m[0] - 10.0, 0.0, 52.0], 0.0);
    let fly = |_| {
        let decision = planner.plan(&scene.input(), &pose, &[]);
        // Two passes per decision: the second must not change anything.
        assert_eq!(planner.plan(&scene.input(), &pose, &[]), decision);
        assert_eq!(decision.poses.len(), config.guidance.blocks());
        pose = motion.advance(&pose, decision.increments_rad[0]);
        assert_eq!(pose, decision.poses[0]);
        pose
    };
    (0..200).map(fly).collect()
}

/// Fleets and regions of several sizes.
const CASES: [(u16, [f64; 2]); 5] = [
    (1, [300.0, 300.0]),
    (2, [500.0, 500.0]),
    (4, [500.0, 500.0]),
    (5, [800.0, 300.0]),
    (7, [300.0, 900.0]),
];

#[test]
fn baselines_stay_near_the_region() {
    for criterion in [Criterion::Circles, Criterion::Lawnmower] {
        for (count, size_m) in CASES {
            for id in 0..count {
                for pose in flight(&config(criterion, id, count, size_m)) {
                    let out =
                        [0, 1].map(|axis: usize| pose.p_world[axis].abs() - 0.5 * size_m[axis]);
                    assert!(out[0].max(out[1]) < 60.0, "{criterion:?} {id} of {count}: {pose:?}");
                }
            }
        }
    }
}

#[test]
fn circles_are_flown_round_and_apart() {
    for (count, size_m) in CASES {
        let mut centres: Vec<[f64; 2]> = Vec::new();
        for id in 0..count {
            let config = config(Criterion::Circles, id, count, size_m);
            let poses = flight(&config);
            let round = &poses[poses.len() - 12..];
            let mean =
                [0, 1].map(|axis: usize| round.iter().map(|p| p.p_world[axis]).sum::<f64>() / 12.0);
            let far = |p: &Pose| (p.p_world[0] - mean[0]).hypot(p.p_world[1] - mean[1]);
            assert!(round.iter().all(|p| far(p) < 30.0), "{id} of {count}: {mean:?}");
            let apart = |c: &[f64; 2]| (c[0] - mean[0]).hypot(c[1] - mean[1]) > 60.0;
            assert!(centres.iter().all(apart), "{id} of {count}: {mean:?} {centres:?}");
            centres.push(mean);
        }
    }
}

/// The union of all footprints is nearly all ground.
#[test]
fn a_lawnmower_visits_everything() {
    for (count, size_m) in CASES {
        let grid = config(Criterion::Lawnmower, 0, count, size_m).raster_grid();
        let mut seen = Raster::empty(grid);
        for id in 0..count {
            let config = config(Criterion::Lawnmower, id, count, size_m);
            let planner = Planner::new(&config);
            flight(&config).iter().for_each(|pose| seen.union_with(&planner.footprint(pose)));
        }
        let share = f64::from(seen.count()) / grid.cells() as f64;
        assert!(share > 0.97, "{count} over {size_m:?}: {share}");
    }
}
