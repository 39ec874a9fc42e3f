//! The set-membership mission as an entry of the list.

use csat_world::observer::ObserverModel;
use csat_world::world::WorldConfig;
use serde::{Deserialize, Serialize};

use super::missions::Offered;
use super::model::Scenario;
use super::validate::{self, Issue};
use crate::set_membership::SetMembership;

/// The tables that only this mission knows, but for those that are fields of every scenario.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tables {
    /// `[pose]`.
    pub pose: ObserverModel,
}

impl SetMembership {
    /// The mission that `scenario` describes.
    pub fn new(scenario: &Scenario) -> Self {
        Self::with_config(scenario.agent_config())
    }
}

impl Offered for SetMembership {
    type Tables = Tables;

    fn of(scenario: &Scenario) -> Self {
        Self::new(scenario)
    }

    fn judge_scenario(scenario: &Scenario) -> Vec<Issue> {
        validate::of_set_membership(scenario)
    }

    fn equip(scenario: &Scenario, world: &mut WorldConfig) {
        world.observer = Some(scenario.own::<Tables>().pose);
    }
}
