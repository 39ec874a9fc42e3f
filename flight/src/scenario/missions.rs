//! The missions that this program flies, as far as scenarios and results need to know them.

use std::marker::PhantomData;
use std::sync::OnceLock;

use csat_mission::mission::{Kind, Mission, Whole};
use csat_world::world::WorldConfig;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::issue::Issue;
use super::mistake::quoted_list;
use super::model::Scenario;
use crate::bayes::Bayes;
use crate::clearing::Clearing;
use crate::set_membership::SetMembership;

/// A mission that scenarios can ask for.
pub trait Offered: Mission {
    /// Its own tables of a scenario: a struct with a field for each top-level table, and defaults.
    /// A table of the name of one of the set-membership mission's takes its place.
    type Tables: Default + Serialize + DeserializeOwned;

    /// Whether its agents need images with labelled pixels: then a camera is judged by the pixels that it has
    /// on a car.
    const LABELS: bool = true;

    /// The mission of a scenario. The scenario has been judged.
    fn of(scenario: &Scenario) -> Self;

    /// What is wrong with a scenario of this mission: what no other judge of scenarios knows.
    fn judge_scenario(scenario: &Scenario) -> Vec<Issue>;

    /// Adds to the world what the mission's own tables say of it. The types and names of the tables are
    /// right; their values may not have been judged.
    fn equip(_: &Scenario, _: &mut WorldConfig) {}
}

/// The kind and the tables of a mission, for code that does not know its types.
pub trait Listed: Sync {
    /// What is known of it without flying it.
    fn kind(&self) -> &'static Kind;

    /// Its own tables of a scenario, with their defaults.
    fn tables(&self) -> toml::Table;

    /// Whether its own tables can be read.
    ///
    /// # Errors
    /// The first mistake of type or name.
    fn check_tables(&self, tables: toml::Table) -> Result<(), toml::de::Error>;

    /// What is wrong with a scenario of this mission.
    fn judge_scenario(&self, scenario: &Scenario) -> Vec<Issue>;

    /// [`Offered::LABELS`].
    fn needs_labels(&self) -> bool;

    /// Adds to the world what the mission's own tables say of it.
    fn equip(&self, scenario: &Scenario, config: &mut WorldConfig);
}

/// The entry of a mission in the list.
pub struct Entry<M>(PhantomData<fn() -> M>);

impl<M: Offered> Entry<M> {
    /// The entry of mission `M`.
    pub const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<M: Offered> Default for Entry<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: Offered> Listed for Entry<M> {
    fn kind(&self) -> &'static Kind {
        &Whole::<M>::KIND
    }

    fn tables(&self) -> toml::Table {
        toml::Table::try_from(M::Tables::default()).expect("defaults are TOML")
    }

    fn check_tables(&self, tables: toml::Table) -> Result<(), toml::de::Error> {
        tables.try_into::<M::Tables>().map(drop)
    }

    fn judge_scenario(&self, scenario: &Scenario) -> Vec<Issue> {
        M::judge_scenario(scenario)
    }

    fn needs_labels(&self) -> bool {
        M::LABELS
    }

    fn equip(&self, scenario: &Scenario, config: &mut WorldConfig) {
        M::equip(scenario, config);
    }
}

static INSTALLED: OnceLock<Vec<&'static dyn Listed>> = OnceLock::new();

/// Makes `missions` the list of this program. The first call counts.
pub fn install(missions: Vec<&'static dyn Listed>) {
    let _ = INSTALLED.set(missions);
}

/// The list of this program; without one that was installed, the missions that ship with csat.
pub fn all() -> &'static [&'static dyn Listed] {
    const SHIPPED: [&dyn Listed; 3] =
        [&Entry::<SetMembership>::new(), &Entry::<Bayes>::new(), &Entry::<Clearing>::new()];
    INSTALLED.get_or_init(|| SHIPPED.to_vec())
}

/// A mission by its name.
pub fn find(name: &str) -> Option<&'static dyn Listed> {
    all().iter().copied().find(|mission| mission.kind().name == name)
}

/// The names of all missions, for people.
pub fn names() -> String {
    quoted_list(all().iter().map(|mission| mission.kind().name))
}

/// The kind of a mission by its name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    find(name).map(Listed::kind)
}
