//! What the world and all agents are told before the start: the region of interest, what is known of
//! the targets, and how the fleet moves.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::camera::Pose;
use crate::fixed_wing::FixedWingModel;

/// The ground X_g of the region of interest: an axis-aligned rectangle centred on the origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Width (east) and depth (north), in metres.
    pub size_m: [f64; 2],
}

impl Ground {
    /// φ(X_g) in square metres.
    pub fn area_m2(&self) -> f64 {
        self.size_m[0] * self.size_m[1]
    }

    /// Whether a point (world, metres) lies in X_g, border included.
    pub fn contains(&self, p_world: [f64; 2]) -> bool {
        (0..2).all(|axis| p_world[axis].abs() <= self.size_m[axis] / 2.0)
    }
}

/// How the cars drive; agents are not told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Driving {
    /// On the roads, each at a constant speed of its own between 0 and v_max (5.34).
    #[default]
    Roads,
    /// Off the roads at v_max, as evasively as the model allows: straight on and along walls, away
    /// from the UAVs, or onto ground that a UAV has just seen.
    Evasive,
    /// They stand, off the roads as well, at places drawn uniformly from the region.
    Static,
    /// They walk at random from such places: in each step normally distributed, without a bound of their
    /// speed.
    RandomWalk,
}

impl Driving {
    /// Whether they keep to v_max (5.34).
    pub fn keeps_v_max(self) -> bool {
        self != Self::RandomWalk
    }
}

/// `[targets]`: how many cars there are, what bounds their motion and their shape.
///
/// Agents of the set-membership mission use all of it except `count`, `driving`, `walk_m_sqrt_s` and `tracks`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TargetsModel {
    /// N^t, the true number of targets.
    pub count: u16,
    /// How they drive.
    pub driving: Driving,
    /// The standard deviation of a random walk along each axis after one second, m/√s: it is
    /// `walk_m_sqrt_s * √t` after t seconds.
    pub walk_m_sqrt_s: f64,
    /// The file of the tracks that the targets follow; without it they drive on their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tracks: Option<PathBuf>,
    /// v_max, the bound on a target's speed, in m/s.
    pub v_max_m_s: f64,
    /// r_s^to: a target's location is always farther than this from any obstacle, in metres (3.8).
    pub obstacle_distance_m: f64,
    /// r_s^tt: two targets' locations are always farther apart than this, in metres (3.11).
    pub target_distance_m: f64,
    /// r^t: radius of the vertical cylinder about the location that contains the shape (3.4), metres.
    pub radius_m: f64,
    /// h^t: height of that cylinder, metres.
    pub cylinder_height_m: f64,
    /// Length, width and height of a car, metres.
    pub body_m: [f64; 3],
}

impl Default for TargetsModel {
    fn default() -> Self {
        Self {
            count: 8,
            driving: Driving::Roads,
            walk_m_sqrt_s: 2.0,
            tracks: None,
            v_max_m_s: 1.0,
            obstacle_distance_m: 2.5,
            target_distance_m: 8.0,
            radius_m: 2.5,
            cylinder_height_m: 2.0,
            body_m: [4.6, 1.8, 1.5],
        }
    }
}

/// The distance that UAVs keep from buildings, metres: above those that they fly over, beside all
/// others.
pub const FLIGHT_CLEARANCE_M: f64 = 2.0;

/// The radius of the launch site is the distance that a UAV flies in this time, seconds.
const LAUNCH_S: f64 = 10.0;

/// Where a UAV starts, at its own altitude.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartPose {
    /// East of the middle of the region, metres.
    pub x_m: f64,
    /// North of the middle of the region, metres.
    pub y_m: f64,
    /// Yaw, counter-clockwise from east, degrees.
    #[serde(default)]
    pub yaw_deg: f64,
}

/// `[agents]`: the fleet and how it flies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FleetModel {
    /// N^u, the number of UAVs.
    pub count: u16,
    /// v^u, the constant horizontal speed, in m/s.
    pub speed_m_s: f64,
    /// Altitude of UAV 0, in metres; UAV i flies i steps above it.
    pub altitude_m: f64,
    /// Difference of altitude between consecutive UAVs, in metres; less in a fleet that would otherwise
    /// exceed `altitude_band_m`.
    pub altitude_step_m: f64,
    /// The most between the altitudes of the first and the last UAV, in metres: from higher up, a
    /// camera sees no ground within d_max and too few pixels of a car.
    pub altitude_band_m: f64,
    /// How far outside the western border the fleet starts when `start` is empty, in metres.
    pub start_offset_m: f64,
    /// Where the UAVs start, by index; a single pose is the start of all UAVs.
    pub start: Vec<StartPose>,
    /// Settling time t_5% of the yaw response, in seconds (thesis figure 5.3).
    pub yaw_settling_s: f64,
    /// Whether buildings may be higher than the UAVs fly; then UAVs fly around them.
    pub avoid_buildings: bool,
    /// What flies.
    pub vehicle: VehicleKind,
    /// How it flies, if it is a fixed-wing aircraft.
    pub fixed_wing: FixedWingModel,
    /// How it flies, if it is a multirotor.
    pub multirotor: MultirotorModel,
}

/// `[agents.multirotor]`: how well a multirotor does what it is told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MultirotorModel {
    /// In each period T its displacement errs by at most this much along either axis, metres, also while it
    /// hovers.
    pub motion_error_m: f64,
}

