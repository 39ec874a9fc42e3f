//! The world of a scenario, and its mistakes as ours: a town, its roads, and room for the cars.

use csat_world::map::geojson::without_mark;
use csat_world::map::{MapError, MapWarning};
use csat_world::world::{World, WorldError};

use super::map_file::MapText;
use super::mistake::Mistake;
use super::source::{Place, Sources};
use super::{Scenario, tree};

/// Makes the world at step 0, or adds what prevents it to `mistakes` and gives the warnings of its map.
/// Keys in `judged` have been judged already.
pub fn make(
    scenario: &Scenario,
    text: Option<&MapText>,
    sources: &Sources,
    tree: &tree::Table,
    judged: &[String],
    mistakes: &mut Vec<Mistake>,
) -> Result<World, Vec<MapWarning>> {
    // A map that was not found is reported already, and without it there is no room to judge.
    if scenario.map.file.is_some() && text.is_none() {
        return Err(Vec::new());
    }
    let config = scenario.world_config();
    let result = match text {
        Some(map) => World::from_geojson(&config, &map.text, scenario.seed),
        None => World::new(&config, scenario.seed),
    };
    let errors = match result {
        Ok(world) => return Ok(world),
        Err(errors) => errors,
    };
    for error in errors.errors {
        let (key, mut mistake) = explain(error, text);
        if !judged.iter().any(|k| k == key) {
            let place = tree::deepest(tree, key).map(|node| sources.place(&node.value));
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

/// The key to blame and what to say.
fn explain(error: WorldError, text: Option<&MapText>) -> (&'static str, Mistake) {
    let name = text.map_or("the map", |map| map.name.as_str());
    match error {
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
        WorldError::Placement(error) => ("targets.count", Mistake::new(error.to_string())),
    }
}

/// Line and column, from 1 and in bytes, as a parser counts them that was not shown the byte order mark.
fn place_in(map: &MapText, line: usize, column: usize) -> Place {
    let text = without_mark(&map.text);
    let before: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let at = before + column.saturating_sub(1);
    Place::in_file(&map.name, text, at..at + 1)
}
