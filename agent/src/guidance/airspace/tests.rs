//! Airspace from synthetic frames: a wall, a street, no obstacle.

use csat_proto::camera::CameraModel;
use csat_proto::frame::Label;
use csat_proto::oem::{OemCell, OemDelta};
use nalgebra::Vector3;

use super::super::Planner;
use super::super::PlannerInput;
use super::super::tests::{CRITERIA, Scene, default_config};
use super::*;
use crate::config::Criterion;

const SPEED_M_S: f64 = 5.0;

/// The default agent with buildings higher than it flies.
fn config() -> AgentConfig {
    let mut config = default_config();
    config.fleet.avoid_buildings = true;
    config
}

/// A frame whose Ground pixels are those with `is_seen` at all corners.
fn frame(pose: Pose, step: u32, is_seen: impl Fn([f64; 2]) -> bool) -> (CameraView, Frame) {
    let model = CameraModel::default();
    let view = model.at(&pose);
    let seen = |c: u16, r: u16| view.ground_point(c.into(), r.into()).is_some_and(&is_seen);
    let label = |row: u16, column: u16| {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
        match corners.iter().all(|(c, r)| seen(column + c, row + r)) {
            true => Label::Ground,
            false => Label::Obstacle,
        }
    };
    let pixels = (0..model.rows).flat_map(|row| (0..model.columns).map(move |c| (row, c)));
    let labels = pixels.map(|(row, column)| label(row, column)).collect();
    let (depth, detections) = (vec![0; model.pixels()], Vec::new());
    (view, Frame { labels, depth, detections, ..Frame::of_detector(Step(step), pose, None) })
}

fn is_free(airspace: &Airspace, p: [f64; 2]) -> bool {
    let unknown = airspace.unknown();
    unknown.grid().cell_of(p).is_none_or(|(column, row)| !unknown.get(column, row))
}

fn east(x: f64, y: f64) -> Pose {
    Pose::level([x, y, 52.0], 0.0)
}

/// The airspace of an agent that flew east from the launch site to x = `to` and saw the ground up to
/// a wall.
fn flown(to: f64, wall: f64) -> Airspace {
    let mut airspace = Airspace::new(&config()).unwrap();
    let mut x = -260.0;
    for step in 0.. {
        let (view, frame) = frame(east(x, 0.0), step, |[x, _]| x < wall);
        airspace.see(&view, &frame);
        if x >= to {
            return airspace;
        }
        x = (x + 2.0 * SPEED_M_S).min(to);
    }
    unreachable!()
}

#[test]
fn nobody_looks_where_he_flies_if_buildings_are_low() {
    assert!(Airspace::new(&default_config()).is_none());
}

#[test]
fn airspace_is_free_from_the_camera_to_the_ground_that_is_seen() {
    let airspace = flown(-260.0, -120.0);
    let free = |x, y| is_free(&airspace, [x, y]);
    assert!(free(-130.0, 0.0) && free(-122.0, 20.0) && free(-160.0, -30.0), "before the wall");
    assert!(!free(-119.0, 0.0) && !free(-100.0, 0.0), "behind the wall");
    assert!(!free(-160.0, 60.0) && !free(-130.0, -80.0), "beside what the camera sees");
    assert!(free(-230.0, 30.0) && !free(-200.0, 60.0), "the launch site");
    assert!(free(-253.0, 200.0) && free(400.0, 0.0), "outside the region nothing stands");
}

/// Directly before the camera, rays to far ground are too high to prove the clearance of 2 m below.
#[test]
fn free_is_what_has_the_clearance_below() {
    let mut airspace = Airspace { launch_m: None, ..Airspace::new(&config()).unwrap() };
    let (view, frame) = frame(east(0.0, 0.0), 7, |[x, _]| (150.0..220.0).contains(&x));
    airspace.see(&view, &frame);
    // z·(1 - s) ≤ z - 2 m from s = 1/26 on.
    let first = (0..60).find(|x| is_free(&airspace, [f64::from(*x) + 0.5, 0.0])).unwrap();
    assert!((6..=8).contains(&first), "{first}");
    assert!(!is_free(&airspace, [3.5, 0.0]) && is_free(&airspace, [140.0, 0.0]));
}

