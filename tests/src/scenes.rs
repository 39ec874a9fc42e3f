//! Random scenes, poses and cameras: with many hard cases, and within all assumptions.

use std::f64::consts::TAU;

use csat_agent::config::{AgentConfig, Channels, EstimatorConfig, ExchangeConfig, GuidanceConfig};
use csat_proto::camera::{Assumption, CameraModel, Pose, PoseError, PoseEstimate};
use csat_proto::frame::{Frame, Label};
use csat_proto::ids::{AgentId, Incarnation, RunId, TargetId};
use csat_proto::model::{FleetModel, Ground, TargetsModel};
use csat_proto::time::Step;
use csat_world::camera::Renderer;
use csat_world::scene::{Entity, Prism, Scene};
use csat_world::target::TargetTruth;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::geometry::{Point, distance_m, distance_to_rings_m, edges};

mod shapes;

/// One frame to be taken: the true scene, and the configuration of the agent.
#[derive(Debug, Clone)]
pub struct Case {
    /// The seed that it was drawn from.
    pub seed: u64,
    /// The configuration of the agent.
    pub config: AgentConfig,
    /// Obstacles, then targets.
    pub scene: Scene,
    /// The true states of the targets.
    pub targets: Vec<TargetTruth>,
    /// The pose of the UAV.
    pub pose: Pose,
}

impl Case {
    /// The case of a seed.
    pub fn random(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let config = config(&mut rng);
        let altitude_m = rng.random_range(30.0..80.0);
        let mut scene = Scene { prisms: obstacles(&mut rng, &config.ground, altitude_m) };
        let targets = targets(&mut rng, &config, &scene.prisms);
        let pose = pose(&mut rng, &config, altitude_m, &scene.prisms, &targets);
        scene.prisms.extend(targets.iter().map(|t| t.prism(config.targets.body_m)));
        Self { seed, config, scene, targets, pose }
    }

    /// The case of a seed with a camera without roll, and another assumption.
    pub fn level(seed: u64, assumption: Assumption) -> Self {
        let mut case = Self::random(seed);
        case.pose.roll_rad = 0.0;
        case.config.camera.assumption = assumption;
        case
    }

    /// The frame of the camera.
    pub fn frame(&self) -> Frame {
        let mut renderer = Renderer::new(self.config.camera);
        renderer.frame(&self.scene, &self.pose, Step(1), self.seed, AgentId(0))
    }

    /// The frame of the camera as an agent gets it that knows its pose to a box: the true pose is anywhere in it.
    pub fn uncertain_frame(&self) -> Frame {
        let mut rng = ChaCha8Rng::seed_from_u64(!self.seed);
        let PoseEstimate { pose, error } = estimate(&mut rng, &self.pose);
        Frame { pose, pose_error: error, ..self.frame() }
    }

    /// The rings of every obstacle.
    pub fn obstacles(&self) -> impl Iterator<Item = &[Vec<Point>]> {
        let is_obstacle = |prism: &&Prism| matches!(prism.entity, Entity::Obstacle(_));
        self.scene.prisms.iter().filter(is_obstacle).map(|prism| prism.rings.as_slice())
    }

    /// The distance to the nearest obstacle, metres.
    pub fn distance_to_obstacles_m(&self, p: Point) -> f64 {
        self.obstacles().map(|rings| distance_to_rings_m(rings, p)).fold(f64::INFINITY, f64::min)
    }
}

/// A frame whose pixels are all Unknown: an agent that gets it only predicts.
pub fn blind(camera: &CameraModel, step: Step, pose: Pose) -> Frame {
    let (labels, depth) = (vec![Label::Unknown; camera.pixels()], vec![0; camera.pixels()]);
    Frame { labels, depth, ..Frame::of_detector(step, pose, None) }
}

