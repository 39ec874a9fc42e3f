//! The values of a scenario, and what follows from them alone.

use csat_agent::config::{
    AgentConfig, ChannelNames, Channels, EstimatorConfig, ExchangeConfig, GuidanceConfig,
};
use csat_mission::engine;
use csat_netem::config::NetemConfig;
use csat_netem::link::Links;
use csat_proto::camera::CameraModel;
use csat_proto::ids::{AgentId, Incarnation, RunId};
use csat_proto::model::{FleetModel, Ground, Station, TargetsModel};
use csat_world::lie::Liar;
use csat_world::map::MapConfig;
use csat_world::world::{World, WorldConfig, WorldErrors};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::missions;
use super::set_membership::Tables;

/// A mission, in full.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// What the mission is called, so that a run flown again keeps its name; by default the file is
    /// asked.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Which mission is flown.
    pub mission: String,
    /// What every random stream of the run is derived from.
    pub seed: u64,
    /// `[[stations]]`: agents on the ground, numbered after the UAVs.
    pub stations: Vec<Station>,
    /// `[run]`.
    pub run: RunConfig,
    /// `[map]`: the town.
    pub map: MapConfig,
    /// `[targets]`: the cars.
    pub targets: TargetsModel,
    /// `[agents]`: the fleet.
    pub agents: FleetModel,
    /// `[camera]`.
    pub camera: CameraModel,
    /// `[estimator]` of the set-membership mission, as the next three; another mission's table of the same name
    /// is in `own`.
    pub estimator: EstimatorConfig,
    /// `[guidance]`.
    pub guidance: GuidanceConfig,
    /// `[exchange]`.
    pub exchange: ExchangeConfig,
    /// `[faults]`: which UAVs lie.
    pub faults: FaultsConfig,
    /// `[netem]`: what the links do.
    pub netem: NetemConfig,
    /// The tables of the scenario's mission, but for those above.
    #[serde(skip)]
    pub own: toml::Table,
}

impl Default for Scenario {
    fn default() -> Self {
        Self {
            name: String::new(),
            mission: SET_MEMBERSHIP.to_owned(),
            seed: 1,
            stations: Vec::new(),
            run: RunConfig::default(),
            map: MapConfig::default(),
            targets: TargetsModel::default(),
            agents: FleetModel::default(),
            camera: CameraModel::default(),
            estimator: EstimatorConfig::default(),
            guidance: GuidanceConfig::default(),
            exchange: ExchangeConfig::default(),
            faults: FaultsConfig::default(),
            netem: NetemConfig::default(),
            own: toml::Table::try_from(Tables::default()).expect("defaults are TOML"),
        }
    }
}

/// `[faults]`: what is wrong with UAVs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultsConfig {
    /// `[[faults.liar]]`: the UAVs that lie.
    pub liar: Vec<Liar>,
}

/// `[run]`: how long.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RunConfig {
    /// Simulated seconds.
    pub duration_s: f64,
    /// T, seconds between frames.
    pub period_s: f64,
}

impl Default for RunConfig {
    fn default() -> Self {
        Self { duration_s: 300.0, period_s: 0.5 }
    }
}

impl RunConfig {
    /// The number of steps; step k is at k·T and the last one not later than the duration.
    pub fn steps(&self) -> u32 {
        (self.duration_s / self.period_s + 1e-9).floor() as u32
    }
}

impl Scenario {
    /// The number of steps.
    pub fn steps(&self) -> u32 {
        self.run.steps()
    }

    /// Whether it is the mission of the thesis's §5.4 under `str3` with κ = 1, which is the default one,
    /// whatever the seed and the length.
    pub fn is_thesis_setting(&self) -> bool {
        let mut thesis = Self { name: self.name.clone(), seed: self.seed, ..Self::default() };
        thesis.run.duration_s = self.run.duration_s;
        thesis.netem.trace = self.netem.trace;
        *self == thesis
    }

    /// How many agents there are: UAVs and stations.
    pub fn agent_count(&self) -> u16 {
        self.agents.count.saturating_add(u16::try_from(self.stations.len()).unwrap_or(u16::MAX))
    }

