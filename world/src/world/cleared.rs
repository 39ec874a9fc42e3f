//! What a world has in which UAVs clear roads: the road area R, and the start line S.

use std::sync::Arc;

use csat_proto::model::{FleetModel, StartPose, VehicleKind};

use super::WorldConfig;
use crate::map::Map;
use crate::road_area::{CELL_M, RoadArea};
use crate::start_line::{StartLine, StartLineError};

/// R and S.
#[derive(Debug)]
pub(super) struct Cleared {
    pub roads: Arc<RoadArea>,
    pub start_line: StartLine,
}

impl Cleared {
    /// R and S of a map; `None` where no camera segments roads.
    pub fn of(config: &WorldConfig, map: &Map) -> Result<Option<Self>, StartLineError> {
        if config.segmentation.is_none() {
            return Ok(None);
        }
        let roads = RoadArea::new(map, CELL_M);
        let start_line = StartLine::choose(&roads, config.map.start_line)?;
        Ok(Some(Self { roads: Arc::new(roads), start_line }))
    }

    /// The fleet with its start poses: multirotors without any start above the middle of the start line.
    pub fn launched(&self, fleet: &FleetModel) -> FleetModel {
        let mut fleet = fleet.clone();
        if fleet.start.is_empty() && fleet.vehicle == VehicleKind::Multirotor {
            let [x_m, y_m] = self.start_line.middle();
            fleet.start = vec![StartPose { x_m, y_m, yaw_deg: 0.0 }];
        }
        fleet
    }
}

#[cfg(test)]
mod tests {
    use csat_proto::camera::CameraModel;
    use csat_proto::command::Command;
    use csat_proto::ids::AgentId;
    use csat_proto::model::{OdometryModel, RoadSensor};

    use super::super::{World, WorldError};
    use super::*;
    use crate::map::MapKind;

    fn config() -> WorldConfig {
        let mut config = WorldConfig { period_s: 0.125, ..WorldConfig::default() };
        config.map.kind = MapKind::Desert;
        config.targets.count = 0;
        config.fleet.vehicle = VehicleKind::Multirotor;
        config.fleet.altitude_m = 70.0;
        config.fleet.altitude_step_m = 0.1;
        config.camera = CameraModel {
            columns: 256,
            rows: 256,
            aperture_deg: 80.0,
            tilt_deg: 90.0,
            ..config.camera
        };
        config.segmentation = Some(RoadSensor::default());
        config.odometry = Some(OdometryModel::default());
        config
    }

    #[test]
    fn multirotors_start_above_the_start_line_and_fly_without_cars() {
        for seed in 0..5 {
            let mut world = World::new(&config(), seed).unwrap();
            let line = *world.start_line().unwrap();
            assert_eq!(line.a[0], -250.0, "the nearest one is in the west here");
            let [x, y] = line.middle();
            assert_eq!(world.poses()[1].p_world, [x, y, 70.1]);
            assert!(world.targets().is_empty());
            let roads = world.road_area().unwrap();
            let cleared = roads.component(&line);
            assert!(cleared.area_m2() > 10_000.0, "{}", cleared.area_m2());
            for _ in 0..80 {
                let by_m = [0.125, 0.0];
                world.command(AgentId(0), Command::Displace { by_m }).unwrap();
                world.advance();
            }
            let poses = world.poses();
            let [reported, other] = [0, 1].map(|index| world.reported_poses()[index].pose);
            assert!((poses[0].p_world[0] - x - 10.0).abs() < 80.0 * 0.02);
            let error = reported.p_world[0] - (poses[0].p_world[0] - x);
            assert!(error.abs() <= 0.05 + 0.001 * 80.0 * 0.16, "{error}");
            assert!(other.p_world[0].abs() < 1.0 && reported.yaw_rad == poses[0].yaw_rad);
            assert!(world.command(AgentId(0), Command::Yaw { yaw_rad: 0.0 }).is_err());
        }
    }

    #[test]
    fn own_starts_and_start_lines_are_kept() {
        let mut config = config();
        config.fleet.start = vec![StartPose { x_m: 10.0, y_m: 20.0, yaw_deg: 0.0 }];
        let world = World::new(&config, 1).unwrap();
        assert_eq!(world.poses()[0].p_world, [10.0, 20.0, 70.0]);
        config.map.kind = MapKind::Generated;
        let town = World::new(&config, 1).unwrap();
        let east = crate::start_line::StartLine::all(town.road_area().unwrap());
        let east = east.iter().find(|line| line.a[0] == 250.0).unwrap().middle();
        config.map.start_line = Some(east);
        let world = World::new(&config, 1).unwrap();
        assert_eq!(world.start_line().unwrap().middle(), east);
        config.segmentation = None;
        config.map.start_line = None;
        let world = World::new(&config, 1).unwrap();
        assert!(world.road_area().is_none() && world.start_line().is_none());
    }

    #[test]
    fn impossible_values_are_named() {
        let lines = |config: &WorldConfig| World::new(config, 1).unwrap_err().to_string();
        let mut wrong = config();
        wrong.camera.tilt_deg = 30.0;
        wrong.fleet.multirotor.motion_error_m = -1.0;
        wrong.fleet.start = vec![StartPose { x_m: 0.0, y_m: 0.0, yaw_deg: 45.0 }];
        wrong.odometry = Some(OdometryModel { jitter_m: f64::NAN, drift_share: 2.0 });
        wrong.navigation = Some(Default::default());
        let text = lines(&wrong);
        let keys = [
            "agents.multirotor.motion_error_m",
            "agents.start",
            "odometry.jitter_m",
            "odometry.drift_share",
            "odometry",
            "camera.tilt_deg",
        ];
        let got: Vec<&str> = text.lines().map(|line| line.split(':').next().unwrap()).collect();
        assert_eq!(got, keys, "{text}");
        let mut wrong = config();
        wrong.segmentation = None;
        wrong.map.start_line = Some([-250.0, 0.0]);
        assert!(lines(&wrong).starts_with("map.start_line: got [-250.0, 0.0], expected"));
    }

    #[test]
    fn a_map_without_roads_has_no_start_line() {
        let mut open = config();
        open.map.kind = MapKind::Open;
        let errors = World::new(&open, 1).unwrap_err().errors;
        assert_eq!(errors, [WorldError::StartLine(StartLineError::NoRoads)]);
        let mut astray = config();
        astray.map.start_line = Some([0.0, 0.0]);
        let errors = World::new(&astray, 1).unwrap_err().errors;
        let is_off = matches!(errors[..], [WorldError::StartLine(StartLineError::OffRoad { .. })]);
        assert!(is_off, "{errors:?}");
    }
}
