//! What a frame shows from all poses of a box.
//!
//! The true pose is in a box about the reported one ([`PoseError`]). What must contain is the union over the box
//! (∃), what must be contained the intersection (∀) (thesis §6.1.2). Both follow from where single points may be:
//!
//! - A location enters or leaves the image of an outline only when the outline crosses it on a path of poses. An edge
//!   between two corners is mapped to a segment between their images, so the edge sweeps no more than the convex
//!   hull of the places of both corners: `PoseBox::swept_outline`.
//! - A convex hull of points moves within the hull of their places: `PoseBox::tilt`, `PoseBox::turned` and `PoseBox::moved`.
//!
//! Places of points are computed in the frame of the heading, where roll, pitch and height act, then turned by the
//! yaw and moved by the position, which both act on the ground as rigid motions (docs/concepts/pose.md).

use csat_proto::camera::{CameraView, Pose, PoseError};
use csat_proto::region::{MAX_COORDINATE_M, Ring, grid_point, metres, to_units};
use nalgebra::{Matrix3, Vector3};

use super::hull::convex_hull;
use crate::region::NUMERIC_MARGIN_M;

/// The least angle of a ray below the horizon, radians: beyond it, ground is too far for the grid.
const LEAST_DIP_RAD: f64 = 1e-3;

/// Yaws beyond this are taken for any, radians: the triangle of an arc would be large.
const MOST_YAW_RAD: f64 = 1.0;

/// How far points are from the camera, and how far above or below it, at most, metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extent {
    /// The distance.
    pub reach_m: f64,
    /// The difference of the heights.
    pub drop_m: f64,
}

impl Extent {
    /// That of the points of both.
    pub(super) fn or(self, other: Self) -> Self {
        Self { reach_m: self.reach_m.max(other.reach_m), drop_m: self.drop_m.max(other.drop_m) }
    }
}

/// How far roll and pitch move points over the ground: a rectangle along the heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tilt {
    ahead_m: f64,
    aside_m: f64,
    /// The unit vector of the reported heading, `world`.
    ahead: [f64; 2],
    /// The error of that heading.
    yaw_rad: f64,
}

impl Tilt {
    /// Points whose convex hull contains `points` (`world`, metres), wherever they are moved.
    pub(super) fn about(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let [cos, sin] = self.ahead;
        let moves = corners(self.ahead_m, self.aside_m)
            .map(|[ahead, aside]| [ahead * cos - aside * sin, ahead * sin + aside * cos]);
        let all = points.iter().flat_map(|p| moves.map(|[dx, dy]| [p[0] + dx, p[1] + dy]));
        all.collect()
    }

    /// How far a point is moved, at most, metres.
    pub(super) fn most_m(&self) -> f64 {
        self.ahead_m.hypot(self.aside_m)
    }

    /// How far a point is moved along a unit vector, at most, metres, at any yaw of the box.
    pub(super) fn along_m(&self, [x, y]: [f64; 2]) -> f64 {
        let [cos, sin] = self.ahead;
        let [ahead, aside] = [(x * cos + y * sin).abs(), (y * cos - x * sin).abs()];
        self.ahead_m * ahead + self.aside_m * aside + self.yaw_rad * self.most_m()
    }
}

/// The poses that a frame may have been taken from.
#[derive(Debug, Clone)]
pub struct PoseBox {
    pose: Pose,
    error: PoseError,
    /// Takes a ray of the image, (c, r, 1), to the body.
    body_from_image: Matrix3<f64>,
}

/// An interval: least and greatest number.
type Interval = [f64; 2];

impl PoseBox {
    /// The poses within `error` of `pose`, for the camera of `view`, which is at `pose`.
    pub fn new(view: &CameraView, pose: &Pose, error: &PoseError) -> Self {
        let body_from_image = pose.world_from_body().transpose() * view.ray_matrix();
        Self { pose: *pose, error: *error, body_from_image }
    }

    /// Whether it is one pose.
    pub fn is_exact(&self) -> bool {
        self.error.is_none()
    }

    /// A convex set that contains the image on the ground of the image point (c, r), pixels, from every pose of the
    /// box. `None` if the ray may miss the ground, or meet it beyond the grid.
    pub(crate) fn ground_place(&self, c: f64, r: f64) -> Option<Ring> {
        let tilted = self.tilted_ground(c, r)?;
        let place = self.moved(tilted.into_iter().map(|p| self.to_world(p)));
        // A point beyond the grid would be moved to its end, and the hull with it.
        let end = to_units(MAX_COORDINATE_M);
        place.iter().all(|p| p.x.abs() < end && p.y.abs() < end).then_some(place)
    }

