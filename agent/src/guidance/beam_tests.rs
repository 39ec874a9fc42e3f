use csat_proto::ids::AgentId;
use csat_proto::oem::{OemCell, OemDelta};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::Planner;
use super::super::tests::{Scene, default_config, fill};
use super::super::viewshed::RayCaster;
use super::*;
use crate::config::{Criterion, Objective};

fn config(n_mpc: u8, beam: u16) -> AgentConfig {
    let mut config = default_config();
    config.ground.size_m = [320.0, 320.0];
    config.guidance.criterion = Criterion::Str4;
    config.guidance.str4.n_mpc = n_mpc;
    config.guidance.str4.beam = beam;
    config.guidance.str4.first_look = 0;
    config
}

fn scene(config: &AgentConfig, rng: &mut ChaCha8Rng) -> Scene {
    let mut scene = Scene::new(config);
    for _ in 0..12 {
        let [x, y] = [0, 1].map(|_| rng.random_range(-160.0..120.0));
        let mut blob = Raster::empty(config.raster_grid());
        fill(&mut blob, [x, x + rng.random_range(5.0..60.0)], [y, y + 30.0]);
        scene.wanted.union_with(&blob);
    }
    fill(&mut scene.margin, [-20.0, 10.0], [-20.0, 30.0]);
    for _ in 0..30 {
        let [column, row] = [0, 1].map(|_| rng.random_range(0..config.oem_grid().columns));
        scene.occupy(column, row, rng.random_range(30..420));
    }
    scene
}

fn start(rng: &mut ChaCha8Rng) -> Pose {
    Pose::level([-90.0, rng.random_range(-60.0..60.0), 53.0], rng.random_range(-0.7..0.7))
}

/// The set with the four neighbours of every cell: 3 m of growth are one cell of 4 m in each of the
/// first two blocks, as 6 m are 1.5 cells.
fn spread(set: &Raster) -> Raster {
    let (mut spread, grid) = (set.clone(), *set.grid());
    for (column, row) in set.iter() {
        for (east, north) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let cell = (column.checked_add_signed(east), row.checked_add_signed(north));
            if let (Some(column), Some(row)) = cell
                && column < grid.columns
                && row < grid.rows
            {
                spread.set(column, row);
            }
        }
    }
    spread
}

#[test]
fn sets_spread_as_fast_as_targets_drive() {
    let mut config = config(6, 1);
    for (v_max_m_s, way_m) in [(1.0, 18.0), (0.0, 0.0), (0.3, 5.4), (2.0, 36.0)] {
        config.targets.v_max_m_s = v_max_m_s;
        let beam = Beam::new(&config, vec![]);
        let mut set = Raster::empty(beam.grid);
        set.set(40, 40);
        for block in 0..6 {
            set = set.dilated_disc(beam.spread_m(block));
        }
        let reached = set.iter().filter(|&(_, row)| row == 40).map(|(column, _)| column).max();
        let reached_m = f64::from(reached.unwrap() - 40) * beam.grid.cell_m;
        assert!((reached_m - way_m).abs() <= 0.5 * beam.grid.cell_m, "{v_max_m_s}: {reached_m} m");
    }
}

/// The cost of a set in a fleet of 4, m². UAV 3, whose share is the north-east, is silent.
fn counted_m2(config: &AgentConfig, set: &Raster) -> f64 {
    let silent = match config.guidance.objective {
        Objective::Own => 1.0,
        Objective::Fleet => config.guidance.str4.silent,
    };
    let cell_m2 = set.grid().cell_m.powi(2);
    let of = |(column, row)| {
        let [x, y] = set.grid().centre(column, row);
        if x < 0.0 || y < 0.0 { 1.0 } else { silent }
    };
    set.iter().map(|cell| cell_m2 * of(cell)).sum()
}

