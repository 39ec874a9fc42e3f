//! `[pose]` of the set-membership mission.

use csat_proto::camera::{CameraModel, Pose};
use csat_world::observer::ObserverModel;

use super::camera::least_corner_dip_deg;
use super::fleet::altitudes;
use super::{Check, Scenario};
use crate::scenario::mistake::Mistake;

/// The agent takes larger errors of the yaw for any yaw, degrees.
const MOST_YAW_DEG: f64 = 57.0;
/// Obstacle margins of targets whose places are less certain than this share of `r_s^to` are dropped.
const MARGIN_SHARE: f64 = 0.75;

/// Judges how well poses are known.
pub(super) fn judge(check: &mut Check, scenario: &Scenario, pose: &ObserverModel) {
    let before = check.0.len();
    check.that(
        pose.error.iter().all(|bound| *bound >= 0.0 && bound.is_finite()),
        &["pose.error"],
        &format!("{:?}", pose.error),
        "six half-widths from 0 on: x, y, z in metres; roll, pitch, yaw in degrees",
    );
    check.positive("pose.time_constant_s", pose.time_constant_s);
    check.time("pose.fix_period_s", pose.fix_period_s);
    let expected = "a share of the path, from 0 to below 1";
    check.that(
        (0.0..1.0).contains(&pose.drift),
        &["pose.drift"],
        &pose.drift.to_string(),
        expected,
    );
    denied(check, scenario, pose);
    if check.0.len() == before && !pose.is_exact() {
        limits(check, scenario, pose);
    }
}

fn denied(check: &mut Check, scenario: &Scenario, pose: &ObserverModel) {
    let half = scenario.map.size_m.map(|size| 0.5 * size);
    for (index, zone) in pose.denied.iter().enumerate() {
        let mut that = |holds: bool, name: &str, got: &str, expected: &str| {
            check.at(holds, &format!("pose.denied[{index}].{name}"), &got, expected);
        };
        let ([west, south], [east, north]) = (zone.min_m, zone.max_m);
        let is_ordered = west < east && south < north;
        let expected = format!("north-east of min_m, [{west}, {south}]");
        that(is_ordered, "max_m", &format!("[{east}, {north}]"), &expected);
        let meets = west < half[0] && east > -half[0] && south < half[1] && north > -half[1];
        let expected =
            format!("a rectangle that meets the region, +-{} m x +-{} m", half[0], half[1]);
        that(meets || !is_ordered, "min_m", &format!("[{west}, {south}]"), &expected);
        let is_late = zone.from_s < zone.until_s && zone.from_s >= 0.0;
        that(
            is_late,
            "from_s",
            &zone.from_s.to_string(),
            &format!("a time from 0 to until_s, {}", zone.until_s),
        );
    }
}

/// What errors of this size do to the camera and to the margins.
fn limits(check: &mut Check, scenario: &Scenario, pose: &ObserverModel) {
    let [x, y, z, roll, pitch, yaw] = pose.error;
    let got = format!("{:?}", pose.error);
    check.that(
        !scenario.agents.avoid_buildings,
        &["agents.avoid_buildings", "pose.error"],
        "true where poses are not exact",
        "pose.error = [0, 0, 0, 0, 0, 0] with fixes at every step: keeping clear of buildings needs the exact place",
    );
    let widest_m = scenario.map.size_m.into_iter().fold(0.0, f64::max);
    let expected = format!(
        "first numbers, the errors of x and y, up to {widest_m} m, the longer side of the region"
    );
    check.that(x.max(y) <= widest_m, &["pose.error", "map.size_m"], &got, &expected);
    let [lowest_m, highest_m] = altitudes(&scenario.agents);
    let expected =
        format!("a third number, the error of the height, below the lowest altitude, {lowest_m} m");
    check.that(z < lowest_m, &["pose.error", "agents.altitude_m"], &got, &expected);
    let expected = format!("a sixth number, the error of the yaw, up to {MOST_YAW_DEG} degrees");
    check.that(yaw <= MOST_YAW_DEG, &["pose.error"], &got, &expected);
    let dip_deg = least_dip_deg(&scenario.camera, highest_m.max(lowest_m) + z);
    let expected = format!(
        "errors of roll and pitch of less than {dip_deg:.2} degrees together: with more, the horizon enters the image"
    );
    check.that(roll + pitch < dip_deg, &["pose.error", "camera.tilt_deg"], &got, &expected);
    let vanishing_m = MARGIN_SHARE * scenario.targets.obstacle_distance_m;
    if x.hypot(y) >= vanishing_m {
        let text = format!("no obstacle margin survives `pose.error` of {x} m and {y} m");
        let expected = format!(
            "errors of x and y of less than {vanishing_m} m together, three quarters of targets.obstacle_distance_m"
        );
        let keys = ["pose.error", "targets.obstacle_distance_m"];
        check.warn(&keys, Mistake::new(text).expected(expected));
    }
}

/// The least angle below the horizon of a ray of the image that meets the ground within d_max, degrees.
fn least_dip_deg(camera: &CameraModel, altitude_m: f64) -> f64 {
    let view = camera.at(&Pose::level([0.0, 0.0, altitude_m], 0.0));
    let least = least_corner_dip_deg(&view);
    let farthest = (altitude_m / camera.d_max_m).min(1.0).asin().to_degrees();
    least.max(farthest)
}
