//! What a mission is: every number that decides how it goes, in one TOML file.
//!
//! A scenario is layered: the defaults (the paper's city), then a shipped scenario or a file, then
//! `--set` in order, then `--seed`. [`load`] reports every mistake at once, each with its place.

pub mod camera_check;
pub mod differences;
mod explain;
mod idle_walls;
pub mod keys;
mod map_file;
mod mission;
pub mod mistake;
mod read;
pub mod set;
pub mod shipped;
mod shorthand;
pub mod source;
mod trace_file;
mod tracks_file;
pub mod tree;
pub mod validate;
mod world;

use std::path::Path;

use csat_agent::config::{ChannelNames, Channels, EstimatorConfig, ExchangeConfig, GuidanceConfig};
use csat_mission::engine;
use csat_mission::mission::Kind;
use csat_netem::config::NetemConfig;
use csat_netem::link::Links;
use csat_proto::camera::CameraModel;
use csat_proto::model::{FleetModel, Ground, Station, TargetsModel};
use csat_world::map::{LeftOut, MapConfig, MapWarning, by_cause};
use csat_world::world::{World, WorldConfig, WorldErrors};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::missions::{self, Flyable};
pub use map_file::MapText;
pub use mistake::{Mistake, Mistakes, did_you_mean, similar};
use source::{Place, Source, Sources};
pub use tracks_file::TracksText;
use tree::Node;
use validate::Issue;

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
    /// `[estimator]`.
    pub estimator: EstimatorConfig,
    /// `[guidance]`.
    pub guidance: GuidanceConfig,
    /// `[exchange]`.
    pub exchange: ExchangeConfig,
    /// `[netem]`: what the links do.
    pub netem: NetemConfig,
    /// The tables that only the mission of the scenario knows, but for those above.
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
            netem: NetemConfig::default(),
            own: toml::Table::new(),
        }
    }
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

    /// What the world is made of, but for the tracks, which are in a file of their own.
    pub fn world_config(&self) -> WorldConfig {
        WorldConfig {
            map: self.map.clone(),
            targets: self.targets.clone(),
            tracks: None,
            fleet: self.agents.clone(),
            stations: self.stations.clone(),
            camera: self.camera,
            period_s: self.run.period_s,
        }
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

    /// The inverse of [`Self::to_toml`]. It judges nothing but types and names.
    ///
    /// # Errors
    /// When the text is no scenario.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        let mut table: toml::Table = toml::from_str(text)?;
        let mission = table.get("mission").and_then(toml::Value::as_str).unwrap_or_default();
        let known = missions::find(mission).map(Flyable::tables).unwrap_or_default();
        let own = known.keys().filter_map(|key| table.remove_entry(key)).collect();
        Ok(Self { own, ..table.try_into()? })
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

/// The tables that only the set-membership mission knows.
const OF_SET_MEMBERSHIP: [&str; 3] = ["estimator", "guidance", "exchange"];

/// What to load.
#[derive(Debug, Clone, Copy, Default)]
pub struct Request<'a> {
    /// A shipped name or a path; `None` is the first shipped one.
    pub scenario: Option<&'a str>,
    /// `--set` arguments, later ones winning.
    pub sets: &'a [String],
    /// `--seed`.
    pub seed: Option<u64>,
}

/// A scenario that may run.
#[derive(Debug)]
pub struct Loaded {
    /// The scenario's own name, else the shipped one or that of the file without its ending.
    pub name: String,
    /// The scenario.
    pub scenario: Scenario,
    /// The file of an imported town.
    pub map: Option<MapText>,
    /// The file of the cars' tracks.
    pub tracks: Option<TracksText>,
    /// The world at step 0.
    pub world: World,
    /// What is allowed but probably not meant.
    pub warnings: Vec<Mistake>,
    sources: Sources,
    tree: tree::Table,
}

