//! The foot of a wall: seen ground in front of an obstacle bounds the position of the obstacle.
//!
//! Obstacles are Z-convex (3.1): all points below a point of an obstacle belong to it too. So no
//! point of an obstacle is above seen ground, and of the points that may have lit an Obstacle pixel
//! those above seen ground are excluded. With noisy depths the position of a wall is uncertain by a
//! metre or two; the ground in front of its foot removes nearly half of that, and all of it where the
//! measured depth is too short.

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label};
use nalgebra::Vector3;

use super::label_at;
use super::pose_box::PoseBox;

/// Pixels within this distance of the image of a point must be Ground too, pixels; far more than
/// rounding.
const GUARD_PX: f64 = 0.01;
/// Images in a strip shift by no more than this times what they shift at its end, as long as that is little.
const SLACK: f64 = 1.2;
/// How often the step is halved after a part that is not all seen.
const HALVINGS: u32 = 3;

/// The part of the hull of `corners` (`world`, metres) that is not above seen ground, as the corners
/// of a set that contains it. On the side of the camera, the part is cut off that is seen through
/// Ground pixels of the same frame over the whole width of the hull. Empty if all of it is seen.
///
/// At another roll, pitch and height of the box, the ground at a point is seen through a pixel that shows ground
/// nearby from the reported ones. So there must be seen ground all around, as far as such an image can shift.
pub(super) fn unseen_part(
    view: &CameraView,
    poses: &PoseBox,
    frame: &Frame,
    corners: Vec<[f64; 2]>,
) -> Vec<[f64; 2]> {
    let Some(strip) = Strip::around(view, &corners) else { return corners };
    let Some(shift_m) = strip.shift_m(view, poses) else { return corners };
    let seen_to = strip.widened(shift_m).seen_to(view, frame) - shift_m;
    let [start, end] = strip.along;
    if seen_to <= start {
        return corners;
    }
    if seen_to >= end {
        return Vec::new();
    }
    let behind = corners.into_iter().filter(|&p| strip.coordinates(p)[0] >= seen_to);
    behind.chain(strip.across.map(|across| strip.point(seen_to, across))).collect()
}

/// Whether the ground at `p` is seen.
pub(super) fn is_seen(view: &CameraView, frame: &Frame, p: [f64; 2]) -> bool {
    let image = view.project(&Vector3::new(p[0], p[1], 0.0));
    image.and_then(|point| label_at(view, frame, point)) == Some(Label::Ground)
}

/// A rectangle on the ground that points away from the camera.
struct Strip {
    /// The nadir: the point below the camera, `world`, metres.
    nadir: [f64; 2],
    /// The direction away from the camera, a unit vector.
    direction: [f64; 2],
    /// Least and greatest coordinate along the direction, metres.
    along: [f64; 2],
    /// Least and greatest coordinate across it, to the left, metres.
    across: [f64; 2],
    /// The length of a row of pixels on the ground there, metres.
    row_m: f64,
}

impl Strip {
    /// The strip that contains `points`; `None` if that is not in front of the camera.
    fn around(view: &CameraView, points: &[[f64; 2]]) -> Option<Self> {
        let camera = view.centre_world();
        let &[x, y] = points.first()?;
        let (dx, dy) = (x - camera.x, y - camera.y);
        let length = dx.hypot(dy);
        if length <= 0.0 || camera.z <= 0.0 {
            return None;
        }
        let row_m = (length * length + camera.z * camera.z) / (view.focal_px() * camera.z);
        let empty = [f64::INFINITY, f64::NEG_INFINITY];
        let mut strip = Self {
            nadir: [camera.x, camera.y],
            direction: [dx / length, dy / length],
            along: empty,
            across: empty,
            row_m,
        };
        for &p in points {
            let [along, across] = strip.coordinates(p);
            strip.along = [strip.along[0].min(along), strip.along[1].max(along)];
            strip.across = [strip.across[0].min(across), strip.across[1].max(across)];
        }
        Some(strip)
    }

    /// (along, across) of a point, metres.
    fn coordinates(&self, p: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = [p[0] - self.nadir[0], p[1] - self.nadir[1]];
        let [ux, uy] = self.direction;
        [ux * dx + uy * dy, ux * dy - uy * dx]
    }

    /// The point at (along, across), `world`, metres.
    fn point(&self, along: f64, across: f64) -> [f64; 2] {
        let ([x, y], [ux, uy]) = (self.nadir, self.direction);
        [x + ux * along - uy * across, y + uy * along + ux * across]
    }

    /// How far the image on the ground of any point in the strip shifts over the box, at most, metres; `None` if that
    /// is not known.
    fn shift_m(&self, view: &CameraView, poses: &PoseBox) -> Option<f64> {
        if poses.is_exact() {
            return Some(0.0);
        }
        // Images shift the more, the farther away they are.
        let shift_at = |beyond_m: f64| {
            let across = self.across[0].abs().max(self.across[1].abs()) + beyond_m;
            let sides = [-across, across].map(|across| {
                let [x, y] = self.point(self.along[1] + beyond_m, across);
                let [c, r] = view.project(&Vector3::new(x, y, 0.0))?;
                poses.tilt_shift_m(c, r)
            });
            Some(sides[0]?.max(sides[1]?))
        };
        let shift_m = SLACK * shift_at(0.0)?;
        (shift_at(shift_m)? <= shift_m).then_some(shift_m)
    }

