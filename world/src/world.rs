//! The state of the world, which advances by one period at a time.

use std::collections::BTreeMap;
use std::sync::Arc;

use csat_proto::camera::{CameraModel, Pose, PoseEstimate};
use csat_proto::command::Command;
use csat_proto::ids::AgentId;
use csat_proto::model::{
    Driving, FleetModel, Ground, OdometryModel, RoadSensor, Station, TargetsModel,
};
use csat_proto::time::Step;

use crate::lie::{Liar, Lie};
use crate::map::{self, Map, MapConfig, MapError, MapRules, MapWarning};
use crate::navigation::{Navigation, NavigationModel};
use crate::observer::{Observer, ObserverModel};
use crate::obstacle::{Obstacle, Walls};
use crate::odometry::Odometry;
use crate::road::{RoadGraph, RoadRules};
use crate::road_area::RoadArea;
use crate::scene::{Prism, Scene};
use crate::start_line::StartLine;
use crate::target::{Chase, TargetTruth, Watcher, road_clearance_m};
use crate::track::Tracks;
use crate::truth::Monitor;
use crate::uav::{self, Vehicle};

mod cars;
mod check;
mod cleared;
mod error;
mod launch;
pub mod stations;
#[cfg(test)]
mod tests;

use cars::{Cars, inset_m, off_road};
use check::{lowest_altitude_m, mistakes};
use cleared::Cleared;
pub use error::{CommandError, WorldError, WorldErrors};

/// Connected pieces of road shorter than this carry no cars, metres.
const MIN_NETWORK_M: f64 = 20.0;

/// The configuration of a world.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldConfig {
    /// The town.
    pub map: MapConfig,
    /// The cars.
    pub targets: TargetsModel,
    /// The tracks that the cars follow; without tracks they drive on the roads.
    pub tracks: Option<Tracks>,
    /// The UAVs.
    pub fleet: FleetModel,
    /// The ground stations.
    pub stations: Vec<Station>,
    /// The cameras of the UAVs.
    pub camera: CameraModel,
    /// The errors of reported poses; `None` where they are exact.
    pub navigation: Option<NavigationModel>,
    /// The errors of reported poses that are relative to the start; `None` where they are not.
    pub odometry: Option<OdometryModel>,
    /// How well a UAV knows its pose, as a box that contains it; `None` where nobody needs such a box.
    pub observer: Option<ObserverModel>,
    /// What cameras that segment roads get wrong; `None` where none does.
    pub segmentation: Option<RoadSensor>,
    /// The UAVs that lie.
    pub liars: Vec<Liar>,
    /// T, seconds.
    pub period_s: f64,
}

impl Default for WorldConfig {
    fn default() -> Self {
        Self {
            map: MapConfig::default(),
            targets: TargetsModel::default(),
            tracks: None,
            fleet: FleetModel::default(),
            stations: Vec::new(),
            camera: CameraModel::default(),
            navigation: None,
            odometry: None,
            observer: None,
            segmentation: None,
            liars: Vec::new(),
            period_s: 0.5,
        }
    }
}

impl WorldConfig {
    /// What the cars and the UAVs require of the town.
    pub fn map_rules(&self) -> MapRules {
        let lowest_altitude_m = match self.fleet.avoid_buildings {
            true => f64::INFINITY,
            false => lowest_altitude_m(&self.fleet),
        };
        MapRules { lowest_altitude_m, road_clearance_m: road_clearance_m(&self.targets) }
    }
}

/// The town, the cars, the UAVs and the ground stations at step k.
#[derive(Debug)]
pub struct World {
    config: WorldConfig,
    map: Map,
    prisms: Vec<Prism>,
    walls: Walls,
    roads: RoadGraph,
    cars: Cars,
    vehicles: Vec<Box<dyn Vehicle>>,
    /// By UAV; empty where reported poses are exact.
    navigation: Vec<Navigation>,
    /// By UAV; empty where reported poses are not relative to the start.
    odometry: Vec<Odometry>,
    /// By UAV; empty where no pose has a box.
    observers: Vec<Observer>,
    cleared: Option<Cleared>,
    lies: Vec<Lie>,
    step: Step,
}