/// Σ φ(X^Δ_k) of a sequence by the definition, m², less the bonus of first looks. The other UAV tells what it has seen at
/// the ends of blocks in which it is in contact, which under `str4` is always. Views are those
/// of the camera at the rounded pose (every third cell, every quarter of a degree), point by point.
fn cost(config: &AgentConfig, scene: &Scene, start: &Pose, poses: &[Pose], other: &[Pose]) -> f64 {
    let beam = Beam::new(config, vec![]);
    let (mut remaining, margin) = (beam.coarse(&scene.wanted), beam.coarse(&scene.margin));
    let mut caster = RayCaster::new(beam.grid, config.camera.d_max_m);
    caster.load(&scene.oem);
    let mut first_looks = FirstLooks::new(beam.grid, config);
    if config.guidance.str4.first_look > 0 {
        first_looks.load(&remaining, &margin, caster.height_map(), start);
    }
    let mut look_first = |pose: &Pose, remaining: &mut Raster| {
        let before = counted_m2(config, remaining);
        first_looks.look(RoundedPose::of(pose, &beam.grid)).take_from(remaining);
        before - counted_m2(config, remaining)
    };
    let first_look = f64::from(config.guidance.str4.first_look);
    let corner = beam.grid.centre(0, 0);
    let mut see = |pose: &Pose, remaining: &mut Raster| {
        let place = [0, 1].map(|i| ((pose.p_world[i] - corner[i]) / 12.0).round() * 3.0);
        let [x, y] = [0, 1].map(|i| corner[i] + place[i] * 4.0);
        let quarters = (pose.yaw_rad.to_degrees() * 4.0).round();
        let rounded = Pose::level([x, y, pose.p_world[2]], (quarters / 4.0).to_radians());
        let camera = config.camera.at(&rounded);
        let eye = place.map(|cell| cell as i32);
        let mut viewshed = caster.viewshed(eye, pose.p_world[2], 300.0);
        for (column, row) in remaining.clone().iter() {
            let p = remaining.grid().centre(column, row);
            let ground = nalgebra::Vector3::new(p[0], p[1], 0.0);
            let in_image = camera
                .project(&ground)
                .is_some_and(|[c, r]| (0.0..480.0).contains(&c) && (0.0..360.0).contains(&r));
            let is_near = (ground - camera.centre_world()).norm() <= config.camera.d_max_m;
            let [east, north] = [column as i32 - eye[0], row as i32 - eye[1]];
            let rays = caster.rays_of([[east, north]].into_iter());
            caster.cast(&mut viewshed, &rays);
            let (word, bit) = (column as i32 / 64, 1 << (column % 64));
            if in_image && is_near && viewshed.seen(row as i32, word, bit) != 0 {
                remaining.clear(column, row);
            }
        }
    };
    let is_in_contact = |own: &Pose, other: &Pose| {
        let squares: f64 = (0..3).map(|i| (own.p_world[i] - other.p_world[i]).powi(2)).sum();
        !config.predicts_contact() || squares.sqrt() <= config.radio_range_m
    };
    let (mut sum, mut theirs) = (0.0, remaining.clone());
    for (own, other) in poses.iter().zip(other) {
        for set in [&mut remaining, &mut theirs] {
            *set = spread(set);
            set.subtract(&margin);
        }
        see(other, &mut theirs);
        look_first(other, &mut theirs);
        if is_in_contact(own, other) {
            remaining.intersect_with(&theirs);
        }
        sum -= first_look * look_first(own, &mut remaining.clone());
        see(own, &mut remaining);
        sum += counted_m2(config, &remaining);
        look_first(own, &mut remaining);
    }
    sum
}

