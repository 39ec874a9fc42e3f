//! Footprints.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::geometry::Point;

/// A footprint about the origin and the radius of a circle around it, metres.
pub fn random(rng: &mut ChaCha8Rng) -> (Vec<Vec<Point>>, f64) {
    let rings = match rng.random_range(0..6) {
        0 | 1 => vec![rectangle(rng.random_range(4.0..25.0), rng.random_range(4.0..15.0))],
        2 => {
            let (a, b) = (rng.random_range(5.0..9.0), rng.random_range(-3.0..3.0));
            vec![vec![[-a, -a], [a, -a], [a, b], [b, b], [b, a], [-a, a]]]
        }
        3 => {
            // A U whose inside may be wide enough for a target.
            let w = rng.random_range(2.0..5.0);
            let (a, b) = (w + rng.random_range(1.0..4.0), rng.random_range(6.0..12.0));
            vec![vec![[-a, -b], [a, -b], [a, b], [w, b], [w, -w], [-w, -w], [-w, b], [-a, b]]]
        }
        4 => vec![star(rng)],
        _ => {
            let court = rng.random_range(2.0..8.0);
            let side = court + rng.random_range(1.0..5.0);
            let mut hole = rectangle(2.0 * court, 2.0 * court);
            hole.reverse();
            vec![rectangle(2.0 * side, 2.0 * side), hole]
        }
    };
    let radius = rings.iter().flatten().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
    (rings, radius)
}

/// A ring turned, then moved.
pub fn placed(ring: &[Point], centre: Point, angle_rad: f64) -> Vec<Point> {
    let (s, c) = angle_rad.sin_cos();
    ring.iter().map(|[x, y]| [centre[0] + c * x - s * y, centre[1] + s * x + c * y]).collect()
}

fn rectangle(width: f64, depth: f64) -> Vec<Point> {
    let (x, y) = (width / 2.0, depth / 2.0);
    vec![[-x, -y], [x, -y], [x, y], [-x, y]]
}

fn star(rng: &mut ChaCha8Rng) -> Vec<Point> {
    let n = rng.random_range(5..12);
    let corner = |i: usize| {
        let angle = (i as f64 + rng.random_range(-0.3..0.3)) * TAU / n as f64;
        let radius = rng.random_range(2.0..12.0);
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..n).map(corner).collect()
}
