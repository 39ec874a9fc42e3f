//! Finding the file that `map.file` names.

use std::path::{Path, PathBuf};

use super::mistake::{Mistake, did_you_mean};
use super::source::{Site, Sources};
use super::{Scenario, quoted_list, shipped, tree};

/// A map to import.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapText {
    /// What people call it: a path, or the name of a shipped map.
    pub name: String,
    /// GeoJSON.
    pub text: String,
}

/// Reads the map of the scenario, and makes `map.file` mean the same from any folder: an absolute
/// path, or `shipped:` and a name.
pub fn resolve(
    scenario: &mut Scenario,
    sources: &Sources,
    tree: &tree::Table,
    mistakes: &mut Vec<Mistake>,
) -> Option<MapText> {
    let file = scenario.map.file.clone()?.to_string_lossy().into_owned();
    let site = tree::exact(tree, "map.file")?.value.clone();
    match find(&file, &site, sources) {
        Ok((path, map)) => {
            scenario.map.file = Some(path);
            Some(map)
        }
        Err(mistake) => {
            mistakes.push(mistake.at(Some(sources.place(&site))));
            None
        }
    }
}

fn find(file: &str, site: &Site, sources: &Sources) -> Result<(PathBuf, MapText), Mistake> {
    if let Some(name) = file.strip_prefix(shipped::PREFIX) {
        return shipped_map(name).ok_or_else(|| no_such(name));
    }
    let Some(folder) = &sources.get(site.source).folder else { return Err(no_such(file)) };
    let path = folder.join(file);
    match std::fs::read_to_string(&path) {
        Ok(text) => {
            let absolute = path.canonicalize().unwrap_or_else(|_| path.clone());
            Ok((absolute, MapText { name: file.to_owned(), text }))
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let is_name = Path::new(file).file_name().is_some_and(|name| name == file);
            let found = if is_name { shipped_map(file) } else { None };
            found.ok_or_else(|| no_such(&path.to_string_lossy()))
        }
        Err(error) => {
            Err(Mistake::new(format!("cannot read the map `{}`: {error}", path.display())))
        }
    }
}

fn shipped_map(name: &str) -> Option<(PathBuf, MapText)> {
    let text = shipped::map(name)?.to_owned();
    let path = PathBuf::from(format!("{}{name}", shipped::PREFIX));
    Some((path, MapText { name: name.to_owned(), text }))
}

fn no_such(name: &str) -> Mistake {
    let mistake = Mistake::new(format!("there is no map `{name}`")).expected(format!(
        "a GeoJSON file (relative to the scenario file, or with --set to the current folder) or \
         one of {}",
        quoted_list(shipped::map_names())
    ));
    match did_you_mean(name, shipped::map_names()) {
        Some(guess) => mistake.help(guess),
        None => mistake,
    }
}
