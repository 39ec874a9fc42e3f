//! Values that have the right type and still make no mission.
//!
//! The town's own values (`map.*`) are judged by `csat-world` when it makes the town.

mod cost;
mod exchange;

use std::ops::RangeInclusive;

use csat_agent::config::{EstimatorConfig, GuidanceConfig};
use csat_agent::guidance::airspace::turning_room_m;
use csat_proto::camera::CameraModel;
use csat_proto::model::{Driving, FleetModel, StartPose, TargetsModel};
use csat_world::map::MapKind;

use super::camera_check::car_coverage;
pub use super::issue::Issue;
use super::issue::owned;
use super::mistake::Mistake;
use super::model::{RunConfig, Scenario};
use csat_mission::documents::micro;

/// The most sequences of increments that `str1` to `str3` try in a decision.
const MAX_SEQUENCES: usize = 1_000_000;
/// The most cells of a raster.
const MAX_CELLS: f64 = 16_777_216.0;
/// The most pixels of an image.
const MAX_PIXELS: usize = 16_777_216;
/// The longest mission, and the longest that anything in it may take, seconds.
const MAX_TIME_S: f64 = 1e6;

/// The keys of whole numbers with what they may be: said in the same words to a user who writes 0, -1, 1.5
/// and a million.
const WHOLE_NUMBERS: [(&str, RangeInclusive<u64>, &str); 11] = [
    ("agents.count", 1..=1024, "a whole number from 1 to 1024"),
    ("targets.count", 0..=1024, "a whole number from 0 to 1024"),
    ("camera.columns", 1..=65535, "a whole number from 1 to 65535"),
    ("camera.rows", 1..=65535, "a whole number from 1 to 65535"),
    ("camera.min_pixels", 1..=u64::MAX, "a whole number above 0"),
    ("estimator.max_vertices", 50..=1_000_000, "a whole number from 50 to 1000000"),
    ("guidance.n_mpc", 1..=6, "a whole number from 1 to 6"),
    ("guidance.str4.n_mpc", 1..=32, "a whole number from 1 to 32"),
    ("guidance.str4.beam", 1..=1024, "a whole number from 1 to 1024"),
    ("guidance.str4.first_look", 0..=1000, "a whole number from 0 to 1000"),
    ("exchange.max_vertices", 4..=u64::MAX, "a whole number, 4 or more"),
];

/// What is expected of a key whose value is a whole number within limits.
pub fn whole_number(key: &str) -> Option<&'static str> {
    limits(key).map(|(_, expected)| expected)
}

fn limits(key: &str) -> Option<(&'static RangeInclusive<u64>, &'static str)> {
    WHOLE_NUMBERS.iter().find(|(k, ..)| *k == key).map(|(_, range, expected)| (range, *expected))
}

/// All issues of a scenario; `own` are those that only its mission knows.
pub fn validate(scenario: &Scenario, own: Vec<Issue>) -> Vec<Issue> {
    let mut issues = of_any_mission(scenario).0;
    issues.extend(own);
    for (key, what) in scenario.netem.mistakes(scenario.agent_count()) {
        let key = format!("netem.{key}");
        let key = key.trim_end_matches('.');
        let mistake = Mistake::new(format!("`{key}`: {what}"));
        issues.push(Issue { keys: with_ancestors(key), mistake, is_warning: false });
    }
    issues
}

/// What every mission has: the length, the cars, the fleet and its cameras.
fn of_any_mission(scenario: &Scenario) -> Check {
    let mut check = Check(Vec::new());
    let name = &scenario.name;
    let is_plain = !name.contains(['/', '\\', '\0']) && !name.starts_with('.');
    check.that(is_plain, &["name"], &format!("`{name}`"), "a name that a folder can have");
    run(&mut check, &scenario.run);
    targets(&mut check, &scenario.targets);
    let is_fleet = fleet(&mut check, scenario);
    camera(&mut check, scenario, is_fleet);
    check
}

/// What the set-membership mission has besides.
pub fn of_set_membership(scenario: &Scenario) -> Vec<Issue> {
    let before = of_any_mission(scenario);
    let period_s = run(&mut Check(Vec::new()), &scenario.run);
    let mut check = Check(Vec::new());
    estimator(&mut check, &scenario.estimator, scenario.map.size_m);
    guidance(&mut check, &scenario.guidance, period_s);
    let is_clean = before.0.is_empty() && check.0.is_empty();
    if is_clean && scenario.agents.avoid_buildings {
        room_to_turn(&mut check, scenario);
    }
    exchange::judge(&mut check, &scenario.exchange, &scenario.netem, period_s);
    if before.0.iter().chain(&check.0).all(|issue| issue.is_warning) {
        cost::judge(&mut check, scenario, period_s);
    }
    check.0
}