/// A box that contains a pose: of any width in some of its components, none in others.
fn estimate(rng: &mut ChaCha8Rng, pose: &Pose) -> PoseEstimate {
    let size: f64 = *[0.02, 0.3, 1.0].choose(rng).expect("some");
    let half = [4.0, 4.0, 1.0, 0.15, 0.03, 0.03].map(|most: f64| {
        if rng.random_bool(0.6) { size * rng.random_range(0.0..most) } else { 0.0 }
    });
    // At the ends of the box more often than inside.
    let off = half
        .map(|half| half * *[-1.0, 1.0, rng.random_range(-1.0..1.0)].choose(rng).expect("some"));
    let [x, y, z] = pose.p_world;
    let reported = Pose {
        p_world: [x + off[0], y + off[1], z + off[2]],
        yaw_rad: pose.yaw_rad + off[3],
        pitch_rad: pose.pitch_rad + off[4],
        roll_rad: pose.roll_rad + off[5],
    };
    // The sums above are rounded.
    let [x, y, z, yaw_rad, pitch_rad, roll_rad] =
        half.map(|half| if half > 0.0 { half + 1e-12 } else { 0.0 });
    let error = PoseError { p_world: [x, y, z], yaw_rad, pitch_rad, roll_rad };
    PoseEstimate { pose: reported, error }
}

fn config(rng: &mut ChaCha8Rng) -> AgentConfig {
    let body_m = *[[4.6, 1.8, 1.5], [4.6, 1.8, 1.5], [3.0, 3.0, 2.0], [4.2, 0.8, 0.6]]
        .choose(rng)
        .expect("some");
    let half_diagonal_m = f64::hypot(body_m[0], body_m[1]) / 2.0;
    let targets = TargetsModel {
        count: 0,
        v_max_m_s: rng.random_range(0.0..3.0),
        obstacle_distance_m: half_diagonal_m + rng.random_range(0.01..1.0),
        target_distance_m: rng.random_range(5.5..10.0),
        radius_m: half_diagonal_m + *[1e-9, 0.03, 0.5].choose(rng).expect("some"),
        cylinder_height_m: body_m[2],
        body_m,
        ..TargetsModel::default()
    };
    let estimator = EstimatorConfig {
        disc_vertices: *[8, 16, 24].choose(rng).expect("some"),
        simplify_m: *[0.0, 0.15, 0.5].choose(rng).expect("some"),
        outline_tolerance_px: *[0.0, 1.0, 2.0].choose(rng).expect("some"),
        ..EstimatorConfig::default()
    };
    AgentConfig {
        run: RunId(0),
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: 0.5,
        ground: Ground { size_m: [0; 2].map(|_| rng.random_range(80.0..150.0)) },
        targets,
        fleet: FleetModel { count: 2, ..FleetModel::default() },
        stations: 0,
        camera: camera(rng),
        pose_error: PoseError::NONE,
        estimator,
        guidance: GuidanceConfig::default(),
        exchange: ExchangeConfig::default(),
        channels: Channels::default(),
        radio_range_m: f64::INFINITY,
    }
}

fn camera(rng: &mut ChaCha8Rng) -> CameraModel {
    let sizes = [(64, 48), (96, 72), (48, 36), (54, 72)];
    let (columns, rows) = *sizes.choose(rng).expect("some");
    let assumptions = [Assumption::EveryRay, Assumption::SomeRay, Assumption::CentreRay];
    let weight = rng.random_range(0..5usize);
    let noise: f64 = *[0.0, 0.002, 0.01, 0.05].choose(rng).expect("some");
    CameraModel {
        columns,
        rows,
        aperture_deg: rng.random_range(15.0..90.0),
        tilt_deg: rng.random_range(15.0..90.0),
        d_max_m: rng.random_range(60.0..300.0),
        depth_noise: [-noise * rng.random_range(0.0..1.0), noise * rng.random_range(0.0..1.0)],
        min_pixels: rng.random_range(1..5),
        box_error_px: *[0, 0, 1, 5].choose(rng).expect("some"),
        assumption: assumptions[weight.saturating_sub(2)],
        misidentify: 0.0,
    }
}

fn obstacles(rng: &mut ChaCha8Rng, ground: &Ground, altitude_m: f64) -> Vec<Prism> {
    let mut placed: Vec<(Point, f64)> = Vec::new();
    let mut prisms = Vec::new();
    for _ in 0..rng.random_range(2..14) {
        let (rings, radius_m) = shapes::random(rng);
        let centre = ground.size_m.map(|size| rng.random_range(-0.5..0.5) * size);
        if placed.iter().any(|&(c, r)| distance_m(c, centre) < r + radius_m) {
            continue;
        }
        placed.push((centre, radius_m));
        let angle = rng.random_range(0.0..TAU);
        let rings = rings.iter().map(|ring| shapes::placed(ring, centre, angle)).collect();
        // Some obstacles reach almost up to the camera.
        let tallest: f64 = if rng.random_bool(0.2) { altitude_m - 0.5 } else { 25.0 };
        let height_m = rng.random_range(2.0..tallest);
        prisms.push(Prism { entity: Entity::Obstacle(prisms.len() as u32), rings, height_m });
    }
    prisms
}

