//! What a mission is: every number that decides how it goes, in one TOML file.
//!
//! A scenario is layered: the defaults (the paper's city), then a shipped scenario or a file, then
//! `--set` in order, then `--seed`. [`load`] reports every mistake at once, each with its place.

mod bayes;
pub mod camera_check;
pub mod clearing;
pub mod differences;
mod explain;
mod idle_walls;
mod issue;
pub mod keys;
mod map_file;
mod mission;
pub mod missions;
pub mod mistake;
mod model;
mod read;
pub mod set;
mod set_membership;
pub mod shipped;
mod shorthand;
pub mod source;
mod trace_file;
mod tracks_file;
pub mod tree;
mod unit;
pub mod validate;
mod world;

use std::path::Path;

use csat_mission::mission::Kind;
use csat_world::map::{LeftOut, MapWarning, by_cause};
use csat_world::world::World;

pub use map_file::MapText;
pub use mistake::{Mistake, Mistakes, did_you_mean, quoted_list, similar};
pub use model::{FaultsConfig, RunConfig, SET_MEMBERSHIP, Scenario};
use source::{Place, Source, Sources};
pub use tracks_file::TracksText;
use tree::Node;
use validate::Issue;

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

    /// The scenario as a run folder keeps it, with the map and the tracks beside it: a user who flies the
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
    for issue in validate::validate(&scenario, mission.judge_scenario(&scenario)) {
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
/// file. If that is not the key that the issue is told of, it is named as well: a user who sets one value
/// is not to be told only of another one that no longer fits.
fn blame(issue: &Issue, sources: &Sources, tree: &tree::Table) -> Mistake {
    let is_below = |key: &str, outer: &str| {
        key.strip_prefix(outer).is_some_and(|rest| rest.starts_with(['.', '[']))
    };
    let is_written_below = |outer: &str| {
        let mut keys = issue.keys.iter();
        keys.any(|key| is_below(key, outer) && tree::exact(tree, key).is_some())
    };
    let written = || {
        // A table is not to blame where the key in it was written.
        let keys = issue.keys.iter().filter(|key| !is_written_below(key));
        keys.filter_map(|key| Some((key, tree::exact(tree, key)?)))
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

#[cfg(test)]
mod liars_tests;
#[cfg(test)]
mod pose_tests;
#[cfg(test)]
mod reference_tests;
#[cfg(test)]
mod station_tests;
#[cfg(test)]
mod tests;
