//! Where the aircraft is, for steering: the reported poses, filtered. Factors keep the reported poses.

use csat_proto::camera::Pose;
use csat_proto::fixed_wing::{FixedWing, FixedWingModel};
use csat_proto::time::Step;

use crate::config::AgentConfig;

/// How much of the difference between a reported and the predicted pose is believed, at most: the vehicle's
/// model says the rest. White errors of the position are reduced to a sixth.
const GAIN: f64 = 0.05;
/// The same of roll and pitch, which the model predicts from the commands.
const ATTITUDE_GAIN: f64 = 0.02;

/// How the aircraft flies, and how often it is commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Airframe {
    /// Its dynamics, and the wind.
    pub model: FixedWingModel,
    /// Its airspeed, m/s.
    pub airspeed_m_s: f64,
    /// From one step to the next, seconds.
    pub period_s: f64,
}

impl Airframe {
    /// The airframe of an agent.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            model: config.fleet.fixed_wing,
            airspeed_m_s: config.fleet.speed_m_s,
            period_s: config.period_s,
        }
    }

    /// Frames and commands per second.
    pub fn per_second(&self) -> u32 {
        (1.0 / self.period_s).round().max(1.0) as u32
    }

    /// The radius of the tightest turn over ground, metres. With the wind it is wider than without.
    pub fn turn_radius_m(&self) -> f64 {
        let [east, north] = self.model.wind_m_s;
        let widened = 1.0 + east.hypot(north) / self.airspeed_m_s;
        FixedWing::turn_radius_m(&self.model, self.airspeed_m_s) * widened
    }

    /// The pose after level flight at the heading of a pose, seconds.
    pub fn straight_on(&self, pose: &Pose, seconds: f64) -> Pose {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let [x, y, z] = pose.p_world;
        let [east, north] = self.model.wind_m_s;
        let p_world = [
            x + seconds * (self.airspeed_m_s * cos + east),
            y + seconds * (self.airspeed_m_s * sin + north),
            z,
        ];
        let pitch_rad = -self.model.pitch_trim_deg.to_radians();
        Pose { p_world, pitch_rad, roll_rad: 0.0, ..*pose }
    }
}

/// Predicts the pose with the vehicle's model and corrects it with a small gain.
#[derive(Debug, Clone)]
pub struct Navigation {
    airframe: Airframe,
    commanded_yaw_rad: f64,
    /// Since the first report: the step of the last one, how many there were, and the estimate.
    estimate: Option<(Step, u32, Pose)>,
}

impl Navigation {
    /// A filter without an estimate.
    pub fn new(airframe: Airframe) -> Self {
        Self { airframe, commanded_yaw_rad: 0.0, estimate: None }
    }

    /// The pose at `step` after the reported one was taken into account. Its yaw is not wrapped.
    pub fn update(&mut self, step: Step, reported: &Pose) -> Pose {
        let Some((last, count, _)) = self.estimate else {
            self.commanded_yaw_rad = reported.yaw_rad;
            self.estimate = Some((step, 1, *reported));
            return *reported;
        };
        let mut vehicle = self.vehicle();
        let elapsed = f64::from(step.0.saturating_sub(last.0)) * self.airframe.period_s;
        if elapsed > 0.0 {
            vehicle.advance(elapsed);
        }
        let mut pose = vehicle.pose();
        let count = count.saturating_add(1);
        // The mean of the first reports, then a fading one.
        let gain = GAIN.max(1.0 / f64::from(count));
        let attitude_gain = ATTITUDE_GAIN.max(1.0 / f64::from(count));
        for axis in 0..3 {
            pose.p_world[axis] += gain * (reported.p_world[axis] - pose.p_world[axis]);
        }
        pose.yaw_rad += gain * wrapped(reported.yaw_rad - pose.yaw_rad);
        pose.pitch_rad += attitude_gain * (reported.pitch_rad - pose.pitch_rad);
        pose.roll_rad += attitude_gain * (reported.roll_rad - pose.roll_rad);
        self.estimate = Some((step, count, pose));
        pose
    }

    /// Notes the commanded heading, radians.
    pub fn command(&mut self, yaw_rad: f64) {
        self.commanded_yaw_rad = yaw_rad;
    }

    /// The aircraft as estimated, under its command.
    pub fn vehicle(&self) -> FixedWing {
        let pose = self.estimate.map_or_else(Pose::default, |(_, _, pose)| pose);
        let mut vehicle = FixedWing::new(self.airframe.model, pose, self.airframe.airspeed_m_s);
        vehicle.command(self.commanded_yaw_rad);
        vehicle
    }
}

/// An angle in [−π, π).
pub(super) fn wrapped(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle_rad + PI).rem_euclid(TAU) - PI
}
