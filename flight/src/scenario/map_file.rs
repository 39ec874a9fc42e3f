//! Finding the file that `map.file` names.

use std::path::{Path, PathBuf};

use csat_world::map::MapKind;

use super::mistake::{Mistake, did_you_mean, quoted_list};
use super::model::Scenario;
use super::source::{Site, Sources};
use super::{shipped, tree};

/// A map to import.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapText {
    /// What people call it: a path, or the name of a shipped map.
    pub name: String,
    /// GeoJSON.
    pub text: String,
    /// Whether it comes from inside the program.
    pub is_shipped: bool,
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
    if !is_other_kind_on_purpose(&site, sources, tree) {
        scenario.map.kind = MapKind::GeoJson;
    }
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

/// A user who names a file wants the town in it, whatever the kind was before; unless they ask for a
/// generated town, or for none, in the same breath (or later), which is a contradiction for others to
/// report.
fn is_other_kind_on_purpose(file: &Site, sources: &Sources, tree: &tree::Table) -> bool {
    let Some(kind) = tree::exact(tree, "map.kind") else { return false };
    let is_other = matches!(kind.to_value().as_str(), Some("generated" | "open"));
    is_other && is_beside(&kind.value, file, sources)
}

/// Whether a value was written in the same breath as a file's name, or later: in the same source or
/// one above it, or both on the command line.
pub fn is_beside(value: &Site, file: &Site, sources: &Sources) -> bool {
    let is_argument = |site: &Site| !sources.get(site.source).is_file;
    value.source >= file.source || is_argument(value) && is_argument(file)
}

fn find(file: &str, site: &Site, sources: &Sources) -> Result<(PathBuf, MapText), Mistake> {
    if let Some(name) = file.strip_prefix(shipped::PREFIX) {
        return shipped_map(name).ok_or_else(|| no_such(name));
    }
    let Some(folder) = &sources.get(site.source).folder else { return Err(no_such(file)) };
    // `./x` is not what anybody wrote.
    let path = if folder.as_os_str() == "." { PathBuf::from(file) } else { folder.join(file) };
    match std::fs::read_to_string(&path) {
        Ok(text) => {
            let absolute = path.canonicalize().unwrap_or_else(|_| path.clone());
            Ok((absolute, MapText { name: file.to_owned(), text, is_shipped: false }))
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let is_name = Path::new(file).file_name().is_some_and(|name| name == file);
            let found = if is_name { shipped_map(file) } else { None };
            found.ok_or_else(|| no_such(&path.to_string_lossy()))
        }
        Err(error) => {
            let text = format!("cannot read the map `{}`: {error}", path.display());
            Err(Mistake::new(text).expected("a GeoJSON file"))
        }
    }
}

fn shipped_map(name: &str) -> Option<(PathBuf, MapText)> {
    let text = shipped::map(name)?.to_owned();
    let path = PathBuf::from(format!("{}{name}", shipped::PREFIX));
    Some((path, MapText { name: name.to_owned(), text, is_shipped: true }))
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
