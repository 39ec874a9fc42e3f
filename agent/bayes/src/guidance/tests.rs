use csat_proto::camera::CameraModel;
use csat_proto::detector::DetectorModel;
use csat_proto::fixed_wing::FixedWingModel;
use csat_proto::ids::{ChannelId, Incarnation, RunId};
use csat_proto::model::{FleetModel, Ground, StartPose, VehicleKind};
use csat_proto::raster::Grid;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::config::{BeliefConfig, ExchangeConfig, GuidanceConfig};
use crate::search_map::CELL_M;

pub(super) fn config(criterion: Criterion) -> AgentConfig {
    AgentConfig {
        run: RunId(1),
        seed: 0,
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: 0.25,
        ground: Ground { size_m: [1000.0, 1000.0] },
        fleet: FleetModel {
            count: 2,
            speed_m_s: 20.0,
            altitude_m: 90.0,
            altitude_step_m: 0.0,
            start: vec![StartPose { x_m: -5000.0, y_m: 0.0, yaw_deg: 0.0 }],
            vehicle: VehicleKind::FixedWing,
            ..FleetModel::default()
        },
        stations: 0,
        camera: CameraModel {
            columns: 640,
            rows: 480,
            aperture_deg: 49.3,
            tilt_deg: 90.0,
            ..CameraModel::default()
        },
        detector: DetectorModel::default(),
        pose_sigma: [10.5, 5.5, 2.0, 0.01, 0.05, 0.02],
        walk_m: 0.0,
        belief: BeliefConfig::default(),
        exchange: ExchangeConfig::default(),
        guidance: GuidanceConfig { criterion, ..GuidanceConfig::default() },
        channel: ChannelId(0),
    }
}

/// A map with a probability by place, up to a factor.
fn map(density: impl Fn([f64; 2]) -> f64) -> SearchMap {
    let grid = Grid::covering(&Ground { size_m: [1000.0, 1000.0] }, CELL_M);
    let centre = |cell: u32| grid.centre(cell % grid.columns, cell / grid.columns);
    let mut mass: Vec<f64> = (0..grid.columns * grid.rows).map(|c| density(centre(c))).collect();
    let sum: f64 = mass.iter().sum();
    mass.iter_mut().for_each(|m| *m /= sum);
    SearchMap { grid, mass }
}

/// An aircraft in flight under a guide that is told poses with errors.
struct Flown {
    guide: Guide,
    aircraft: FixedWing,
    sigma: [f64; 6],
    step: Step,
    rng: ChaCha8Rng,
}

impl Flown {
    fn new(config: &AgentConfig, [x, y]: [f64; 2], yaw_rad: f64) -> Self {
        let FleetModel { fixed_wing, speed_m_s, altitude_m, .. } = config.fleet;
        Self {
            guide: Guide::new(config),
            aircraft: FixedWing::level(fixed_wing, [x, y, altitude_m], yaw_rad, speed_m_s),
            sigma: config.pose_sigma,
            step: Step(0),
            rng: ChaCha8Rng::seed_from_u64(5),
        }
    }

    /// One step; gives the true pose after it.
    fn next(
        &mut self,
        map: &SearchMap,
        target: Option<Gaussian>,
        neighbours: &[NeighbourPlan],
    ) -> Pose {
        self.aircraft.advance(0.25);
        self.step = self.step.after(1);
        let pose = self.aircraft.pose();
        // Uniform errors of the same variance.
        let [along, across, up, yaw, pitch, roll] =
            self.sigma.map(|s| s * 3f64.sqrt() * self.rng.random_range(-1.0..1.0));
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let [x, y, z] = pose.p_world;
        let reported = Pose {
            p_world: [x + along * cos - across * sin, y + along * sin + across * cos, z + up],
            yaw_rad: pose.yaw_rad + yaw,
            pitch_rad: pose.pitch_rad + pitch,
            roll_rad: pose.roll_rad + roll,
        };
        let map = || map.clone();
        let input =
            GuidanceInput { step: self.step, pose: &reported, map: &map, target, neighbours };
        if let Some(command) = self.guide.step(&input) {
            let Command::Yaw { yaw_rad } = command else { panic!("{command:?}") };
            self.aircraft.command(yaw_rad);
        }
        pose
    }

