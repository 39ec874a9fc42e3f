//! How UAVs move.

use csat_proto::camera::Pose;
use csat_proto::command::Command;
use csat_proto::fixed_wing::FixedWing;
use csat_proto::ids::AgentId;
use csat_proto::model::{FleetModel, Ground, VehicleKind};

mod multirotor;
mod quadcopter;

use crate::random::{StreamPurpose, stream};
use multirotor::Multirotor;
use quadcopter::Quadcopter;

/// A vehicle that carries a camera and follows commands.
pub trait Vehicle: std::fmt::Debug + Send + Sync {
    /// Its current pose.
    fn pose(&self) -> Pose;

    /// Follows this command from now on, if it is of the kind that the vehicle follows; returns whether it is.
    fn command(&mut self, command: Command) -> bool;

    /// Lets `dt_s` seconds pass.
    fn advance(&mut self, dt_s: f64);
}

/// UAV `index` of the fleet where it starts, at its own altitude. The seed is that of the errors of its motion.
pub fn at_start(fleet: &FleetModel, ground: &Ground, index: u16, seed: u64) -> Box<dyn Vehicle> {
    let start = fleet.start_of(index, ground);
    let p_world = [start.x_m, start.y_m, fleet.altitude_of(index)];
    let (yaw_rad, speed_m_s) = (start.yaw_deg.to_radians(), fleet.speed_m_s);
    match fleet.vehicle {
        VehicleKind::Quadcopter => {
            Box::new(Quadcopter::new(p_world, yaw_rad, speed_m_s, fleet.yaw_settling_s))
        }
        VehicleKind::FixedWing => {
            Box::new(FixedWing::level(fleet.fixed_wing, p_world, yaw_rad, speed_m_s))
        }
        VehicleKind::Multirotor => {
            let rng = stream(seed, StreamPurpose::Motion(AgentId(index)));
            let error_m = fleet.multirotor.motion_error_m;
            Box::new(Multirotor::new(p_world, speed_m_s, error_m, rng))
        }
    }
}

impl Vehicle for FixedWing {
    fn pose(&self) -> Pose {
        self.pose()
    }

    fn command(&mut self, command: Command) -> bool {
        let Command::Yaw { yaw_rad } = command else { return false };
        self.command(yaw_rad);
        true
    }

    fn advance(&mut self, dt_s: f64) {
        self.advance(dt_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::fixed_wing::FixedWingModel;
    use csat_proto::model::StartPose;

    #[test]
    fn the_fleet_starts_together_each_at_its_altitude() {
        let ground = Ground { size_m: [500.0, 300.0] };
        let fleet = FleetModel::default();
        let pose = at_start(&fleet, &ground, 2, 1).pose();
        assert_eq!(pose, Pose::level([-260.0, 0.0, 58.0], 0.0));
    }

    #[test]
    fn start_poses_are_taken_by_index_and_one_is_a_base() {
        let ground = Ground { size_m: [500.0, 300.0] };
        let poses = [(10.0, -20.0, 90.0), (30.0, 40.0, 0.0)];
        let start = poses.map(|(x_m, y_m, yaw_deg)| StartPose { x_m, y_m, yaw_deg });
        let each = FleetModel { count: 2, start: start.into(), ..FleetModel::default() };
        let pose = |fleet: &FleetModel, i| at_start(fleet, &ground, i, 1).pose();
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(pose(&each, 0), Pose::level([10.0, -20.0, 52.0], quarter));
        assert_eq!(pose(&each, 1), Pose::level([30.0, 40.0, 55.0], 0.0));
        let base = FleetModel { start: start[..1].into(), ..FleetModel::default() };
        assert_eq!(pose(&base, 3), Pose::level([10.0, -20.0, 61.0], quarter));
        let mut uav = at_start(&base, &ground, 0, 1);
        uav.advance(2.0);
        assert!((uav.pose().p_world[1] + 10.0).abs() < 1e-9, "it flies along its yaw");
    }

    #[test]
    fn a_fixed_wing_aircraft_starts_level_with_its_nose_up_and_banks_into_turns() {
        let ground = Ground { size_m: [500.0, 300.0] };
        let wind_m_s = [0.0, 3.0];
        let fleet = FleetModel {
            speed_m_s: 20.0,
            vehicle: VehicleKind::FixedWing,
            fixed_wing: FixedWingModel { wind_m_s, ..FixedWingModel::default() },
            ..FleetModel::default()
        };
        let mut uav = at_start(&fleet, &ground, 1, 1);
        assert_eq!((uav.pose().p_world, uav.pose().roll_rad), ([-260.0, 0.0, 55.0], 0.0));
        assert_eq!(uav.pose().pitch_rad, -4f64.to_radians());
        uav.advance(1.0);
        let [x, y, z] = uav.pose().p_world;
        assert!((x + 240.0).abs() < 1e-9 && (y - 3.0).abs() < 1e-9 && z == 55.0);
        uav.command(Command::Yaw { yaw_rad: 1.0 });
        uav.advance(1.0);
        assert!(uav.pose().yaw_rad > 0.05 && uav.pose().roll_rad < -0.1, "{:?}", uav.pose());
    }

    #[test]
    fn every_multirotor_errs_on_its_own() {
        let ground = Ground { size_m: [500.0, 300.0] };
        let mut fleet = FleetModel { vehicle: VehicleKind::Multirotor, ..FleetModel::default() };
        fleet.multirotor.motion_error_m = 0.5;
        let moved = |fleet: &FleetModel, index, seed| {
            let mut uav = at_start(fleet, &ground, index, seed);
            let start = uav.pose().p_world;
            assert!(uav.command(Command::Displace { by_m: [1.0, 0.0] }));
            assert!(!uav.command(Command::Yaw { yaw_rad: 0.0 }));
            uav.advance(1.0);
            [0, 1].map(|axis| uav.pose().p_world[axis] - start[axis])
        };
        let all = [moved(&fleet, 0, 1), moved(&fleet, 1, 1), moved(&fleet, 0, 2)];
        assert_eq!(all[0], moved(&fleet, 0, 1));
        assert!(all[0] != all[1] && all[0] != all[2]);
        assert!(all.iter().all(|[x, y]| (x - 1.0).abs() <= 0.5 && y.abs() <= 0.5), "{all:?}");
        for vehicle in [VehicleKind::Quadcopter, VehicleKind::FixedWing] {
            let mut uav = at_start(&FleetModel { vehicle, ..fleet.clone() }, &ground, 0, 1);
            assert!(!uav.command(Command::Displace { by_m: [1.0, 0.0] }), "{vehicle:?}");
        }
    }
}
