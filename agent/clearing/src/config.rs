//! The configuration of an agent. Agents of one mission differ in `id` and `incarnation` only.

use csat_proto::camera::CameraModel;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::FleetModel;
use serde::{Deserialize, Serialize};

use crate::radii::Radii;

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
    /// The fleet and how it flies.
    pub fleet: FleetModel,
    /// Ground stations, which are numbered after the UAVs.
    pub stations: u16,
    /// The camera: it looks straight down, row 0 is north, column 0 is west.
    pub camera: CameraModel,
    /// The side of the cells of which the road area consists, metres.
    pub cell_m: f64,
    /// Each pixel on a road has one that is labelled so within this distance, pixels (Chebyshev).
    pub gap_px: u16,
    /// The most by which a displacement errs along each axis, metres, hovering included.
    pub motion_error_m: f64,
    /// How wrong the odometry is.
    pub odometry: OdometryBounds,
    /// The channel of short range, which measures offsets.
    pub hbsr: ChannelId,
    /// The most by which an offset on `hbsr` errs along each axis, metres.
    pub offset_error_m: f64,
    /// The channel of long range.
    pub lblr: ChannelId,
    /// The most by which a bearing on `lblr` errs, degrees.
    pub bearing_error_deg: f64,
    /// The ends of the start line S, east and north of where UAV 0 starts, metres.
    pub start_line_m: [[f64; 2]; 2],
    /// `[clearing]`.
    pub clearing: ClearingConfig,
}

/// How wrong the displacement between two frames is, at most, that follows from the poses of an agent.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryBounds {
    /// Along each axis, however near the frames are, metres: half of it at each end.
    pub jitter_m: f64,
    /// What comes to it, as a share of the path between the frames.
    pub drift_share: f64,
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

    /// How many periods there are in a time, rounded up, at least one.
    pub fn steps(&self, seconds: f64) -> u32 {
        (seconds / self.period_s - 1e-9).ceil().clamp(1.0, f64::from(u32::MAX)) as u32
    }

    /// The side of a pixel on the ground, metres.
    pub fn pixel_m(&self) -> f64 {
        self.fleet.altitude_m / self.camera.focal_px()
    }

    /// The distances that follow from the bounds of all errors.
    pub fn radii(&self) -> Radii {
        Radii::new(self)
    }
}

/// By which rules frontiers are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rules {
    /// A frontier point is kept until the road beyond it is known to be cleared.
    #[default]
    Acknowledged,
    /// The rules of the paper: (9) within a stripe, encounters by overlap, splits at once. To show where they leak.
    Paper,
}

/// Which sub-frontiers a cleaner gives away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Give {
    /// Those that hinder the candidate, in the order north, east, south, west.
    Paper,
    /// The fewest pixels that let it move on, and it moves on as long as it can.
    #[default]
    Balanced,
}

/// How masks are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coding {
    /// One bit per pixel.
    Bitmap,
    /// The lengths of runs of equal pixels.
    #[default]
    Runs,
}

/// `[clearing]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClearingConfig {
    /// By which rules frontiers are kept.
    pub rules: Rules,
    /// Which sub-frontiers are given away.
    pub give: Give,
    /// How masks are written.
    pub coding: Coding,
    /// ΔM: cleared ground grows up to this distance from the edge of the image, pixels.
    pub margin_px: u16,
    /// A frontier stays at least this far from the edge of the image, pixels.
    pub guard_px: u16,
    /// |Δ|: the displacement of a cleaner per period along each axis, metres. Along a diagonal it is √2 of it.
    pub step_m: f64,
    /// From the front tail to the next one, metres.
    pub spacing_m: f64,
    /// After this time without follower and helper a cleaner that cannot move says so, seconds.
    pub patience_s: f64,
    /// A cleaner is given up when it was silent for this long, seconds.
    pub lost_after_s: f64,
    /// Seconds between two states on `hbsr`.
    pub beat_period_s: f64,
    /// Seconds between two safe masks on `hbsr`.
    pub safe_period_s: f64,
    /// Seconds between two states on `lblr`.
    pub call_period_s: f64,
    /// A message that is older than this is dropped, seconds.
    pub max_age_s: f64,
    /// The name of the channel of short range in `[netem]`.
    pub hbsr: String,
    /// The name of the channel of long range in `[netem]`.
    pub lblr: String,
    /// Whether that one may reach less far than across the region, which the paper assumes that it does.
    pub allow_short_lblr: bool,
}

impl Default for ClearingConfig {
    fn default() -> Self {
        Self {
            rules: Rules::default(),
            give: Give::default(),
            coding: Coding::default(),
            margin_px: 22,
            guard_px: 14,
            step_m: 0.125,
            spacing_m: 8.0,
            patience_s: 20.0,
            lost_after_s: 40.0,
            beat_period_s: 0.25,
            safe_period_s: 1.0,
            call_period_s: 1.0,
            max_age_s: 60.0,
            hbsr: "hbsr".to_owned(),
            lblr: "lblr".to_owned(),
            allow_short_lblr: false,
        }
    }
}

/// A value that makes no sense.
#[derive(Debug, Clone, PartialEq)]
pub struct Mistake {
    /// The key in the scenario.
    pub key: String,
    /// What it says.
    pub got: String,
    /// What would be accepted.
    pub expected: String,
}