/// What a run folder calls a map of the user's own.
pub const MAP_FILE: &str = "map.geojson";
/// What a run folder calls the tracks of the cars.
pub const TRACKS_FILE: &str = "tracks.csv";

impl Loaded {
    /// The kind of mission that it describes.
    pub fn kind(&self) -> &'static Kind {
        missions::kind(&self.scenario.mission).expect("it was loaded")
    }

    /// The map, if it is not a shipped one.
    pub fn own_map(&self) -> Option<&MapText> {
        self.map.as_ref().filter(|map| !map.is_shipped)
    }

    /// The scenario as a run folder keeps it, with the map and the tracks beside it: whoever flies the
    /// run again flies over the same town and cars, however the files were edited since and wherever
    /// the folder went.
    pub fn kept(&self) -> Scenario {
        let mut scenario = self.scenario.clone();
        if self.own_map().is_some() {
            scenario.map.file = Some(MAP_FILE.into());
        }
        if self.tracks.is_some() {
            scenario.targets.tracks = Some(TRACKS_FILE.into());
        }
        scenario
    }

    /// Where a dotted key, or else the nearest table around it, was written. For mistakes that show
    /// only later, such as a map without room for the cars.
    pub fn place(&self, key: &str) -> Option<Place> {
        tree::deepest(&self.tree, key).map(|node| self.sources.place(&node.value))
    }
}

/// Loads a scenario.
///
/// # Errors
/// Everything that is wrong with it.
pub fn load(request: Request<'_>) -> Result<Loaded, Mistakes> {
    let name = request.scenario.unwrap_or(shipped::SCENARIOS[0].name);
    let mut mistakes = Vec::new();
    let mut sources = Sources::default();
    let mut tree = match open(name) {
        Ok(source) => {
            let json = json_as_scenario(&source);
            let index = sources.push(source);
            let mut parsed = match json {
                Some(mistake) => {
                    mistakes.push(mistake);
                    tree::Table::new()
                }
                None => tree::parse(&sources, index, &mut mistakes),
            };
            shorthand::expand(&mut parsed);
            // What a parser recovers after a syntax error would only raise false alarms.
            if mistakes.is_empty() { parsed } else { tree::Table::new() }
        }
        Err(mistake) => {
            mistakes.push(mistake);
            tree::Table::new()
        }
    };
    for argument in request.sets {
        let mut over = set::parse(&mut sources, argument, &mut mistakes);
        shorthand::expand(&mut over);
        tree::merge(&mut tree, over);
    }
    if let Some(seed) = request.seed {
        let source = Source {
            name: "--seed".to_owned(),
            text: format!("seed={seed}"),
            is_file: false,
            folder: None,
        };
        let index = sources.push(source);
        tree::merge(&mut tree, tree::parse(&sources, index, &mut mistakes));
    }
    let mission = mission::choose(&sources, &mut tree, &mut mistakes);
    let mut scenario = read::read(&sources, &tree, mission, &mut mistakes);
    let map = map_file::resolve(&mut scenario, &sources, &tree, &mut mistakes);
    trace_file::resolve(&mut scenario, &mut sources, &tree, &mut mistakes);
    let tracks = tracks_file::resolve(&mut scenario, &mut sources, &tree, &mut mistakes);
    let mut warnings = Vec::new();
    let mut judged = Vec::new();
    for issue in validate::validate(&scenario) {
        let mistake = blame(&issue, &sources, &tree);
        if issue.is_warning {
            warnings.push(mistake);
        } else {
            mistakes.push(mistake);
            judged.extend(issue.keys);
        }
    }
    let files = world::Files { map: map.as_ref(), tracks: tracks.as_ref() };
    let world = world::make(&scenario, files, &sources, &tree, &judged, &mut mistakes);
    let map_warnings = world.as_ref().map_or_else(|map| map.as_slice(), World::warnings);
    // A shipped map is larger than the region on purpose.
    let is_shipped = map.as_ref().is_some_and(|map| map.is_shipped);
    let is_cut = |w: &MapWarning| matches!(w, MapWarning::LeftOut { reason: LeftOut::Outside, .. });
    // Where heights are refused they are not lowered.
    let is_refused =
        |w: &MapWarning| matches!(w, MapWarning::MaxHeightLowered { .. }) && !mistakes.is_empty();
    let is_told = |w: &&MapWarning| !(is_refused(w) || is_shipped && is_cut(w));
    let told: Vec<MapWarning> = map_warnings.iter().filter(is_told).cloned().collect();
    warnings.extend(by_cause(&told).into_iter().map(Mistake::new));
    if let Ok(world) = &world {
        warnings.extend(idle_walls::warnings(&scenario, world, &sources, &tree));
    }
    match world {
        Ok(world) if mistakes.is_empty() => {
            if scenario.name.is_empty() {
                scenario.name = stem(name);
            }
            let name = scenario.name.clone();
            Ok(Loaded { name, scenario, map, tracks, world, warnings, sources, tree })
        }
        _ => Err(Mistakes { mistakes, warnings }),
    }
}

