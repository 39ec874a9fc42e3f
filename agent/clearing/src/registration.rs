//! Where the image is on the lattice of the masks: at the whole pixel nearest to the odometry.
//!
//! Only displacements between frames count, so it does not matter where the odometry has its origin.

use csat_proto::camera::Pose;
use csat_proto::time::Step;

use crate::config::AgentConfig;
use crate::radii::DRIFT_PX;

/// The place of the image on the lattice, and how much the odometry may have drifted.
#[derive(Debug, Clone)]
pub struct Registration {
    pixel_m: f64,
    drift_share: f64,
    /// The longest path of a displacement's error, metres.
    error_m: f64,
    /// The longest path in a period, metres.
    most_m: f64,
    /// The step of the last frame, and row and column of its first pixel on the lattice.
    last: Option<(Step, [i32; 2])>,
    /// The most that was flown since the lattice was taken up, metres.
    path_m: f64,
}

/// What changed from one frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moved {
    /// How far the ground moved in the image: down and to the right, pixels.
    pub by: [i32; 2],
    /// Whether the lattice has to be taken up anew, by a pixel.
    pub is_drifted: bool,
    /// Whether the odometry may have drifted by more, because frames were missed: masks are worth nothing then.
    pub is_lost: bool,
}

impl Registration {
    /// An agent without a frame.
    pub fn new(config: &AgentConfig) -> Self {
        let error_m = std::f64::consts::SQRT_2 * config.motion_error_m;
        Self {
            pixel_m: config.pixel_m(),
            drift_share: config.odometry.drift_share,
            error_m,
            most_m: config.fleet.speed_m_s * config.period_s + error_m,
            last: None,
            path_m: 0.0,
        }
    }

    /// Takes the lattice up at the present frame.
    pub fn restart(&mut self) {
        self.path_m = 0.0;
    }

    /// Places the frame of a step, after a command to fly `commanded_m` metres in the period after the last frame.
    pub fn place(&mut self, step: Step, pose: &Pose, commanded_m: [f64; 2]) -> Moved {
        let [east, north, _] = pose.p_world;
        let next = [-north, east].map(|metres| (metres / self.pixel_m).round() as i32);
        let (last_step, last) = self.last.replace((step, next)).unwrap_or((step, next));
        let periods = step.0.saturating_sub(last_step.0);
        let flown_m = commanded_m[0].hypot(commanded_m[1]);
        self.path_m += flown_m + f64::from(periods) * self.error_m;
        let reserve_m = DRIFT_PX * self.pixel_m;
        let is_lost = self.drift_share * self.path_m > reserve_m;
        // The reserve has to last for the next period, too.
        let is_drifted = self.drift_share * (self.path_m + self.most_m) >= reserve_m;
        if is_drifted {
            self.restart();
        }
        let by = [0, 1].map(|axis| last[axis].saturating_sub(next[axis]));
        Moved { by, is_drifted, is_lost }
    }

    /// How far the mask of an agent that was at this offset (east, north, metres) is to be moved, down and to
    /// the right, to lie on the own masks.
    pub fn placement(&self, offset_m: [f64; 2]) -> [i32; 2] {
        let [east, north] = offset_m;
        [-north, east].map(|metres| (metres / self.pixel_m).round() as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::validate::tests::config;

    #[test]
    fn the_lattice_is_taken_up_before_the_drift_is_a_pixel() {
        let mut config = config();
        config.odometry.drift_share = 0.02;
        let mut registration = Registration::new(&config);
        let mut step = Step(0);
        let mut place = |east_m: f64, periods| {
            let pose = Pose::level([east_m, 0.0, 70.0], 0.0);
            step = step.after(periods);
            registration.place(step, &pose, [1.0, 0.0])
        };
        let pixel_m = config.pixel_m();
        let most_m = pixel_m / 0.02 - config.fleet.speed_m_s * config.period_s;
        let steps = (1_i32..100).find(|step| place(f64::from(*step), 1).is_drifted);
        // Each step counts the error of the motion as well.
        let step_m = 1.0 + std::f64::consts::SQRT_2 * config.motion_error_m;
        let expected = (most_m / step_m) as i32;
        assert!(steps.is_some_and(|steps| steps.abs_diff(expected) <= 1), "{steps:?} {expected}");
        let moved = place(f64::from(steps.unwrap_or_default()), 1);
        assert!(!moved.is_drifted && !moved.is_lost && moved.by == [0, 0]);
        assert!(place(0.0, 100_000).is_lost, "the vehicle may have strayed anywhere");
    }
}