/// The direction of the rays counts, not that of the rows of pixels: a UAV that banks sees to the side.
#[test]
fn every_attitude_is_sound() {
    for (pitch_rad, roll_rad) in [(0.0, 0.5), (0.3, -0.4), (-0.2, 0.1), (0.9, 0.0)] {
        let mut airspace = Airspace { launch_m: None, ..Airspace::new(&config()).unwrap() };
        let pose = Pose { pitch_rad, roll_rad, ..Pose::level([3.0, -8.0, 52.0], 0.7) };
        let is_seen = |[x, y]: [f64; 2]| x + 0.5 * y < 60.0;
        let (view, frame) = frame(pose, 3, is_seen);
        airspace.see(&view, &frame);
        let (grid, mut count) = (*airspace.unknown().grid(), 0);
        for (row, column) in (0..grid.rows).flat_map(|r| (0..grid.columns).map(move |c| (r, c))) {
            let [x, y] = grid.centre(column, row);
            let inside = x.abs() < 249.0 && y.abs() < 249.0;
            if inside && !airspace.unknown().get(column, row) {
                assert!(is_seen([x, y]), "{x} {y} is behind the wall");
                // A ray to ground beyond it is in the image.
                let beyond = (0..2000).map(|i| 1.0 + 0.01 * f64::from(i)).any(|s| {
                    let g = [3.0 + s * (x - 3.0), -8.0 + s * (y + 8.0)];
                    let image = view.project(&Vector3::new(g[0], g[1], 0.0));
                    image.is_some_and(|[c, r]| {
                        (0.0..480.0).contains(&c) && (0.0..360.0).contains(&r)
                    })
                });
                assert!(beyond, "{x} {y}");
                count += 1;
            }
        }
        assert!(count > 300 || pitch_rad < 0.0, "{count} cells at {pitch_rad}, {roll_rad}");
    }
}

#[test]
fn the_launch_site_is_of_the_first_life_and_has_room_to_turn() {
    let config = config();
    let room_m = turning_room_m(&config);
    assert!((33.0..42.0).contains(&room_m), "{room_m}");
    assert!(room_m < config.fleet.launch_radius_m());
    let again = AgentConfig { incarnation: Incarnation(1), ..config.clone() };
    for (config, is_home) in [(config, true), (again, false)] {
        let mut airspace = Airspace::new(&config).unwrap();
        let (view, frame) = frame(east(-260.0, 0.0), 0, |_| false);
        airspace.see(&view, &frame);
        assert_eq!(is_free(&airspace, [-230.0, 10.0]), is_home);
        let oem = Oem::unexplored(config.oem_grid());
        let ways = airspace.ways(&east(-260.0, 0.0), &oem, Step(0));
        // The airspace outside the region is free.
        assert_eq!(ways.is_safe(0.0), is_home);
    }
    let mut straight = self::config();
    straight.guidance.increments_deg = vec![0.0];
    assert_eq!(turning_room_m(&straight), f64::INFINITY);
}

/// A UAV may fly towards a wall as long as it can turn back in seen airspace.
#[test]
fn no_increment_leads_where_a_uav_cannot_turn_back() {
    let oem = Oem::unexplored(config().oem_grid());
    let wall = 60.0;
    let straight_up_to = (0..30)
        .map(|i| -100.0 + 5.0 * f64::from(i))
        .take_while(|&x| {
            let airspace = flown(x, wall);
            let ways = airspace.ways(&east(x, 0.0), &oem, Step(60));
            assert!(ways.is_any_safe() || x > 20.0, "{x}");
            ways.is_safe(0.0)
        })
        .last()
        .unwrap();
    // After another block and a circle 4 m are left to the wall.
    assert!((15.0..30.0).contains(&straight_up_to), "{straight_up_to}");
}

