//! A quadcopter (thesis §5.4.1, figure 5.3).

use csat_proto::camera::Pose;
use csat_proto::command::Command;

use super::Vehicle;

/// Damping ratio of the yaw response.
const DAMPING: f64 = 0.7;

/// ω t_5% of the step response of a second-order system with damping 0.7, whose overshoot (4.6 %)
/// stays within 5 %: the root of 1 − e^{−ζτ} (cos βτ + ζ/β sin βτ) = 0.95, β = √(1 − ζ²).
const SETTLING: f64 = 2.899_820_526_071_221;

/// Longest integration step of the position, seconds.
const SUBSTEP_S: f64 = 0.01;

/// A quadcopter with its inner loops closed: constant speed and altitude, pitch and roll 0, yaw
/// following the command as a second-order response, velocity along the current yaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadcopter {
    p_world: [f64; 3],
    speed_m_s: f64,
    yaw_rad: f64,
    yaw_rate_rad_s: f64,
    commanded_yaw_rad: f64,
    /// ω of the yaw response, rad/s.
    frequency_rad_s: f64,
}

impl Quadcopter {
    /// A quadcopter at `p_world` (metres) that flies at `speed_m_s` along `yaw_rad`, its yaw
    /// settling to within 5 % of a step in `yaw_settling_s`.
    pub fn new(p_world: [f64; 3], yaw_rad: f64, speed_m_s: f64, yaw_settling_s: f64) -> Self {
        Self {
            p_world,
            speed_m_s,
            yaw_rad,
            yaw_rate_rad_s: 0.0,
            commanded_yaw_rad: yaw_rad,
            frequency_rad_s: SETTLING / yaw_settling_s,
        }
    }

    /// Yaw and yaw rate after `t_s`: the exact solution of
    /// ψ̈ = ω² (ψ_c − ψ) − 2 ζ ω ψ̇.
    fn yaw_after(&self, t_s: f64) -> [f64; 2] {
        let omega = self.frequency_rad_s;
        let beta = omega * (1.0 - DAMPING * DAMPING).sqrt();
        let error = self.yaw_rad - self.commanded_yaw_rad;
        let b = (self.yaw_rate_rad_s + DAMPING * omega * error) / beta;
        let decay = (-DAMPING * omega * t_s).exp();
        let (sin, cos) = (beta * t_s).sin_cos();
        let offset = decay * (error * cos + b * sin);
        let rate = decay * beta * (b * cos - error * sin) - DAMPING * omega * offset;
        [self.commanded_yaw_rad + offset, rate]
    }
}

impl Vehicle for Quadcopter {
    fn pose(&self) -> Pose {
        Pose::level(self.p_world, self.yaw_rad)
    }

    fn command(&mut self, command: Command) -> bool {
        let Command::Yaw { yaw_rad } = command else { return false };
        self.commanded_yaw_rad = yaw_rad;
        true
    }

    fn advance(&mut self, dt_s: f64) {
        let substeps = (dt_s / SUBSTEP_S).ceil().max(1.0);
        let h = dt_s / substeps;
        for _ in 0..substeps as u64 {
            // The yaw is exact; Simpson's rule for the position.
            let middle = self.yaw_after(h / 2.0)[0];
            let [end, rate] = self.yaw_after(h);
            for (axis, along) in [f64::cos, f64::sin].into_iter().enumerate() {
                let mean = (along(self.yaw_rad) + 4.0 * along(middle) + along(end)) / 6.0;
                self.p_world[axis] += self.speed_m_s * h * mean;
            }
            (self.yaw_rad, self.yaw_rate_rad_s) = (end, rate);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quadcopter() -> Quadcopter {
        Quadcopter::new([0.0, 0.0, 52.0], 0.0, 5.0, 1.2)
    }

    #[test]
    fn the_yaw_settles_to_five_per_cent_at_the_settling_time() {
        let mut uav = quadcopter();
        uav.command(Command::Yaw { yaw_rad: 1.0 });
        let mut last_outside_s = 0.0;
        for i in 1..=4000 {
            uav.advance(1e-3);
            if (uav.pose().yaw_rad - 1.0).abs() > 0.05 {
                last_outside_s = f64::from(i) * 1e-3;
            }
        }
        assert!((last_outside_s - 1.2f64).abs() < 2e-3, "{last_outside_s}");
        assert!((uav.pose().yaw_rad - 1.0).abs() < 2e-3);
    }

    #[test]
    fn straight_flight_is_exact() {
        let mut uav = quadcopter();
        for _ in 0..20 {
            uav.advance(0.5);
        }
        let [x, y, z] = uav.pose().p_world;
        assert!((x - 50.0).abs() < 1e-9 && y == 0.0 && z == 52.0);
        assert_eq!((uav.pose().pitch_rad, uav.pose().roll_rad), (0.0, 0.0));
    }

    #[test]
    fn the_length_of_the_time_step_does_not_matter() {
        let [mut coarse, mut fine] = [quadcopter(), quadcopter()];
        for turn in [1.0, -0.5, 3.0] {
            for uav in [&mut coarse, &mut fine] {
                uav.command(Command::Yaw { yaw_rad: turn });
            }
            coarse.advance(3.0);
            for _ in 0..3000 {
                fine.advance(1e-3);
            }
        }
        let (a, b) = (coarse.pose(), fine.pose());
        assert!((a.yaw_rad - b.yaw_rad).abs() < 1e-9);
        for axis in 0..3 {
            assert!((a.p_world[axis] - b.p_world[axis]).abs() < 1e-6, "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_new_command_does_not_jump() {
        let mut uav = quadcopter();
        uav.command(Command::Yaw { yaw_rad: 1.0 });
        uav.advance(0.4);
        let before = uav;
        uav.command(Command::Yaw { yaw_rad: -1.0 });
        uav.advance(1e-6);
        assert!((uav.yaw_rad - before.yaw_rad).abs() < 1e-4);
        assert!((uav.yaw_rate_rad_s - before.yaw_rate_rad_s).abs() < 1e-3);
    }
}
