//! A fixed-wing aircraft with its inner loops closed: coordinated turns at constant airspeed and altitude.
//! The world flies it, and agents that plan predict it.

use serde::{Deserialize, Serialize};

use crate::camera::Pose;

/// Standard gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.806_65;

/// The longest integration step, seconds.
const SUBSTEP_S: f64 = 0.05;

/// `[agents.fixed_wing]`: how a fixed-wing aircraft turns, and the wind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FixedWingModel {
    /// The steepest bank, degrees.
    pub roll_max_deg: f64,
    /// Time constant of the roll, seconds.
    pub roll_time_constant_s: f64,
    /// Time constant in which the autopilot closes a small error of the heading, seconds.
    pub heading_time_constant_s: f64,
    /// Nose-up pitch in level flight, degrees. In a turn it grows with the load, as the lift does.
    pub pitch_trim_deg: f64,
    /// Time constant of the pitch, seconds.
    pub pitch_time_constant_s: f64,
    /// The wind: east and north, m/s. The heading is the direction of the nose, not of the way.
    pub wind_m_s: [f64; 2],
}

impl Default for FixedWingModel {
    fn default() -> Self {
        Self {
            roll_max_deg: 30.0,
            roll_time_constant_s: 0.5,
            heading_time_constant_s: 1.5,
            pitch_trim_deg: 4.0,
            pitch_time_constant_s: 0.5,
            wind_m_s: [0.0, 0.0],
        }
    }
}

/// A fixed-wing aircraft in flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedWing {
    model: FixedWingModel,
    airspeed_m_s: f64,
    pose: Pose,
    commanded_yaw_rad: f64,
}

/// Roll, pitch, yaw, east, north; or their rates.
type State = [f64; 5];

impl FixedWing {
    /// An aircraft at a pose, which flies straight on at `airspeed_m_s`.
    pub fn new(model: FixedWingModel, pose: Pose, airspeed_m_s: f64) -> Self {
        Self { model, airspeed_m_s, commanded_yaw_rad: pose.yaw_rad, pose }
    }

    /// An aircraft in level flight at a place, `world`, metres.
    pub fn level(
        model: FixedWingModel,
        p_world: [f64; 3],
        yaw_rad: f64,
        airspeed_m_s: f64,
    ) -> Self {
        let pitch_rad = -model.pitch_trim_deg.to_radians();
        Self::new(model, Pose { p_world, yaw_rad, pitch_rad, roll_rad: 0.0 }, airspeed_m_s)
    }

    /// Its pose.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// From now on it flies at this heading, counter-clockwise from east, radians, not wrapped: it turns by
    /// the difference to its own.
    pub fn command(&mut self, yaw_rad: f64) {
        self.commanded_yaw_rad = yaw_rad;
    }

    /// The radius of its tightest turn without wind, metres.
    pub fn turn_radius_m(model: &FixedWingModel, airspeed_m_s: f64) -> f64 {
        airspeed_m_s * airspeed_m_s / (GRAVITY_M_S2 * model.roll_max_deg.to_radians().tan())
    }

