//! The Bayesian search as an entry of the list.

use csat_bayes::config::{AgentConfig, BeliefConfig, ExchangeConfig, GuidanceConfig};
use csat_proto::detector::DetectorModel;
use csat_proto::ids::{AgentId, Incarnation, RunId};
use csat_proto::model::Driving;
use csat_world::navigation::NavigationModel;
use csat_world::world::WorldConfig;
use serde::{Deserialize, Serialize};

use super::missions::Offered;
use super::model::Scenario;
use super::validate::{self, Issue};
use crate::bayes::Bayes;

/// The tables that only this mission knows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
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

impl Offered for Bayes {
    type Tables = Tables;

    /// Its detector reports points.
    const LABELS: bool = false;

    fn of(scenario: &Scenario) -> Self {
        Self::with_config(agent_config(scenario))
    }

    fn judge_scenario(scenario: &Scenario) -> Vec<Issue> {
        validate::bayes::judge(scenario, &scenario.own())
    }

    fn equip(scenario: &Scenario, world: &mut WorldConfig) {
        world.navigation = Some(scenario.own::<Tables>().pose);
    }
}

/// What the first agent is told.
fn agent_config(scenario: &Scenario) -> AgentConfig {
    let Tables { belief, detector, exchange, guidance, pose } = scenario.own();
    let walk_m = match scenario.targets.driving {
        Driving::RandomWalk => scenario.targets.walk_m_sqrt_s * scenario.run.period_s.sqrt(),
        _ => 0.0,
    };
    AgentConfig {
        run: RunId(scenario.seed),
        seed: scenario.seed,
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: scenario.run.period_s,
        ground: scenario.ground(),
        fleet: scenario.agents.clone(),
        stations: scenario.agent_count() - scenario.agents.count,
        camera: scenario.camera,
        detector,
        pose_sigma: pose.sigma,
        walk_m,
        belief,
        // An unknown name is a mistake, and the first radio here.
        channel: scenario.netem.channel_id(&exchange.channel).unwrap_or_default(),
        exchange,
        guidance,
    }
}