    fn fly(&mut self, seconds: u32, map: &SearchMap, neighbours: &[NeighbourPlan]) -> Vec<Pose> {
        (0..4 * seconds).map(|_| self.next(map, None, neighbours)).collect()
    }
}

fn place(pose: &Pose) -> [f64; 2] {
    [pose.p_world[0], pose.p_world[1]]
}

fn windy(criterion: Criterion, wind_m_s: [f64; 2]) -> AgentConfig {
    let mut config = config(criterion);
    config.fleet.fixed_wing = FixedWingModel { wind_m_s, ..FixedWingModel::default() };
    config
}

#[test]
fn in_straight_flight_errors_of_reported_poses_hardly_bank_the_aircraft() {
    for wind in [[0.0, 0.0], [2.0, -4.0]] {
        let mut config = windy(Criterion::Waypoints, wind);
        config.guidance.waypoints = vec![vec![[1e5, 0.0]]];
        let mut flown = Flown::new(&config, [0.0, 0.0], 0.0);
        let poses = flown.fly(120, &map(|_| 1.0), &[]);
        let banks = poses[80..].iter().map(|pose| pose.roll_rad.abs());
        let most = banks.fold(0.0, f64::max).to_degrees();
        assert!(most < 4.0, "{most} deg");
        let last = place(&poses[479]);
        assert!(last[1].abs() < 10.0 && last[0] > 1900.0, "{last:?}");
    }
}

#[test]
fn way_points_are_passed_in_order_again_and_again() {
    let mut config = windy(Criterion::Waypoints, [3.0, 3.0]);
    // The third one is inside of the turn after the second one.
    let points = vec![[300.0, 0.0], [300.0, 300.0], [270.0, 250.0], [-100.0, 0.0]];
    config.guidance.waypoints = vec![points.clone()];
    let mut flown = Flown::new(&config, [0.0, 0.0], 0.0);
    let poses = flown.fly(240, &map(|_| 1.0), &[]);
    let mut visited = 0;
    for pose in &poses {
        if route::distance(place(pose), points[visited % 4]) < 75.0 {
            visited += 1;
        }
    }
    assert!(visited >= 8, "{visited}");
}

/// The strip of aircraft 1 is the eastern half: each place of it comes into the image.
#[test]
fn lanes_cover_the_strip_and_their_turns_can_be_flown() {
    for wind in [[0.0, 0.0], [4.0, 2.0]] {
        let config = AgentConfig { id: AgentId(1), ..windy(Criterion::Lawnmower, wind) };
        let mut flown = Flown::new(&config, [40.0, -500.0], 1.57);
        let mut left = map(|[x, _]| if x > 0.0 { 1.0 } else { 0.0 });
        let grid = left.grid;
        for pose in flown.fly(800, &map(|_| 1.0), &[]) {
            let ([x, y], view) = (place(&pose), config.camera.at(&pose));
            for row in grid.rows_between(y - 60.0, y + 60.0) {
                for column in grid.columns_between(x - 60.0, x + 60.0) {
                    let [px, py] = grid.centre(column, row);
                    let image = view.project(&nalgebra::Vector3::new(px, py, 0.0));
                    if image.is_some_and(|[c, r]| c.min(r) > 0.0 && c < 640.0 && r < 480.0) {
                        left.mass[(row * grid.columns + column) as usize] = 0.0;
                    }
                }
            }
        }
        let missed: f64 = left.mass.iter().sum();
        assert!(missed < 0.002, "wind {wind:?}: {missed}");
        assert_eq!(flown.guide.planned().len(), 20);
    }
}

/// No way between lanes is much longer than the widest turn, and the aircraft stays on the route.
#[test]
fn u_turns_are_possible() {
    let config = config(Criterion::Lawnmower);
    let airframe = Airframe::new(&config);
    let start = Pose::level([-460.0, -500.0, 90.0], 1.57);
    let route = Lanes::new(&config, &airframe).route(&start);
    let mut flown = Flown::new(&config, place(&start), 1.57);
    let poses = flown.fly(600, &map(|_| 1.0), &[]);
    let off = |pose: &Pose| {
        let off = route.points().iter().map(|p| route::distance(*p, place(pose)));
        off.fold(f64::INFINITY, f64::min)
    };
    let most = poses.iter().map(off).fold(0.0, f64::max);
    assert!(most < 20.0, "{most} m off");
}

