//! What there is to see.

use csat_proto::agent::Agent;
use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::model::TargetsModel;
use csat_proto::time::{SimTime, Step};
use csat_world::camera::Renderer;
use csat_world::scene::{Entity, Prism, Scene};
use csat_world::target::TargetTruth;

use crate::set_membership::SetMembership;
use csat_mission::mission::{Detail, Mission};

/// Where the UAV is, metres (§4.7.2).
pub const P_WORLD: [f64; 3] = [0.0, 0.0, 50.0];
/// How far east the cars stand, metres (§4.7.2).
pub const CARS_M: [f64; 5] = [60.0, 90.0, 120.0, 150.0, 180.0];

/// Buildings as §4.7.6 tells of them: one on the left whose roof is seen, 20 m x 20 m and 15 m high,
/// and two in the background whose roofs are above the image. [west, south, east, north, height].
const BUILDINGS_M: [[f64; 5]; 3] = [
    [100.0, 25.0, 120.0, 45.0, 15.0],
    [150.0, -64.0, 165.0, -40.0, 30.0],
    [150.0, -38.0, 165.0, -14.0, 30.0],
];

/// The pose of every look.
pub fn pose() -> Pose {
    Pose::level(P_WORLD, 0.0)
}

/// Where car `index` is, `world`, metres.
pub fn location(index: usize) -> [f64; 2] {
    [CARS_M[index], 0.0]
}

/// The distance of car `index`'s location from the UAV, metres.
pub fn distance_m(index: usize) -> f64 {
    CARS_M[index].hypot(P_WORLD[2])
}

/// The five cars.
pub fn cars(targets: &TargetsModel, heading_rad: f64) -> Scene {
    let car = |index: usize| {
        let id = TargetId(index as u16);
        TargetTruth { id, location: location(index), heading_rad, speed_m_s: 0.0 }
    };
    Scene { prisms: (0..CARS_M.len()).map(|i| car(i).prism(targets.body_m)).collect() }
}

/// (4.50) of one look at the buildings: the ground hidden in the frame against the ground that the
/// occupancy-elevation map made of this frame says is hidden, per cent.
pub fn oem_iou_pct(mission: &SetMembership, seed: u64) -> Option<f64> {
    let mut agent = mission.agent(AgentId(0), Incarnation(0));
    let mut renderer = Renderer::new(mission.camera(AgentId(0))?);
    let frame = renderer.frame(&buildings(), &pose(), Step(0), seed, AgentId(0));
    agent.handle_frame(SimTime(0), &frame);
    agent.handle_timeout(SimTime(0));
    mission.report(&mut agent, &Pose::default(), Detail::Brief).oem_iou_pct
}

/// The buildings.
pub fn buildings() -> Scene {
    let building = |(index, [west, south, east, north, height_m]): (u32, [f64; 5])| {
        let ring = vec![[west, south], [east, south], [east, north], [west, north]];
        Prism { entity: Entity::Obstacle(index), rings: vec![ring], height_m }
    };
    Scene { prisms: (0..).zip(BUILDINGS_M).map(building).collect() }
}
