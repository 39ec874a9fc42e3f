//! A model of motion that is more exact than (5.35): the yaw follows a command as a second-order
//! response (thesis figure 5.3), so the UAV drifts to the outside of a turn.

use csat_proto::camera::Pose;

use crate::config::AgentConfig;

/// Damping ratio of the yaw response.
const DAMPING: f64 = 0.7;
/// ω·t_5% of a response with that damping.
const SETTLING: f64 = 2.8998;
/// Integration step, seconds.
const STEP_S: f64 = 0.05;

/// The motion of a UAV over a block, after straight flight.
#[derive(Debug, Clone)]
pub(super) struct Turning {
    /// By increment: the turn, radians, and the way through the block, step by step, metres ahead and
    /// to the left of its beginning.
    turns: Vec<(f64, Vec<[f64; 2]>)>,
}

impl Turning {
    /// The motion of the fleet over one block of T_MPC, for each of `increments`, radians.
    pub(super) fn new(config: &AgentConfig, increments: &[f64]) -> Self {
        let omega = SETTLING / config.fleet.yaw_settling_s;
        let root = (1.0 - DAMPING * DAMPING).sqrt();
        // The share of the turn that is completed after a time.
        let share = |t_s: f64| {
            let (sin, cos) = (root * omega * t_s).sin_cos();
            1.0 - (-DAMPING * omega * t_s).exp() * (cos + DAMPING / root * sin)
        };
        let steps = (config.guidance.period_s / STEP_S).round().max(1.0) as u32;
        let step_m = config.fleet.speed_m_s * config.guidance.period_s / f64::from(steps);
        let way = |&turn_rad: &f64| {
            let times_s = (0..steps).map(|i| (f64::from(i) + 0.5) * STEP_S);
            let way = times_s.scan([0.0, 0.0], |[ahead, left], t_s| {
                let (sin, cos) = (turn_rad * share(t_s)).sin_cos();
                (*ahead, *left) = (*ahead + step_m * cos, *left + step_m * sin);
                Some([*ahead, *left])
            });
            (turn_rad, way.collect())
        };
        Self { turns: increments.iter().map(way).collect() }
    }

    /// The level pose one block after `pose` with the yaw increment of this index, when the yaw has
    /// settled.
    pub(super) fn advance(&self, pose: &Pose, increment: usize) -> Pose {
        let [x, y] =
            self.way(pose, increment).next_back().unwrap_or([pose.p_world[0], pose.p_world[1]]);
        Pose::level([x, y, pose.p_world[2]], pose.yaw_rad + self.turns[increment].0)
    }

    /// The way through that block, step by step, `world`, metres.
    pub(super) fn way<'a>(
        &'a self,
        pose: &Pose,
        increment: usize,
    ) -> impl DoubleEndedIterator<Item = [f64; 2]> + use<'a> {
        let ([x, y, _], (sin, cos)) = (pose.p_world, pose.yaw_rad.sin_cos());
        let steps = self.turns[increment].1.iter();
        steps.map(move |[ahead, left]| [x + ahead * cos - left * sin, y + ahead * sin + left * cos])
    }

    /// Bound of the error of a way, metres per turn, because the turn before has not quite settled
    /// when the block begins: the remainder, at most √2·e^{-ζωT} of a turn, decays with ζω.
    pub(super) fn doubt_m(config: &AgentConfig, turn_rad: f64) -> f64 {
        let rate = DAMPING * SETTLING / config.fleet.yaw_settling_s;
        let left_rad =
            std::f64::consts::SQRT_2 * turn_rad.abs() * (-rate * config.guidance.period_s).exp();
        config.fleet.speed_m_s * left_rad / rate
    }

    /// The longest step of a way, metres.
    pub(super) fn step_m(config: &AgentConfig) -> f64 {
        config.fleet.speed_m_s * STEP_S
    }
}