#[test]
fn information_goes_to_unseen_ground() {
    for side in [1.0, -1.0] {
        let mut flown = Flown::new(&config(Criterion::Information), [-300.0, 0.0], 0.0);
        let unseen = map(|[_, y]| if y * side > 0.0 { 1.0 } else { 0.01 });
        let end = place(&flown.fly(12, &unseen, &[])[47]);
        assert!(end[1] * side > 30.0, "{end:?}");
    }
}

#[test]
fn information_avoids_ground_that_a_neighbour_is_going_to_see() {
    let patches =
        map(|[x, y]| if x.abs() < 80.0 && (60.0..200.0).contains(&y.abs()) { 1.0 } else { 0.0 });
    for side in [1.0, -1.0] {
        let mut flown = Flown::new(&config(Criterion::Information), [-200.0, 0.0], 0.0);
        let lane = |second: u32| {
            let along = -200.0 + 20.0 * f64::from(second % 20);
            let y = if second < 20 { 100.0 } else { 170.0 };
            Pose::level([along, y * side, 90.0], 0.0)
        };
        let poses = (1..=40).map(lane).collect();
        let plan = NeighbourPlan { id: AgentId(1), step: Step(0), poses };
        let end = place(&flown.fly(8, &patches, &[plan])[31]);
        assert!(end[1] * side < -20.0, "{side}: {end:?}");
    }
}

#[test]
fn with_a_target_it_comes_back_again_and_again() {
    let mut flown = Flown::new(&config(Criterion::Information), [-200.0, 60.0], 0.0);
    let target = Gaussian { mean: [0.0, 0.0], covariance: [200.0, 0.0, 200.0] };
    let anywhere = map(|_| 1.0);
    let (mut visits, mut near) = (0, false);
    for _ in 0..4 * 90 {
        let pose = flown.next(&anywhere, Some(target), &[]);
        let d = route::distance(place(&pose), target.mean);
        visits += u32::from(d < 45.0 && !near);
        near = d < if near { 60.0 } else { 45.0 };
        assert!(d < 320.0, "{d} m away");
    }
    assert!(visits >= 3, "{visits}");
}

#[test]
fn it_flies_what_it_announces_in_wind_too() {
    for wind in [[0.0, 0.0], [5.0, -3.0]] {
        let mut config = windy(Criterion::Information, wind);
        config.guidance.period_s = 20.0;
        config.pose_sigma = [0.0; 6];
        let mut flown = Flown::new(&config, [-300.0, -300.0], 0.7);
        flown.fly(1, &map(|_| 1.0), &[]);
        let planned = flown.guide.planned().to_vec();
        assert_eq!(flown.guide.planned_at(), Step(1));
        let poses = flown.fly(18, &map(|_| 1.0), &[]);
        for (second, pose) in planned.iter().enumerate().skip(1).take(17) {
            // Poses of `fly` begin at step 5; that of `second` is at step 5 + 4 `second`.
            let off = route::distance(place(pose), place(&poses[4 * second]));
            assert!(off < 2.0 + 0.6 * second as f64, "second {second}: {off} m off");
        }
    }
}

#[test]
fn equal_inputs_make_equal_commands() {
    let fly = || {
        let mut flown = Flown::new(&config(Criterion::Information), [-460.0, -500.0], 1.57);
        flown.fly(10, &map(|[x, y]| 1.0 + (x / 90.0).sin() * (y / 70.0).sin()), &[])
    };
    assert_eq!(fly(), fly());
}

#[test]
fn on_ground_that_is_all_the_same_it_goes_straight() {
    let mut flown = Flown::new(&config(Criterion::Information), [0.0, 0.0], 0.0);
    let nothing = SearchMap { mass: vec![0.0; 6400], ..map(|_| 1.0) };
    let poses = flown.fly(10, &nothing, &[]);
    assert!(poses.iter().all(|pose| pose.roll_rad.abs() < 0.02));
}