/// A way out stays one: the UAV flies it until another increment is safe.
#[test]
fn a_way_out_is_flown_to_its_end_and_round_and_round() {
    let config = config();
    let oem = Oem::unexplored(config.oem_grid());
    let mut airspace = flown(10.0, 60.0);
    let (mut pose, mut step) = (east(10.0, 0.0), Step(60));
    let ways = airspace.ways(&pose, &oem, step);
    assert!(ways.is_safe(0.0));
    let behind = ways.behind(0.0);
    let motion = Turning::new(&config, &config.guidance.gentlest_first_rad());
    pose = motion.advance(&pose, 0);
    assert!(!airspace.fly(step, behind));
    // From now on no increment is safe, and only the way out is left.
    let wide = Airspace { margin_m: 400.0, ..airspace.clone() };
    let closed = airspace.unknown().dilated_disc(FLIGHT_CLEARANCE_M);
    let mut airspace = wide;
    for _ in 0..40 {
        step = Step(step.0 + 6);
        let ways = airspace.ways(&pose, &oem, step);
        assert!(!ways.is_any_safe());
        let (decision, behind) = (ways.retreat(), ways.behind_retreat());
        let index = config.guidance.gentlest_first_rad();
        let index = index.iter().position(|u| *u == decision.increments_rad[0]).unwrap();
        for [x, y] in motion.way(&pose, index) {
            let (column, row) = closed.grid().cell_of([x, y]).unwrap();
            assert!(!closed.get(column, row), "at {x}, {y}");
        }
        pose = motion.advance(&pose, index);
        assert_eq!(pose, decision.poses[0]);
        assert!(!airspace.fly(step, behind), "never lost");
    }
}

/// After a missed decision there is no way out, which is reported once.
#[test]
fn who_has_no_way_out_flies_what_is_least_bad() {
    let config = config();
    let oem = Oem::unexplored(config.oem_grid());
    let mut airspace = Airspace { launch_m: None, ..Airspace::new(&config).unwrap() };
    let pose = east(-210.0, 0.0);
    // From the west border only the way to the west is free.
    let west = Pose { yaw_rad: std::f64::consts::PI, ..pose };
    for (pose, turns_back) in [(pose, true), (west, false)] {
        let ways = airspace.ways(&pose, &oem, Step(6));
        assert!(!ways.is_any_safe() && ways.behind_retreat().is_none());
        let first = ways.retreat().increments_rad[0];
        assert_eq!(first.abs() > 0.1, turns_back && first.abs() > 0.1, "{first}");
    }
    assert!(airspace.fly(Step(6), None), "lost");
    assert!(!airspace.fly(Step(12), None), "still lost: said already");
}

/// Every criterion flies safe increments, and later blocks keep clear of known buildings.
#[test]
fn plans_keep_to_what_may_be_flown() {
    let all = [Criterion::Str4, Criterion::Circles, Criterion::Lawnmower];
    let mut blind = 0;
    for criterion in CRITERIA.into_iter().chain(all) {
        let mut config = config();
        config.guidance.criterion = criterion;
        config.guidance.str4.n_mpc = 4;
        let mut scene = Scene::new(&config);
        // X^Δ lies behind the wall, which is in the OEM.
        let columns = 150..170;
        (100..150).for_each(|row| scene.wanted.set_run(row, columns.clone()));
        for row in 30..70 {
            let cell = scene.oem.grid().index(62, row) as u32;
            let state = OemCell::Occupied { height_dm: 400 };
            scene.oem.join(OemDelta { cell, state });
        }
        let airspace = flown(32.0, 60.0);
        let pose = east(32.0, 0.0);
        let ways = airspace.ways(&pose, &scene.oem, Step(60));
        assert!(ways.is_any_safe() && !ways.is_safe(0.0));
        let input = PlannerInput { ways: Some(&ways), ..scene.input() };
        let decision = Planner::new(&config).plan(&input, &pose, &[]);
        assert!(ways.is_safe(decision.increments_rad[0]), "{criterion:?}: {decision:?}");
        assert!(ways.behind(decision.increments_rad[0]).is_some());
        let free = Planner::new(&config).plan(&scene.input(), &pose, &[]);
        let mut blocks = free.poses.iter().zip(&free.increments_rad[1..]);
        let meets_wall = |(pose, turn): (&Pose, &f64)| !ways.is_open(pose, *turn);
        blind += u32::from(!ways.is_safe(free.increments_rad[0]) || blocks.any(meets_wall));
        for (pose, turn) in decision.poses.iter().zip(&decision.increments_rad[1..]) {
            assert!(ways.is_open(pose, *turn), "{criterion:?} plans through the wall");
        }
    }
    assert!(blind >= 4, "{blind} of 7 would fly into the wall");
}