    /// The strip with a border of this width.
    fn widened(&self, border_m: f64) -> Self {
        let wider = |[low, high]: [f64; 2]| [low - border_m, high + border_m];
        Self { along: wider(self.along), across: wider(self.across), ..*self }
    }

    /// The coordinate along the strip up to which all of it is seen, metres.
    fn seen_to(&self, view: &CameraView, frame: &Frame) -> f64 {
        let [mut seen_to, end] = self.along;
        let mut step = self.row_m;
        let mut halvings = 0;
        while seen_to < end && halvings <= HALVINGS {
            let next = (seen_to + step).min(end);
            if self.is_all_seen(view, frame, [seen_to, next]) {
                seen_to = next;
            } else {
                halvings += 1;
                step *= 0.5;
            }
        }
        seen_to
    }

    /// Whether the strip between two coordinates is seen: all pixels of the box around its image are
    /// Ground. Straight lines have straight images, so the box around the corners contains the image.
    fn is_all_seen(&self, view: &CameraView, frame: &Frame, along: [f64; 2]) -> bool {
        let model = view.model();
        let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for (along, across) in along.iter().flat_map(|&a| self.across.map(|w| (a, w))) {
            let [x, y] = self.point(along, across);
            let Some(image) = view.project(&Vector3::new(x, y, 0.0)) else { return false };
            for axis in 0..2 {
                low[axis] = low[axis].min(image[axis] - GUARD_PX);
                high[axis] = high[axis].max(image[axis] + GUARD_PX);
            }
        }
        let within = low[0] >= 0.0
            && low[1] >= 0.0
            && high[0] < f64::from(model.columns)
            && high[1] < f64::from(model.rows);
        within && {
            let columns = low[0] as usize..=high[0] as usize;
            (low[1] as usize..=high[1] as usize).all(|row| {
                let start = row * usize::from(model.columns);
                let pixels = &frame.labels[start + columns.start()..=start + columns.end()];
                pixels.iter().all(|&label| label == Label::Ground)
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use csat_proto::camera::{CameraModel, Pose, PoseError};
    use csat_proto::time::Step;

    use super::*;

    /// A wall to the east of this, metres.
    const WALL_M: f64 = 100.0;

    /// The frame of a camera above the origin that looks east at a wall at `WALL_M`.
    fn wall() -> (CameraView, Frame) {
        let pose = Pose::level([0.0, 0.0, 52.0], 0.0);
        let model = CameraModel::default();
        let view = model.at(&pose);
        let is_before =
            |c: u16, r: u16| view.ground_point(c.into(), r.into()).is_some_and(|[x, _]| x < WALL_M);
        let label = |row: u16, column: u16| {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
            match corners.iter().filter(|(c, r)| is_before(column + c, row + r)).count() {
                4 => Label::Ground,
                0 => Label::Obstacle,
                _ => Label::Unknown,
            }
        };
        let labels = (0..model.rows)
            .flat_map(|row| (0..model.columns).map(move |column| (row, column)))
            .map(|(row, column)| label(row, column))
            .collect();
        let depth = vec![0; model.pixels()];
        let frame = Frame { labels, depth, ..Frame::of_detector(Step(0), pose, None) };
        (view, frame)
    }

    fn exact(view: &CameraView) -> PoseBox {
        PoseBox::new(view, &Pose::default(), &PoseError::NONE)
    }

    /// A strip a pixel wide that points east.
    fn hull([near, far]: [f64; 2], north: f64) -> Vec<[f64; 2]> {
        vec![[near, north - 0.1], [near, north + 0.1], [far, north + 0.12], [far, north - 0.12]]
    }

    #[test]
    fn a_wall_is_not_in_front_of_its_foot() {
        let (view, frame) = wall();
        for north in [0.0, 7.3, -20.0] {
            let rest = unseen_part(&view, &exact(&view), &frame, hull([98.5, 100.9], north));
            let nearest = rest.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min);
            // A row of pixels spans 0.42 m there, and that of the foot is not Ground.
            assert!((99.1..=WALL_M).contains(&nearest), "{nearest}");
            assert!(rest.contains(&[100.9, north + 0.12]) && rest.contains(&[100.9, north - 0.12]));
        }
    }

    #[test]
    fn what_is_all_seen_or_not_at_all_is_not_cut() {
        let (view, frame) = wall();
        assert_eq!(
            unseen_part(&view, &exact(&view), &frame, hull([95.0, 97.0], 0.0)),
            Vec::<[f64; 2]>::new()
        );
        for unseen in [hull([100.5, 102.0], 0.0), hull([98.0, 101.0], 60.0), Vec::new()] {
            assert_eq!(unseen_part(&view, &exact(&view), &frame, unseen.clone()), unseen);
        }
        assert!(is_seen(&view, &frame, [98.0, 0.0]) && !is_seen(&view, &frame, [101.0, 0.0]));
        assert!(!is_seen(&view, &frame, [98.0, 60.0]) && !is_seen(&view, &frame, [-98.0, 0.0]));
    }

    /// One pixel in front of the wall that is not Ground ends the seen part.
    #[test]
    fn every_pixel_of_the_strip_has_to_be_ground() {
        let (view, mut frame) = wall();
        let [c, r] = view.project(&Vector3::new(99.0, 0.05, 0.0)).unwrap();
        frame.labels[r as usize * 480 + c as usize] = Label::Target;
        let rest = unseen_part(&view, &exact(&view), &frame, hull([97.0, 100.9], 0.0));
        let nearest = rest.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min);
        assert!((97.5..=99.0).contains(&nearest), "{nearest}");
    }
}