/// A path and all paths around it, inner ones first: what is wrong with a value that the user did not write,
/// such as a default, is said of the table that lacks it.
fn with_ancestors(path: &str) -> Vec<String> {
    let ends = path.rmatch_indices(['.', '[']).map(|(end, _)| &path[..end]);
    std::iter::once(path).chain(ends).map(str::to_owned).collect()
}

struct Check(Vec<Issue>);

impl Check {
    /// Demands that `holds`; `keys` begins with the value's own key.
    fn that(&mut self, holds: bool, keys: &[&'static str], got: &str, expected: &str) {
        if !holds {
            self.0.push(Issue::refused(keys, got, expected));
        }
    }

    fn positive(&mut self, key: &'static str, value: f64) {
        let holds = value > 0.0 && value.is_finite();
        self.that(holds, &[key], &value.to_string(), "a number above 0");
    }

    fn not_negative(&mut self, key: &'static str, value: f64) {
        let holds = value >= 0.0 && value.is_finite();
        self.that(holds, &[key], &value.to_string(), "0 or a number above it");
    }

    /// A time from 0 on.
    fn time(&mut self, key: &'static str, value_s: f64) {
        let holds = (0.0..=MAX_TIME_S).contains(&value_s);
        let expected = format!("a time from 0 to {MAX_TIME_S} s");
        self.that(holds, &[key], &value_s.to_string(), &expected);
    }

    /// Demands a value of [`WHOLE_NUMBERS`], and tells whether it is one.
    fn whole(&mut self, key: &'static str, value: impl Into<u64>) -> bool {
        let value = value.into();
        let (range, expected) = limits(key).expect("a key of the table");
        let holds = range.contains(&value);
        self.that(holds, &[key], &value.to_string(), expected);
        holds
    }

    fn warn(&mut self, keys: &[&'static str], mistake: Mistake) {
        self.0.push(Issue { keys: owned(keys), mistake, is_warning: true });
    }
}

/// Judges `[run]`; gives the period that others are measured by, unless it is wrong itself: one
/// mistake is not to be reported thrice.
fn run(check: &mut Check, run: &RunConfig) -> Option<f64> {
    check.positive("run.period_s", run.period_s);
    let holds = run.duration_s >= run.period_s && run.duration_s <= MAX_TIME_S;
    let expected = format!("at least one period, {} s, and at most {MAX_TIME_S} s", run.period_s);
    check.that(holds, &["run.duration_s"], &run.duration_s.to_string(), &expected);
    let flown_s = run.period_s * f64::from(run.steps());
    if holds && (run.duration_s - flown_s).abs() > 1e-6 {
        let text = format!(
            "`run.duration_s` = {} s is no multiple of run.period_s = {} s",
            run.duration_s, run.period_s
        );
        let help = format!("the mission ends with its last frame, at {} s", micro(flown_s));
        check.warn(&["run.duration_s", "run.period_s"], Mistake::new(text).help(help));
    }
    (run.period_s > 0.0).then_some(run.period_s)
}

fn targets(check: &mut Check, targets: &TargetsModel) {
    check.whole("targets.count", targets.count);
    check.that(
        targets.tracks.is_none() || targets.driving == Driving::Roads,
        &["targets.driving", "targets.tracks"],
        "`evasive` with targets.tracks",
        "no such key: cars follow their tracks",
    );
    let v_max = targets.v_max_m_s;
    let holds = (0.0..=100.0).contains(&v_max);
    check.that(holds, &["targets.v_max_m_s"], &v_max.to_string(), "a speed from 0 to 100 m/s");
    check.not_negative("targets.obstacle_distance_m", targets.obstacle_distance_m);
    check.positive("targets.radius_m", targets.radius_m);
    check.positive("targets.cylinder_height_m", targets.cylinder_height_m);
    let distance = targets.target_distance_m;
    check.that(
        distance > 2.0 * targets.radius_m && distance.is_finite(),
        &["targets.target_distance_m", "targets.radius_m"],
        &distance.to_string(),
        &format!("more than two radii, {} m, so that cars never touch", 2.0 * targets.radius_m),
    );
    let [length, width, height] = targets.body_m;
    let body_ok = targets.body_m.iter().all(|s| *s > 0.0 && s.is_finite());
    let got = format!("[{length}, {width}, {height}]");
    check.that(body_ok, &["targets.body_m"], &got, "length, width and height above 0");
    let half_diagonal = length.hypot(width) / 2.0;
    check.that(
        !body_ok || half_diagonal <= targets.radius_m,
        &["targets.radius_m", "targets.body_m"],
        &targets.radius_m.to_string(),
        &format!("at least half the diagonal of targets.body_m, {half_diagonal:.3} m"),
    );
    check.that(
        !body_ok || height <= targets.cylinder_height_m,
        &["targets.cylinder_height_m", "targets.body_m"],
        &targets.cylinder_height_m.to_string(),
        &format!("at least the height of targets.body_m, {height} m"),
    );
}

/// Judges `[agents]`; tells whether there are as many as there may be.
fn fleet(check: &mut Check, scenario: &Scenario) -> bool {
    let fleet = &scenario.agents;
    let is_fleet = check.whole("agents.count", fleet.count);
    let speed = fleet.speed_m_s;
    let holds = speed > 0.0 && speed <= 300.0;
    check.that(holds, &["agents.speed_m_s"], &speed.to_string(), "above 0 and up to 300 m/s");
    check.not_negative("agents.start_offset_m", fleet.start_offset_m);
    start(check, fleet, scenario.map.size_m);
    check.positive("agents.yaw_settling_s", fleet.yaw_settling_s);
    let step = fleet.altitude_step_m;
    check.that(
        step.is_finite() && (step != 0.0 || fleet.count < 2),
        &["agents.altitude_step_m"],
        &step.to_string(),
        "a number other than 0: each UAV has an altitude of its own",
    );
    check.positive("agents.altitude_band_m", fleet.altitude_band_m);
    let (key, floor, what) = match scenario.map.kind {
        MapKind::Generated => {
            ("map.max_height_m", scenario.map.max_height_m, "the highest building")
        }
        _ => ("targets.cylinder_height_m", scenario.targets.cylinder_height_m, "a car"),
    };
    let (key, floor, what) = match fleet.avoid_buildings {
        true => ("targets.cylinder_height_m", scenario.targets.cylinder_height_m, "a car"),
        false => (key, floor, what),
    };
    let around = match key {
        "map.max_height_m" => ", or agents.avoid_buildings = true",
        _ => "",
    };
    let lowest = altitudes(fleet)[0];
    check.that(
        lowest > floor && lowest.is_finite(),
        &["agents.altitude_m", "agents.altitude_step_m", key],
        &format!("{} (the lowest UAV at {lowest} m)", fleet.altitude_m),
        &format!("all UAVs above {what}, {key} = {floor} m{around}"),
    );
    is_fleet
}

/// How far outside the region a UAV may start, metres.
const MAX_START_M: f64 = 1000.0;

fn start(check: &mut Check, fleet: &FleetModel, size_m: [f64; 2]) {
    let (got, count) = (fleet.start.len(), usize::from(fleet.count));
    check.that(
        matches!(got, 0 | 1) || got == count,
        &["agents.start", "agents.count"],
        &format!("{got} poses for {count} UAVs"),
        "none, one that is the base of all, or one for each UAV",
    );
    for (index, StartPose { x_m, y_m, yaw_deg }) in fleet.start.iter().enumerate() {
        let values = [
            ("x_m", *x_m, size_m[0] / 2.0 + MAX_START_M),
            ("y_m", *y_m, size_m[1] / 2.0 + MAX_START_M),
            ("yaw_deg", *yaw_deg, 360.0),
        ];
        let is_within = |value: f64, most: f64| (-most..=most).contains(&value); // false for NaN
        for (name, value, most) in values.into_iter().filter(|(_, v, most)| !is_within(*v, *most)) {
            let key = format!("agents.start[{index}].{name}");
            let text = format!("`{key}` cannot be {value}");
            let expected = match name {
                "yaw_deg" => "degrees from -360 to 360".to_owned(),
                _ => {
                    format!("from -{most} to {most} m, {MAX_START_M} m outside the region at most")
                }
            };
            let mistake = Mistake::new(text).expected(expected);
            check.0.push(Issue { keys: with_ancestors(&key), mistake, is_warning: false });
        }
    }
}

/// Who flies around buildings turns back in the launch site, if need be, and decides in time.
fn room_to_turn(check: &mut Check, scenario: &Scenario) {
    let uavs = scenario.agents.count;
    if scenario.netem.crashes().any(|crash| crash.agent < uavs) {
        let text = "a UAV whose agent has crashed flies straight on, into buildings as well";
        let mistake = Mistake::new(text).expected("kind = \"radio\" with agents.avoid_buildings");
        check.warn(&["netem.outage", "agents.avoid_buildings"], mistake);
    }
    let room_m = turning_room_m(&scenario.agent_config());
    let radius_m = scenario.agents.launch_radius_m();
    let increments = &scenario.guidance.increments_deg;
    check.that(
        room_m <= radius_m,
        &[
            "guidance.increments_deg",
            "guidance.period_s",
            "agents.avoid_buildings",
            "agents.yaw_settling_s",
        ],
        &format!("{increments:?} with agents.avoid_buildings"),
        &format!(
            "a turn in which a UAV needs at most {radius_m} m, the room where it starts; the \
             sharpest needs {room_m:.1} m"
        ),
    );
}

/// The lowest and the highest altitude.
fn altitudes(fleet: &FleetModel) -> [f64; 2] {
    let (first, last) = (fleet.altitude_m, fleet.altitude_of(fleet.count.max(1) - 1));
    [first.min(last), first.max(last)]
}

/// Steps of depth that are told no finer than this are warned of, metres.
const COARSE_DEPTH_M: f64 = 0.1;

fn camera(check: &mut Check, scenario: &Scenario, is_fleet: bool) {
    let camera = &scenario.camera;
    let before = check.0.len();
    let image = format!("{} x {}", camera.columns, camera.rows);
    check.whole("camera.columns", camera.columns);
    check.whole("camera.rows", camera.rows);
    let keys = ["camera.columns", "camera.rows"];
    let expected = format!("an image of at most {MAX_PIXELS} pixels");
    check.that(camera.pixels() <= MAX_PIXELS, &keys, &image, &expected);
    let aperture = camera.aperture_deg;
    let expected = "an angle from 1 to below 180 degrees";
    let holds = (1.0..180.0).contains(&aperture);
    check.that(holds, &["camera.aperture_deg"], &aperture.to_string(), expected);
    let tilt_ok = (-90.0..=90.0).contains(&camera.tilt_deg);
    let expected = "an angle below the horizon, up to 90 degrees";
    check.that(tilt_ok, &["camera.tilt_deg"], &camera.tilt_deg.to_string(), expected);
    check.positive("camera.d_max_m", camera.d_max_m);
    let depth_step_m = camera.depth_step_m();
    if depth_step_m > COARSE_DEPTH_M && depth_step_m.is_finite() {
        let text = format!(
            "depths are told in steps of {depth_step_m:.2} m, a 65535th of `camera.d_max_m`"
        );
        let expected = format!("steps of at most {COARSE_DEPTH_M} m: sets of cars are as coarse");
        check.warn(&["camera.d_max_m"], Mistake::new(text).expected(expected));
    }
    check.whole("camera.min_pixels", camera.min_pixels);
    let [lo, hi] = camera.depth_noise;
    check.that(
        lo > -1.0 && lo <= 0.0 && hi >= 0.0 && hi.is_finite(),
        &["camera.depth_noise"],
        &format!("[{lo}, {hi}]"),
        "an interval around 0 that begins above -1",
    );
    let fleet_ok = altitudes(&scenario.agents).iter().all(|a| *a > 0.0 && a.is_finite());
    if check.0.len() == before && fleet_ok && is_fleet {
        pixels_on_a_car(check, camera, &scenario.agents, scenario.targets.body_m);
    }
}

fn pixels_on_a_car(check: &mut Check, camera: &CameraModel, fleet: &FleetModel, body_m: [f64; 3]) {
    const KEYS: [&str; 6] = [
        "camera.tilt_deg",
        "camera.d_max_m",
        "camera.aperture_deg",
        "agents.altitude_m",
        "camera.rows",
        "camera.columns",
    ];
    let [_, highest] = altitudes(fleet);
    let Some(coverage) = car_coverage(camera, highest, body_m) else {
        let got =
            format!("{} (at {highest} m altitude no ground within d_max is seen)", camera.tilt_deg);
        check.that(false, &KEYS, &got, "a camera that sees ground nearer than camera.d_max_m");
        return;
    };
    let (Some(worst), Some(best)) = (coverage.worst(), coverage.best()) else { return };
    let image = format!("{} x {} pixels", camera.columns, camera.rows);
    let keys = ["camera.columns", "camera.rows", "camera.min_pixels", "agents.altitude_m"];
    if best.best < camera.min_pixels {
        let text = format!(
            "{image} are too coarse: at {highest} m altitude a car never has more than {} pixels",
            best.best
        );
        let expected = format!("camera.min_pixels = {} somewhere in view", camera.min_pixels);
        let mistake = Mistake::new(text).expected(expected);
        check.0.push(Issue { keys: owned(&keys), mistake, is_warning: false });
    } else if worst.worst < camera.min_pixels {
        let sure = coverage.sure_up_to_m(camera.min_pixels);
        let sure = sure.map_or("nowhere".into(), |m| format!("up to {m:.0} m ahead"));
        let text = format!(
            "{image} are coarse for Assumptions 4 and 7: at {highest} m altitude a car {:.0} m \
             ahead ({:.0} m from the camera) may have only {} pixels",
            worst.ground_m, worst.slant_m, worst.worst
        );
        let expected = format!(
            "camera.min_pixels = {} in the whole footprint; cars are surely identified {sure}",
            camera.min_pixels
        );
        check.warn(&keys, Mistake::new(text).expected(expected));
    }
}

fn estimator(check: &mut Check, estimator: &EstimatorConfig, size_m: [f64; 2]) {
    let vertices = estimator.disc_vertices;
    check.that(
        (4..=256).contains(&vertices) && vertices.is_multiple_of(2),
        &["estimator.disc_vertices"],
        &vertices.to_string(),
        "an even number from 4 to 256",
    );
    check.whole("estimator.max_vertices", estimator.max_vertices);
    check.not_negative("estimator.simplify_m", estimator.simplify_m);
    check.not_negative("estimator.simplify_margin_m", estimator.simplify_margin_m);
    check.not_negative("estimator.outline_tolerance_px", estimator.outline_tolerance_px);
    let cells = [
        ("estimator.raster_cell_m", estimator.raster_cell_m),
        ("estimator.oem_cell_m", estimator.oem_cell_m),
    ];
    for (key, cell) in cells {
        let count = (size_m[0] / cell) * (size_m[1] / cell);
        let holds = cell > 0.0 && cell.is_finite() && count <= MAX_CELLS;
        let expected = format!("a length above 0 that makes at most {MAX_CELLS} cells");
        check.that(holds, &[key], &cell.to_string(), &expected);
    }
}

fn guidance(check: &mut Check, guidance: &GuidanceConfig, period_s: Option<f64>) {
    check.not_negative("guidance.kappa", guidance.kappa);
    check.not_negative("guidance.lambda", guidance.lambda);
    let n_mpc = guidance.n_mpc;
    let is_short = check.whole("guidance.n_mpc", n_mpc);
    if let Some(period_s) = period_s {
        let periods = guidance.period_s / period_s;
        check.that(
            periods.round() >= 1.0 && (periods - periods.round()).abs() < 1e-9,
            &["guidance.period_s", "run.period_s"],
            &guidance.period_s.to_string(),
            &format!("a multiple of run.period_s = {period_s} s"),
        );
        let timeout = guidance.plan_timeout_s;
        check.that(
            timeout >= 0.0 && timeout < period_s,
            &["guidance.plan_timeout_s", "run.period_s"],
            &timeout.to_string(),
            &format!("0 or more and below run.period_s = {period_s} s"),
        );
    }
    check.whole("guidance.str4.n_mpc", guidance.str4.n_mpc);
    check.whole("guidance.str4.beam", guidance.str4.beam);
    check.whole("guidance.str4.first_look", guidance.str4.first_look);
    let increments = &guidance.increments_deg;
    let valid = increments.iter().all(|u| u.abs() <= 180.0);
    let got = if increments.is_empty() { "empty".to_owned() } else { format!("{increments:?}") };
    check.that(
        valid && (1..=32).contains(&increments.len()),
        &["guidance.increments_deg"],
        &got,
        "1 to 32 angles from -180 to 180 degrees",
    );
    let sequences = increments.len().saturating_pow(n_mpc.into());
    check.that(
        sequences <= MAX_SEQUENCES || !is_short,
        &["guidance.n_mpc", "guidance.increments_deg"],
        &format!("{n_mpc} with {} increments", increments.len()),
        &format!("at most {MAX_SEQUENCES} sequences of increments to try"),
    );
}
