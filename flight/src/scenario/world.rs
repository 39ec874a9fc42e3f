//! The world of a scenario, and its mistakes as ours: a town, its roads, and room for the cars.

use csat_world::map::geojson::without_mark;
use csat_world::map::{MapError, MapWarning};
use csat_world::track::TrackError;
use csat_world::world::stations::StationError;
use csat_world::world::{World, WorldError};

use super::map_file::MapText;
use super::mistake::Mistake;
use super::model::Scenario;
use super::source::{Place, Sources};
use super::tracks_file::TracksText;
use super::tree;

/// The files that a scenario names.
#[derive(Debug, Clone, Copy)]
pub struct Files<'a> {
    /// The map.
    pub map: Option<&'a MapText>,
    /// The tracks of the cars.
    pub tracks: Option<&'a TracksText>,
}

/// Makes the world at step 0, or adds what prevents it to `mistakes` and gives the warnings of its map.
/// Keys in `judged` have been judged already.
pub fn make(
    scenario: &Scenario,
    files: Files<'_>,
    sources: &Sources,
    tree: &tree::Table,
    judged: &[String],
    mistakes: &mut Vec<Mistake>,
) -> Result<World, Vec<MapWarning>> {
    let Files { map, tracks } = files;
    // A file that was not found is reported already, and without it there is nothing to judge.
    let lacks_map = scenario.map.file.is_some() && map.is_none();
    if lacks_map || scenario.targets.tracks.is_some() && tracks.is_none() {
        return Err(Vec::new());
    }
    let mut config = scenario.world_config();
    config.tracks = tracks.map(|tracks| tracks.tracks.clone());
    let result = match map {
        Some(map) => World::from_geojson(&config, &map.text, scenario.seed),
        None => World::new(&config, scenario.seed),
    };
    let errors = match result {
        Ok(world) => return Ok(world),
        Err(errors) => errors,
    };
    let is_track = |error: &WorldError| matches!(error, WorldError::Track(_));
    let (track_errors, errors_of_keys): (Vec<_>, Vec<_>) =
        errors.errors.into_iter().partition(is_track);
    if let Some(tracks) = tracks {
        let rows: Vec<TrackError> = track_errors.into_iter().filter_map(row).collect();
        mistakes.extend(tracks.mistakes(&rows, sources));
    }
    for error in errors_of_keys {
        let (key, mut mistake) = explain(error, map);
        if !judged.contains(&key) {
            let place = tree::deepest(tree, &key).map(|node| sources.place(&node.value));
            mistake = match (&mistake.place, place) {
                (None, place) => mistake.at(place),
                (Some(_), Some(Place { source, line, column, is_file, .. })) => {
                    let at = if is_file { format!(":{line}:{column}") } else { String::new() };
                    mistake.help(format!("`{key}` is set in {source}{at}"))
                }
                (Some(_), None) => mistake,
            };
            mistakes.push(mistake);
        }
    }
    Err(errors.map_warnings)
}

fn row(error: WorldError) -> Option<TrackError> {
    match error {
        WorldError::Track(error) => Some(error),
        _ => None,
    }
}

/// The key to blame and what to say.
fn explain(error: WorldError, text: Option<&MapText>) -> (String, Mistake) {
    let name = text.map_or("the map", |map| map.name.as_str());
    let (key, mistake) = match error {
        WorldError::Station(error) => return explain_station(&error),
        WorldError::Config { key, got, expected }
        | WorldError::Map(MapError::Config { key, got, expected }) => {
            (key, Mistake::new(format!("`{key}` cannot be {got}")).expected(expected))
        }
        WorldError::Map(error @ MapError::BuiltShare { .. }) => {
            ("map.built_share", Mistake::new(error.to_string()))
        }
        WorldError::Map(MapError::NotJson { reason, line, column }) => {
            let place = text.map(|map| place_in(map, line, column));
            let mistake = Mistake::new(format!("the map {name} is not JSON: {reason}")).at(place);
            ("map.file", mistake)
        }
        WorldError::Map(error) => ("map.file", Mistake::new(format!("{name}: {error}"))),
        WorldError::OffRoad(error) => ("targets.count", Mistake::new(error.to_string())),
        WorldError::Placement(error) => ("targets.count", Mistake::new(error.to_string())),
        WorldError::StartLine(error) => ("map.start_line", Mistake::new(error.to_string())),
        WorldError::Track(error) => ("targets.tracks", Mistake::new(error.to_string())),
    };
    (key.to_owned(), mistake)
}

/// Said of the station, with what was expected apart.
fn explain_station(error: &StationError) -> (String, Mistake) {
    let key = error.index().map_or("stations".to_owned(), |index| format!("stations[{index}]"));
    let text = error.to_string();
    let mistake = match text.split_once(": expected ") {
        Some((what, expected)) => Mistake::new(what).expected(expected),
        None => Mistake::new(text),
    };
    (key, mistake)
}

/// Line and column, from 1 and in bytes, as a parser counts them that was not shown the byte order mark.
fn place_in(map: &MapText, line: usize, column: usize) -> Place {
    let text = without_mark(&map.text);
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let at = before + column.saturating_sub(1);
    Place::in_file(&map.name, text, at..at + 1)
}