    /// Points whose convex hull contains that image from every roll, pitch and height of the box, in the frame of the
    /// heading: x ahead, y to the left, metres, origin at the nadir.
    ///
    /// In that frame the image is z (cot β, w / sin β), with β the angle of the ray below the horizon in the plane
    /// of the heading, and w its slope out of that plane. Roll moves both, pitch adds to β. For fixed z and w the
    /// image runs on a convex arc of a hyperbola, which lies in the triangle of its ends and the meeting point of
    /// their tangents; in z and w it is linear.
    fn tilted_ground(&self, c: f64, r: f64) -> Option<[[f64; 2]; 12]> {
        let ray = self.body_from_image * Vector3::new(c, r, 1.0);
        let roll = around(self.pose.roll_rad, self.error.roll_rad);
        let left = harmonic(ray.y, -ray.z, roll);
        let down = harmonic(-ray.z, -ray.y, roll);
        // The angle is monotone in `down` on either side of the nadir, the length in its size.
        let dips = down.map(|down| down.atan2(ray.x));
        let lengths = down.map(|down| ray.x.hypot(down));
        let least_length =
            if down[0] * down[1] <= 0.0 { ray.x.abs() } else { lengths[0].min(lengths[1]) };
        let slope = quotient(left, [least_length, lengths[0].max(lengths[1])]);
        let pitch = around(self.pose.pitch_rad, self.error.pitch_rad);
        let dip = [dips[0].min(dips[1]) + pitch[0], dips[0].max(dips[1]) + pitch[1]];
        let is_below = dip[0] >= LEAST_DIP_RAD && dip[1] <= std::f64::consts::PI - LEAST_DIP_RAD;
        let height = around(self.pose.p_world[2], self.error.p_world[2]);
        if !is_below || height[0] <= 0.0 || least_length <= 0.0 {
            return None;
        }
        let (middle, half) = (0.5 * (dip[0] + dip[1]), 0.5 * (dip[1] - dip[0]));
        // (cot β, 1 / sin β) at the ends of the arc, and where the tangents meet.
        let unit = |beta: f64, stretch: f64| [beta.cos() / beta.sin(), stretch / beta.sin()];
        let arc = [unit(dip[0], 1.0), unit(middle, half.cos()), unit(dip[1], 1.0)];
        let mut points = [[0.0; 2]; 12];
        for (i, point) in points.iter_mut().enumerate() {
            let ([ahead, aside], w, z) = (arc[i % 3], slope[i / 3 % 2], height[i / 6]);
            *point = [z * ahead, z * aside * w];
        }
        Some(points)
    }

    /// By how much at least the errors of the position widen any set, metres, in every direction.
    pub(super) fn least_shift_m(&self) -> f64 {
        let [x, y, _] = self.error.p_world;
        x.min(y)
    }

    /// How far the errors of the position move any point, at most, metres.
    pub(crate) fn most_shift_m(&self) -> f64 {
        let [x, y, _] = self.error.p_world;
        x.hypot(y)
    }

    /// How far the image on the ground of an image point from the reported pose can be from its image at another
    /// roll, pitch and height of the box, metres. `None` if the ray may miss the ground.
    pub(super) fn tilt_shift_m(&self, c: f64, r: f64) -> Option<f64> {
        let reported = Self { error: PoseError::NONE, ..self.clone() };
        let [x, y] = reported.tilted_ground(c, r)?[0];
        let gaps = self.tilted_ground(c, r)?.map(|p| (p[0] - x).hypot(p[1] - y));
        Some(gaps.into_iter().fold(0.0, f64::max))
    }

    /// How far roll and pitch move the ground projections of points that are fixed to the camera.
    pub(super) fn tilt(&self, extent: Extent) -> Tilt {
        let PoseError { pitch_rad, roll_rad, yaw_rad, .. } = self.error;
        // A tilt moves a point by no more than this angle times its distance; so its drop changes by no more.
        let drop_m = extent.drop_m + extent.reach_m * (pitch_rad + roll_rad);
        // d(ahead)/d(pitch) is the drop, d(aside)/d(roll) the drop before the pitch.
        let slant = (self.pose.pitch_rad.abs() + pitch_rad).min(1.0);
        let (sin, cos) = self.pose.yaw_rad.sin_cos();
        Tilt {
            ahead_m: drop_m * pitch_rad + slant * extent.reach_m * roll_rad,
            aside_m: (drop_m + slant * extent.reach_m) * roll_rad,
            ahead: [cos, sin],
            yaw_rad,
        }
    }

