//! Where a UAV is after a block that begins with a turn, more closely than (5.35): its yaw follows a
//! command as a second-order response (thesis figure 5.3), so in the turn it drifts to the outside.

use csat_proto::camera::Pose;

use crate::config::AgentConfig;

/// Damping ratio of the yaw response.
const DAMPING: f64 = 0.7;
/// ω·t_5% of a response with that damping.
const SETTLING: f64 = 2.8998;
/// Integration step, seconds.
const STEP_S: f64 = 0.05;

/// The motion of a UAV that flew straight before, block by block.
#[derive(Debug, Clone)]
pub(super) struct Turning {
    /// The way of one integration step, metres.
    step_m: f64,
    /// The share of the turn that is done in the middle of each step of a block.
    shares: Vec<f64>,
}

impl Turning {
    /// The motion of the fleet over one block of T_MPC.
    pub(super) fn new(config: &AgentConfig) -> Self {
        let omega = SETTLING / config.fleet.yaw_settling_s;
        let root = (1.0 - DAMPING * DAMPING).sqrt();
        let share = |t_s: f64| {
            let (sin, cos) = (root * omega * t_s).sin_cos();
            1.0 - (-DAMPING * omega * t_s).exp() * (cos + DAMPING / root * sin)
        };
        let steps = (config.guidance.period_s / STEP_S).round().max(1.0) as u32;
        Self {
            step_m: config.fleet.speed_m_s * config.guidance.period_s / f64::from(steps),
            shares: (0..steps).map(|i| share((f64::from(i) + 0.5) * STEP_S)).collect(),
        }
    }

    /// The pose one block after `pose` with a yaw increment, settled again. Level.
    pub(super) fn advance(&self, pose: &Pose, increment_rad: f64) -> Pose {
        let [mut x, mut y, z] = pose.p_world;
        for share in &self.shares {
            let (sin, cos) = (pose.yaw_rad + increment_rad * share).sin_cos();
            x += self.step_m * cos;
            y += self.step_m * sin;
        }
        Pose::level([x, y, z], pose.yaw_rad + increment_rad)
    }
}
