//! The world of a scenario, and its mistakes as ours: a town, its roads, and room for the cars.

use csat_world::map::{MapError, MapWarning};
use csat_world::world::{World, WorldError};

use super::map_file::MapText;
use super::mistake::Mistake;
use super::source::Sources;
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
        let (key, mistake) = explain(error, text);
        if !judged.iter().any(|k| k == key) {
            let place = tree::deepest(tree, key).map(|node| sources.place(&node.value));
            mistakes.push(mistake.at(place));
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
        WorldError::Map(error) => ("map.file", Mistake::new(format!("{name}: {error}"))),
        WorldError::Placement(error) => ("targets.count", Mistake::new(error.to_string())),
    }
}
