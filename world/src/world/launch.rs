//! Room to turn at the starts of the UAVs.

use csat_proto::camera::Pose;
use csat_proto::model::{FLIGHT_CLEARANCE_M, FleetModel};

use crate::map::{Map, MapWarning};
use crate::obstacle::Walls;

/// Lowers buildings within [`FleetModel::launch_radius_m`] of a start until that UAV can fly over
/// them, with a warning of the map for each. Buildings farther away keep their heights.
pub(super) fn clear(map: &mut Map, fleet: &FleetModel, starts: &[Pose]) {
    let radius_m = fleet.launch_radius_m();
    for obstacle in &mut map.obstacles {
        let walls = Walls::new(std::slice::from_ref(obstacle));
        let is_near = |start: &&Pose| {
            let [x, y, _] = start.p_world;
            walls.nearest_within([x, y], radius_m.next_up()).is_some()
        };
        let near = starts.iter().filter(is_near);
        let lowest_m = near.map(|start| start.p_world[2]).fold(f64::INFINITY, f64::min);
        let (got_m, max_m) = (obstacle.height_m, lowest_m - FLIGHT_CLEARANCE_M);
        if got_m > max_m {
            obstacle.height_m = max_m;
            let name = obstacle.name.clone();
            map.warnings.push(MapWarning::LaunchSite { name, got_m, max_m, radius_m });
        }
    }
}
