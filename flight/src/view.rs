//! `view.json`: all that `map.svg` is drawn from, in metres of `world`.

use csat_mission::picture::{Layer, Ring, to_millimetre};
use csat_mission::style::Style;
use csat_proto::model::Station;
use csat_world::obstacle::Obstacle;
use serde::{Deserialize, Serialize};

use crate::rounding::{PER_METRE, polygons};
use crate::scenario::Loaded;
use csat_mission::words;

/// The world and what the agents know of it at the end of a mission.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct View {
    /// Name of the scenario.
    pub scenario: String,
    /// Its seed.
    pub seed: u64,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Width (east) and depth (north) of the region.
    pub size_m: [f64; 2],
    /// Buildings.
    pub obstacles: Vec<Building>,
    /// Centre lines of roads.
    pub roads: Vec<Vec<[f64; 2]>>,
    /// The UAVs, by index.
    pub uavs: Vec<UavTrack>,
    /// The ground stations; the first is the agent after the last UAV.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stations: Vec<Station>,
    /// The true locations of each target, by index and step.
    pub targets: Vec<Vec<[f64; 2]>>,
    /// How the layers of the mission are drawn, from the bottom up.
    pub layers: Vec<Style>,
    /// What each agent knows, by index: the UAVs, then the stations.
    pub agents: Vec<Vec<Layer>>,
    /// The line that every program that shows the map has to show with it.
    pub attribution: Option<String>,
}

impl View {
    /// An agent by name, for people: `UAV 0`, `station 4`.
    pub fn name_of(&self, agent: usize) -> String {
        words::named([agent as u16], self.uavs.len() as u16)
    }

    /// What an agent knows; nothing when there is no such agent.
    pub fn of_agent(&self, agent: usize) -> &[Layer] {
        self.agents.get(agent).map_or(&[], Vec::as_slice)
    }
}

/// A building.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Building {
    /// Outer ring, then holes.
    pub rings: Vec<Ring>,
    /// Height.
    pub height_m: f64,
}

impl Building {
    /// An obstacle to the nearest millimetre: one building, unless nothing is left of it or rounding
    /// takes apart what hung together by less.
    pub fn of(obstacle: &Obstacle) -> impl Iterator<Item = Self> {
        let height_m = to_millimetre(obstacle.height_m);
        let shapes = polygons(&[obstacle.rings().collect()], PER_METRE);
        shapes.into_iter().map(move |rings| Self { rings, height_m })
    }
}

/// How a UAV flew.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct UavTrack {
    /// Position by step.
    pub path: Vec<[f64; 2]>,
    /// Last heading, radians counter-clockwise from east.
    pub yaw_rad: f64,
    /// Last footprint.
    pub footprint: Ring,
}

impl View {
    /// The scenario and its town, without UAVs, stations and targets.
    pub fn of_town(loaded: &Loaded) -> Self {
        let map = loaded.world.map();
        let rounded = |ring: &[[f64; 2]]| ring.iter().map(|p| p.map(to_millimetre)).collect();
        Self {
            scenario: loaded.name.clone(),
            seed: loaded.scenario.seed,
            size_m: loaded.scenario.map.size_m,
            obstacles: map.obstacles.iter().flat_map(Building::of).collect(),
            roads: map.roads.iter().map(|road| rounded(road)).collect(),
            attribution: map.attribution.clone(),
            ..Self::default()
        }
    }

    /// With every length of a line to the nearest millimetre: what is drawn is what is written down, and a
    /// large fleet's file stays small.
    pub fn rounded(mut self) -> Self {
        let roads = self.roads.iter_mut();
        let footprints_and_paths =
            self.uavs.iter_mut().flat_map(|u| [&mut u.path, &mut u.footprint]);
        let lines = roads.chain(footprints_and_paths).chain(&mut self.targets);
        for point in lines.flatten() {
            *point = point.map(to_millimetre);
        }
        for uav in &mut self.uavs {
            uav.yaw_rad = (uav.yaw_rad * 1e6).round() / 1e6;
        }
        self
    }
}
