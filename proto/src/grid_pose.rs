//! Poses as messages have them: whole millimetres and 65536ths of a turn.
//!
//! A pose as it is written takes about 14 bytes, and one of a plan, which is written as the difference to the pose
//! before it, about 9: a short radio that may send 300 bytes per second spends its bytes on what was seen.

use std::f64::consts::TAU;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::camera::Pose;

const PER_METRE: f64 = 1e3;
const PER_TURN: f64 = 65_536.0;

/// A rounded pose. It is finite, whatever bytes it is read from. In formats for people, such as JSON, it is a [`Pose`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GridPose {
    /// Position in `world`, millimetres; farther places are at the end of the range, 2147 km.
    p_mm: [i32; 3],
    /// Yaw, pitch and roll, 1/65536 turns.
    angles: [i16; 3],
}

impl GridPose {
    /// What is added to `former` to get this pose, component by component.
    fn since(&self, former: &Self) -> Self {
        Self {
            p_mm: std::array::from_fn(|i| self.p_mm[i].wrapping_sub(former.p_mm[i])),
            angles: std::array::from_fn(|i| self.angles[i].wrapping_sub(former.angles[i])),
        }
    }

    /// The inverse of [`Self::since`].
    fn after(&self, former: &Self) -> Self {
        Self {
            p_mm: std::array::from_fn(|i| self.p_mm[i].wrapping_add(former.p_mm[i])),
            angles: std::array::from_fn(|i| self.angles[i].wrapping_add(former.angles[i])),
        }
    }
}

impl From<Pose> for GridPose {
    fn from(pose: Pose) -> Self {
        let Pose { p_world, yaw_rad, pitch_rad, roll_rad } = pose;
        Self {
            p_mm: p_world.map(|x| (x * PER_METRE).round() as i32),
            // Half a turn to the left and to the right are one heading.
            angles: [yaw_rad, pitch_rad, roll_rad]
                .map(|angle| (angle / TAU * PER_TURN).round().rem_euclid(PER_TURN) as u16 as i16),
        }
    }
}

impl From<GridPose> for Pose {
    /// Angles are within ±π.
    fn from(GridPose { p_mm, angles }: GridPose) -> Self {
        let [yaw_rad, pitch_rad, roll_rad] = angles.map(|angle| f64::from(angle) / PER_TURN * TAU);
        Self { p_world: p_mm.map(|x| f64::from(x) / PER_METRE), yaw_rad, pitch_rad, roll_rad }
    }
}

impl Serialize for GridPose {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match to.is_human_readable() {
            true => Pose::from(*self).serialize(to),
            false => (self.p_mm, self.angles).serialize(to),
        }
    }
}

impl<'de> Deserialize<'de> for GridPose {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        match from.is_human_readable() {
            true => Pose::deserialize(from).map(Self::from),
            false => Deserialize::deserialize(from).map(|(p_mm, angles)| Self { p_mm, angles }),
        }
    }
}

/// For `#[serde(with = …)]`: poses as differences to the poses before them, except in formats for people.
pub mod path {
    use super::{Deserialize, Deserializer, GridPose, Serialize, Serializer};

    /// Writes poses.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<S: Serializer>(poses: &[GridPose], to: S) -> Result<S::Ok, S::Error> {
        if to.is_human_readable() {
            return poses.serialize(to);
        }
        let former = std::iter::once(GridPose::default()).chain(poses.iter().copied());
        let steps: Vec<GridPose> = poses.iter().zip(former).map(|(p, q)| p.since(&q)).collect();
        steps.serialize(to)
    }

    /// Reads poses.
    ///
    /// # Errors
    /// Those of the deserializer.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<GridPose>, D::Error> {
        let is_human_readable = from.is_human_readable();
        let mut poses = Vec::<GridPose>::deserialize(from)?;
        if is_human_readable {
            return Ok(poses);
        }
        let mut former = GridPose::default();
        for pose in &mut poses {
            *pose = pose.after(&former);
            former = *pose;
        }
        Ok(poses)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Path(#[serde(with = "path")] Vec<GridPose>);

    #[test]
    fn a_straight_flight_takes_nine_bytes_a_pose() {
        let pose = |k: u32| Pose::level([-120.0 + 48.0 * f64::from(k), 31.25, 52.0], 0.4).into();
        let poses: Vec<GridPose> = (0..20).map(pose).collect();
        let bytes = postcard::to_stdvec(&Path(poses.clone())).unwrap();
        assert!(bytes.len() < 20 * 9, "{}", bytes.len());
        assert_eq!(postcard::from_bytes::<Path>(&bytes).unwrap(), Path(poses.clone()));
        let json = serde_json::to_string(&Path(poses.clone())).unwrap();
        assert!(json.starts_with(r#"[{"p_world":[-120.0,31.25,52.0],"yaw_rad":0.3999"#), "{json}");
        assert_eq!(serde_json::from_str::<Path>(&json).unwrap(), Path(poses));
    }

    proptest! {
        #[test]
        fn a_pose_is_read_back_to_half_a_millimetre(
            p in prop::array::uniform3(-2e6..2e6f64),
            [yaw_rad, pitch_rad, roll_rad] in prop::array::uniform3(-20.0..20.0f64),
        ) {
            let pose = Pose { p_world: p, yaw_rad, pitch_rad, roll_rad };
            let read = Pose::from(GridPose::from(pose));
            for (a, b) in p.into_iter().zip(read.p_world) {
                prop_assert!((a - b).abs() <= 0.5e-3 + 1e-9);
            }
            let angles = [(yaw_rad, read.yaw_rad), (pitch_rad, read.pitch_rad), (roll_rad, read.roll_rad)];
            for (a, b) in angles {
                prop_assert!((a - b).sin().abs() <= TAU / PER_TURN && (a - b).cos() > 0.0);
            }
            // Rounded once, it stays as it is.
            prop_assert_eq!(GridPose::from(read), GridPose::from(pose));
        }

        #[test]
        fn any_bytes_of_a_path_are_finite_poses(steps in prop::collection::vec((any::<[i32; 3]>(), any::<[i16; 3]>()), 0..9)) {
            let bytes = postcard::to_stdvec(&steps).unwrap();
            let Path(poses) = postcard::from_bytes(&bytes).unwrap();
            prop_assert!(poses.iter().all(|p| Pose::from(*p).p_world.iter().all(|x| x.is_finite())));
            prop_assert_eq!(postcard::to_stdvec(&Path(poses)).unwrap(), bytes);
        }
    }

    #[test]
    fn what_is_no_number_is_the_origin_and_what_is_far_is_at_the_end() {
        let pose =
            Pose { p_world: [f64::NAN, 1e300, -1e300], yaw_rad: f64::INFINITY, ..Pose::default() };
        let read = Pose::from(GridPose::from(pose));
        assert_eq!(read.p_world, [0.0, f64::from(i32::MAX) / 1e3, f64::from(i32::MIN) / 1e3]);
        assert_eq!(read.yaw_rad, 0.0);
    }
}
