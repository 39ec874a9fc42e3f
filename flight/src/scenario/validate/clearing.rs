//! What road clearing has besides.

use csat_clearing::config::{AgentConfig, mistakes};
use csat_proto::camera::CameraModel;
use csat_proto::model::VehicleKind;
use csat_world::map::MapKind;

use super::exchange::idle_radios;
use super::{Check, Issue, Scenario};
use crate::scenario::clearing::{Tables, agent_config};
use crate::scenario::mistake::Mistake;

/// Judges a scenario of the mission.
pub fn judge(scenario: &Scenario, tables: &Tables) -> Vec<Issue> {
    let mut check = Check(Vec::new());
    world(&mut check, scenario);
    camera(&mut check, scenario);
    radios(&mut check, scenario, tables);
    let is_clean = check.0.iter().all(|issue| issue.is_warning);
    let config = agent_config(scenario, tables);
    if is_clean {
        check.0.extend(mistakes(&config).into_iter().map(issue));
        start(&mut check, scenario, &config);
    }
    check.0
}

fn issue(
    csat_clearing::config::Mistake { key, got, expected }: csat_clearing::config::Mistake,
) -> Issue {
    let mistake = Mistake::new(format!("`{key}` cannot be {got}")).expected(expected);
    Issue { keys: vec![key], mistake, is_warning: false }
}

/// Roads without cars, and multirotors.
fn world(check: &mut Check, scenario: &Scenario) {
    check.that(
        scenario.map.kind != MapKind::Open,
        &["map.kind"],
        "`open`",
        "a map with roads: `desert`, `generated` or `geojson`",
    );
    check.that(
        scenario.targets.count == 0,
        &["targets.count"],
        &scenario.targets.count.to_string(),
        "0: evaders are wherever no cleaner has looked, and have no number",
    );
    let agents = &scenario.agents;
    let name = match agents.vehicle {
        VehicleKind::Quadcopter => "`quadcopter`",
        VehicleKind::FixedWing => "`fixed-wing`",
        VehicleKind::Multirotor => "`multirotor`",
    };
    let is_multirotor = agents.vehicle == VehicleKind::Multirotor;
    check.that(
        is_multirotor,
        &["agents.vehicle"],
        name,
        "`multirotor`, which is displaced step by step",
    );
    check.that(
        agents.start.is_empty(),
        &["agents.start"],
        "a list of poses",
        "no such key: the fleet starts above the start line (map.start_line)",
    );
    check.that(
        agents.altitude_step_m == 0.0,
        &["agents.altitude_step_m"],
        &agents.altitude_step_m.to_string(),
        "0: all images have one scale (Gagliardi et al. II)",
    );
}

/// A square image from straight above.
fn camera(check: &mut Check, scenario: &Scenario) {
    let camera = &scenario.camera;
    let of_roads = CameraModel {
        columns: camera.columns,
        rows: camera.rows,
        aperture_deg: camera.aperture_deg,
        tilt_deg: 90.0,
        // Judged for every mission without labels.
        misidentify: camera.misidentify,
        ..CameraModel::default()
    };
    check.that(
        *camera == of_roads,
        &["camera"],
        "one with other labels, depths or boxes than the default, or that is tilted",
        "columns, rows and aperture_deg only, and tilt_deg = 90: it looks straight down and segments roads",
    );
}

/// A radio that measures offsets, and one that reaches across the region.
fn radios(check: &mut Check, scenario: &Scenario, tables: &Tables) {
    let (clearing, netem) = (&tables.clearing, &scenario.netem);
    let names = [("clearing.hbsr", &clearing.hbsr), ("clearing.lblr", &clearing.lblr)];
    for (key, name) in names {
        let is_known = netem.channel_id(name).is_some();
        check.that(is_known, &[key], &format!("`{name}`"), "the name of a radio of [netem]");
    }
    let channel = |name: &str| netem.channel_id(name).and_then(|id| netem.channel(id));
    let mut demand = |holds: bool, name: &str, key: &str, got: &str, expected: String| {
        if !holds {
            let keys = vec![format!("netem.{name}.{key}"), format!("netem.{name}")];
            let mistake = Mistake::new(format!("`{}` cannot be {got}", keys[0])).expected(expected);
            check.0.push(Issue { keys, mistake, is_warning: false });
        }
    };
    if let Some(hbsr) = channel(&clearing.hbsr) {
        let expected =
            "a bound in metres: images are registered by the offsets that this radio measures";
        let is_measured = hbsr.offset_error_m.is_some();
        demand(is_measured, &clearing.hbsr, "offset_error_m", "left out", expected.to_owned());
    }
    if let Some(lblr) = channel(&clearing.lblr) {
        let [east, north] = scenario.map.size_m;
        let diameter_m = east.hypot(north);
        let holds = lblr.range_m >= diameter_m || clearing.allow_short_lblr;
        let expected = format!(
            "a range across the region, {diameter_m:.0} m (Gagliardi et al. II), or clearing.allow_short_lblr = true"
        );
        demand(holds, &clearing.lblr, "range_m", &lblr.range_m.to_string(), expected);
    }
    let used = [clearing.hbsr.as_str(), &clearing.lblr];
    // A radio that a wrong name was meant for is not idle.
    if used.iter().all(|name| netem.channel_id(name).is_some()) {
        idle_radios(check, netem, &used, ["clearing.hbsr", "clearing.lblr"]);
    }
}

/// Cleaners must be able to move as fast as they are told.
fn start(check: &mut Check, scenario: &Scenario, config: &AgentConfig) {
    let needed_m_s = config.clearing.step_m * std::f64::consts::SQRT_2 / config.period_s;
    let speed = scenario.agents.speed_m_s;
    check.that(
        speed >= needed_m_s,
        &["agents.speed_m_s", "clearing.step_m"],
        &speed.to_string(),
        &format!("at least {needed_m_s:.3} m/s, clearing.step_m along both axes in a period"),
    );
}
