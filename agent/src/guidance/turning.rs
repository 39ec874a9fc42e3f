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
    /// By increment: how far it turns, radians, and where the block ends, metres ahead and to the left
    /// of where it began.
    turns: Vec<(f64, [f64; 2])>,
}

impl Turning {
    /// The motion of the fleet over one block of T_MPC, for each of `increments`, radians.
    pub(super) fn new(config: &AgentConfig, increments: &[f64]) -> Self {
        let omega = SETTLING / config.fleet.yaw_settling_s;
        let root = (1.0 - DAMPING * DAMPING).sqrt();
        // The share of the turn that is done after some time.
        let share = |t_s: f64| {
            let (sin, cos) = (root * omega * t_s).sin_cos();
            1.0 - (-DAMPING * omega * t_s).exp() * (cos + DAMPING / root * sin)
        };
        let steps = (config.guidance.period_s / STEP_S).round().max(1.0) as u32;
        let step_m = config.fleet.speed_m_s * config.guidance.period_s / f64::from(steps);
        let way = |&turn_rad: &f64| {
            let times_s = (0..steps).map(|i| (f64::from(i) + 0.5) * STEP_S);
            let end = times_s.fold([0.0, 0.0], |[ahead, left], t_s| {
                let (sin, cos) = (turn_rad * share(t_s)).sin_cos();
                [ahead + step_m * cos, left + step_m * sin]
            });
            (turn_rad, end)
        };
        Self { turns: increments.iter().map(way).collect() }
    }

    /// The pose one block after `pose` with the yaw increment of that index, settled again. Level.
    pub(super) fn advance(&self, pose: &Pose, increment: usize) -> Pose {
        let (turn_rad, [ahead, left]) = self.turns[increment];
        let ([x, y, z], (sin, cos)) = (pose.p_world, pose.yaw_rad.sin_cos());
        let p_world = [x + ahead * cos - left * sin, y + ahead * sin + left * cos, z];
        Pose::level(p_world, pose.yaw_rad + turn_rad)
    }
}