    /// Lets `dt_s` seconds pass: fourth-order Runge-Kutta.
    pub fn advance(&mut self, dt_s: f64) {
        let substeps = (dt_s / SUBSTEP_S).ceil().max(1.0);
        let h = dt_s / substeps;
        let mut s = self.state();
        for _ in 0..substeps as u64 {
            let k1 = self.rates(&s);
            let k2 = self.rates(&moved(&s, &k1, h / 2.0));
            let k3 = self.rates(&moved(&s, &k2, h / 2.0));
            let k4 = self.rates(&moved(&s, &k3, h));
            for i in 0..s.len() {
                s[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
        }
        let [roll_rad, pitch_rad, yaw_rad, x, y] = s;
        let p_world = [x, y, self.pose.p_world[2]];
        self.pose = Pose { p_world, yaw_rad, pitch_rad, roll_rad };
    }

    fn state(&self) -> State {
        let Pose { p_world: [x, y, _], yaw_rad, pitch_rad, roll_rad } = self.pose;
        [roll_rad, pitch_rad, yaw_rad, x, y]
    }

    /// A right bank turns to the right: ψ̇ = −g tan φ / v.
    fn rates(&self, &[roll, pitch, yaw, ..]: &State) -> State {
        let FixedWingModel {
            roll_max_deg,
            roll_time_constant_s,
            heading_time_constant_s,
            pitch_trim_deg,
            pitch_time_constant_s,
            wind_m_s: [wind_east, wind_north],
        } = self.model;
        let v = self.airspeed_m_s;
        let wanted_rad_s = (self.commanded_yaw_rad - yaw) / heading_time_constant_s;
        let most = roll_max_deg.to_radians();
        let wanted_roll = (-v * wanted_rad_s / GRAVITY_M_S2).atan().clamp(-most, most);
        let wanted_pitch = -pitch_trim_deg.to_radians() / roll.cos();
        [
            (wanted_roll - roll) / roll_time_constant_s,
            (wanted_pitch - pitch) / pitch_time_constant_s,
            -GRAVITY_M_S2 * roll.tan() / v,
            v * yaw.cos() + wind_east,
            v * yaw.sin() + wind_north,
        ]
    }
}

fn moved(state: &State, rates: &State, h: f64) -> State {
    std::array::from_fn(|i| state[i] + h * rates[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aircraft() -> FixedWing {
        FixedWing::level(FixedWingModel::default(), [0.0, 0.0, 90.0], 0.0, 20.0)
    }

    #[test]
    fn straight_flight_is_straight_and_drifts_with_the_wind() {
        let mut calm = aircraft();
        calm.advance(10.0);
        let pose = calm.pose();
        assert!((pose.p_world[0] - 200.0).abs() < 1e-9 && pose.p_world[1] == 0.0);
        assert!((pose.pitch_rad + 4.0f64.to_radians()).abs() < 1e-12, "the nose is up");
        let model = FixedWingModel { wind_m_s: [-3.0, 2.0], ..FixedWingModel::default() };
        let mut windy = FixedWing::level(model, [0.0, 0.0, 90.0], 0.0, 20.0);
        windy.advance(10.0);
        assert!((windy.pose().p_world[0] - 170.0).abs() < 1e-9);
        assert!((windy.pose().p_world[1] - 20.0).abs() < 1e-9);
    }

    #[test]
    fn a_steady_turn_is_coordinated_and_has_its_radius() {
        let mut uav = aircraft();
        uav.command(-1000.0);
        uav.advance(5.0);
        let (before, roll) = (uav.pose(), uav.pose().roll_rad);
        assert!((roll - 30.0f64.to_radians()).abs() < 1e-3, "right side down, to the right");
        let pitch = -4.0f64.to_radians() / roll.cos();
        assert!((before.pitch_rad - pitch).abs() < 1e-4, "more lift, more nose up");
        uav.advance(1.0);
        let rate = uav.pose().yaw_rad - before.yaw_rad;
        assert!((rate + GRAVITY_M_S2 * roll.tan() / 20.0).abs() < 1e-3, "{rate}");
        let radius = FixedWing::turn_radius_m(&FixedWingModel::default(), 20.0);
        assert!((radius - 20.0 / -rate).abs() < 0.2, "{radius}");
    }

    #[test]
    fn the_heading_settles() {
        let mut uav = aircraft();
        uav.command(1.0);
        uav.advance(15.0);
        assert!((uav.pose().yaw_rad - 1.0).abs() < 1e-2, "{:?}", uav.pose());
        assert!(uav.pose().roll_rad.abs() < 1e-2);
    }

    #[test]
    fn the_length_of_the_time_step_hardly_matters() {
        let [mut coarse, mut fine] = [aircraft(), aircraft()];
        for turn in [1.0, -0.5, 3.0] {
            [&mut coarse, &mut fine].into_iter().for_each(|uav| uav.command(turn));
            coarse.advance(3.0);
            (0..3000).for_each(|_| fine.advance(1e-3));
        }
        let (a, b) = (coarse.pose(), fine.pose());
        assert!((a.yaw_rad - b.yaw_rad).abs() < 1e-4, "{a:?} {b:?}");
        for axis in 0..2 {
            assert!((a.p_world[axis] - b.p_world[axis]).abs() < 1e-2, "{a:?} {b:?}");
        }
    }
}