/// A beam that keeps every candidate searches the whole tree, also where some of the candidates are in contact with the
/// other UAV and some are not.
#[test]
fn a_wide_beam_finds_what_brute_force_finds() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut differ = 0;
    for round in 0..16 {
        let mut config = config(2, 1000);
        config.fleet.count = 4;
        config.guidance.str4.first_look = round % 4;
        if (4..8).contains(&round) {
            config.guidance.objective = Objective::Fleet;
        }
        if round >= 8 {
            config.guidance.criterion = Criterion::Str5;
            config.radio_range_m = 60.0;
        }
        let (scene, pose, other) = (scene(&config, &mut rng), start(&mut rng), start(&mut rng));
        let plan = Motion::new(&config).forecast(&[other], 0, 2);
        config.id = AgentId(1);
        let input = PlannerInput {
            neighbours: &[AgentId(0)],
            plan_ages: &[0],
            silent: &[AgentId(3)],
            ..scene.input()
        };
        let found = Planner::new(&config).plan(&input, &pose, std::slice::from_ref(&plan));
        let turning = Turning::new(&config, &[-60.0, -30.0, 0.0, 30.0, 60.0].map(f64::to_radians));
        let far = AgentConfig { radio_range_m: f64::INFINITY, ..config.clone() };
        let mut least = f64::INFINITY;
        for (first, second) in (0..5).flat_map(|a| (0..5).map(move |b| (a, b))) {
            let one = turning.advance(&pose, first);
            let poses = [one, turning.advance(&one, second)];
            let sum = cost(&config, &scene, &pose, &poses, &plan);
            least = least.min(sum);
            differ += u32::from(sum != cost(&far, &scene, &pose, &poses, &plan));
        }
        assert_eq!(found.cost, least, "{round}");
        assert_eq!((found.poses.len(), found.nodes), (2, 30));
        assert_eq!(found.cost, cost(&config, &scene, &pose, &found.poses, &plan), "{round}");
    }
    assert!((1..200).contains(&differ), "of 200 sequences with a range, {differ} are out of reach");
}

/// Where nobody is silent, and where silent UAVs' ground counts in full, the objectives are one, whatever was silent at the
/// decision before.
#[test]
fn a_fleet_in_contact_flies_as_its_uavs_would() {
    let mut rng = ChaCha8Rng::seed_from_u64(24);
    let mut config = config(4, 30);
    config.fleet.count = 2;
    let (scene, pose, other) = (scene(&config, &mut rng), start(&mut rng), start(&mut rng));
    let plan = [Motion::new(&config).forecast(&[other], 0, 4)];
    let planner = |objective, silent| {
        let mut config = config.clone();
        config.guidance.objective = objective;
        config.guidance.str4.silent = silent;
        Planner::new(&config)
    };
    let fly = |planner: &mut Planner, silent: &[AgentId]| {
        planner.plan(&PlannerInput { silent, ..scene.input() }, &pose, &plan)
    };
    let silent = [AgentId(1)];
    let own = fly(&mut planner(Objective::Own, 0.0), &silent);
    assert_eq!(fly(&mut planner(Objective::Fleet, 1.0), &silent), own);
    let mut fleet = planner(Objective::Fleet, 0.0);
    assert!(fly(&mut fleet, &silent).cost < own.cost);
    assert_eq!(fly(&mut fleet, &[]), own);
}

#[test]
fn a_wider_beam_is_dearer_and_seldom_worse() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let (mut narrow, mut wide) = (0.0, 0.0);
    for _ in 0..6 {
        let one = config(5, 1);
        let (scene, pose) = (scene(&one, &mut rng), start(&mut rng));
        let plan = |config: &AgentConfig| Planner::new(config).plan(&scene.input(), &pose, &[]);
        let (a, b) = (plan(&one), plan(&config(5, 40)));
        assert_eq!((a.nodes, a.increments_rad.len()), (25, 5));
        assert!(b.nodes > a.nodes && b.nodes <= 5 + 25 + 3 * 200, "{}", b.nodes);
        narrow += a.cost;
        wide += b.cost;
    }
    assert!(wide < narrow, "{wide} {narrow}");
}

