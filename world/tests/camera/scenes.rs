//! Random towns and poses with many cases that are hard to render.

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::TargetId;
use csat_world::scene::{Entity, Prism, Scene};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

pub type Ring = Vec<[f64; 2]>;

/// A town under construction.
#[derive(Default)]
pub struct Town {
    pub scene: Scene,
    targets: u16,
}

impl Town {
    pub fn add(&mut self, rings: Vec<Ring>, height_m: f64) {
        let entity = Entity::Obstacle(self.scene.prisms.len() as u32);
        self.scene.prisms.push(Prism { entity, rings, height_m });
    }

    pub fn add_car(&mut self, centre: [f64; 2], heading_rad: f64) {
        let entity = Entity::Target(TargetId(self.targets));
        self.targets += 1;
        let rings = vec![placed(&rectangle(4.6, 1.8), centre, heading_rad)];
        self.scene.prisms.push(Prism { entity, rings, height_m: 1.5 });
    }
}

/// A rectangle around the origin.
pub fn rectangle(width: f64, depth: f64) -> Ring {
    let (x, y) = (width / 2.0, depth / 2.0);
    vec![[-x, -y], [x, -y], [x, y], [-x, y]]
}

/// A ring turned, then moved.
pub fn placed(ring: &[[f64; 2]], centre: [f64; 2], angle_rad: f64) -> Ring {
    let (s, c) = angle_rad.sin_cos();
    ring.iter().map(|[x, y]| [centre[0] + c * x - s * y, centre[1] + s * x + c * y]).collect()
}

fn reversed(mut ring: Ring) -> Ring {
    ring.reverse();
    ring
}

