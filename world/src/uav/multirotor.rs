//! A multirotor that is displaced step by step (Gagliardi et al. 2014, §III-B).

use csat_proto::camera::Pose;
use csat_proto::command::Command;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Vehicle;

/// Its yaw, radians: towards the south. The image of the pinhole camera is upside down, so that a camera that
/// looks straight down has north in row 0 and west in column 0.
pub const YAW_RAD: f64 = -std::f64::consts::FRAC_PI_2;

/// A multirotor with its inner loops closed: constant altitude and yaw, pitch and roll 0. It hovers unless told to
/// be displaced. Each displacement errs by a uniform number within ±`motion_error_m` along either axis.
#[derive(Debug, Clone)]
pub struct Multirotor {
    p_world: [f64; 3],
    speed_m_s: f64,
    motion_error_m: f64,
    /// What is left of the last command, east and north, metres.
    by_m: [f64; 2],
    rng: ChaCha8Rng,
}

impl Multirotor {
    /// A multirotor that hovers at `p_world` (metres) and flies at most at `speed_m_s`, but for the error of its
    /// motion.
    pub fn new(p_world: [f64; 3], speed_m_s: f64, motion_error_m: f64, rng: ChaCha8Rng) -> Self {
        Self { p_world, speed_m_s, motion_error_m, by_m: [0.0; 2], rng }
    }
}

impl Vehicle for Multirotor {
    fn pose(&self) -> Pose {
        Pose::level(self.p_world, YAW_RAD)
    }

    fn command(&mut self, command: Command) -> bool {
        let Command::Displace { by_m } = command else { return false };
        self.by_m = by_m;
        true
    }

    fn advance(&mut self, dt_s: f64) {
        let [east_m, north_m] = std::mem::take(&mut self.by_m);
        // A displacement that is too fast is shortened; what is left of it is not made up for.
        let (length_m, most_m) = (east_m.hypot(north_m), self.speed_m_s * dt_s);
        let share = if length_m > most_m { most_m / length_m } else { 1.0 };
        for (axis, by_m) in [east_m, north_m].into_iter().enumerate() {
            let error = self.rng.random_range(-1.0..=1.0) * self.motion_error_m;
            self.p_world[axis] += share * by_m + error;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    fn multirotor(motion_error_m: f64, seed: u64) -> Multirotor {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Multirotor::new([10.0, 20.0, 70.0], 4.0, motion_error_m, rng)
    }

    /// Where it is after a period of an eighth of a second, from where it was, metres.
    fn moved(uav: &mut Multirotor, command: Option<[f64; 2]>) -> [f64; 2] {
        let before = uav.pose().p_world;
        if let Some(by_m) = command {
            assert!(uav.command(Command::Displace { by_m }));
        }
        uav.advance(0.125);
        assert_eq!(uav.pose(), Pose::level([uav.p_world[0], uav.p_world[1], 70.0], YAW_RAD));
        [0, 1].map(|axis| uav.pose().p_world[axis] - before[axis])
    }

    #[test]
    fn it_does_what_it_is_told_and_then_hovers() {
        let mut uav = multirotor(0.0, 1);
        assert_eq!(moved(&mut uav, Some([0.125, -0.125])), [0.125, -0.125]);
        assert_eq!(moved(&mut uav, None), [0.0; 2]);
        assert!(!uav.command(Command::Yaw { yaw_rad: 1.0 }));
        assert_eq!(moved(&mut uav, None), [0.0; 2]);
    }

    #[test]
    fn its_speed_is_limited() {
        let mut uav = multirotor(0.0, 1);
        let [east, north] = moved(&mut uav, Some([30.0, 40.0]));
        assert!((east - 0.3).abs() < 1e-12 && (north - 0.4).abs() < 1e-12, "{east} {north}");
        assert_eq!(moved(&mut uav, None), [0.0; 2], "the rest is not made up for");
    }

    #[test]
    fn errors_are_bounded_and_uniform_also_while_it_hovers() {
        let mut uav = multirotor(0.02, 1);
        let mut square = 0.0;
        for step in 0..2000 {
            let by_m = if step % 2 == 0 { [0.125, 0.0] } else { [0.0; 2] };
            let got = moved(&mut uav, (step % 4 < 2).then_some(by_m));
            let expected = if step % 4 == 0 { by_m } else { [0.0; 2] };
            for axis in 0..2 {
                let error: f64 = got[axis] - expected[axis];
                assert!(error.abs() <= 0.02 + 1e-12, "{error}");
                square += error * error / 4000.0;
            }
        }
        // The variance of a uniform number in ±a is a²/3.
        assert!((square * 3.0 / 0.0004 - 1.0).abs() < 0.1, "{square}");
        let first = |seed| moved(&mut multirotor(0.02, seed), None);
        assert_eq!(first(5), first(5));
        assert_ne!(first(5), first(6));
    }
}