/// Caches of earlier decisions, also with other maps, have no effect: neither where buildings are new
/// or higher nor where they vanished.
#[test]
fn a_plan_is_a_function_of_its_arguments() {
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let config = config(4, 20);
    let mut used = Planner::new(&config);
    for _ in 0..3 {
        let mut scene = scene(&config, &mut rng);
        let (pose, other) = (start(&mut rng), [vec![start(&mut rng)]]);
        let states = [200, 300, 309, 440].map(|height_dm| OemCell::Occupied { height_dm });
        for state in states.into_iter().chain([OemCell::Empty]) {
            let cell = config.oem_grid().index(32, 32) as u32;
            scene.oem.join(OemDelta { cell, state });
            let fresh = Planner::new(&config).plan(&scene.input(), &pose, &other);
            assert_eq!(used.plan(&scene.input(), &pose, &other), fresh);
        }
    }
}

/// Two patches, a building on each: at equal cost a UAV looks at the one without an earlier look.
#[test]
fn unknown_buildings_attract() {
    let mut config = config(1, 60);
    config.guidance.increments_deg = vec![60.0, -60.0];
    let sides = [[60.0, 160.0], [-160.0, -60.0]];
    let patches = |sides: &[[f64; 2]]| {
        let mut scene = Scene::new(&config);
        sides.iter().for_each(|side| fill(&mut scene.wanted, [0.0, 100.0], *side));
        for (column, row) in (34..44).flat_map(|c| (46..54).map(move |r| (c, r))) {
            scene.occupy(column, row, 50);
            scene.occupy(column, 63 - row, 50);
        }
        scene
    };
    let pose = Pose::level([0.0, 0.0, 52.0], 0.0);
    let turned = |unknown: [f64; 2], first_look: u16| {
        let mut config = config.clone();
        config.guidance.str4.first_look = first_look;
        let mut planner = Planner::new(&config);
        planner.plan(&patches(&[unknown]).input(), &pose, &[]);
        let decision = planner.plan(&patches(&sides).input(), &pose, &[]);
        decision.increments_rad[0].to_degrees().round()
    };
    assert_eq!(sides.map(|unknown| turned(unknown, 0)), [60.0, 60.0], "ties");
    assert_eq!(sides.map(|unknown| turned(unknown, 10)), [60.0, -60.0]);
}

/// Two patches, one to each side: the second UAV flies to the other one.
#[test]
fn neighbours_repel() {
    let config = config(3, 60);
    let mut scene = Scene::new(&config);
    fill(&mut scene.wanted, [-60.0, 40.0], [50.0, 150.0]);
    fill(&mut scene.wanted, [-60.0, 40.0], [-150.0, -50.0]);
    let pose = Pose::level([-100.0, 0.0, 52.0], 0.0);
    let mut planner = Planner::new(&config);
    let first = planner.plan(&scene.input(), &pose, &[]);
    let second = planner.plan(&scene.input(), &pose, std::slice::from_ref(&first.poses));
    let turned = |poses: &[Pose]| poses[2].yaw_rad;
    assert!(turned(&first.poses) * turned(&second.poses) < 0.0, "{first:?} {second:?}");
}

/// [`Planner::plan`] says that a UAV flies straight ahead after its last pose: it is still there to keep
/// in contact with.
#[test]
fn contact_counts_after_the_end_of_a_plan() {
    let mut config = config(4, 20);
    config.guidance.criterion = Criterion::Str5;
    config.radio_range_m = 50.0;
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let (scene, pose) = (scene(&config, &mut rng), start(&mut rng));
    let short = vec![Pose::level([-90.0, 20.0, 56.0], -0.3)];
    let long = Motion::new(&config).forecast(&short, 0, 4);
    config.id = AgentId(1);
    let input = PlannerInput { neighbours: &[AgentId(0)], plan_ages: &[0], ..scene.input() };
    let plan = |plan: Vec<Pose>| Planner::new(&config).plan(&input, &pose, &[plan]);
    assert_eq!(plan(short), plan(long.clone()));
    let alone = Planner::new(&config).plan(&scene.input(), &pose, &[]);
    assert_ne!(plan(long), alone, "it is in contact");
}