/// Targets as near to corners, walls, each other and the border as the model allows.
fn targets(rng: &mut ChaCha8Rng, config: &AgentConfig, prisms: &[Prism]) -> Vec<TargetTruth> {
    let TargetsModel { obstacle_distance_m, target_distance_m, .. } = config.targets;
    let mut targets: Vec<TargetTruth> = Vec::new();
    for _ in 0..rng.random_range(4..20) {
        let anchor = anchor(rng, prisms, &targets, &config.ground);
        let gap_m = *[1e-6, 0.01, 0.3, 4.0].choose(rng).expect("some");
        let radius_m = gap_m
            + match anchor {
                Anchor::Wall(_) => obstacle_distance_m,
                Anchor::Target(_) => target_distance_m,
                Anchor::Anywhere(_) => 0.0,
            };
        let (Anchor::Wall(p) | Anchor::Target(p) | Anchor::Anywhere(p)) = anchor;
        let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
        let location = [p[0] + radius_m * cos, p[1] + radius_m * sin];
        let clear = prisms.iter().all(|o| {
            let distance = distance_to_rings_m(&o.rings, location);
            distance > obstacle_distance_m
        });
        let apart = targets.iter().all(|t| distance_m(t.location, location) > target_distance_m);
        if clear && apart && config.ground.contains(location) {
            let (id, heading_rad) = (TargetId(targets.len() as u16), rng.random_range(0.0..TAU));
            targets.push(TargetTruth { id, location, heading_rad, speed_m_s: 0.0 });
        }
    }
    targets
}

/// What a target is placed next to.
enum Anchor {
    Wall(Point),
    Target(Point),
    Anywhere(Point),
}

fn anchor(
    rng: &mut ChaCha8Rng,
    prisms: &[Prism],
    targets: &[TargetTruth],
    ground: &Ground,
) -> Anchor {
    match rng.random_range(0..10) {
        0..5 => {
            let Some(prism) = prisms.choose(rng) else { return Anchor::Anywhere([0.0; 2]) };
            let all: Vec<_> = prism.rings.iter().flat_map(|ring| edges(ring)).collect();
            let [a, b] = *all.choose(rng).expect("a ring has edges");
            let t = if rng.random_bool(0.4) { 0.0 } else { rng.random_range(0.0..1.0) };
            Anchor::Wall([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])])
        }
        5..8 if !targets.is_empty() => Anchor::Target(targets.choose(rng).expect("some").location),
        _ => Anchor::Anywhere(ground.size_m.map(|size| rng.random_range(-0.5..0.5) * size)),
    }
}

/// A pose that mostly looks at an obstacle or target; sometimes above one, or at the border looking
/// in or out.
fn pose(
    rng: &mut ChaCha8Rng,
    config: &AgentConfig,
    altitude_m: f64,
    prisms: &[Prism],
    targets: &[TargetTruth],
) -> Pose {
    let anywhere = config.ground.size_m.map(|size| rng.random_range(-0.5..0.5) * (size + 60.0));
    let corner = prisms.choose(rng).map(|prism| prism.rings[0][0]);
    let target = targets.choose(rng).map(|target| target.location);
    let looked_at = if rng.random_bool(0.7) { target.or(corner) } else { corner.or(target) };
    let bearing = rng.random_range(0.0..TAU);
    let (place, yaw_rad) = match (rng.random_range(0..10), looked_at) {
        (0..7, Some(p)) => {
            let half = config.camera.aperture_deg / 2.5;
            let tilt = config.camera.tilt_deg + rng.random_range(-half..half);
            let away_m = altitude_m / tilt.clamp(12.0, 89.9).to_radians().tan();
            let off = rng.random_range(-0.15..0.15);
            let back = [away_m * bearing.cos(), away_m * bearing.sin()];
            ([p[0] - back[0], p[1] - back[1]], bearing + off)
        }
        (7, Some(p)) => (p, bearing),
        _ => (anywhere, bearing),
    };
    let mut lean = || if rng.random_bool(0.3) { rng.random_range(-0.15..0.15) } else { 0.0 };
    let (pitch_rad, roll_rad) = (lean(), lean());
    Pose { p_world: [place[0], place[1], altitude_m], yaw_rad, pitch_rad, roll_rad }
}