    /// X_g.
    pub fn ground(&self) -> Ground {
        Ground { size_m: self.map.size_m }
    }

    /// Which radio carries what; an unknown name is a mistake, and the first radio here.
    pub fn channels(&self) -> Channels {
        let id = |name: &str| self.netem.channel_id(name).unwrap_or_default();
        let ChannelNames { facts, snapshots, plans } = &self.exchange.channels;
        Channels { facts: id(facts), snapshots: id(snapshots), plans: id(plans) }
    }

    /// What the first agent of the set-membership mission is told.
    pub fn agent_config(&self) -> AgentConfig {
        AgentConfig {
            run: RunId(self.seed),
            id: AgentId(0),
            incarnation: Incarnation(0),
            period_s: self.run.period_s,
            ground: self.ground(),
            targets: self.targets.clone(),
            fleet: self.agents.clone(),
            stations: self.agent_count() - self.agents.count,
            camera: self.camera,
            pose_error: self.own::<Tables>().pose.half_widths(),
            estimator: self.estimator,
            guidance: self.guidance.clone(),
            exchange: self.exchange.clone(),
            channels: self.channels(),
            radio_range_m: self.radio_range_m(),
        }
    }

    /// The shortest range of the radios of the set-membership mission, metres; ∞ without limit.
    fn radio_range_m(&self) -> f64 {
        let Channels { facts, snapshots, plans } = self.channels();
        let ranges = [facts, snapshots, plans].into_iter().filter_map(|id| self.netem.channel(id));
        ranges.map(|channel| channel.range_m).fold(f64::INFINITY, f64::min)
    }

    /// What the world is made of, with what the mission adds to it; but for the tracks, which are in a file of
    /// their own.
    pub fn world_config(&self) -> WorldConfig {
        let mut config = WorldConfig {
            map: self.map.clone(),
            targets: self.targets.clone(),
            tracks: None,
            fleet: self.agents.clone(),
            stations: self.stations.clone(),
            camera: self.camera,
            navigation: None,
            odometry: None,
            observer: None,
            segmentation: None,
            liars: self.faults.liar.clone(),
            period_s: self.run.period_s,
        };
        if let Some(mission) = missions::find(&self.mission) {
            mission.equip(self, &mut config);
        }
        config
    }

    /// The scenario in full as TOML; loading it gives an equal scenario.
    pub fn to_toml(&self) -> String {
        let mut table = toml::Table::try_from(self).expect("a loaded scenario is TOML");
        if self.mission != SET_MEMBERSHIP {
            OF_SET_MEMBERSHIP.iter().for_each(|key| drop(table.remove(*key)));
        }
        table.extend(self.own.clone());
        toml::to_string_pretty(&table).expect("a table is TOML")
    }

    /// The mission's own tables.
    ///
    /// # Panics
    /// When they cannot be read: those of a loaded scenario can.
    pub fn own<T: DeserializeOwned>(&self) -> T {
        self.own.clone().try_into().expect("the tables of a loaded scenario have been read")
    }

    /// The links to an agent, with the buildings that stand in their way.
    ///
    /// # Errors
    /// When there is no such world.
    pub fn links(&self, map: Option<&str>) -> Result<Links, WorldErrors> {
        let obstruction = if self.netem.has_propagation() {
            let mut config = self.world_config();
            // Buildings only: an agent knows neither the cars nor their tracks.
            config.targets.count = 0;
            let world = match map {
                Some(text) => World::from_geojson(&config, text, self.seed),
                None => World::new(&config, self.seed),
            };
            engine::obstruction(&self.netem, &world?)
        } else {
            None
        };
        Ok(Links::new(&self.netem, self.seed, obstruction))
    }
}

/// The mission of a scenario that names none.
pub const SET_MEMBERSHIP: &str = "set-membership";

/// The tables of the set-membership mission.
pub(super) const OF_SET_MEMBERSHIP: [&str; 4] = ["estimator", "guidance", "exchange", "faults"];