/// The navigation systems of the UAVs, if they have any.
fn navigation(config: &WorldConfig, seed: u64) -> Vec<Navigation> {
    let Some(model) = config.navigation else { return Vec::new() };
    let system = |id| Navigation::new(model, config.period_s, seed, AgentId(id));
    (0..config.fleet.count).map(system).collect()
}

/// The odometry of the UAVs, if they have any.
fn odometry(config: &WorldConfig, vehicles: &[Box<dyn Vehicle>], seed: u64) -> Vec<Odometry> {
    let Some(model) = config.odometry else { return Vec::new() };
    let poses = vehicles.iter().map(|uav| uav.pose());
    let ids = (0..).map(AgentId);
    ids.zip(poses).map(|(id, pose)| Odometry::new(model, &pose, seed, id)).collect()
}

/// The observers of the UAVs' poses, if they have any.
fn observers(config: &WorldConfig, vehicles: &[Box<dyn Vehicle>], seed: u64) -> Vec<Observer> {
    let Some(model) = config.observer.as_ref().filter(|model| !model.is_exact()) else {
        return Vec::new();
    };
    let model = Arc::new(model.clone());
    let poses = vehicles.iter().map(|uav| uav.pose());
    let ids = (0..).map(AgentId);
    ids.zip(poses)
        .map(|(id, pose)| Observer::new(model.clone(), config.period_s, &pose, seed, id))
        .collect()
}

impl World {
    /// The world of a seed at step 0; equal arguments (and map files) give equal worlds.
    ///
    /// # Errors
    /// All mistakes together; cars are placed only when there is no other mistake.
    pub fn new(config: &WorldConfig, seed: u64) -> Result<Self, WorldErrors> {
        Self::in_town(config, map::load(&config.map, &config.map_rules(), seed), seed)
    }

