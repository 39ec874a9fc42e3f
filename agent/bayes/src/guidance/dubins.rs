//! Shortest paths of bounded curvature between two poses in the plane (Dubins 1957).

use std::f64::consts::TAU;

/// A place and a heading: east and north in metres, radians counter-clockwise from east.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// East and north, metres.
    pub p: [f64; 2],
    /// Heading, radians.
    pub yaw_rad: f64,
}

/// A path of three arcs or straight lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    from: Place,
    radius_m: f64,
    /// The curvature (1 to the left, 0, −1 to the right) and the length in radii of each part.
    parts: [(f64, f64); 3],
}

impl Path {
    /// The shortest path from one place to another one that turns at `radius_m` or wider.
    pub fn shortest(from: Place, to: Place, radius_m: f64) -> Self {
        let (dx, dy) = (to.p[0] - from.p[0], to.p[1] - from.p[1]);
        let d = dx.hypot(dy) / radius_m;
        let direction = dy.atan2(dx);
        let a = (from.yaw_rad - direction).rem_euclid(TAU);
        let b = (to.yaw_rad - direction).rem_euclid(TAU);
        let length = |parts: &[(f64, f64); 3]| parts.iter().map(|part| part.1).sum::<f64>();
        let shorter = |best: [(f64, f64); 3], next: [(f64, f64); 3]| {
            if length(&next) < length(&best) { next } else { best }
        };
        let none = [(0.0, f64::INFINITY); 3];
        let parts = words(a, b, d).into_iter().flatten().fold(none, shorter);
        Self { from, radius_m, parts }
    }

    /// Its length, metres.
    pub fn length_m(&self) -> f64 {
        self.parts.iter().map(|part| part.1).sum::<f64>() * self.radius_m
    }

    /// Its points every `step_m` or less, without the first one, metres.
    pub fn points(&self, step_m: f64) -> Vec<[f64; 2]> {
        let mut place = self.from;
        let mut points = Vec::new();
        for (curvature, length) in self.parts {
            let steps = (length * self.radius_m / step_m).ceil().max(1.0);
            for _ in 0..steps as u32 {
                place = self.after(place, curvature, length / steps);
                points.push(place.p);
            }
        }
        points
    }

    fn after(&self, Place { p: [x, y], yaw_rad }: Place, curvature: f64, length: f64) -> Place {
        let half = curvature * length / 2.0;
        let chord = self.radius_m * if half == 0.0 { length } else { length * half.sin() / half };
        let (sin, cos) = (yaw_rad + half).sin_cos();
        Place { p: [x + chord * cos, y + chord * sin], yaw_rad: yaw_rad + 2.0 * half }
    }
}

/// The six kinds of shortest paths between headings a and b over a distance of d radii, as far as they exist
/// (Shkel and Lumelsky 2001).
fn words(a: f64, b: f64, d: f64) -> [Option<[(f64, f64); 3]>; 6] {
    let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
    let cab = (a - b).cos();
    // Rounding must not make a full circle of no turn.
    let turn = |angle: f64| Some(angle.rem_euclid(TAU)).filter(|a| *a < TAU - 1e-9).unwrap_or(0.0);
    let root = |square: f64| (square >= -1e-12).then(|| square.max(0.0).sqrt());
    let lsl = root(2.0 + d * d - 2.0 * cab + 2.0 * d * (sa - sb)).map(|p| {
        let t = (cb - ca).atan2(d + sa - sb);
        [(1.0, turn(t - a)), (0.0, p), (1.0, turn(b - t))]
    });
    let rsr = root(2.0 + d * d - 2.0 * cab + 2.0 * d * (sb - sa)).map(|p| {
        let t = (ca - cb).atan2(d - sa + sb);
        [(-1.0, turn(a - t)), (0.0, p), (-1.0, turn(t - b))]
    });
    let lsr = root(d * d - 2.0 + 2.0 * cab + 2.0 * d * (sa + sb)).map(|p| {
        let t = (-ca - cb).atan2(d + sa + sb) - (-2.0f64).atan2(p);
        [(1.0, turn(t - a)), (0.0, p), (-1.0, turn(t - b))]
    });
    let rsl = root(d * d - 2.0 + 2.0 * cab - 2.0 * d * (sa + sb)).map(|p| {
        let t = (ca + cb).atan2(d - sa - sb) - 2.0f64.atan2(p);
        [(-1.0, turn(a - t)), (0.0, p), (1.0, turn(b - t))]
    });
    let middle = |cosine: f64| (cosine.abs() <= 1.0).then(|| TAU - cosine.acos());
    let rlr = middle((6.0 - d * d + 2.0 * cab + 2.0 * d * (sa - sb)) / 8.0).map(|p| {
        let t = turn(a - (ca - cb).atan2(d - sa + sb) + p / 2.0);
        [(-1.0, t), (1.0, p), (-1.0, turn(a - b - t + p))]
    });
    let lrl = middle((6.0 - d * d + 2.0 * cab + 2.0 * d * (sb - sa)) / 8.0).map(|p| {
        let t = turn(-a + (cb - ca).atan2(d + sa - sb) + p / 2.0);
        [(1.0, t), (-1.0, p), (1.0, turn(b - a - t + p))]
    });
    [lsl, rsr, lsr, rsl, rlr, lrl]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_end_where_they_should_and_half_circles_are_half_circles() {
        let from = Place { p: [10.0, -5.0], yaw_rad: 0.7 };
        for index in 0..200 {
            let [x, y, yaw_rad] = [7.0, 11.0, 13.0].map(|f| (f64::from(index) * f).sin() * 300.0);
            let path = Path::shortest(from, Place { p: [x, y], yaw_rad }, 70.0);
            let end = path.points(5.0).pop().unwrap();
            assert!((end[0] - x).hypot(end[1] - y) < 1e-6, "{index}: {end:?}, not {x}, {y}");
            assert!(path.length_m() < 300.0 * 3.0 + 4.0 * TAU * 70.0);
        }
        let back = Place { p: [140.0, 0.0], yaw_rad: -TAU / 4.0 };
        let path = Path::shortest(Place { p: [0.0; 2], yaw_rad: TAU / 4.0 }, back, 70.0);
        assert!((path.length_m() - 70.0 * TAU / 2.0).abs() < 1e-6);
    }
}
