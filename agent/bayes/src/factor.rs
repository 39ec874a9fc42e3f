//! Factors: what one frame says of the target, as it is kept and sent.

use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

/// Which factor it is: no two frames of a mission have the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct FactorId {
    /// The aircraft whose frame it is.
    pub source: AgentId,
    /// The incarnation of that aircraft.
    pub incarnation: Incarnation,
    /// How many factors this incarnation stated before.
    pub number: u32,
}

/// A frame in the parameters of its likelihood: who, when, from where, and what was detected (at most 60 bytes).
///
/// The belief is a function of the *set* of factors, so a repeated, late or reordered factor changes nothing
/// that it should not, and a lost one costs information, not truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Factor {
    /// Which one it is.
    pub id: FactorId,
    /// The step of the frame.
    pub step: Step,
    /// The reported pose of the frame.
    pub pose: ReportedPose,
    /// The image point (c, r) of the detection, pixels; `None` if nothing was detected.
    pub sighting: Option<[f32; 2]>,
}

/// A pose as factors have it. All agents, its source included, use these rounded numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReportedPose {
    /// Position in `world`, metres.
    pub p_world: [f32; 3],
    /// Yaw, pitch and roll, radians.
    pub angles_rad: [f32; 3],
}

impl From<&Pose> for ReportedPose {
    fn from(pose: &Pose) -> Self {
        Self {
            p_world: pose.p_world.map(|x| x as f32),
            angles_rad: [pose.yaw_rad, pose.pitch_rad, pose.roll_rad].map(|x| x as f32),
        }
    }
}

impl From<ReportedPose> for Pose {
    fn from(reported: ReportedPose) -> Self {
        let [yaw_rad, pitch_rad, roll_rad] = reported.angles_rad.map(f64::from);
        Self { p_world: reported.p_world.map(f64::from), yaw_rad, pitch_rad, roll_rad }
    }
}
