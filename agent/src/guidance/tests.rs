//! The planner as a whole.

use csat_proto::oem::{OemCell, OemDelta};

use super::*;
use crate::config::Criterion;

/// The first agent of the default fleet over the default ground.
pub(super) fn default_config() -> AgentConfig {
    crate::config::tests::default_config([500.0; 2])
}

pub(super) const CRITERIA: [Criterion; 4] =
    [Criterion::Str1, Criterion::Str2NoHidden, Criterion::Str2, Criterion::Str3];

/// Two increments, left and right; left comes first, so it wins at equal cost.
fn left_or_right(criterion: Criterion, kappa: f64) -> AgentConfig {
    let mut config = default_config();
    config.guidance.criterion = criterion;
    config.guidance.kappa = kappa;
    config.guidance.n_mpc = 1;
    config.guidance.increments_deg = vec![60.0, -60.0];
    config
}

/// The left increment, degrees.
const LEFT: f64 = 60.0;
const RIGHT: f64 = -60.0;

/// The first increment, degrees.
fn turn(decision: &Decision) -> f64 {
    decision.increments_rad[0].to_degrees().round()
}

/// The owned data of a planner input.
pub(super) struct Scene {
    pub(super) wanted: Raster,
    pub(super) margin: Raster,
    pub(super) hidden_now: Raster,
    pub(super) hidden_recent: Raster,
    pub(super) oem: Oem,
    pub(super) pose_error: PoseError,
}

impl Scene {
    pub(super) fn new(config: &AgentConfig) -> Self {
        let empty = Raster::empty(config.raster_grid());
        Self {
            wanted: empty.clone(),
            margin: empty.clone(),
            hidden_now: empty.clone(),
            hidden_recent: empty,
            oem: Oem::unexplored(config.oem_grid()),
            pose_error: config.pose_error,
        }
    }

    pub(super) fn input(&self) -> PlannerInput<'_> {
        PlannerInput {
            wanted: &self.wanted,
            margin: &self.margin,
            hidden_now: &self.hidden_now,
            neighbours: &[],
            plan_ages: &[],
            silent: &[],
            neighbours_hidden_now: &[],
            hidden_recent: &self.hidden_recent,
            oem: &self.oem,
            view_cache: None,
            pose_error: self.pose_error,
            ways: None,
        }
    }

    pub(super) fn occupy(&mut self, column: u32, row: u32, height_dm: u16) {
        let cell = self.oem.grid().index(column, row) as u32;
        self.oem.join(OemDelta { cell, state: OemCell::Occupied { height_dm } });
    }
}