/// Puts an issue where it was made: at the first of its keys on the command line, else the first in a
/// file. If that is not the key that the issue is told of, it is named as well: whoever sets one value
/// is not to be told only of another one that no longer fits.
fn blame(issue: &Issue, sources: &Sources, tree: &tree::Table) -> Mistake {
    let written = || {
        let nodes = issue.keys.iter().map(|key| (key, tree::exact(tree, key)));
        nodes.filter_map(|(key, node)| Some((key, node?)))
    };
    let is_argument = |(_, node): &(_, &Node)| !sources.get(node.value.source).is_file;
    let mut mistake = issue.mistake.clone();
    let Some((key, node)) = written().find(is_argument).or_else(|| written().next()) else {
        return mistake;
    };
    let told = &issue.keys[0];
    if !told.starts_with(key.as_str()) {
        mistake.message = format!("with this `{key}`, {}", mistake.message);
    }
    mistake.at(Some(sources.place(&node.value)))
}

/// Finds the text of a scenario.
fn open(name: &str) -> Result<Source, Mistake> {
    let path = Path::new(name);
    // A name without an ending means a shipped scenario even where a folder is called the same.
    if let Some(shipped) = shipped::scenario(name) {
        return Ok(Source {
            name: format!("{}.toml", shipped.name),
            text: shipped.text.to_owned(),
            is_file: true,
            folder: None,
        });
    }
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(Source {
            name: name.to_owned(),
            text,
            is_file: true,
            folder: Some(path.parent().unwrap_or(Path::new("")).to_owned()),
        }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let mistake = Mistake::new(format!("there is no scenario `{name}`")).expected(format!(
                "a TOML file or one of {}",
                quoted_list(shipped::scenario_names())
            ));
            Err(match did_you_mean(name, shipped::scenario_names()) {
                Some(guess) => mistake.help(guess),
                None => mistake,
            })
        }
        Err(error) => {
            let text = format!("cannot read the scenario `{name}`: {error}");
            Err(Mistake::new(text).expected("a TOML file"))
        }
    }
}

/// A town given as the scenario, which is easily done.
fn json_as_scenario(source: &Source) -> Option<Mistake> {
    let text = source.text.trim_start_matches('\u{feff}').trim_start();
    text.starts_with(['{', '\u{1e}']).then(|| {
        Mistake::new(format!("`{}` is JSON", source.name))
            .expected("a scenario, which is a TOML file")
            .help(format!("to fly over a GeoJSON town: `--set map.file={}`", source.name))
    })
}

fn stem(name: &str) -> String {
    Path::new(name).file_stem().map_or_else(|| name.to_owned(), |s| s.to_string_lossy().into())
}

fn quoted_list(names: impl Iterator<Item = &'static str>) -> String {
    names.map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod reference_tests;
#[cfg(test)]
mod station_tests;
#[cfg(test)]
mod tests;