    /// As [`Self::new`], with the town of this GeoJSON text: `map.file` only names it and is not
    /// read.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_geojson(config: &WorldConfig, text: &str, seed: u64) -> Result<Self, WorldErrors> {
        Self::in_town(config, map::from_geojson(&config.map, text, &config.map_rules()), seed)
    }

    /// As [`Self::new`], in a town that was made elsewhere.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_map(config: &WorldConfig, map: Map, seed: u64) -> Result<Self, WorldErrors> {
        Self::in_town(config, Ok(map), seed)
    }

    fn in_town(
        config: &WorldConfig,
        map: Result<Map, Vec<MapError>>,
        seed: u64,
    ) -> Result<Self, WorldErrors> {
        let mut errors = mistakes(config);
        let mut map = match map {
            Ok(map) if errors.is_empty() => map,
            Ok(map) => return Err(WorldErrors { errors, map_warnings: map.warnings }),
            Err(more) => {
                errors.extend(more.into_iter().map(WorldError::Map));
                return Err(errors.into());
            }
        };
        let walls = Walls::new(&map.obstacles);
        let indoors = stations::indoors(&config.stations, &walls, &map.obstacles);
        if !indoors.is_empty() {
            let errors = indoors.into_iter().map(WorldError::Station).collect();
            return Err(WorldErrors { errors, map_warnings: map.warnings });
        }
        let rules = RoadRules {
            inset_m: inset_m(&config.targets),
            clearance_m: road_clearance_m(&config.targets),
            min_network_m: MIN_NETWORK_M,
        };
        let roads = RoadGraph::build(&map.ground, &map.roads, &walls, &rules);
        let cars = match Cars::start(config, &map, &walls, &roads, seed) {
            Ok(cars) => cars,
            Err(errors) => return Err(WorldErrors { errors, map_warnings: map.warnings }),
        };
        let cleared = Cleared::of(config, &map).map_err(|error| WorldErrors {
            errors: vec![error.into()],
            map_warnings: map.warnings.clone(),
        })?;
        let fleet = cleared.as_ref().map(|cleared| cleared.launched(&config.fleet));
        let config = WorldConfig { fleet: fleet.unwrap_or(config.fleet.clone()), ..config.clone() };
        let at_start = |index| uav::at_start(&config.fleet, &map.ground, index, seed);
        let vehicles: Vec<Box<dyn Vehicle>> = (0..config.fleet.count).map(at_start).collect();
        if config.fleet.avoid_buildings {
            let starts: Vec<Pose> = vehicles.iter().map(|v| v.pose()).collect();
            launch::clear(&mut map, &config.fleet, &starts);
        }
        let prisms = (0..).zip(&map.obstacles).map(|(i, o)| o.prism(i)).collect();
        let navigation = navigation(&config, seed);
        let odometry = odometry(&config, &vehicles, seed);
        let observers = observers(&config, &vehicles, seed);
        let lies = config.liars.iter().map(|liar| Lie::new(*liar)).collect();
        let step = Step(0);
        let mut world = Self {
            config,
            map,
            prisms,
            walls,
            roads,
            cars,
            vehicles,
            navigation,
            odometry,
            observers,
            cleared,
            lies,
            step,
        };
        world.advance_lies();
        Ok(world)
    }

    /// Lets one period T pass: k becomes k + 1.
    pub fn advance(&mut self) {
        let period_s = self.config.period_s;
        self.step.0 += 1;
        match (&mut self.cars, self.config.targets.driving) {
            (Cars::Scripted(cars), _) => {
                cars.advance_to(f64::from(self.step.0) * period_s, period_s);
            }
            (Cars::Walking(walkers), _) => {
                walkers.advance(&off_road(&self.config, &self.map, &self.walls), period_s);
            }
            (Cars::Driving(_), Driving::Evasive) => self.evade(),
            (Cars::Driving(traffic), _) => traffic.advance(&self.roads, period_s),
        }
        for vehicle in &mut self.vehicles {
            vehicle.advance(period_s);
        }
        self.navigation.iter_mut().for_each(Navigation::advance);
        for (odometry, vehicle) in self.odometry.iter_mut().zip(&self.vehicles) {
            odometry.advance(&vehicle.pose());
        }
        for (observer, vehicle) in self.observers.iter_mut().zip(&self.vehicles) {
            observer.advance(&vehicle.pose());
        }
        self.advance_lies();
    }

    fn advance_lies(&mut self) {
        let (now_s, mut lies) = (self.now_s(), std::mem::take(&mut self.lies));
        lies.iter_mut().for_each(|lie| lie.advance(now_s, self.targets()));
        self.lies = lies;
    }

    fn now_s(&self) -> f64 {
        f64::from(self.step.0) * self.config.period_s
    }

    /// Lets the cars evade for one period; they react to what the UAVs see at its beginning.
    fn evade(&mut self) {
        let Cars::Driving(traffic) = &mut self.cars else { return };
        let WorldConfig { camera, period_s, .. } = &self.config;
        let watcher = |pose: &Pose| {
            Watcher::new([pose.p_world[0], pose.p_world[1]], &camera.at(pose).footprint())
        };
        let watchers: Vec<Watcher> = self.vehicles.iter().map(|v| watcher(&v.pose())).collect();
        let ground = off_road(&self.config, &self.map, &self.walls);
        let chase = Chase { ground, watchers: &watchers };
        traffic.evade(&chase, *period_s);
    }

    /// Commands a UAV, from now on.
    ///
    /// # Errors
    /// When there is no such UAV, a number is not finite, or the vehicle follows another kind of commands;
    /// nothing changes then.
    pub fn command(&mut self, agent: AgentId, command: Command) -> Result<(), CommandError> {
        let count = self.vehicles.len();
        let vehicle = self.vehicles.get_mut(usize::from(agent.0));
        let is_obeyed =
            vehicle.is_some_and(|vehicle| command.is_finite() && vehicle.command(command));
        if is_obeyed { Ok(()) } else { Err(CommandError { agent, count, command }) }
    }

    /// k.
    pub fn step(&self) -> Step {
        self.step
    }

    /// The configuration of the world.
    pub fn config(&self) -> &WorldConfig {
        &self.config
    }

    /// The pose of every agent, by index: the UAVs, then the ground stations.
    pub fn poses(&self) -> Vec<Pose> {
        let stations = self.config.stations.iter().map(Station::pose);
        self.vehicles.iter().map(|v| v.pose()).chain(stations).collect()
    }

    /// The same as the agents are told: poses of UAVs have errors if [`WorldConfig::navigation`] says so, or are
    /// relative to their starts if [`WorldConfig::odometry`] does, or come with a box that contains the true one
    /// if [`WorldConfig::observer`] does.
    pub fn reported_poses(&self) -> Vec<PoseEstimate> {
        let mut poses: Vec<PoseEstimate> =
            self.poses().into_iter().map(PoseEstimate::from).collect();
        for (estimate, navigation) in poses.iter_mut().zip(&self.navigation) {
            estimate.pose = navigation.reported(&estimate.pose);
        }
        for (estimate, odometry) in poses.iter_mut().zip(&self.odometry) {
            estimate.pose = odometry.reported(&estimate.pose);
        }
        for (estimate, observer) in poses.iter_mut().zip(&self.observers) {
            *estimate = observer.estimate(&estimate.pose);
        }
        poses
    }

    /// The true state of every target, by index.
    pub fn targets(&self) -> &[TargetTruth] {
        match &self.cars {
            Cars::Driving(traffic) => traffic.truths(),
            Cars::Walking(walkers) => walkers.truths(),
            Cars::Scripted(cars) => cars.truths(),
        }
    }

    /// The obstacles; prism i of [`Self::scene`] is obstacle i.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.map.obstacles
    }

    /// Where cars can drive.
    pub fn roads(&self) -> &RoadGraph {
        &self.roads
    }

    /// R, where cameras segment roads.
    pub fn road_area(&self) -> Option<&Arc<RoadArea>> {
        self.cleared.as_ref().map(|cleared| &cleared.roads)
    }

    /// S, where cameras segment roads.
    pub fn start_line(&self) -> Option<&StartLine> {
        self.cleared.as_ref().map(|cleared| &cleared.start_line)
    }

    /// The region of interest.
    pub fn ground(&self) -> Ground {
        self.map.ground
    }

    /// The town as mapped.
    pub fn map(&self) -> &Map {
        &self.map
    }

    /// What was corrected in the map or left out of it.
    pub fn warnings(&self) -> &[MapWarning] {
        &self.map.warnings
    }

    /// Everything that stands on the ground now: obstacles by index, then targets by index.
    pub fn scene(&self) -> Scene {
        self.scene_with(self.targets())
    }

    fn scene_with(&self, targets: &[TargetTruth]) -> Scene {
        let bodies = targets.iter().map(|t| t.prism(self.config.targets.body_m));
        Scene { prisms: self.prisms.iter().cloned().chain(bodies).collect() }
    }

    /// The scene that the camera of each agent that lies now shows in place of [`Self::scene`].
    pub fn false_scenes(&self) -> BTreeMap<AgentId, Scene> {
        let lies = self.lies.iter().filter(|lie| lie.has_begun(self.now_s()));
        lies.map(|lie| (lie.agent(), self.scene_with(&lie.shown(self.targets())))).collect()
    }

    /// A monitor of this world that has checked nothing yet.
    pub fn monitor(&self) -> Monitor {
        let WorldConfig { targets, period_s, .. } = &self.config;
        Monitor::new(self.map.ground, targets.clone(), *period_s, &self.map.obstacles)
    }
}