/// What is wrong with the values of a configuration; empty if nothing is.
pub fn mistakes(config: &AgentConfig) -> Vec<Mistake> {
    let mut found = Vec::new();
    let ClearingConfig { margin_px, guard_px, step_m, spacing_m, .. } = config.clearing;
    let mut demand = |is_right: bool, key: &str, got: String, expected: String| {
        if !is_right {
            found.push(Mistake { key: key.to_owned(), got, expected });
        }
    };
    let [rows, columns] = [config.camera.rows, config.camera.columns];
    demand(rows == columns, "camera.rows", rows.to_string(), format!("{columns} (a square image)"));
    let (pixel_m, cell_m) = (config.pixel_m(), config.cell_m);
    let at_most = format!("at most {cell_m} m, the side of a cell");
    demand(pixel_m <= cell_m, "camera.columns", format!("pixels of {pixel_m} m"), at_most);
    let radii = config.radii();
    // Beyond M there has to be room for the errors of a motion, and a quarter of the image is left for M.
    let slack = radii.motion.saturating_add(2);
    let most = columns / 4;
    let (least_guard, most_guard) = (radii.least_guard(), most.saturating_sub(slack));
    let is_guard = (least_guard..=most_guard).contains(&guard_px);
    let expected = match least_guard <= most_guard {
        true => format!("{least_guard} to {most_guard}"),
        false => format!(
            "{least_guard} or more for these errors of segmentation, odometry and motion, which is too much for {columns} columns"
        ),
    };
    demand(is_guard, "clearing.guard_px", guard_px.to_string(), expected);
    let least = guard_px.saturating_add(slack);
    let is_margin = (least..=most).contains(&margin_px) || !is_guard && margin_px <= most;
    let expected = if is_guard { format!("{least} to {most}") } else { format!("at most {most}") };
    demand(is_margin, "clearing.margin_px", margin_px.to_string(), expected);
    let unsafe_px = 2 * (u32::from(radii.blind()) + u32::from(radii.rho));
    let key = format!("netem.{}.offset_error_m", config.clearing.hbsr);
    let expected = "less: at this error no mask is safe at any pixel".to_owned();
    demand(unsafe_px < columns.into(), &key, config.offset_error_m.to_string(), expected);
    let expected = format!("more than 0, at most {pixel_m} m, a pixel");
    demand(step_m > 0.0 && step_m <= pixel_m, "clearing.step_m", step_m.to_string(), expected);
    let expected =
        format!("less than {step_m} m, clearing.step_m: else a cleaner cannot keep its place");
    let motion_m = config.motion_error_m;
    let can_hold = (0.0..step_m).contains(&motion_m) || step_m <= 0.0;
    demand(can_hold, "agents.multirotor.motion_error_m", motion_m.to_string(), expected);
    demand(
        (0.0..=1000.0).contains(&spacing_m),
        "clearing.spacing_m",
        spacing_m.to_string(),
        "0 to 1000 m".to_owned(),
    );
    for (key, seconds) in times(&config.clearing) {
        let key = format!("clearing.{key}");
        let is_time = seconds > 0.0 && seconds.is_finite();
        demand(is_time, &key, seconds.to_string(), "more than 0 s, and finite".to_owned());
    }
    let heard_s = 3.0 * config.clearing.call_period_s;
    let lost_s = config.clearing.lost_after_s;
    let expected = format!("at least {heard_s} s, three times call_period_s");
    demand(lost_s >= heard_s, "clearing.lost_after_s", lost_s.to_string(), expected);
    found
}

fn times(clearing: &ClearingConfig) -> [(&'static str, f64); 6] {
    [
        ("patience_s", clearing.patience_s),
        ("lost_after_s", clearing.lost_after_s),
        ("beat_period_s", clearing.beat_period_s),
        ("safe_period_s", clearing.safe_period_s),
        ("call_period_s", clearing.call_period_s),
        ("max_age_s", clearing.max_age_s),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::validate::tests::config;

    /// The keys that are wrong after a change, with what is expected.
    fn wrong(change: impl Fn(&mut AgentConfig)) -> Vec<(String, String)> {
        let mut config = config();
        change(&mut config);
        mistakes(&config).into_iter().map(|wrong| (wrong.key, wrong.expected)).collect()
    }

    fn check(change: impl Fn(&mut AgentConfig), key: &str, expected: &str) {
        let found = wrong(change);
        let is_told = found.iter().any(|(k, e)| k == key && e.contains(expected));
        assert!(is_told && found.len() == 1, "{key} ({expected}): {found:?}");
    }

    #[test]
    fn every_mistake_is_told_with_what_is_expected() {
        assert_eq!(wrong(|_| {}), []);
        check(|c| c.camera.rows = 128, "camera.rows", "256 (a square image)");
        check(|c| c.fleet.altitude_m = 90.0, "camera.columns", "the side of a cell");
        check(|c| c.clearing.guard_px = 3, "clearing.guard_px", " to ");
        check(|c| c.clearing.guard_px = u16::MAX, "clearing.guard_px", " to ");
        check(|c| c.gap_px = 60, "clearing.guard_px", "too much for 256 columns");
        check(|c| c.clearing.margin_px = 14, "clearing.margin_px", " to 64");
        check(|c| c.clearing.margin_px = 65, "clearing.margin_px", " to 64");
        let offset = "netem.hbsr.offset_error_m";
        check(|c| c.offset_error_m = 1e300, offset, "no mask is safe");
        check(|c| c.clearing.step_m = 0.5, "clearing.step_m", "a pixel");
        check(|c| c.clearing.step_m = 0.0, "clearing.step_m", "more than 0");
        let motion = "agents.multirotor.motion_error_m";
        check(|c| c.motion_error_m = c.clearing.step_m, motion, "keep its place");
        check(|c| c.clearing.spacing_m = -1.0, "clearing.spacing_m", "0 to 1000 m");
        check(|c| c.clearing.max_age_s = f64::INFINITY, "clearing.max_age_s", "finite");
        check(|c| c.clearing.lost_after_s = 1.0, "clearing.lost_after_s", "three times");
    }
}
