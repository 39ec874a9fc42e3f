//! Plane geometry and a second pinhole camera, implemented from the definitions: they share no code
//! with what they check.

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::region::{Region, metres};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A point of the ground, `world`, metres.
pub type Point = [f64; 2];

/// Distance between two points, metres.
pub fn distance_m(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance from a point to a segment, metres.
pub fn distance_to_segment_m(p: Point, [a, b]: [Point; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let squared = d[0] * d[0] + d[1] * d[1];
    let along = if squared > 0.0 {
        (((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    distance_m(p, [a[0] + along * d[0], a[1] + along * d[1]])
}

/// The edges of a ring.
pub fn edges(ring: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
}

/// Whether a point is inside a polygon with holes, by the even-odd rule.
pub fn is_inside(rings: &[Vec<Point>], p: Point) -> bool {
    let crosses = |[a, b]: [Point; 2]| {
        (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    rings.iter().flat_map(|ring| edges(ring)).filter(|&edge| crosses(edge)).count() % 2 == 1
}

/// Distance from a point to a polygon with holes, metres; 0 inside.
pub fn distance_to_rings_m(rings: &[Vec<Point>], p: Point) -> f64 {
    if is_inside(rings, p) {
        return 0.0;
    }
    let distances =
        rings.iter().flat_map(|ring| edges(ring)).map(|edge| distance_to_segment_m(p, edge));
    distances.fold(f64::INFINITY, f64::min)
}

/// Up to `count` random points of a region; fewer when it fills little of its bounding boxes.
pub fn points_in(region: &Region, count: usize, rng: &mut ChaCha8Rng) -> Vec<Point> {
    let mut points = Vec::new();
    for shape in region.shapes() {
        let ring: Vec<Point> = shape[0].iter().map(|&p| metres(p)).collect();
        let bound = |axis: usize| {
            let values = ring.iter().map(|p| p[axis]);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            })
        };
        let ([west, east], [south, north]) = (bound(0), bound(1));
        let share = count.div_ceil(region.shapes().len());
        let drawn = (0..8 * share).map(|_| {
            let t: [f64; 2] = [rng.random(), rng.random()];
            [west + t[0] * (east - west), south + t[1] * (north - south)]
        });
        points.extend(drawn.filter(|&p| region.contains(p)).take(share));
    }
    points
}

/// The area of the symmetric difference of two sets, square metres.
pub fn difference_m2(a: &Region, b: &Region) -> f64 {
    use csat_agent::region::Outer;
    let common = Outer::containing(a.clone()).intersection(&Outer::containing(b.clone()));
    (a.area_m2() + b.area_m2() - 2.0 * common.region().area_m2()).max(0.0)
}

/// The pinhole of (3.16) and (4.43) for a pose without roll, implemented from the angles.
#[derive(Debug, Clone, Copy)]
pub struct Pinhole {
    centre: Vector3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
    forward: Vector3<f64>,
    focal_px: f64,
    half: [f64; 2],
}

impl Pinhole {
    /// The camera at a pose.
    pub fn new(model: &CameraModel, pose: &Pose) -> Self {
        assert_eq!(pose.roll_rad, 0.0, "this pinhole does not roll");
        let (sin_yaw, cos_yaw) = pose.yaw_rad.sin_cos();
        let (sin, cos) = (model.tilt_deg.to_radians() + pose.pitch_rad).sin_cos();
        let forward = Vector3::new(cos_yaw * cos, sin_yaw * cos, -sin);
        let right = Vector3::new(sin_yaw, -cos_yaw, 0.0);
        let half = [f64::from(model.columns) / 2.0, f64::from(model.rows) / 2.0];
        Self {
            centre: Vector3::from(pose.p_world),
            right,
            down: forward.cross(&right),
            forward,
            focal_px: half[0] / (model.aperture_deg.to_radians() / 2.0).tan(),
            half,
        }
    }

    /// The image point of a point of space, and its distance; `None` behind the camera.
    pub fn project(&self, p_world: Vector3<f64>) -> Option<([f64; 2], f64)> {
        let v = p_world - self.centre;
        let depth = v.dot(&self.forward);
        (depth > 1e-9).then(|| {
            let c = self.half[0] - self.focal_px * v.dot(&self.right) / depth;
            let r = self.half[1] - self.focal_px * v.dot(&self.down) / depth;
            ([c, r], v.norm())
        })
    }

    /// The point at a distance along the ray of an image point.
    pub fn point_at(&self, [c, r]: [f64; 2], distance_m: f64) -> Vector3<f64> {
        let x = (self.half[0] - c) / self.focal_px;
        let y = (self.half[1] - r) / self.focal_px;
        let ray = self.right * x + self.down * y + self.forward;
        self.centre + ray * (distance_m / ray.norm())
    }

    /// Where the ray of an image point meets the ground; `None` when it does not.
    pub fn ground(&self, [c, r]: [f64; 2]) -> Option<Point> {
        let ray = self.point_at([c, r], 1.0) - self.centre;
        (ray.z < 0.0).then(|| {
            let p = self.centre - ray * (self.centre.z / ray.z);
            [p.x, p.y]
        })
    }
}
