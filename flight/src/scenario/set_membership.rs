//! The set-membership mission as an entry of the list.

use std::collections::BTreeMap;

use super::missions::Offered;
use super::model::Scenario;
use super::validate::{self, Issue};
use crate::set_membership::SetMembership;

impl SetMembership {
    /// The mission that `scenario` describes.
    pub fn new(scenario: &Scenario) -> Self {
        Self::with_config(scenario.agent_config())
    }
}

impl Offered for SetMembership {
    /// Its tables are fields of every scenario.
    type Tables = BTreeMap<String, ()>;

    fn of(scenario: &Scenario) -> Self {
        Self::new(scenario)
    }

    fn judge_scenario(scenario: &Scenario) -> Vec<Issue> {
        validate::of_set_membership(scenario)
    }
}
