//! The configuration of an agent. Agents of one mission differ in `id` and `incarnation` only.

use csat_proto::camera::CameraModel;
use csat_proto::detector::DetectorModel;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::{FleetModel, Ground};
use serde::{Deserialize, Serialize};

/// What an agent is told before the start.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentConfig {
    /// The run.
    pub run: RunId,
    /// The seed of the mission.
    pub seed: u64,
    /// Its number.
    pub id: AgentId,
    /// Its life.
    pub incarnation: Incarnation,
    /// T, seconds between frames.
    pub period_s: f64,
    /// The region in which the target is.
    pub ground: Ground,
    /// The fleet and how it flies.
    pub fleet: FleetModel,
    /// Ground stations, which are numbered after the aircraft.
    pub stations: u16,
    /// The camera.
    pub camera: CameraModel,
    /// The detector.
    pub detector: DetectorModel,
    /// The deviations of reported poses, as in `[pose]`: along track, across track and height, metres; yaw,
    /// pitch and roll, radians.
    pub pose_sigma: [f64; 6],
    /// Standard deviation of the target's displacement per period and axis, metres; 0 for one that stands.
    pub walk_m: f64,
    /// `[belief]`.
    pub belief: BeliefConfig,
    /// `[exchange]`.
    pub exchange: ExchangeConfig,
    /// `[guidance]`.
    pub guidance: GuidanceConfig,
    /// The radio of all messages.
    pub channel: ChannelId,
}

impl AgentConfig {
    /// Whether the agent is a ground station.
    pub fn is_station(&self) -> bool {
        self.id.0 >= self.fleet.count
    }

    /// How many agents there are.
    pub fn agents(&self) -> u16 {
        self.fleet.count.saturating_add(self.stations)
    }

    /// How many periods there are in a time, rounded up.
    pub fn steps(&self, seconds: f64) -> u32 {
        (seconds / self.period_s - 1e-9).ceil().clamp(0.0, f64::from(u32::MAX)) as u32
    }
}

/// How an agent represents its belief.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BeliefKind {
    /// A value for each cell of a regular grid.
    Grid,
    /// A sampling importance resampling (SIR) particle filter.
    Particles,
    /// Cells that split where probability gathers.
    #[default]
    Adaptive,
}

/// `[belief]`: the representation of p(x | z).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BeliefConfig {
    /// Which one.
    pub kind: BeliefKind,
    /// Side of a cell of the grid, and of the largest cells of `adaptive`, metres.
    pub cell_m: f64,
    /// Least side of the cells of `adaptive`, metres.
    pub min_cell_m: f64,
    /// Number of particles.
    pub particles: u32,
    /// Standard deviation per axis of what is added to each particle in each step, metres; (9).
    pub process_noise_m: f64,
    /// For a target that moves: factors that are later than this are left out, seconds.
    pub lag_s: f64,
}

impl Default for BeliefConfig {
    fn default() -> Self {
        Self {
            kind: BeliefKind::default(),
            cell_m: 12.5,
            min_cell_m: 0.5,
            particles: 6400,
            process_noise_m: 1.0,
            lag_s: 10.0,
        }
    }
}

/// What agents tell each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ExchangeMode {
    /// Nothing.
    #[serde(rename = "none")]
    None,
    /// Each factor once.
    #[serde(rename = "facts")]
    Facts,
    /// Each factor, and those that others are missing again.
    #[default]
    #[serde(rename = "facts+repair")]
    FactsRepair,
    /// Beliefs.
    #[serde(rename = "snapshot")]
    Snapshot,
}

/// How beliefs of others are fused with the own one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fusion {
    /// The weighted geometric mean (Chernoff fusion), which counts nothing twice.
    #[default]
    Chernoff,
    /// The product, which counts twice what both know from the same frames. To show what that does.
    Product,
}

/// `[exchange]` of the Bayesian search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExchangeConfig {
    /// What is sent.
    pub mode: ExchangeMode,
    /// How beliefs are fused, in mode `snapshot`.
    pub fusion: Fusion,
    /// Seconds between an agent's beliefs, in mode `snapshot`.
    pub snapshot_period_s: f64,
    /// Least seconds between two messages with factors that others are missing, in mode `facts+repair`.
    pub repair_period_s: f64,
    /// How long a factor may be under way before its receiver is taken to be missing it, seconds.
    pub repair_delay_s: f64,
    /// What an agent may send, bytes per second; `inf` for no limit. What tells most is sent first.
    pub budget_bytes_s: f64,
    /// Messages older than this are dropped, seconds. What they hold may be older.
    pub max_age_s: f64,
    /// The radio that carries the messages, by its name in `[netem]`.
    pub channel: String,
}

impl Default for ExchangeConfig {
    fn default() -> Self {
        Self {
            mode: ExchangeMode::default(),
            fusion: Fusion::default(),
            snapshot_period_s: 2.0,
            repair_period_s: 1.0,
            repair_delay_s: 1.0,
            budget_bytes_s: f64::INFINITY,
            max_age_s: 60.0,
            channel: "radio".to_owned(),
        }
    }
}

/// Where aircraft fly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Parallel lanes over a strip of the region for each aircraft.
    Lawnmower,
    /// From one given point to the next, again and again.
    Waypoints,
    /// Where the probability of detection, and then the expected decrease of uncertainty, is greatest.
    #[default]
    Information,
}

/// `[guidance]` of the Bayesian search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GuidanceConfig {
    /// Where aircraft fly.
    pub criterion: Criterion,
    /// From one lane of `lawnmower` to the next, metres.
    pub lane_m: f64,
    /// The points of `waypoints`, `world`, metres: a list for each aircraft, or one for all.
    pub waypoints: Vec<Vec<[f64; 2]>>,
    /// Seconds between two decisions of `information`.
    pub period_s: f64,
    /// How far `information` looks ahead, seconds.
    pub horizon_s: f64,
    /// How many plans `information` keeps at each stage of its search.
    pub beam: u16,
    /// The distance over which probability that is out of reach of the horizon attracts, metres.
    pub attraction_m: f64,
    /// The weight of that attraction; 1 counts probability at no distance like that which is detected.
    pub attraction: f64,
    /// What `information` detects t seconds from now is worth e^(−t/`discount_s`), seconds.
    pub discount_s: f64,
    /// By what share `information` values ground beside seen ground, or beside the border, higher.
    pub edge_worth: f64,
}

impl Default for GuidanceConfig {
    fn default() -> Self {
        Self {
            criterion: Criterion::default(),
            lane_m: 60.0,
            waypoints: Vec::new(),
            period_s: 1.0,
            horizon_s: 20.0,
            beam: 12,
            attraction_m: 150.0,
            attraction: 1.0,
            discount_s: 40.0,
            edge_worth: 2.0,
        }
    }
}
