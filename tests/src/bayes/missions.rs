//! Scenarios of the Bayesian search for tests.

use csat_bayes::config::{BeliefConfig, ExchangeConfig, GuidanceConfig};
use csat_flight::scenario::{self, Request, Scenario, missions};
use csat_proto::detector::DetectorModel;
use csat_world::navigation::NavigationModel;
use serde::Serialize;

/// The mission's own tables.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Tables {
    /// `[belief]`.
    pub belief: BeliefConfig,
    /// `[detector]`.
    pub detector: DetectorModel,
    /// `[exchange]`.
    pub exchange: ExchangeConfig,
    /// `[guidance]`.
    pub guidance: GuidanceConfig,
    /// `[pose]`.
    pub pose: NavigationModel,
}

/// The shipped scenario `tisdale`.
///
/// # Panics
/// When it does not load.
pub fn tisdale() -> Scenario {
    let request = Request { scenario: Some("tisdale"), ..Request::default() };
    scenario::load(request).expect("it is shipped").scenario
}

/// The scenario with these tables.
///
/// # Panics
/// When something is wrong with it.
pub fn with_tables(mut scenario: Scenario, tables: &Tables) -> Scenario {
    scenario.own = toml::Table::try_from(tables).expect("tables are TOML");
    let mission = missions::find(&scenario.mission).expect("it is shipped");
    let issues = scenario::validate::validate(&scenario, mission.judge_scenario(&scenario));
    let wrong: Vec<_> = issues.iter().filter(|issue| !issue.is_warning).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    scenario
}
