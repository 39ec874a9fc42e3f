//! The configuration of an agent.

use csat_proto::camera::{CameraModel, PoseError};
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::{FleetModel, Ground, TargetsModel};
use csat_proto::raster::Grid;
use serde::{Deserialize, Serialize};

/// The configuration of one agent.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentConfig {
    /// The run; messages of other runs are dropped.
    pub run: RunId,
    /// i.
    pub id: AgentId,
    /// The agent's incarnation.
    pub incarnation: Incarnation,
    /// T, seconds between frames.
    pub period_s: f64,
    /// X_g.
    pub ground: Ground,
    /// What is known of the targets; `count` is not read.
    pub targets: TargetsModel,
    /// The fleet.
    pub fleet: FleetModel,
    /// How many ground stations there are: the agents after the UAVs.
    pub stations: u16,
    /// The camera.
    pub camera: CameraModel,
    /// How well poses will be known, for guidance; frames say how well theirs are.
    pub pose_error: PoseError,
    /// `[estimator]`.
    pub estimator: EstimatorConfig,
    /// `[guidance]`.
    pub guidance: GuidanceConfig,
    /// `[exchange]`.
    pub exchange: ExchangeConfig,
    /// Which radio carries which messages.
    pub channels: Channels,
    /// The shortest range of these radios, metres; ∞ without limit. Only `str5` reads it.
    pub radio_range_m: f64,
}

/// The names, in the scenario, of the radios that carry each kind of message.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChannelNames {
    /// Facts.
    pub facts: String,
    /// Snapshots.
    pub snapshots: String,
    /// Flight plans, the own one and those that are passed on.
    pub plans: String,
}

impl Default for ChannelNames {
    fn default() -> Self {
        let radio = || "radio".to_owned();
        Self { facts: radio(), snapshots: radio(), plans: radio() }
    }
}

/// Which radio carries each kind of message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Channels {
    /// Facts.
    pub facts: ChannelId,
    /// Snapshots.
    pub snapshots: ChannelId,
    /// Flight plans.
    pub plans: ChannelId,
}

impl AgentConfig {
    /// How many agents there are: UAVs and ground stations.
    pub fn agents(&self) -> u16 {
        self.fleet.count.saturating_add(self.stations)
    }

    /// Whether this agent is a ground station, which has no camera and makes no plans.
    pub fn is_station(&self) -> bool {
        (self.fleet.count..self.agents()).contains(&self.id.0)
    }

    /// Whether the planner predicts who is in contact: `str5`, where radios have a range.
    pub fn predicts_contact(&self) -> bool {
        self.guidance.criterion == Criterion::Str5 && self.radio_range_m < f64::INFINITY
    }

    /// Whether agents pass on the plans of others. Who may lie may lie about them.
    pub fn relays_plans(&self) -> bool {
        self.predicts_contact() && self.exchange.liars == 0
    }

    /// The number of steps until `seconds` are over, at most [`u32::MAX`].
    pub fn steps(&self, seconds: f64) -> u32 {
        // The conversion saturates.
        (seconds / self.period_s).ceil() as u32
    }

    /// The grid of the rasters: hidden ground and planning.
    pub fn raster_grid(&self) -> Grid {
        Grid::covering(&self.ground, self.estimator.raster_cell_m)
    }

    /// Whether Obstacle pixels are used: the estimator of `str1` ignores them (thesis §5.2.1).
    pub fn uses_obstacle_pixels(&self) -> bool {
        self.guidance.criterion != Criterion::Str1
    }

    /// The camera for guidance. Guidance lays out rays and windows up to d_max, so d_max is limited
    /// to what is needed to see all of X_g from twice its diagonal away.
    pub fn planning_camera(&self) -> CameraModel {
        planning_camera(self.camera, &self.ground, &self.fleet)
    }

    /// The grid of the occupancy-elevation map.
    pub fn oem_grid(&self) -> Grid {
        Grid::covering(&self.ground, self.estimator.oem_cell_m)
    }
}

/// [`AgentConfig::planning_camera`] of agents that share `camera`.
pub fn planning_camera(camera: CameraModel, ground: &Ground, fleet: &FleetModel) -> CameraModel {
    let [east, north] = ground.size_m;
    let ends = [0, fleet.count.saturating_sub(1)].map(|i| fleet.altitude_of(i));
    let farthest_m = (2.0 * east.hypot(north)).hypot(ends[0].max(ends[1]));
    CameraModel { d_max_m: camera.d_max_m.min(farthest_m), ..camera }
}