/// A concave star with `n` points, radii within [low, high].
fn star(rng: &mut ChaCha8Rng, n: usize, low: f64, high: f64) -> Ring {
    (0..n)
        .map(|i| {
            let angle = (i as f64 + rng.random_range(-0.3..0.3)) * std::f64::consts::TAU / n as f64;
            let radius = rng.random_range(low..high);
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect()
}

/// Adds obstacles to a square cell of 20 m; leaves at least 0.2 m at its border.
fn fill_cell(town: &mut Town, rng: &mut ChaCha8Rng, centre: [f64; 2]) {
    let angle = if rng.random_bool(0.4) { 0.0 } else { rng.random_range(0.0..6.3) };
    let height = |rng: &mut ChaCha8Rng| {
        if rng.random_bool(0.3) { 10.0 } else { rng.random_range(2.0..30.0) }
    };
    let h = height(rng);
    let at = |ring: &[[f64; 2]]| placed(ring, centre, angle);
    match rng.random_range(0..9) {
        0 => {
            let (w, d) = (rng.random_range(3.0..13.0), rng.random_range(3.0..13.0));
            town.add(vec![at(&rectangle(w, d))], h);
        }
        1 => {
            let l =
                [[-6.0, -6.0], [6.0, -6.0], [6.0, -2.0], [-1.0, -2.0], [-1.0, 6.0], [-6.0, 6.0]];
            town.add(vec![at(&l)], h);
            // Sometimes the notch is filled by another building that touches both wings.
            if rng.random_bool(0.5) {
                let filling = [[-1.0, -2.0], [6.0, -2.0], [6.0, 4.0], [-1.0, 4.0]];
                let other = if rng.random_bool(0.3) { h } else { height(rng) };
                town.add(vec![at(&filling)], other);
            }
        }
        2 => {
            let u = [
                [-6.0, -6.0],
                [6.0, -6.0],
                [6.0, 6.0],
                [3.0, 6.0],
                [3.0, -3.0],
                [-3.0, -3.0],
                [-3.0, 6.0],
                [-6.0, 6.0],
            ];
            town.add(vec![at(&u)], h);
            if rng.random_bool(0.5) {
                town.add_car(placed(&[[0.0, 2.0]], centre, angle)[0], angle);
            }
        }
        3 => {
            let court = reversed(rectangle(8.0, 7.0));
            town.add(vec![at(&rectangle(13.0, 12.0)), at(&court)], h);
            match rng.random_range(0..4) {
                0 => town.add_car(centre, angle + rng.random_range(-0.3..0.3)),
                1 => town.add(vec![at(&rectangle(3.0, 3.0))], height(rng)),
                // Fills the court completely: all walls touch.
                2 => town.add(vec![at(&rectangle(8.0, 7.0))], height(rng)),
                _ => {}
            }
        }
        4 => {
            let n = rng.random_range(5..12);
            let ring = star(rng, n, 2.0, 9.5);
            town.add(vec![at(&ring)], h);
        }
        5 => {
            // Two buildings that share part of a wall.
            let shift = rng.random_range(-4.0..4.0);
            let a = [[-5.0, -5.0], [0.0, -5.0], [0.0, 5.0], [-5.0, 5.0]];
            let b = [[0.0, -3.0 + shift], [6.0, -3.0 + shift], [6.0, 3.0], [0.0, 3.0]];
            town.add(vec![at(&a)], h);
            let other = if rng.random_bool(0.3) { h } else { height(rng) };
            if shift < 5.0 {
                town.add(vec![at(&b)], other);
            }
        }
        6 => {
            // A car in the corner behind a tower.
            town.add(vec![at(&rectangle(4.0, 6.0))], h);
            let gap = rng.random_range(0.0..0.5);
            let spot = [2.0 + 0.9 + gap, rng.random_range(-4.0..4.0)];
            town.add_car(placed(&[spot], centre, angle)[0], angle + std::f64::consts::FRAC_PI_2);
        }
        7 => {
            // A ring of touching wedges of different heights around a point.
            for i in 0..5 {
                let at_angle = |i: usize| (i as f64 / 5.0 * std::f64::consts::TAU).sin_cos();
                let ((s0, c0), (s1, c1)) = (at_angle(i), at_angle(i + 1));
                let wedge = [[0.0, 0.0], [8.0 * c0, 8.0 * s0], [8.0 * c1, 8.0 * s1]];
                let top = height(rng);
                town.add(vec![at(&wedge)], top);
            }
        }
        _ => {
            let heading = rng.random_range(0.0..6.3);
            town.add_car(centre, heading);
        }
    }
}

/// A town of `side` x `side` cells around the origin.
pub fn town(rng: &mut ChaCha8Rng, side: usize) -> Scene {
    let mut town = Town::default();
    let spacing = if rng.random_bool(0.4) { 24.0 } else { rng.random_range(20.0..26.0) };
    for cell in 0..side * side {
        if rng.random_bool(0.75) {
            let offset = |i: usize| (i as f64 - (side as f64 - 1.0) / 2.0) * spacing;
            fill_cell(&mut town, rng, [offset(cell % side), offset(cell / side)]);
        }
    }
    town.scene
}

/// A camera with `columns` x `rows` pixels and varied optics.
pub fn model(rng: &mut ChaCha8Rng, columns: u16, rows: u16) -> CameraModel {
    // Straight down, and half as many pixels as metres to the roofs: edges on borders of pixels.
    let round = rng.random_bool(0.2);
    let aperture_deg = rng.random_range(20.0..80.0);
    let tilt_deg = rng.random_range(10.0..90.0);
    CameraModel {
        columns,
        rows,
        aperture_deg: if round { 90.0 } else { aperture_deg },
        tilt_deg: if round { 90.0 } else { tilt_deg },
        d_max_m: if rng.random_bool(0.4) { rng.random_range(30.0..120.0) } else { 300.0 },
        ..CameraModel::default()
    }
}

/// A pose above the town: anywhere, above a roof, or with rounded position and attitude.
pub fn pose(rng: &mut ChaCha8Rng, scene: &Scene) -> Pose {
    let top = scene.prisms.iter().fold(0.0f64, |top, prism| top.max(prism.height_m));
    let mut place = [rng.random_range(-90.0..90.0), rng.random_range(-90.0..90.0)];
    if rng.random_bool(0.2) {
        // Exactly above a corner, or in the plane of a wall.
        let prism = &scene.prisms[rng.random_range(0..scene.prisms.len())];
        let ring = &prism.rings[0];
        let (a, b) = (ring[0], ring[1]);
        let t = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(-3.0..3.0) };
        place = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    }
    let mut above = if rng.random_bool(0.2) { 0.1 } else { rng.random_range(0.5..40.0) };
    if rng.random_bool(0.2) {
        place = place.map(|x: f64| (x / 6.0).round());
        above = (10.0 + 24.0 - top).max(24.0 - top % 24.0);
    }
    let yaw_rad = match rng.random_range(0..3) {
        0 => f64::from(rng.random_range(0..4)) * std::f64::consts::FRAC_PI_2,
        _ => rng.random_range(-3.2..3.2),
    };
    let tilted = rng.random_bool(0.5);
    let mut angle = || if tilted { rng.random_range(-0.6..0.6) } else { 0.0 };
    let (pitch_rad, roll_rad) = (angle(), angle());
    Pose { p_world: [place[0], place[1], top + above], yaw_rad, pitch_rad, roll_rad }
}

/// A pose among the towers of a town, some of which are then higher than the camera: beside them,
/// at a corner or in the plane of a wall, now and then exactly as high as one.
pub fn pose_among(rng: &mut ChaCha8Rng, scene: &Scene) -> Pose {
    let above = pose(rng, scene);
    let tops: Vec<f64> = scene.prisms.iter().map(|prism| prism.height_m).collect();
    let z = match rng.random_range(0..4) {
        0 => tops[rng.random_range(0..tops.len())],
        _ => above.p_world[2] * rng.random_range(0.1..1.0),
    };
    let mut place = [above.p_world[0], above.p_world[1]];
    if rng.random_bool(0.4) {
        // Close before a wall.
        let ring = &scene.prisms[rng.random_range(0..scene.prisms.len())].rings[0];
        let (a, b) = (ring[0], ring[1]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let off = rng.random_range(0.002..3.0) / dx.hypot(dy);
        let t = rng.random_range(-0.2..1.2);
        place = [a[0] + t * dx + off * dy, a[1] + t * dy - off * dx];
    }
    let is_in = |prism: &Prism| prism.height_m > z - 0.01 && is_inside(prism, place);
    // A camera in a wall is not allowed.
    if scene.prisms.iter().any(is_in) {
        return above;
    }
    Pose { p_world: [place[0], place[1], z], ..above }
}

/// By the even-odd rule.
fn is_inside(prism: &Prism, p: [f64; 2]) -> bool {
    let crosses = |a: [f64; 2], b: [f64; 2]| {
        let x = || a[0] + (p[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]);
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < x()
    };
    let edges = prism.rings.iter().flat_map(|r| (0..r.len()).map(|i| (r[i], r[(i + 1) % r.len()])));
    edges.filter(|&(a, b)| crosses(a, b)).count() % 2 == 1
}
