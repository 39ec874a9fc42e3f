//! What the tests of the exchange share.

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::detector::DetectorModel;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::{FleetModel, Ground};
use csat_proto::time::Step;

use crate::config::{AgentConfig, BeliefConfig, ExchangeConfig, GuidanceConfig};
use crate::factor::{Factor, FactorId};

/// An agent of four aircraft and a station; two steps are a second.
pub fn config(id: u16) -> AgentConfig {
    AgentConfig {
        run: RunId(7),
        seed: 1,
        id: AgentId(id),
        incarnation: Incarnation(0),
        period_s: 0.5,
        ground: Ground { size_m: [100.0, 50.0] },
        fleet: FleetModel { count: 4, ..FleetModel::default() },
        stations: 1,
        camera: CameraModel::default(),
        detector: DetectorModel::default(),
        pose_sigma: [0.0; 6],
        walk_m: 0.0,
        belief: BeliefConfig::default(),
        exchange: ExchangeConfig::default(),
        guidance: GuidanceConfig::default(),
        channel: ChannelId(0),
    }
}

/// The pose of all messages and factors.
pub const POSE: Pose =
    Pose { p_world: [1.0, 2.0, 80.0], yaw_rad: 0.3, pitch_rad: 0.1, roll_rad: 0.2 };

/// The factor of an aircraft that states one in each step.
pub fn factor(source: u16, incarnation: u32, number: u32) -> Factor {
    let (source, incarnation) = (AgentId(source), Incarnation(incarnation));
    let id = FactorId { source, incarnation, number };
    Factor { id, step: Step(number), pose: (&POSE).into(), sighting: None }
}