    /// Points whose convex hull contains points (`world`, metres, at the reported yaw) from every yaw of the box, about
    /// the nadir.
    pub(super) fn turned(&self, points: impl IntoIterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
        let ([x, y, _], half) = (self.pose.p_world, self.error.yaw_rad);
        if half <= 0.0 {
            return points.into_iter().collect();
        }
        let from_nadir = points.into_iter().map(|p| [p[0] - x, p[1] - y]);
        let to_world = |[dx, dy]: [f64; 2]| [x + dx, y + dy];
        if half > MOST_YAW_RAD {
            let all_around = from_nadir.flat_map(|[dx, dy]| corners(dx.hypot(dy), dx.hypot(dy)));
            return all_around.map(to_world).collect();
        }
        // An arc lies in the triangle of its ends and the meeting point of their tangents.
        let turns = [(-half, 1.0), (0.0, 1.0 / half.cos()), (half, 1.0)].map(|(turn, stretch)| {
            let (sin, cos) = f64::sin_cos(turn);
            [stretch * sin, stretch * cos]
        });
        let turned = from_nadir.flat_map(|[dx, dy]| {
            turns.map(|[sin, cos]| [dx * cos - dy * sin, dx * sin + dy * cos])
        });
        turned.map(to_world).collect()
    }

    /// A convex set that contains points (`world`, metres, at the reported yaw and position) from every yaw and
    /// position of the box.
    pub(super) fn moved(&self, points: impl IntoIterator<Item = [f64; 2]>) -> Ring {
        let [wide_x, wide_y, _] = self.error.p_world;
        let turned = self.turned(points).into_iter().map(grid_point).collect();
        let boxes = corners(wide_x + NUMERIC_MARGIN_M, wide_y + NUMERIC_MARGIN_M);
        let turned = convex_hull(turned).unwrap_or_default();
        let places = turned.iter().flat_map(|p| {
            let [x, y] = metres(*p);
            boxes.map(|[dx, dy]| grid_point([x + dx, y + dy]))
        });
        convex_hull(places.collect()).unwrap_or_default()
    }

    /// How far the positions of the box move a point along a unit vector, at most, metres.
    pub(super) fn shift_along_m(&self, [x, y]: [f64; 2]) -> f64 {
        let [wide_x, wide_y, _] = self.error.p_world;
        x.abs() * wide_x + y.abs() * wide_y + NUMERIC_MARGIN_M
    }

    /// A point of the frame of the heading, `world`.
    fn to_world(&self, [ahead, aside]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.pose.yaw_rad.sin_cos();
        let [x, y, _] = self.pose.p_world;
        [x + ahead * cos - aside * sin, y + ahead * sin + aside * cos]
    }

    /// Convex rings whose union contains the images on the ground of the edges of `outline` from every pose of the
    /// box. The rings of `outline` are of image points, pixels. `None` if a part may miss the ground.
    pub(super) fn swept_outline(&self, outline: &[Vec<[f64; 2]>]) -> Option<Vec<Ring>> {
        let mut swept = Vec::new();
        for ring in outline {
            let places: Option<Vec<Ring>> =
                ring.iter().map(|&[c, r]| self.ground_place(c, r)).collect();
            let places = places?;
            let next = places.iter().cycle().skip(1);
            let edges = places.iter().zip(next).map(|(a, b)| [&a[..], &b[..]].concat());
            swept.extend(edges.filter_map(convex_hull));
        }
        Some(swept)
    }
}

/// [middle - half, middle + half].
fn around(middle: f64, half: f64) -> Interval {
    [middle - half, middle + half]
}

/// The corners of a rectangle about the origin.
fn corners(half_x: f64, half_y: f64) -> [[f64; 2]; 4] {
    [[-half_x, -half_y], [half_x, -half_y], [half_x, half_y], [-half_x, half_y]]
}

/// The range of a cos t + b sin t over an interval shorter than π.
fn harmonic(a: f64, b: f64, [from, to]: Interval) -> Interval {
    let at = |t: f64| a * t.cos() + b * t.sin();
    let (first, last, amplitude) = (at(from), at(to), a.hypot(b));
    // The derivative changes its sign where an extreme lies between the ends.
    let slope = |t: f64| b * t.cos() - a * t.sin();
    let (mut low, mut high) = (first.min(last), first.max(last));
    if slope(from) > 0.0 && slope(to) < 0.0 {
        high = amplitude;
    } else if slope(from) < 0.0 && slope(to) > 0.0 {
        low = -amplitude;
    }
    [low, high]
}

/// The range of a / b for b above 0.
fn quotient(a: Interval, b: Interval) -> Interval {
    let all = a.map(|a| b.map(|b| a / b));
    let flat = all.as_flattened();
    [
        flat.iter().copied().fold(f64::INFINITY, f64::min),
        flat.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]
}
