//! Road clearing as an entry of the list.

use csat_clearing::config::{AgentConfig, ClearingConfig, OdometryBounds};
use csat_proto::ids::{AgentId, Incarnation, RunId};
use csat_proto::model::{OdometryModel, RoadSensor};
use csat_world::road_area::CELL_M;
use csat_world::world::WorldConfig;
use serde::{Deserialize, Serialize};

use super::missions::Offered;
use super::model::Scenario;
use super::validate::{self, Issue};
use crate::clearing::Clearing;

/// The tables that only this mission knows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tables {
    /// `[clearing]`.
    pub clearing: ClearingConfig,
    /// `[odometry]`.
    pub odometry: OdometryModel,
    /// `[segmentation]`.
    pub segmentation: RoadSensor,
}

impl Offered for Clearing {
    type Tables = Tables;

    /// It needs roads, and no pixels on cars.
    const LABELS: bool = false;

    fn of(scenario: &Scenario) -> Self {
        let tables = scenario.own();
        Self::new(agent_config(scenario, &tables), tables.segmentation)
    }

    fn judge_scenario(scenario: &Scenario) -> Vec<Issue> {
        validate::clearing::judge(scenario, &scenario.own())
    }

    fn equip(scenario: &Scenario, world: &mut WorldConfig) {
        let Tables { odometry, segmentation, .. } = scenario.own();
        world.odometry = Some(odometry);
        world.segmentation = Some(segmentation);
    }
}

/// What the first agent is told.
pub fn agent_config(scenario: &Scenario, tables: &Tables) -> AgentConfig {
    let Tables { clearing, odometry, segmentation } = tables.clone();
    let OdometryModel { jitter_m, drift_share } = odometry;
    let netem = &scenario.netem;
    // An unknown name is a mistake, and the first radio here.
    let channel = |name: &str| netem.channel_id(name).unwrap_or_default();
    let (hbsr, lblr) = (channel(&clearing.hbsr), channel(&clearing.lblr));
    AgentConfig {
        run: RunId(scenario.seed),
        seed: scenario.seed,
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: scenario.run.period_s,
        fleet: scenario.agents.clone(),
        stations: scenario.agent_count() - scenario.agents.count,
        camera: scenario.camera,
        cell_m: CELL_M,
        gap_px: segmentation.gap_px,
        motion_error_m: scenario.agents.multirotor.motion_error_m,
        odometry: OdometryBounds { jitter_m, drift_share },
        hbsr,
        // An offset that is not measured is a mistake, too.
        offset_error_m: netem
            .channel(hbsr)
            .and_then(|channel| channel.offset_error_m)
            .unwrap_or_default(),
        lblr,
        bearing_error_deg: netem.channel(lblr).map_or(0.0, |channel| channel.bearing_error_deg),
        // The world lets UAV 0 start above the middle of the start line.
        start_line_m: [[0.0; 2]; 2],
        clearing,
    }
}
