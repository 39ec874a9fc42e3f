//! Which mission a scenario asks for, and which tables it may have: those that only other missions have are
//! mistakes.

use super::missions::{self, Listed};
use super::mistake::{Mistake, did_you_mean};
use super::model::{OF_SET_MEMBERSHIP, SET_MEMBERSHIP};
use super::source::Sources;
use super::tree::{self, Kind, Table};

/// The mission that `tree` names, or the default one. Tables that only other missions have are taken out of
/// the tree, each with a mistake.
pub fn choose(
    sources: &Sources,
    tree: &mut Table,
    mistakes: &mut Vec<Mistake>,
) -> &'static dyn Listed {
    let Some(mission) = named(sources, tree, mistakes) else {
        // Which tables are right is not known then.
        missions::all().iter().flat_map(|m| tables_of(*m)).for_each(|key| drop(tree.remove(&key)));
        return default();
    };
    let name = mission.kind().name;
    let own = tables_of(mission);
    for other in missions::all().iter().filter(|other| other.kind().name != name) {
        // Missions may have tables of the same name.
        for key in tables_of(*other).into_iter().filter(|key| !own.contains(key)) {
            let Some(node) = tree.remove(&key) else { continue };
            let text = format!("`{key}` belongs to the mission `{}`", other.kind().name);
            let expected = format!("tables of the mission `{name}`, which this scenario is");
            let mistake = Mistake::new(text).expected(expected);
            mistakes.push(mistake.at(Some(sources.place(&node.key))));
        }
    }
    mission
}

/// The names of the tables of a mission.
pub(super) fn tables_of(mission: &dyn Listed) -> Vec<String> {
    let mut all: Vec<String> = mission.tables().keys().cloned().collect();
    if mission.kind().name == SET_MEMBERSHIP {
        all.extend(OF_SET_MEMBERSHIP.map(str::to_owned));
    }
    all
}

fn default() -> &'static dyn Listed {
    missions::find(SET_MEMBERSHIP).unwrap_or(missions::all()[0])
}

/// The mission that the tree names, or the default one; `None`, with a mistake, if there is no such mission.
fn named(
    sources: &Sources,
    tree: &mut Table,
    mistakes: &mut Vec<Mistake>,
) -> Option<&'static dyn Listed> {
    let Some(node) = tree::exact(tree, "mission") else { return Some(default()) };
    // A value of another type is told with those of all other keys.
    let Kind::Leaf(toml::Value::String(name)) = &node.kind else { return None };
    if let Some(mission) = missions::find(name) {
        return Some(mission);
    }
    let known = || missions::all().iter().map(|mission| mission.kind().name);
    let mut mistake = Mistake::new(format!("`mission` cannot be `{name}`"))
        .expected(format!("one of {}", missions::names()))
        .at(Some(sources.place(&node.value)));
    if let Some(guess) = did_you_mean(name, known()) {
        mistake = mistake.help(guess);
    }
    mistakes.push(mistake);
    tree.remove("mission");
    None
}
