//! The world of a scenario, and its mistakes as ours: a town, its roads, and room for the cars.

use csat_world::map::MapError;
use csat_world::world::{World, WorldConfig, WorldError};

use super::map_file::MapText;
use super::mistake::Mistake;
use super::source::Sources;
use super::{Scenario, shipped, tree};

/// Makes the world at step 0, or adds what prevents it to `mistakes`. Keys in `judged` have been
/// judged already.
pub fn make(
    scenario: &Scenario,
    text: Option<&MapText>,
    sources: &Sources,
    tree: &tree::Table,
    judged: &[String],
    mistakes: &mut Vec<Mistake>,
) -> Option<World> {
    // A map that was not found is reported already, and without it there is no room to judge.
    if scenario.map.file.is_some() && text.is_none() {
        return None;
    }
    let mut config = WorldConfig {
        map: scenario.map.clone(),
        targets: scenario.targets,
        fleet: scenario.agents,
        camera: scenario.camera,
        period_s: scenario.run.period_s,
    };
    let (result, _unpacked) = match unpack(&mut config, text) {
        Ok(unpacked) => (World::new(&config, scenario.seed), unpacked),
        Err(mistake) => {
            mistakes.push(mistake);
            return None;
        }
    };
    let errors = match result {
        Ok(world) => return Some(world),
        Err(errors) => errors.0,
    };
    for error in errors {
        let (key, mistake) = explain(error, text);
        if !judged.iter().any(|k| k == key) {
            let place = tree::deepest(tree, key).map(|node| sources.place(&node.value));
            mistakes.push(mistake.at(place));
        }
    }
    None
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

/// A file that is removed when it is not needed any more.
#[derive(Debug)]
struct Unpacked(std::path::PathBuf);

impl Drop for Unpacked {
    fn drop(&mut self) {
        // Nobody minds when it stays: it is in the folder for temporary files.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A world reads its map from a file: a shipped map becomes one for as long as that takes.
fn unpack(config: &mut WorldConfig, text: Option<&MapText>) -> Result<Option<Unpacked>, Mistake> {
    use std::sync::atomic::{AtomicU32, Ordering};
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let (Some(file), Some(text)) = (&config.map.file, text) else { return Ok(None) };
    if !file.to_string_lossy().starts_with(shipped::PREFIX) {
        return Ok(None);
    }
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let name = format!("csat-{}-{number}-{}", std::process::id(), text.name);
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, &text.text).map_err(|error| {
        Mistake::new(format!("cannot write the map to `{}`: {error}", path.display()))
    })?;
    config.map.file = Some(path.clone());
    Ok(Some(Unpacked(path)))
}