/// `[estimator]`: how sets are computed and kept small. No value here can break the guarantee.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EstimatorConfig {
    /// Corners of the regular polygons that stand for discs.
    pub disc_vertices: u16,
    /// How far a simplification may shift the border of a set, metres.
    pub simplify_m: f64,
    /// The same for the obstacle margin, whose border consists of many small arcs, metres.
    pub simplify_margin_m: f64,
    /// How far corners of the clear ground's outline in the image may be cut, pixels.
    pub outline_tolerance_px: f64,
    /// The most vertices of a set that was measured or is about to grow. Sets with more are
    /// simplified, outer approximations outward and inner ones inward.
    pub max_vertices: u32,
    /// Cell of the rasters (hidden ground, planning), metres.
    pub raster_cell_m: f64,
    /// Cell of the occupancy-elevation map, metres.
    pub oem_cell_m: f64,
}

impl Default for EstimatorConfig {
    fn default() -> Self {
        Self {
            disc_vertices: 16,
            simplify_m: 0.15,
            simplify_margin_m: 0.25,
            outline_tolerance_px: 1.0,
            max_vertices: 8000,
            raster_cell_m: 2.0,
            oem_cell_m: 5.0,
        }
    }
}

/// The cost that the planner minimises (docs/concepts/guidance.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// (5.16): the whole footprint is seen; obstacles are ignored, by the estimator too.
    Str1,
    /// (5.21) without H^CVS.
    Str2NoHidden,
    /// (5.21): what is hidden now stays hidden.
    Str2,
    /// (5.27) and (5.32): the OEM predicts what will be hidden.
    Str3,
    /// Not in the thesis: ground counts for as long as it stays unseen, over a longer horizon
    /// ([`Str4Config`]).
    Str4,
    /// Not in the thesis: `str4`, where ground that another UAV sees counts from when this one hears of it.
    Str5,
    /// No planning: each UAV flies a fixed circle.
    Circles,
    /// No planning: each UAV sweeps its band of the region, lane by lane.
    Lawnmower,
}

/// Whose knowledge the planner serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// What this UAV itself knows.
    Own,
    /// What all UAVs know together: ground in the shares of silent UAVs counts less ([`Str4Config::silent`]). Only for
    /// `str4`.
    Fleet,
}

/// When each UAV plans (thesis §5.3.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// By index, each UAV accounting for those before it.
    Sequential,
    /// The same, and a second pass in which each UAV accounts for all others.
    SequentialLoopback,
    /// All at once, with the last known plans of the other UAVs.
    Asynchronous,
}

/// `[guidance]`: the predictive controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GuidanceConfig {
    /// The cost.
    pub criterion: Criterion,
    /// Whose knowledge it is about.
    pub objective: Objective,
    /// κ, weight of recently hidden ground (5.32).
    pub kappa: f64,
    /// λ, weight of the distance tie-break.
    pub lambda: f64,
    /// N_MPC, the number of blocks of `period_s` in the horizon.
    pub n_mpc: u8,
    /// T_MPC, seconds between decisions.
    pub period_s: f64,
    /// U, the yaw increments to choose from, degrees.
    pub increments_deg: Vec<f64>,
    /// When each UAV plans.
    pub schedule: Schedule,
    /// How long a sequential schedule waits for plans that do not arrive, per decision, seconds.
    pub plan_timeout_s: f64,
    /// `[guidance.str4]`; read by `str4` and `str5`.
    pub str4: Str4Config,
}

/// `[guidance.str4]`: the horizon and the width of the search of `str4` and `str5`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Str4Config {
    /// The number of blocks of T_MPC in the horizon, instead of `guidance.n_mpc`.
    pub n_mpc: u8,
    /// How many candidates are kept per block.
    pub beam: u16,
    /// The value of the first look from nearby at unknown ground beside a building: its area for this
    /// many blocks.
    pub first_look: u16,
    /// Under the objective `fleet`, what ground counts in the share of a UAV from which no plan arrives, from 0 to 1.
    pub silent: f64,
}

impl Default for Str4Config {
    fn default() -> Self {
        Self { n_mpc: 20, beam: 200, first_look: 10, silent: 0.25 }
    }
}

impl Criterion {
    /// Whether the planner looks a minute ahead, over `guidance.str4.n_mpc` blocks.
    pub fn is_far_sighted(self) -> bool {
        matches!(self, Self::Str4 | Self::Str5)
    }
}

