//! What the Bayesian search has besides.

use csat_bayes::config::{
    BeliefConfig, BeliefKind, Criterion, ExchangeConfig, ExchangeMode, GuidanceConfig,
};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::detector::DetectorModel;
use csat_proto::model::{Driving, VehicleKind};
use csat_world::map::MapKind;
use csat_world::navigation::{NavigationModel, Noise};

use super::camera::least_corner_dip_deg;
use super::exchange::idle_radios;
use super::{Check, Issue, Scenario};
use crate::scenario::bayes::Tables;

/// The most cells of a grid: what an aircraft's belief takes is eight bytes for each.
const MAX_CELLS: f64 = 67_108_864.0;
/// The least probability of a false alarm.
const MIN_FALSE: f64 = 1e-9;
/// The most particles.
const MAX_PARTICLES: u32 = 1_000_000;
/// How far outside the region a waypoint may be, metres.
const MAX_OUTSIDE_M: f64 = 1000.0;
/// How far below the horizon the highest ray of a camera has to point, degrees.
const MIN_DIP_DEG: f64 = 5.0;

/// Judges a scenario of the mission.
pub fn judge(scenario: &Scenario, tables: &Tables) -> Vec<Issue> {
    let Tables { belief, detector, exchange, guidance, pose } = tables;
    let mut check = Check(Vec::new());
    world(&mut check, scenario);
    navigation(&mut check, pose);
    self::detector(&mut check, detector);
    camera(&mut check, scenario);
    self::belief(&mut check, belief, scenario.map.size_m);
    self::exchange(&mut check, exchange, belief, scenario);
    self::guidance(&mut check, guidance, scenario);
    check.0
}

/// One target on open ground, and aircraft.
fn world(check: &mut Check, scenario: &Scenario) {
    check.that(
        scenario.map.kind == MapKind::Open,
        &["map.kind"],
        "a town",
        "`open`: the likelihoods know no buildings that hide a target",
    );
    let targets = &scenario.targets;
    check.that(
        targets.count == 1,
        &["targets.count"],
        &targets.count.to_string(),
        "1: the belief is of one target",
    );
    check.that(
        matches!(targets.driving, Driving::Static | Driving::RandomWalk)
            && targets.tracks.is_none(),
        &["targets.driving", "targets.tracks"],
        "a car that drives",
        "`static` or `random-walk`, which the filter knows",
    );
    check.that(
        scenario.agents.vehicle == VehicleKind::FixedWing,
        &["agents.vehicle"],
        "`quadcopter`",
        "`fixed-wing`, whose flight guidance predicts",
    );
}

fn navigation(check: &mut Check, pose: &NavigationModel) {
    let holds = pose.sigma.iter().all(|sigma| *sigma > 0.0 && sigma.is_finite());
    let expected = "six deviations above 0: along track, across track and height in metres; yaw, pitch and roll in \
                    radians";
    check.that(holds, &["pose.sigma"], &format!("{:?}", pose.sigma), expected);
    check.positive("pose.time_constant_s", pose.time_constant_s);
    let default = NavigationModel::default().time_constant_s;
    check.that(
        pose.noise == Noise::GaussMarkov || pose.time_constant_s == default,
        &["pose.time_constant_s", "pose.noise"],
        &pose.time_constant_s.to_string(),
        "pose.noise = \"gauss-markov\", as white noise has no time constant",
    );
}

