//! Scenarios of the Bayesian search for tests.

use csat_bayes::config::{BeliefConfig, ExchangeConfig, GuidanceConfig};
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
