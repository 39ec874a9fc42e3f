//! One agent at one step: a row of metrics.

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

/// One agent at one step: a row of `metrics.csv`. What is said of the fleet is the same in all rows
/// of a step. Per cent are of the ground area φ(X_g).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StepRecord {
    /// k.
    pub step: u32,
    /// k·T, seconds.
    pub time_s: f64,
    /// i.
    pub agent: u16,
    /// East, metres.
    pub x_m: f64,
    /// North, metres.
    pub y_m: f64,
    /// Altitude, metres.
    pub z_m: f64,
    /// Heading, radians.
    pub yaw_rad: f64,
    /// card(L_i).
    pub identified: u16,
    /// e^t_i (5.36), metres; `None` while L_i = ∅.
    pub localization_error_m: Option<f64>,
    /// Φ^t_i (5.37), square metres.
    pub target_area_m2: Option<f64>,
    /// Φ^{t,eq}_i (5.38), metres.
    pub target_radius_m: Option<f64>,
    /// φ(X̄_i), per cent.
    pub unexplored_pct: f64,
    /// φ(X̄_i ∩ X^h_i), per cent, with X^h of (5.43)-(5.44).
    pub hidden_pct: f64,
    /// This agent's term of (5.45), per cent; `None` when nothing is hidden nor expected to be.
    pub oem_iou_pct: Option<f64>,
    /// Vertices of all of the agent's sets.
    pub vertices: u32,
    /// Bytes that the agent sent in this step.
    pub bytes_sent: u64,
    /// Failures of the guarantee found in this agent at this step.
    pub violations: u32,
    /// Fleet: card(∪ L_i).
    pub identified_union: u16,
    /// Fleet: targets whose location lies in the footprint of at least one UAV.
    pub targets_in_fov: u16,
    /// Fleet: card(∪ D_i), targets that at least one CVS identified in this step.
    pub targets_detected: u16,
    /// Fleet: Φ^FoV (5.40), per cent.
    pub footprint_pct: f64,
    /// Fleet: Φ^g (5.41), per cent.
    pub ground_seen_pct: f64,
    /// Fleet: Φ^{g,cum} (5.42), per cent.
    pub explored_pct: f64,
    /// What the agent is.
    #[serde(default)]
    pub role: Role,
    /// How old the newest frame of another UAV is that the agent heard of from that UAV, mean over the other
    /// UAVs, seconds; `None` where there are none.
    #[serde(default)]
    pub news_age_s: Option<f64>,
    /// What the stages took; not in the file, which is the same for equal runs.
    #[serde(skip)]
    pub times: StageTimes,
}