fn detector(check: &mut Check, detector: &DetectorModel) {
    let DetectorModel { p_detection, p_false, detected_resolution, missed_resolution } = *detector;
    let is_share = p_detection > 0.0 && p_detection < 1.0;
    let expected = "a probability between 0 and 1, both excluded";
    check.that(is_share, &["detector.p_detection"], &p_detection.to_string(), expected);
    let expected = format!(
        "a probability from {MIN_FALSE} to below 1: a filter that excludes false alarms never recovers from one"
    );
    let is_rare = (MIN_FALSE..1.0).contains(&p_false);
    check.that(is_rare, &["detector.p_false"], &p_false.to_string(), &expected);
    let resolutions = [
        ("detector.detected_resolution", detected_resolution),
        ("detector.missed_resolution", missed_resolution),
    ];
    let mut is_valid = is_share && is_rare;
    for (key, [mean, variance]) in resolutions {
        let holds = mean > 0.0 && mean.is_finite() && variance > 0.0 && variance.is_finite();
        let expected = "mean and variance, both above 0, of px/m²";
        check.that(holds, &[key], &format!("[{mean}, {variance}]"), expected);
        is_valid &= holds;
    }
    if is_valid {
        // The greatest probability of detection is at a mean, or between or beyond the two; look closely.
        let most = (0..4000).map(|i| detector.p_detected(f64::from(i) * 0.25)).fold(0.0, f64::max);
        check.that(
            most + p_false <= 1.0,
            &["detector.p_false", "detector.p_detection"],
            &format!("{p_false} with a greatest p(D | V, r) of {most:.6}"),
            "probabilities whose sum is at most 1",
        );
    }
}

/// All of the image must be on the ground, in the steepest turn, too.
fn camera(check: &mut Check, scenario: &Scenario) {
    let (camera, wing) = (&scenario.camera, &scenario.agents.fixed_wing);
    let of_labels = CameraModel {
        columns: camera.columns,
        rows: camera.rows,
        aperture_deg: camera.aperture_deg,
        tilt_deg: camera.tilt_deg,
        // Judged for every mission without labels.
        misidentify: camera.misidentify,
        ..CameraModel::default()
    };
    check.that(
        *camera == of_labels,
        &["camera"],
        "one with other labels, depths or boxes than the default",
        "columns, rows, aperture_deg and tilt_deg only: a detector has neither labels nor depths",
    );
    let roll = wing.roll_max_deg;
    let pitch = wing.pitch_trim_deg.to_radians() / roll.to_radians().cos();
    let dip_deg = |roll_deg: f64| {
        let pose = Pose {
            p_world: [0.0, 0.0, 100.0],
            yaw_rad: 0.0,
            pitch_rad: -pitch,
            roll_rad: roll_deg.to_radians(),
        };
        least_corner_dip_deg(&camera.at(&pose))
    };
    let least = dip_deg(roll).min(dip_deg(-roll));
    check.that(
        least >= MIN_DIP_DEG,
        &["camera.tilt_deg", "camera.aperture_deg", "agents.fixed_wing.roll_max_deg"],
        &format!(
            "{} (a bank of {roll}° lifts a corner of the image to {:.1}° {} the horizon)",
            camera.tilt_deg,
            least.abs(),
            if least < 0.0 { "above" } else { "below" }
        ),
        &format!("an image that stays {MIN_DIP_DEG}° below the horizon, such as a camera that looks down, 90"),
    );
}

fn belief(check: &mut Check, belief: &BeliefConfig, size_m: [f64; 2]) {
    let cells =
        |side_m: f64| size_m.iter().map(|size| (size / side_m).ceil().max(1.0)).product::<f64>();
    let side = belief.cell_m;
    let count = cells(side);
    let holds = side > 0.0 && side.is_finite() && count <= MAX_CELLS;
    let takes = match side > 0.0 {
        true => format!("{side} ({count:.3e} cells, {:.2} GB for each agent)", 8.0 * count / 1e9),
        false => side.to_string(),
    };
    let expected = format!(
        "a length above 0 that makes at most {MAX_CELLS} cells, {:.2} GB for each agent",
        8.0 * MAX_CELLS / 1e9
    );
    check.that(holds, &["belief.cell_m", "map.size_m"], &takes, &expected);
    let least = belief.min_cell_m;
    check.that(
        least > 0.0 && least <= side && side / least <= 4096.0,
        &["belief.min_cell_m", "belief.cell_m"],
        &least.to_string(),
        &format!("above 0 and at most belief.cell_m = {side} m, and no less than a 4096th of it"),
    );
    check.that(
        (1..=MAX_PARTICLES).contains(&belief.particles),
        &["belief.particles"],
        &belief.particles.to_string(),
        &format!("a whole number from 1 to {MAX_PARTICLES}"),
    );
    check.not_negative("belief.process_noise_m", belief.process_noise_m);
    check.not_negative("belief.lag_s", belief.lag_s);
}

