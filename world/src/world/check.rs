//! Checks of a scenario before the world is built.

use std::fmt::Debug;

use csat_proto::model::{
    FLIGHT_CLEARANCE_M, FleetModel, Ground, OdometryModel, StartPose, VehicleKind,
};

use super::{WorldConfig, WorldError, stations};
use crate::navigation::NavigationModel;
use crate::road_area::CELL_M;
use crate::sensor;

/// Altitude of the lowest UAV, metres; of UAV 0 in an empty fleet.
pub(super) fn lowest_altitude_m(fleet: &FleetModel) -> f64 {
    fleet.altitude_of(0).min(fleet.altitude_of(fleet.count.saturating_sub(1)))
}

/// The mistakes in all tables except `[map]`.
pub(super) fn mistakes(config: &WorldConfig) -> Vec<WorldError> {
    let WorldConfig { targets, fleet, period_s, .. } = config;
    let ground = Ground { size_m: config.map.size_m };
    let far = stations::far_away(&config.stations, fleet.count, &ground);
    let mut errors: Vec<WorldError> = far.into_iter().map(WorldError::Station).collect();
    let mut expect = |holds: bool, key: &'static str, got: &dyn Debug, expected: &str| {
        if !holds {
            let (got, expected) = (format!("{got:?}"), expected.to_owned());
            errors.push(WorldError::Config { key, got, expected });
        }
    };
    let length = |x: f64| x.is_finite() && x >= 0.0;
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let checks = [
        ("targets.v_max_m_s", targets.v_max_m_s),
        ("targets.obstacle_distance_m", targets.obstacle_distance_m),
        ("targets.target_distance_m", targets.target_distance_m),
        ("targets.walk_m_sqrt_s", targets.walk_m_sqrt_s),
        ("agents.speed_m_s", fleet.speed_m_s),
        ("agents.start_offset_m", fleet.start_offset_m),
        ("agents.multirotor.motion_error_m", fleet.multirotor.motion_error_m),
    ];
    for (key, value) in checks {
        expect(length(value), key, &value, "a number from 0 up");
    }
    for (key, value) in
        [("run.period_s", *period_s), ("agents.yaw_settling_s", fleet.yaw_settling_s)]
    {
        expect(positive(value), key, &value, "a number above 0, in seconds");
    }
    let step = fleet.altitude_step_m;
    expect(step.is_finite(), "agents.altitude_step_m", &step, "a number, in metres");
    let band = fleet.altitude_band_m;
    expect(positive(band), "agents.altitude_band_m", &band, "a number above 0, in metres");
    if let Some(NavigationModel { sigma, time_constant_s, .. }) = &config.navigation {
        let sigma_ok = sigma.iter().all(|s| length(*s));
        expect(sigma_ok, "pose.sigma", sigma, "six numbers from 0 up, in metres and radians");
        let time = time_constant_s;
        expect(positive(*time), "pose.time_constant_s", time, "a number above 0, in seconds");
    }
    if fleet.avoid_buildings {
        // At its start a UAV flies over the buildings there; elsewhere `map` checks the altitude.
        let (lowest_m, least_m) = (lowest_altitude_m(fleet), FLIGHT_CLEARANCE_M + 1.0);
        let expected = format!("more than {least_m} m for the lowest UAV");
        expect(lowest_m > least_m, "agents.altitude_m", &lowest_m, &expected);
    }
    let body = targets.body_m;
    let body_ok = body.iter().all(|x| positive(*x));
    expect(body_ok, "targets.body_m", &body, "three lengths above 0");
    if body_ok {
        // The shape lies in the cylinder C^t (3.4).
        let radius = body[0].hypot(body[1]) / 2.0;
        let expected = format!("at least {radius:.3}, half the diagonal of targets.body_m");
        expect(targets.radius_m >= radius, "targets.radius_m", &targets.radius_m, &expected);
        let height = targets.cylinder_height_m;
        let expected = format!("at least {}, the height of targets.body_m", body[2]);
        expect(height >= body[2], "targets.cylinder_height_m", &height, &expected);
    }
    of_clearing(config, &mut expect);
    errors
}

/// Takes whether a value holds, its key, the value, and what is expected.
type Expect<'a> = dyn FnMut(bool, &'static str, &dyn Debug, &str) + 'a;

/// The mistakes in what worlds have in which roads are cleared.
fn of_clearing(config: &WorldConfig, expect: &mut Expect<'_>) {
    let fleet = &config.fleet;
    let is_north_up = |start: &StartPose| start.yaw_deg == 0.0;
    let yaw_ok = fleet.vehicle != VehicleKind::Multirotor || fleet.start.iter().all(is_north_up);
    let yaws: Vec<f64> = fleet.start.iter().map(|start| start.yaw_deg).collect();
    let expected = "yaw_deg = 0 for all: a multirotor's image has north in its first row";
    expect(yaw_ok, "agents.start", &yaws, expected);
    if let Some(OdometryModel { jitter_m, drift_share }) = &config.odometry {
        let jitter_ok = jitter_m.is_finite() && *jitter_m >= 0.0;
        expect(jitter_ok, "odometry.jitter_m", jitter_m, "a number from 0 up, in metres");
        let drift_ok = (0.0..=1.0).contains(drift_share);
        expect(drift_ok, "odometry.drift_share", drift_share, "a share from 0 to 1");
        let is_one = config.navigation.is_none();
        expect(is_one, "odometry", &config.navigation, "no table `[pose]` beside it");
    }
    let start = &config.map.start_line;
    match &config.segmentation {
        Some(sensor) => {
            let heights_m =
                [0, fleet.count.saturating_sub(1)].map(|index| fleet.altitude_of(index));
            for (key, got, expected) in sensor::mistakes(&config.camera, sensor, heights_m, CELL_M)
            {
                expect(false, key, &format_args!("{got}"), &expected);
            }
        }
        None => {
            let got = start.unwrap_or_default();
            let expected = "no such key: no camera of this mission segments roads";
            expect(start.is_none(), "map.start_line", &got, expected);
        }
    }
}
