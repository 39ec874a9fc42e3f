//! `[agents]`: who flies, where, and how.

use csat_proto::fixed_wing::FixedWingModel;
use csat_proto::model::{FleetModel, StartPose, VehicleKind};
use csat_world::map::MapKind;

use super::{Check, Scenario};

/// Judges `[agents]`; tells whether there are as many as there may be.
pub(super) fn judge(check: &mut Check, scenario: &Scenario) -> bool {
    let fleet = &scenario.agents;
    let is_fleet = check.whole("agents.count", fleet.count);
    let speed = fleet.speed_m_s;
    let holds = speed > 0.0 && speed <= 300.0;
    check.that(holds, &["agents.speed_m_s"], &speed.to_string(), "above 0 and up to 300 m/s");
    check.not_negative("agents.start_offset_m", fleet.start_offset_m);
    start(check, fleet, scenario.map.size_m);
    vehicle(check, fleet);
    let step = fleet.altitude_step_m;
    let is_multirotor = fleet.vehicle == VehicleKind::Multirotor;
    check.that(
        step.is_finite() && (step != 0.0 || fleet.count < 2 || is_multirotor),
        &["agents.altitude_step_m"],
        &step.to_string(),
        "a number other than 0: each UAV has an altitude of its own, except for multirotors",
    );
    check.positive("agents.altitude_band_m", fleet.altitude_band_m);
    above_all(check, scenario);
    is_fleet
}

/// All UAVs fly above all that they do not fly around.
fn above_all(check: &mut Check, scenario: &Scenario) {
    let fleet = &scenario.agents;
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
            let expected = match name {
                "yaw_deg" => "degrees from -360 to 360".to_owned(),
                _ => {
                    format!("from -{most} to {most} m, {MAX_START_M} m outside the region at most")
                }
            };
            check.at(false, &format!("agents.start[{index}].{name}"), &value, &expected);
        }
    }
}

/// The steepest bank that may be asked for, degrees.
const MAX_ROLL_DEG: f64 = 80.0;
/// The greatest pitch in level flight, either way, degrees.
const MAX_TRIM_DEG: f64 = 45.0;

/// The keys of a vehicle, and none of another one.
fn vehicle(check: &mut Check, fleet: &FleetModel) {
    let usual = FleetModel::default();
    let before = check.0.len();
    check.positive("agents.yaw_settling_s", fleet.yaw_settling_s);
    fixed_wing(check, fleet);
    if check.0.len() > before {
        return;
    }
    let with = match fleet.vehicle {
        VehicleKind::Quadcopter => "with agents.vehicle = \"quadcopter\"",
        VehicleKind::FixedWing => "with agents.vehicle = \"fixed-wing\"",
        VehicleKind::Multirotor => "with agents.vehicle = \"multirotor\"",
    };
    let mut unused = |key, values: [f64; 2]| check.unused(&[key, "agents.vehicle"], values, with);
    if fleet.vehicle != VehicleKind::Quadcopter {
        unused("agents.yaw_settling_s", [fleet.yaw_settling_s, usual.yaw_settling_s]);
    }
    if fleet.vehicle != VehicleKind::Multirotor {
        let errors = [fleet.multirotor, usual.multirotor].map(|model| model.motion_error_m);
        unused("agents.multirotor.motion_error_m", errors);
    }
    if fleet.vehicle == VehicleKind::FixedWing {
        return;
    }
    let (own, usual) = (&fleet.fixed_wing, &usual.fixed_wing);
    unused("agents.fixed_wing.roll_max_deg", [own.roll_max_deg, usual.roll_max_deg]);
    unused(
        "agents.fixed_wing.roll_time_constant_s",
        [own.roll_time_constant_s, usual.roll_time_constant_s],
    );
    unused(
        "agents.fixed_wing.heading_time_constant_s",
        [own.heading_time_constant_s, usual.heading_time_constant_s],
    );
    unused("agents.fixed_wing.pitch_trim_deg", [own.pitch_trim_deg, usual.pitch_trim_deg]);
    unused(
        "agents.fixed_wing.pitch_time_constant_s",
        [own.pitch_time_constant_s, usual.pitch_time_constant_s],
    );
    let keys = ["agents.fixed_wing.wind_m_s", "agents.vehicle"];
    let values = [own.wind_m_s, usual.wind_m_s];
    check.unused(&keys, values, with);
}

fn fixed_wing(check: &mut Check, fleet: &FleetModel) {
    let FixedWingModel {
        roll_max_deg,
        roll_time_constant_s,
        heading_time_constant_s,
        pitch_trim_deg,
        pitch_time_constant_s,
        wind_m_s,
    } = fleet.fixed_wing;
    check.that(
        roll_max_deg > 0.0 && roll_max_deg < MAX_ROLL_DEG,
        &["agents.fixed_wing.roll_max_deg"],
        &roll_max_deg.to_string(),
        &format!("an angle above 0 and below {MAX_ROLL_DEG} degrees"),
    );
    check.positive("agents.fixed_wing.roll_time_constant_s", roll_time_constant_s);
    check.positive("agents.fixed_wing.heading_time_constant_s", heading_time_constant_s);
    check.positive("agents.fixed_wing.pitch_time_constant_s", pitch_time_constant_s);
    check.that(
        pitch_trim_deg.abs() <= MAX_TRIM_DEG,
        &["agents.fixed_wing.pitch_trim_deg"],
        &pitch_trim_deg.to_string(),
        &format!("an angle from -{MAX_TRIM_DEG} to {MAX_TRIM_DEG} degrees"),
    );
    let [east, north] = wind_m_s;
    let is_speed = fleet.speed_m_s > 0.0;
    check.that(
        !is_speed || east.hypot(north) < fleet.speed_m_s, // false for NaN
        &["agents.fixed_wing.wind_m_s", "agents.speed_m_s"],
        &format!("{wind_m_s:?}"),
        &format!("a wind slower than agents.speed_m_s = {} m/s", fleet.speed_m_s),
    );
}

/// The lowest and the highest altitude.
pub(super) fn altitudes(fleet: &FleetModel) -> [f64; 2] {
    let (first, last) = (fleet.altitude_m, fleet.altitude_of(fleet.count.max(1) - 1));
    [first.min(last), first.max(last)]
}
