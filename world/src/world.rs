//! Everything that is true, one period at a time.

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::AgentId;
use csat_proto::model::{FleetModel, Ground, TargetsModel};
use csat_proto::time::Step;

use crate::map::{self, Map, MapConfig, MapError, MapRules, MapWarning};
use crate::obstacle::{Obstacle, Walls};
use crate::road::{RoadGraph, RoadRules};
use crate::scene::{Prism, Scene};
use crate::target::{PlacementError, TargetTruth, Traffic, road_clearance_m};
use crate::truth::Monitor;
use crate::uav::{Quadcopter, Vehicle, YawCommand};

mod check;

use check::{lowest_altitude_m, mistakes};

/// Roads end this far inside the border of the region, metres: a car's cylinder stays inside.
const ROAD_INSET_M: f64 = 3.0;
/// Connected pieces of road shorter than this carry no cars, metres.
const MIN_NETWORK_M: f64 = 20.0;

/// What a world is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldConfig {
    /// The town.
    pub map: MapConfig,
    /// The cars.
    pub targets: TargetsModel,
    /// The UAVs.
    pub fleet: FleetModel,
    /// Their cameras.
    pub camera: CameraModel,
    /// T, seconds.
    pub period_s: f64,
}

impl Default for WorldConfig {
    fn default() -> Self {
        Self {
            map: MapConfig::default(),
            targets: TargetsModel::default(),
            fleet: FleetModel::default(),
            camera: CameraModel::default(),
            period_s: 0.5,
        }
    }
}

/// One reason why there is no world.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// A value of the scenario that cannot work.
    #[error("{key}: got {got}, expected {expected}")]
    Config {
        /// The scenario key.
        key: &'static str,
        /// Its value.
        got: String,
        /// What would do.
        expected: String,
    },
    /// The map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// No room for all cars.
    #[error(transparent)]
    Placement(#[from] PlacementError),
}

/// Every reason why there is no world; never empty.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldErrors(pub Vec<WorldError>);

impl std::fmt::Display for WorldErrors {
    /// One line per reason.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            let separator = if index > 0 { "\n" } else { "" };
            write!(f, "{separator}{error}")?;
        }
        Ok(())
    }
}

impl std::error::Error for WorldErrors {}

/// The fleet has no such UAV, or the command is no angle.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("UAV {agent} of {count}: command to yaw {yaw_rad} rad")]
pub struct CommandError {
    /// Who was to be commanded.
    pub agent: AgentId,
    /// Number of UAVs.
    pub count: usize,
    /// The command.
    pub yaw_rad: f64,
}

/// The town, the cars and the UAVs at step k.
#[derive(Debug)]
pub struct World {
    config: WorldConfig,
    map: Map,
    prisms: Vec<Prism>,
    roads: RoadGraph,
    traffic: Traffic,
    vehicles: Vec<Box<dyn Vehicle>>,
    step: Step,
}

impl World {
    /// The world of a seed at step 0; equal arguments (and map files) give equal worlds.
    ///
    /// # Errors
    /// Every mistake at once; placement is tried only when all else is right.
    pub fn new(config: &WorldConfig, seed: u64) -> Result<Self, WorldErrors> {
        let mut errors = mistakes(config);
        let clearance_m = road_clearance_m(&config.targets);
        let rules = MapRules {
            lowest_altitude_m: lowest_altitude_m(&config.fleet),
            road_clearance_m: clearance_m,
        };
        let map = map::load(&config.map, &rules, seed).unwrap_or_else(|e| {
            errors.extend(e.into_iter().map(WorldError::Map));
            let ground = Ground { size_m: config.map.size_m };
            Map { ground, obstacles: vec![], roads: vec![], attribution: None, warnings: vec![] }
        });
        if !errors.is_empty() {
            return Err(WorldErrors(errors));
        }
        let walls = Walls::new(&map.obstacles);
        let rules = RoadRules { inset_m: ROAD_INSET_M, clearance_m, min_network_m: MIN_NETWORK_M };
        let roads = RoadGraph::build(&map.ground, &map.roads, &walls, &rules);
        let traffic = Traffic::place(&roads, map.roads.len(), &config.targets, seed)
            .map_err(|e| WorldErrors(vec![e.into()]))?;
        let prisms = (0..).zip(&map.obstacles).map(|(i, o)| o.prism(i)).collect();
        let vehicles = (0..config.fleet.count)
            .map(|i| Quadcopter::at_start(&config.fleet, &map.ground, i))
            .map(|q| Box::new(q) as Box<dyn Vehicle>)
            .collect();
        let config = config.clone();
        Ok(Self { config, map, prisms, roads, traffic, vehicles, step: Step(0) })
    }

    /// Lets one period T pass: k becomes k + 1.
    pub fn advance(&mut self) {
        self.traffic.advance(&self.roads, self.config.period_s);
        for vehicle in &mut self.vehicles {
            vehicle.advance(self.config.period_s);
        }
        self.step.0 += 1;
    }