impl GuidanceConfig {
    /// The number of blocks in the horizon of the criterion; at least 1.
    pub fn blocks(&self) -> usize {
        let blocks = if self.criterion.is_far_sighted() { self.str4.n_mpc } else { self.n_mpc };
        usize::from(blocks.max(1))
    }

    /// U, radians, in the order of preference among increments of equal cost: the gentlest turn
    /// first, then as listed. Without increments the UAV flies straight ahead.
    pub fn gentlest_first_rad(&self) -> Vec<f64> {
        let mut increments: Vec<f64> =
            self.increments_deg.iter().map(|degrees| degrees.to_radians()).collect();
        if increments.is_empty() {
            increments.push(0.0);
        }
        increments.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        increments
    }
}

impl Default for GuidanceConfig {
    fn default() -> Self {
        Self {
            criterion: Criterion::Str3,
            objective: Objective::Own,
            kappa: 1.0,
            lambda: 1e-5,
            n_mpc: 2,
            period_s: 3.0,
            increments_deg: vec![-60.0, -30.0, 0.0, 30.0, 60.0],
            schedule: Schedule::SequentialLoopback,
            plan_timeout_s: 0.4,
            str4: Str4Config::default(),
        }
    }
}

/// Which messages agents send (docs/links.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ExchangeMode {
    /// None: each UAV works alone.
    #[serde(rename = "none")]
    None,
    /// All knowledge at every step, as in the paper.
    #[serde(rename = "snapshot")]
    Snapshot,
    /// Each frame's measurements.
    #[serde(rename = "facts")]
    Facts,
    /// Facts, and snapshots of all knowledge every `snapshot_period_s` and for agents that are
    /// missing facts.
    #[serde(rename = "facts+repair")]
    FactsRepair,
}

/// `[exchange]`: which messages are sent and which are believed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExchangeConfig {
    /// Which messages are sent.
    pub mode: ExchangeMode,
    /// On which radios.
    pub channels: ChannelNames,
    /// Seconds between an agent's regular snapshots in `facts+repair`.
    pub snapshot_period_s: f64,
    /// Least seconds between an agent's snapshots for agents that are missing facts.
    pub repair_period_s: f64,
    /// How long a message may be in flight before its receiver is taken to be missing it, seconds.
    pub repair_delay_s: f64,
    /// What an agent may send, bytes per second; `inf` for no limit. Sets are simplified until they
    /// fit, outer approximations outward and inner ones inward, most of all far from the UAVs.
    pub budget_bytes_s: f64,
    /// Messages older than this are dropped, seconds.
    pub max_age_s: f64,
    /// Bound on the difference of two agents' clocks, seconds.
    pub clock_skew_s: f64,
    /// Facts, and the knowledge of snapshots, with more vertices than this are dropped; agents send
    /// no such messages.
    pub max_vertices: u32,
    /// q: how many agents may lie, or be mistaken, about what they see. With 0 all are believed.
    pub liars: u16,
}

impl Default for ExchangeConfig {
    fn default() -> Self {
        Self {
            mode: ExchangeMode::FactsRepair,
            channels: ChannelNames::default(),
            snapshot_period_s: 10.0,
            repair_period_s: 5.0,
            repair_delay_s: 2.0,
            budget_bytes_s: f64::INFINITY,
            max_age_s: 60.0,
            clock_skew_s: 0.0,
            max_vertices: 50_000,
            liars: 0,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The first agent of the default fleet over ground of this size.
    pub(crate) fn default_config(size_m: [f64; 2]) -> AgentConfig {
        AgentConfig {
            run: RunId(0),
            id: AgentId(0),
            incarnation: Incarnation(0),
            period_s: 0.5,
            ground: Ground { size_m },
            targets: TargetsModel::default(),
            fleet: FleetModel::default(),
            stations: 0,
            camera: CameraModel::default(),
            pose_error: PoseError::NONE,
            estimator: EstimatorConfig::default(),
            guidance: GuidanceConfig::default(),
            exchange: ExchangeConfig::default(),
            channels: Channels::default(),
            radio_range_m: f64::INFINITY,
        }
    }

    #[test]
    fn times_of_any_length_are_counted_in_steps() {
        let steps = |seconds| default_config([100.0; 2]).steps(seconds);
        assert_eq!([0.0, 0.1, 0.5, 10.0, 10.1].map(steps), [0, 1, 1, 20, 21]);
        assert_eq!([1e12, 1e30, f64::INFINITY].map(steps), [u32::MAX; 3]);
    }
}