impl Default for MultirotorModel {
    fn default() -> Self {
        Self { motion_error_m: 0.02 }
    }
}

/// What a UAV is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VehicleKind {
    /// A quadcopter: level, along its yaw.
    #[default]
    Quadcopter,
    /// A fixed-wing aircraft: coordinated turns.
    FixedWing,
    /// A multirotor: level, with a constant yaw, displaced step by step.
    Multirotor,
}

impl FleetModel {
    /// The altitude of UAV `index`, in metres.
    pub fn altitude_of(&self, index: u16) -> f64 {
        let widest_m = self.altitude_band_m / f64::from(self.count.max(2) - 1);
        let step_m = self.altitude_step_m.max(-widest_m).min(widest_m);
        self.altitude_m + f64::from(index) * step_m
    }

    /// Where UAV `index` starts over the region `ground`: at its own pose, at the common one, or
    /// `start_offset_m` west of the middle of the western border, heading east.
    pub fn start_of(&self, index: u16, ground: &Ground) -> StartPose {
        let x_m = -ground.size_m[0] / 2.0 - self.start_offset_m;
        let outside = StartPose { x_m, y_m: 0.0, yaw_deg: 0.0 };
        let own = self.start.get(usize::from(index)).or(self.start.first());
        own.copied().unwrap_or(outside)
    }

    /// The radius about its start within which a UAV has room to turn, metres: no building there is
    /// as high as the UAVs fly.
    pub fn launch_radius_m(&self) -> f64 {
        LAUNCH_S * self.speed_m_s
    }
}

impl Default for FleetModel {
    fn default() -> Self {
        Self {
            count: 4,
            speed_m_s: 5.0,
            altitude_m: 52.0,
            altitude_step_m: 3.0,
            altitude_band_m: 24.0,
            start_offset_m: 10.0,
            start: Vec::new(),
            yaw_settling_s: 1.2,
            avoid_buildings: false,
            vehicle: VehicleKind::default(),
            fixed_wing: FixedWingModel::default(),
            multirotor: MultirotorModel::default(),
        }
    }
}

/// `[segmentation]`: what a camera that segments roads gets wrong. A pixel is labelled Road if its middle is on
/// a road, except for these errors, which are drawn anew for each frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RoadSensor {
    /// The bound that always holds: a pixel whose middle is on a road has a pixel labelled Road within this
    /// Chebyshev distance, pixels. With 0 no road pixel is missed.
    pub gap_px: u16,
    /// Gaps: the share of the road pixels that squares of `2 gap_px` pixels hit, 0..1. Fewer are missed: squares
    /// overlap, and the bound holds.
    pub gap_share: f64,
    /// Ragged edges: the share of the pixels on either side of an edge that have the label of the other side,
    /// 0..1; of the road's pixels only as many as the bound allows.
    pub edge_share: f64,
    /// Speckle: the share of all pixels that are labelled Road whatever they show, 0..1.
    pub speckle_share: f64,
}

impl Default for RoadSensor {
    fn default() -> Self {
        Self { gap_px: 1, gap_share: 0.05, edge_share: 0.2, speckle_share: 0.001 }
    }
}

impl RoadSensor {
    /// One that makes no errors.
    pub const EXACT: Self = Self { gap_px: 0, gap_share: 0.0, edge_share: 0.0, speckle_share: 0.0 };
}

/// `[odometry]`: the errors of the pose that an agent is told. It is in a frame of the agent's own, whose origin
/// is its start and whose axes are those of `world`; height and attitude are true.
///
/// Along either axis, the displacement between any two frames errs by at most `jitter_m` plus `drift_share` of
/// the path flown between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryModel {
    /// The error that is drawn anew for each frame, metres: half of it at either end of a displacement.
    pub jitter_m: f64,
    /// The error that grows with the path, in a direction and at a rate that each agent keeps, as a share of
    /// the path, 0..1.
    pub drift_share: f64,
}

impl Default for OdometryModel {
    fn default() -> Self {
        Self { jitter_m: 0.05, drift_share: 0.001 }
    }
}

/// One of `[[stations]]`: a ground station, an agent without camera that stays where it is. In a fleet
/// of N^u UAVs the first station is agent N^u.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Station {
    /// East, in metres of `world`.
    pub x_m: f64,
    /// North, in metres of `world`.
    pub y_m: f64,
    /// Height of its antenna above the ground, in metres.
    pub z_m: f64,
}

impl Station {
    /// Where its antenna is, `world`, metres; level, towards the east.
    pub fn pose(&self) -> Pose {
        Pose::level([self.x_m, self.y_m, self.z_m], 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_fleet_flies_in_the_band_too() {
        let fleet = |count| FleetModel { count, ..FleetModel::default() };
        assert_eq!([0, 3].map(|i| fleet(4).altitude_of(i)), [52.0, 61.0]);
        assert_eq!([0, 8].map(|i| fleet(9).altitude_of(i)), [52.0, 76.0]);
        assert_eq!([0, 63].map(|i| fleet(64).altitude_of(i)), [52.0, 76.0]);
        assert!(fleet(64).altitude_of(1) > 52.0, "each its own");
        let downwards = FleetModel { altitude_step_m: -2.0, ..fleet(25) };
        assert_eq!(downwards.altitude_of(24), 28.0);
        assert_eq!(fleet(1).altitude_of(0), 52.0);
    }
}
