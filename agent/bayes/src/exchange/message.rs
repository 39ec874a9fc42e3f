//! What agents tell each other: the body of an envelope, in postcard.

use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

use super::held::Held;
use crate::factor::{Factor, ReportedPose};
use crate::tiles::Tiles;

/// The most bytes of a factor in a message.
pub const MAX_FACTOR_BYTES: usize = 60;
/// The most poses of a plan.
pub const MAX_PLAN: usize = 64;
/// The most bytes of a pose in a message.
pub const POSE_BYTES: usize = 24;

/// The body of a message. Each part may be left out.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Message {
    /// The factors that the sender holds, so that others send what is missing; `None` if it does not tell.
    pub held: Option<Held>,
    /// Factors: own ones and those of others.
    pub factors: Vec<Factor>,
    /// Where the sender will be.
    pub plan: Plan,
    /// The sender's belief.
    pub belief: Option<Tiles>,
}

/// Where an aircraft expects to be. What is not in it is not known.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Plan {
    /// The step of the first pose.
    pub first: Step,
    /// Steps from one pose to the next, at least 1 if there are poses.
    pub period: u32,
    /// The poses, at most [`MAX_PLAN`].
    pub poses: Vec<ReportedPose>,
}

impl Plan {
    /// The step of a pose.
    pub fn step(&self, index: usize) -> Step {
        let index = u32::try_from(index).unwrap_or(u32::MAX);
        self.first.after(self.period.saturating_mul(index))
    }

    /// Its first `count` poses.
    pub fn first_poses(&self, count: usize) -> Self {
        let count = count.min(self.poses.len());
        Self { poses: self.poses[..count].to_vec(), ..*self }
    }
}

/// The size of a value in a message, bytes.
pub fn size_of<T: Serialize>(value: &T) -> usize {
    let size = postcard::ser_flavors::Size::default();
    postcard::serialize_with_flavor(value, size).expect("what messages hold always serialises")
}

#[cfg(test)]
mod tests {
    use csat_proto::ids::{AgentId, Incarnation};

    use super::*;
    use crate::factor::FactorId;

    #[test]
    fn a_factor_takes_few_bytes() {
        let id = FactorId {
            source: AgentId(u16::MAX),
            incarnation: Incarnation(u32::MAX),
            number: u32::MAX,
        };
        let pose = ReportedPose { p_world: [1.0; 3], angles_rad: [1.0; 3] };
        let most = Factor { id, step: Step(u32::MAX), pose, sighting: Some([1.0; 2]) };
        assert!(size_of(&most) <= MAX_FACTOR_BYTES);
        assert_eq!(size_of(&pose), POSE_BYTES);
        let usual = FactorId { source: AgentId(7), incarnation: Incarnation(1), number: 1000 };
        let usual = Factor { id: usual, step: Step(1001), sighting: None, ..most };
        assert_eq!(size_of(&usual), 31);
        assert_eq!(size_of(&usual), postcard::to_stdvec(&usual).unwrap().len());
    }

    #[test]
    fn steps_of_plans_do_not_overflow() {
        let plan = Plan { first: Step(u32::MAX - 3), period: u32::MAX, poses: Vec::new() };
        assert_eq!((plan.step(0), plan.step(usize::MAX)), (plan.first, Step(u32::MAX)));
    }
}
