//! Values that have the right type and still make no mission.
//!
//! The town's own values (`map.*`) are judged by `csat-world` when it makes the town.

pub mod bayes;
mod camera;
pub mod clearing;
mod cost;
mod exchange;
mod faults;
mod fleet;
mod pose;
mod targets;

use std::fmt::Display;
use std::ops::RangeInclusive;

use csat_agent::config::{Criterion, EstimatorConfig, GuidanceConfig, Objective};
use csat_agent::guidance::airspace::turning_room_m;
use csat_proto::model::VehicleKind;

pub use super::issue::Issue;
use super::issue::owned;
use super::missions;
use super::mistake::Mistake;
use super::model::{RunConfig, Scenario};
use super::set_membership::Tables;
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
const WHOLE_NUMBERS: [(&str, RangeInclusive<u64>, &str); 12] = [
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
    ("exchange.liars", 0..=1023, "a whole number, fewer than agents.count"),
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
    targets::judge(&mut check, &scenario.targets);
    let is_fleet = fleet::judge(&mut check, scenario);
    let is_clean = camera::judge(&mut check, &scenario.camera);
    let needs_labels = missions::find(&scenario.mission).is_none_or(|m| m.needs_labels());
    if needs_labels {
        camera::judge_labels(&mut check, scenario, is_fleet && is_clean);
    } else {
        camera::judge_nameless(&mut check, scenario);
    }
    check
}

/// What the set-membership mission has besides.
pub fn of_set_membership(scenario: &Scenario) -> Vec<Issue> {
    let before = of_any_mission(scenario);
    let period_s = run(&mut Check(Vec::new()), &scenario.run);
    let mut check = Check(Vec::new());
    check.that(
        scenario.targets.driving.keeps_v_max(),
        &["targets.driving"],
        "`random-walk` in the mission `set-membership`",
        "cars that keep to targets.v_max_m_s, as its guarantee assumes",
    );
    check.that(
        scenario.agents.vehicle == VehicleKind::Quadcopter,
        &["agents.vehicle"],
        "`fixed-wing` in the mission `set-membership`",
        "`quadcopter`, whose flight its guidance predicts",
    );
    estimator(&mut check, &scenario.estimator, scenario.map.size_m);
    guidance(&mut check, &scenario.guidance, period_s);
    let is_clean = before.0.is_empty() && check.0.is_empty();
    pose::judge(&mut check, scenario, &scenario.own::<Tables>().pose, period_s);
    if is_clean && scenario.agents.avoid_buildings {
        room_to_turn(&mut check, scenario);
    }
    exchange::judge(&mut check, &scenario.exchange, &scenario.netem, period_s);
    faults::judge(&mut check, scenario);
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

    /// Demands that the value at `path`, which may be in an array, `holds`.
    fn at(&mut self, holds: bool, path: &str, got: &dyn Display, expected: &str) {
        if !holds {
            let mistake = Mistake::new(format!("`{path}` cannot be {got}")).expected(expected);
            self.0.push(Issue { keys: with_ancestors(path), mistake, is_warning: false });
        }
    }

    fn positive(&mut self, key: &'static str, value: f64) {
        let holds = value > 0.0 && value.is_finite();
        self.that(holds, &[key], &value.to_string(), "a finite number above 0");
    }

    fn not_negative(&mut self, key: &'static str, value: f64) {
        let holds = value >= 0.0 && value.is_finite();
        self.that(holds, &[key], &value.to_string(), "a finite number from 0 on");
    }

    fn share(&mut self, key: &'static str, value: f64) {
        let holds = (0.0..=1.0).contains(&value);
        self.that(holds, &[key], &value.to_string(), "a share from 0 to 1");
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

    /// Refuses a value other than the default where the key has no effect.
    fn unused<T: PartialEq + std::fmt::Debug>(
        &mut self,
        keys: &[&'static str],
        [value, default]: [T; 2],
        why: &str,
    ) {
        let got = format!("{value:?} {why}");
        self.that(value == default, keys, &got, "no such key: it has no effect");
    }

    /// Demands a time from 0 on at `path`, at which something begins, and tells whether it is one. Warns if it is after
    /// the mission's end; `help` says what does not happen then.
    fn begins(&mut self, path: &str, from_s: f64, run: &RunConfig, help: &str) -> bool {
        let is_time = (0.0..=MAX_TIME_S).contains(&from_s);
        self.at(is_time, path, &from_s, &format!("a time from 0 to {MAX_TIME_S} s"));
        let end_s = end_s(run);
        if is_time && from_s > end_s {
            let text = format!("`{path}` = {from_s} s is after the mission's end, {end_s} s");
            let mistake = Mistake::new(text).help(help);
            self.0.push(Issue { keys: with_ancestors(path), mistake, is_warning: true });
        }
        is_time
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
        let help = format!("the mission ends with its last frame, at {} s", end_s(run));
        check.warn(&["run.duration_s", "run.period_s"], Mistake::new(text).help(help));
    }
    (run.period_s > 0.0).then_some(run.period_s)
}

/// The time of the last frame, seconds; of a mission whose length is refused, ∞.
fn end_s(run: &RunConfig) -> f64 {
    match run.period_s > 0.0 && run.duration_s >= run.period_s {
        true => micro(run.period_s * f64::from(run.steps())),
        false => f64::INFINITY,
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
    check.that(
        guidance.objective == Objective::Own || guidance.criterion == Criterion::Str4,
        &["guidance.objective", "guidance.criterion"],
        "fleet",
        "\"own\", as guidance.criterion is not \"str4\"",
    );
    check.share("guidance.str4.silent", guidance.str4.silent);
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
