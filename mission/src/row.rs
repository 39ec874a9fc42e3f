//! One agent at one step: a row of `metrics.csv`.

use serde::{Deserialize, Serialize};

use crate::timing::StageTimes;

/// What an agent is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// A UAV.
    #[default]
    Uav,
    /// A ground station.
    Station,
}

/// One agent at one step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    /// k.
    pub step: u32,
    /// k·T, seconds.
    pub time_s: f64,
    /// i.
    pub agent: u16,
    /// What the agent is.
    pub role: Role,
    /// Its true position, `world`, metres.
    pub p_world: [f64; 3],
    /// Its true heading, radians counter-clockwise from east.
    pub yaw_rad: f64,
    /// Bytes that the agent sent in this step.
    pub bytes_sent: u64,
    /// Broken promises found in this agent at this step.
    pub violations: u32,
    /// The mission's values, by its columns.
    pub values: Vec<Option<f64>>,
    /// What the stages took; not in the file, which is the same for equal runs.
    pub times: StageTimes,
}