fn exchange(
    check: &mut Check,
    exchange: &ExchangeConfig,
    belief: &BeliefConfig,
    scenario: &Scenario,
) {
    check.positive("exchange.snapshot_period_s", exchange.snapshot_period_s);
    check.positive("exchange.repair_period_s", exchange.repair_period_s);
    check.not_negative("exchange.repair_delay_s", exchange.repair_delay_s);
    check.positive("exchange.max_age_s", exchange.max_age_s);
    let budget = exchange.budget_bytes_s;
    let expected = "a number above 0, in bytes per second, or inf";
    check.that(budget > 0.0, &["exchange.budget_bytes_s"], &budget.to_string(), expected);
    check.that(
        exchange.mode != ExchangeMode::Snapshot || belief.kind != BeliefKind::Particles,
        &["exchange.mode", "belief.kind"],
        "`snapshot` with belief.kind = \"particles\"",
        "`facts` or `facts+repair`, or belief.kind = \"grid\" or \"adaptive\": particles cannot be fused",
    );
    let (name, netem) = (&exchange.channel, &scenario.netem);
    let is_known = netem.channel_id(name).is_some();
    check.that(
        is_known,
        &["exchange.channel"],
        &format!("`{name}`"),
        "the name of a radio of [netem]",
    );
    idle_radios(check, netem, &[name], ["exchange.channel", "exchange.channel"]);
}

fn guidance(check: &mut Check, guidance: &GuidanceConfig, scenario: &Scenario) {
    check.positive("guidance.lane_m", guidance.lane_m);
    check.positive("guidance.attraction_m", guidance.attraction_m);
    check.not_negative("guidance.attraction", guidance.attraction);
    check.positive("guidance.discount_s", guidance.discount_s);
    check.not_negative("guidance.edge_worth", guidance.edge_worth);
    let (period, horizon) = (guidance.period_s, guidance.horizon_s);
    check.positive("guidance.period_s", period);
    check.that(
        horizon >= period && horizon <= 300.0,
        &["guidance.horizon_s", "guidance.period_s"],
        &horizon.to_string(),
        &format!("from guidance.period_s = {period} s to 300 s"),
    );
    let beam = guidance.beam;
    let expected = "a whole number from 1 to 1024";
    check.that((1..=1024).contains(&beam), &["guidance.beam"], &beam.to_string(), expected);
    let (lists, count) = (guidance.waypoints.len(), usize::from(scenario.agents.count));
    let is_flown = guidance.criterion == Criterion::Waypoints;
    check.that(
        if is_flown { lists == 1 || lists == count } else { lists == 0 },
        &["guidance.waypoints", "guidance.criterion", "agents.count"],
        &format!("{lists} lists of points"),
        &format!("one list, or one for each of {count} aircraft, with guidance.criterion = \"waypoints\"; else none"),
    );
    check.that(
        guidance.waypoints.iter().all(|list| list.len() >= 2),
        &["guidance.waypoints"],
        "a list of less than two points",
        "two points or more in each list",
    );
    let most = scenario.map.size_m.map(|size| size / 2.0 + MAX_OUTSIDE_M);
    for p in guidance.waypoints.iter().flatten() {
        let holds = (0..2).all(|axis| p[axis].abs() <= most[axis]);
        let expected = format!("points at most {MAX_OUTSIDE_M} m outside the region");
        check.that(holds, &["guidance.waypoints"], &format!("{p:?}"), &expected);
    }
}