    /// Commands a UAV, from now on.
    ///
    /// # Errors
    /// When there is no such UAV, or the angle is not finite; nothing changes then.
    pub fn command(&mut self, agent: AgentId, command: YawCommand) -> Result<(), CommandError> {
        let (count, yaw_rad) = (self.vehicles.len(), command.yaw_rad);
        match self.vehicles.get_mut(usize::from(agent.0)) {
            Some(vehicle) if yaw_rad.is_finite() => {
                vehicle.command(command);
                Ok(())
            }
            _ => Err(CommandError { agent, count, yaw_rad }),
        }
    }

    /// k.
    pub fn step(&self) -> Step {
        self.step
    }

    /// What the world was made from.
    pub fn config(&self) -> &WorldConfig {
        &self.config
    }

    /// Where every UAV is, by index.
    pub fn poses(&self) -> Vec<Pose> {
        self.vehicles.iter().map(|v| v.pose()).collect()
    }

    /// What is true of every target, by index.
    pub fn targets(&self) -> &[TargetTruth] {
        self.traffic.truths()
    }

    /// The obstacles; prism i of [`Self::scene`] is obstacle i.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.map.obstacles
    }

    /// Where cars can drive.
    pub fn roads(&self) -> &RoadGraph {
        &self.roads
    }

    /// The region of interest.
    pub fn ground(&self) -> Ground {
        self.map.ground
    }

    /// The town as mapped.
    pub fn map(&self) -> &Map {
        &self.map
    }

    /// What was put right in the map or left out of it.
    pub fn warnings(&self) -> &[MapWarning] {
        &self.map.warnings
    }

    /// Everything that stands on the ground now: obstacles by index, then targets by index.
    pub fn scene(&self) -> Scene {
        let bodies = self.targets().iter().map(|t| t.prism(self.config.targets.body_m));
        Scene { prisms: self.prisms.iter().cloned().chain(bodies).collect() }
    }

    /// A monitor of this world, which has seen nothing yet.
    pub fn monitor(&self) -> Monitor {
        let WorldConfig { targets, period_s, .. } = self.config;
        Monitor::new(self.map.ground, targets, period_s, &self.map.obstacles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Entity;
    use csat_proto::ids::TargetId;

    #[test]
    fn the_scene_holds_obstacles_then_targets() {
        let world = World::new(&WorldConfig::default(), 1).unwrap();
        let scene = world.scene();
        let obstacles = world.obstacles().len();
        assert_eq!(scene.prisms.len(), obstacles + 8);
        for (i, prism) in scene.prisms[..obstacles].iter().enumerate() {
            assert_eq!(prism.entity, Entity::Obstacle(i as u32));
            assert_eq!(prism.height_m, world.obstacles()[i].height_m);
        }
        for (j, prism) in scene.prisms[obstacles..].iter().enumerate() {
            assert_eq!(prism.entity, Entity::Target(TargetId(j as u16)));
        }
    }

    #[test]
    fn commands_steer_and_wrong_ones_change_nothing() {
        let mut world = World::new(&WorldConfig::default(), 1).unwrap();
        assert!(world.command(AgentId(1), YawCommand { yaw_rad: 1.0 }).is_ok());
        assert!(world.command(AgentId(2), YawCommand { yaw_rad: f64::NAN }).is_err());
        let error = world.command(AgentId(4), YawCommand { yaw_rad: 1.0 }).unwrap_err();
        assert_eq!((error.agent, error.count), (AgentId(4), 4));
        for _ in 0..20 {
            world.advance();
        }
        let yaws: Vec<f64> = world.poses().iter().map(|p| p.yaw_rad).collect();
        assert!((yaws[1] - 1.0).abs() < 1e-3);
        assert_eq!([yaws[0], yaws[2], yaws[3]], [0.0; 3]);
        assert_eq!(world.step(), Step(20));
        let altitudes: Vec<f64> = world.poses().iter().map(|p| p.p_world[2]).collect();
        assert_eq!(altitudes, [52.0, 55.0, 58.0, 61.0]);
    }

    #[test]
    fn every_mistake_is_reported_at_once() {
        let mut config = WorldConfig { period_s: 0.0, ..WorldConfig::default() };
        config.map.built_share = -1.0;
        config.targets.v_max_m_s = f64::NAN;
        config.targets.radius_m = 2.0;
        config.fleet.yaw_settling_s = -1.0;
        let errors = World::new(&config, 1).unwrap_err();
        let text = errors.to_string();
        let keys = [
            "targets.v_max_m_s",
            "run.period_s",
            "agents.yaw_settling_s",
            "targets.radius_m",
            "map.built_share",
        ];
        assert_eq!(text.lines().count(), keys.len(), "{text}");
        assert!(keys.iter().zip(text.lines()).all(|(key, line)| line.starts_with(key)), "{text}");
    }

    #[test]
    fn no_room_is_an_error_that_says_what_to_change() {
        let mut config = WorldConfig::default();
        config.map.size_m = [60.0, 60.0];
        config.targets.count = 500;
        let errors = World::new(&config, 1).unwrap_err();
        assert!(matches!(errors.0[..], [WorldError::Placement(_)]), "{errors}");
    }
}