pub(super) fn fill(raster: &mut Raster, x: [f64; 2], y: [f64; 2]) {
    raster.fill_rings(&[[[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]]);
}

/// In the middle, heading east: north is left, south is right.
fn middle() -> Pose {
    Pose::level([0.0, 0.0, 52.0], 0.0)
}

/// Equal patches on both sides.
fn both_sides(config: &AgentConfig) -> Scene {
    let mut scene = Scene::new(config);
    fill(&mut scene.wanted, [0.0, 160.0], [60.0, 200.0]);
    fill(&mut scene.wanted, [0.0, 160.0], [-200.0, -60.0]);
    scene
}

fn first_turn(config: &AgentConfig, scene: &Scene, neighbours: &[Vec<Pose>]) -> f64 {
    turn(&Planner::new(config).plan(&scene.input(), &middle(), neighbours))
}

#[test]
fn a_wall_turns_str3_away_and_leaves_the_others_cold() {
    for criterion in CRITERIA {
        let config = left_or_right(criterion, 0.0);
        let mut scene = both_sides(&config);
        assert_eq!(first_turn(&config, &scene, &[]), LEFT, "a tie");
        // A wall 40 m high to the left, y 55..60.
        (45..90).for_each(|column| scene.occupy(column, 61, 400));
        let expected = if criterion == Criterion::Str3 { RIGHT } else { LEFT };
        assert_eq!(first_turn(&config, &scene, &[]), expected, "{criterion:?}");
    }
}

#[test]
fn only_str2_believes_that_the_hidden_stays_hidden() {
    for criterion in CRITERIA {
        let config = left_or_right(criterion, 0.0);
        let mut scene = both_sides(&config);
        fill(&mut scene.hidden_now, [0.0, 160.0], [100.0, 200.0]);
        let expected = if criterion == Criterion::Str2 { RIGHT } else { LEFT };
        assert_eq!(first_turn(&config, &scene, &[]), expected, "{criterion:?}");
    }
}

#[test]
fn obstacle_margins_attract_only_str1() {
    for criterion in CRITERIA {
        let config = left_or_right(criterion, 1.0);
        let mut scene = both_sides(&config);
        fill(&mut scene.wanted, [0.0, 160.0], [60.0, 240.0]);
        fill(&mut scene.margin, [-20.0, 240.0], [40.0, 250.0]);
        let expected = if criterion == Criterion::Str1 { LEFT } else { RIGHT };
        assert_eq!(first_turn(&config, &scene, &[]), expected, "{criterion:?}");
    }
}

#[test]
fn kappa_pulls_to_what_was_hidden() {
    for (criterion, kappa, expected) in [
        (Criterion::Str3, 0.0, LEFT),
        (Criterion::Str3, 1.0, RIGHT),
        (Criterion::Str2, 1.0, LEFT), // no J² there
    ] {
        let config = left_or_right(criterion, kappa);
        let mut scene = both_sides(&config);
        fill(&mut scene.hidden_recent, [0.0, 160.0], [-200.0, -60.0]);
        assert_eq!(first_turn(&config, &scene, &[]), expected, "{criterion:?} {kappa}");
    }
}

#[test]
fn neighbours_repel() {
    for criterion in CRITERIA {
        let config = left_or_right(criterion, 1.0);
        let scene = both_sides(&config);
        let first = Planner::new(&config).plan(&scene.input(), &middle(), &[]);
        assert_eq!(turn(&first), LEFT);
        assert_eq!(first_turn(&config, &scene, &[first.poses]), RIGHT, "{criterion:?}");
        assert_eq!(first_turn(&config, &scene, &[vec![]]), LEFT, "a neighbour without a plan");
    }
}

/// Agents with the same knowledge decide the same, with a shared view cache and without.
#[test]
fn shared_looks_change_nothing_and_save_looking_twice() {
    for criterion in CRITERIA {
        let config = left_or_right(criterion, 1.0);
        let mut scene = both_sides(&config);
        (45..90).for_each(|column| scene.occupy(column, 61, 400));
        let view_cache = ViewCache::default();
        let together = PlannerInput { view_cache: Some(&view_cache), ..scene.input() };
        let first = Planner::new(&config).plan(&together, &middle(), &[]).poses;
        let second = vec![Pose { yaw_rad: -0.4, ..first[0] }];
        for (plans, poses_looked_from) in
            [(vec![], 2), (vec![first.clone()], 2), (vec![first, second], 3)]
        {
            let alone = Planner::new(&config).plan(&scene.input(), &middle(), &plans);
            let shared = Planner::new(&config).plan(&together, &middle(), &plans);
            assert_eq!(format!("{alone:?}"), format!("{shared:?}"), "{criterion:?}");
            let expected = if criterion == Criterion::Str3 { poses_looked_from } else { 0 };
            assert_eq!(view_cache.poses(), expected, "{criterion:?}");
        }
    }
}

/// A box that has grown is planned for like one that was always as wide, and forgotten when it shrinks again.
#[test]
fn a_wider_box_about_the_pose_sees_less() {
    for criterion in [Criterion::Str3, Criterion::Str4] {
        let mut config = default_config();
        config.guidance.criterion = criterion;
        let mut scene = both_sides(&config);
        fill(&mut scene.wanted, [-250.0, 0.0], [-150.0, 30.0]);
        let wide = PoseError { p_world: [20.0, 20.0, 0.0], ..PoseError::NONE };
        let plan = |planner: &mut Planner, pose_error| {
            planner.plan(&PlannerInput { pose_error, ..scene.input() }, &middle(), &[])
        };
        let always_wide = AgentConfig { pose_error: wide, ..config.clone() };
        let expected = plan(&mut Planner::new(&always_wide), wide);
        let mut planner = Planner::new(&config);
        let exact = plan(&mut planner, PoseError::NONE);
        let grown = plan(&mut planner, wide);
        assert_eq!(grown, expected, "{criterion:?}");
        assert!(grown.cost > exact.cost, "{criterion:?}: {} {}", grown.cost, exact.cost);
        assert_eq!(plan(&mut planner, PoseError::NONE), exact, "{criterion:?}");
    }
}

/// In str2 another UAV does not see ground that is hidden to it (5.19).
#[test]
fn what_is_hidden_to_a_neighbour_is_left_to_others() {
    let config = left_or_right(Criterion::Str2, 0.0);
    let scene = both_sides(&config);
    let mut all = Raster::empty(config.raster_grid());
    fill(&mut all, [-250.0, 250.0], [-250.0, 250.0]);
    let mut planner = Planner::new(&config);
    let taken = vec![vec![planner.plan(&scene.input(), &middle(), &[]).poses[0]]];
    let hidden = [Some(&all)];
    let input = PlannerInput { neighbours_hidden_now: &hidden, ..scene.input() };
    assert_eq!(turn(&planner.plan(&input, &middle(), &taken)), LEFT);
    assert_eq!(turn(&planner.plan(&scene.input(), &middle(), &taken)), RIGHT);
}

/// No candidate sees anything: the distance decides, also when no footprint meets the region.
#[test]
fn who_sees_nothing_flies_to_the_nearest_remains() {
    let mut config = default_config();
    config.guidance.n_mpc = 1;
    let mut scene = Scene::new(&config);
    fill(&mut scene.wanted, [-250.0, -230.0], [-250.0, 250.0]);
    let mut planner = Planner::new(&config);
    for (pose, expected) in [
        (Pose::level([200.0, 0.0, 52.0], 0.3), LEFT),
        (Pose::level([400.0, -100.0, 52.0], -1.0), RIGHT),
    ] {
        let decision = planner.plan(&scene.input(), &pose, &[]);
        assert_eq!(turn(&decision), expected, "{pose:?}");
        assert!(decision.terms.distance_m > 100.0);
    }
    let nothing = Scene::new(&config);
    let decision = planner.plan(&nothing.input(), &middle(), &[]);
    assert_eq!((decision.increments_rad, decision.cost), (vec![0.0], 0.0), "straight ahead");
}

/// `predicted_hidden` lies in the footprint and does not depend on the criterion.
#[test]
fn predicted_hidden_ground_lies_in_the_footprint() {
    let config = left_or_right(Criterion::Str1, 0.0);
    let mut planner = Planner::new(&config);
    let mut scene = Scene::new(&config);
    assert_eq!(planner.predicted_hidden(&scene.oem, None, &middle()).count(), 0);
    (45..55).for_each(|row| scene.occupy(70, row, 200)); // x 100..105, y -25..25
    let hidden = planner.predicted_hidden(&scene.oem, None, &middle());
    let mut common = hidden.clone();
    common.intersect_with(&planner.footprint(&middle()));
    assert_eq!(common, hidden);
    // The base and the shadow of the roof: a trapezium from x 100 to 105·52/32.
    let stretch = 52.0 / 32.0;
    let expected = (105.0 * stretch - 100.0) * 25.0 * (1.0 + stretch * 105.0 / 100.0);
    assert!((hidden.area_m2() / expected - 1.0).abs() < 0.02, "{} {expected}", hidden.area_m2());
}
