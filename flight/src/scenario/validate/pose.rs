//! `[pose]` of the set-membership mission.

use csat_agent::config::AgentConfig;
use csat_agent::sense::Sensor;
use csat_proto::camera::{CameraModel, Pose, PoseError};
use csat_proto::frame::{Frame, Label};
use csat_proto::region::MAX_COORDINATE_M;
use csat_proto::time::Step;
use csat_world::observer::ObserverModel;

use super::fleet::altitudes;
use super::{Check, MAX_TIME_S, Scenario, camera};
use crate::scenario::mistake::Mistake;

/// The agent takes larger errors of the yaw for any yaw, degrees.
const MOST_YAW_DEG: f64 = 57.0;
/// Obstacle margins of targets whose places are less certain than this share of `r_s^to` are dropped.
const MARGIN_SHARE: f64 = 0.75;
/// The most time constants in a period: an error draws a number in each.
const MOST_TURNS: f64 = 100.0;
/// The columns of the image in which clear ground is looked for.
const COLUMNS: u16 = 120;
/// The cells of the rasters there, which do not matter, metres.
const CELL_M: f64 = 100.0;

/// Judges how well poses are known.
pub(super) fn judge(
    check: &mut Check,
    scenario: &Scenario,
    pose: &ObserverModel,
    period_s: Option<f64>,
) {
    let is_bounded = pose.error.iter().all(|bound| *bound >= 0.0 && bound.is_finite());
    check.that(
        is_bounded,
        &["pose.error"],
        &format!("{:?}", pose.error),
        "six finite half-widths from 0 on: x, y, z in metres; roll, pitch, yaw in degrees",
    );
    let time_constant_s = pose.time_constant_s;
    let is_long = period_s.is_none_or(|period_s| time_constant_s * MOST_TURNS >= period_s);
    check.that(
        time_constant_s > 0.0 && time_constant_s <= MAX_TIME_S && is_long,
        &["pose.time_constant_s", "run.period_s"],
        &time_constant_s.to_string(),
        &format!(
            "at least a hundredth of run.period_s = {} s, and at most {MAX_TIME_S} s",
            scenario.run.period_s
        ),
    );
    check.time("pose.fix_period_s", pose.fix_period_s);
    check.that(
        (0.0..1.0).contains(&pose.drift),
        &["pose.drift"],
        &pose.drift.to_string(),
        "a share of the path, from 0 to below 1",
    );
    denied(check, scenario, pose);
    if is_bounded && !pose.is_exact() {
        limits(check, scenario, pose);
    }
    gaps(check, pose, period_s);
}

fn denied(check: &mut Check, scenario: &Scenario, pose: &ObserverModel) {
    let half = scenario.map.size_m.map(|size| 0.5 * size);
    for (index, zone) in pose.denied.iter().enumerate() {
        let mut that = |holds: bool, name: &str, got: &str, expected: &str| {
            check.at(holds, &format!("pose.denied[{index}].{name}"), &got, expected);
            holds
        };
        let ([west, south], [east, north]) = (zone.min_m, zone.max_m);
        let [min, max] = [zone.min_m, zone.max_m].map(|[x, y]| format!("[{x}, {y}]"));
        let is_corner = |corner: [f64; 2]| !corner.iter().any(|x| x.is_nan());
        let expected = "two numbers, east and north of the middle of the region";
        let is_min = that(is_corner(zone.min_m), "min_m", &min, expected);
        let is_max = that(is_corner(zone.max_m), "max_m", &max, expected);
        let expected = format!("a corner to the north-east of min_m = {min}");
        if is_min && is_max && that(west < east && south < north, "max_m", &max, &expected) {
            let meets = west < half[0] && east > -half[0] && south < half[1] && north > -half[1];
            let expected =
                format!("a rectangle that meets the region, +-{} m x +-{} m", half[0], half[1]);
            that(meets, "min_m", &min, &expected);
        }
        let (from_s, until_s) = (zone.from_s, zone.until_s);
        let path = |name: &str| format!("pose.denied[{index}].{name}");
        if check.begins(&path("from_s"), from_s, &scenario.run, "the zone has no effect") {
            let expected = format!("a time after from_s = {from_s} s, or inf");
            check.at(until_s > from_s, &path("until_s"), &until_s, &expected);
        }
    }
}

/// Warns of fixes that come at other times than those that are asked for, and of zones without fixes that matter less
/// than somebody may think.
fn gaps(check: &mut Check, pose: &ObserverModel, period_s: Option<f64>) {
    let fix_s = pose.fix_period_s;
    if let Some(period_s) = period_s.filter(|_| fix_s > 0.0) {
        let periods = fix_s / period_s;
        if periods.round() < 1.0 || (periods - periods.round()).abs() > 1e-6 {
            let text = format!(
                "`pose.fix_period_s` = {fix_s} s is no multiple of run.period_s = {period_s} s"
            );
            let help = "a fix comes with the first frame at or after each multiple of it";
            check.warn(&["pose.fix_period_s", "run.period_s"], Mistake::new(text).help(help));
        }
    }
    if !pose.denied.is_empty() && pose.error == [0.0; 6] {
        let text = match pose.drift > 0.0 {
            true => "outside `pose.denied` poses are exact: pose.error is 0",
            false => "`pose.denied` has no effect: pose.error and pose.drift are 0",
        };
        let mistake = Mistake::new(text).expected("pose.error with the bounds of fixes");
        check.warn(&["pose.denied", "pose.error", "pose.drift"], mistake);
    }
}

/// What errors of this size do to the camera and to the margins.
fn limits(check: &mut Check, scenario: &Scenario, pose: &ObserverModel) {
    let [x, y, z, .., yaw] = pose.error;
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
    let [lowest_m, _] = altitudes(&scenario.agents);
    let expected =
        format!("a third number, the error of the height, below the lowest altitude, {lowest_m} m");
    // Altitudes that are no heights are refused elsewhere.
    let is_underground = z >= lowest_m && lowest_m > 0.0;
    check.that(!is_underground, &["pose.error", "agents.altitude_m"], &got, &expected);
    let expected = format!("a sixth number, the error of the yaw, up to {MOST_YAW_DEG} degrees");
    check.that(yaw <= MOST_YAW_DEG, &["pose.error"], &got, &expected);
    if x.max(y) <= widest_m && z < lowest_m && yaw <= MOST_YAW_DEG {
        clear_ground(check, scenario, pose);
    }
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

/// Refuses errors with which a frame proves no clear ground although the reported pose is exact: then this holds for
/// half of the frames at least. Warns if it may only be so where the reported pose errs, too.
fn clear_ground(check: &mut Check, scenario: &Scenario, pose: &ObserverModel) {
    const EXACT: [[f64; 2]; 1] = [[0.0, 0.0]];
    const WORST: [[f64; 2]; 4] = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let camera = CameraModel { misidentify: 0.0, ..scenario.camera };
    if !camera::judge(&mut Check(Vec::new()), &camera) {
        return;
    }
    let altitudes_m = altitudes(&scenario.agents);
    let mut looks = altitudes_m.map(|altitude_m| Look::new(&camera, scenario, altitude_m));
    // The altitude of the first UAV whose frame proves nothing.
    let mut lost_m = |error: &PoseError, reports: &[[f64; 2]]| {
        let is_lost = |look: &mut Look| reports.iter().any(|shares| !look.proves(error, *shares));
        looks.iter_mut().position(is_lost).map(|index| altitudes_m[index])
    };
    let keys = ["pose.error", "camera.tilt_deg", "camera.d_max_m", "agents.altitude_m"];
    let error = pose.half_widths();
    if lost_m(&PoseError::NONE, &EXACT).is_some() {
        // The camera sees no ground, which is told elsewhere.
    } else if let Some(altitude_m) = lost_m(&error, &EXACT) {
        let expected = format!(
            "smaller errors, or a camera that sees less far: at {altitude_m} m altitude, even over open ground and with \
             an exact report of the pose, a frame proves no clear ground"
        );
        check.that(false, &keys, &format!("{:?}", pose.error), &expected);
    } else if let Some(altitude_m) = lost_m(&error, &WORST) {
        let text = format!(
            "with this `pose.error`, some frames at {altitude_m} m altitude prove no clear ground, even over open ground"
        );
        let expected = "smaller errors of roll and pitch, or a camera that sees less far";
        check.warn(&keys, Mistake::new(text).expected(expected));
    }
}

/// A level UAV over open ground, and what its agent makes of its frame.
struct Look {
    sensor: Sensor,
    frame: Frame,
}

impl Look {
    /// At the border of the region, looking out, with fewer pixels than the camera has.
    fn new(camera: &CameraModel, scenario: &Scenario, altitude_m: f64) -> Self {
        let scale = (f64::from(COLUMNS) / f64::from(camera.columns)).min(1.0);
        let scaled = |pixels: u16| ((f64::from(pixels) * scale) as u16).max(1);
        let (columns, rows) = (scaled(camera.columns), scaled(camera.rows));
        let camera = CameraModel { columns, rows, ..*camera };
        let mut config = AgentConfig { camera, ..Scenario::default().agent_config() };
        config.ground.size_m = [2.0 * MAX_COORDINATE_M; 2];
        config.estimator.raster_cell_m = CELL_M;
        config.estimator.outline_tolerance_px = 0.0;
        let east_m = 0.5 * scenario.map.size_m[0];
        let pose = Pose::level([east_m, 0.0, altitude_m], 0.0);
        let view = camera.at(&pose);
        let is_ground = |c: u16, r: u16| {
            let ground = view.ground_point(c.into(), r.into());
            let distance_m = |[x, y]: [f64; 2]| (x - east_m).hypot(y).hypot(altitude_m);
            ground.is_some_and(|ground| distance_m(ground) <= camera.d_max_m)
        };
        let label = |(c, r)| {
            let corners = [(c, r), (c + 1, r), (c, r + 1), (c + 1, r + 1)];
            let is_all = corners.into_iter().all(|(c, r)| is_ground(c, r));
            if is_all { Label::Ground } else { Label::Unknown }
        };
        let pixels = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r)));
        let labels: Vec<Label> = pixels.map(label).collect();
        let frame = Frame::of_detector(Step(0), pose, None);
        let frame = Frame { depth: vec![0; labels.len()], labels, ..frame };
        Self { sensor: Sensor::new(&config), frame }
    }

    /// Whether its frame proves clear ground with this box about a pose that is reported as turned by these shares of
    /// the bounds of roll and pitch.
    fn proves(&mut self, error: &PoseError, [roll, pitch]: [f64; 2]) -> bool {
        let pose = Pose {
            roll_rad: roll * error.roll_rad,
            pitch_rad: pitch * error.pitch_rad,
            ..self.frame.pose
        };
        let frame = Frame { pose, pose_error: *error, ..self.frame.clone() };
        !self.sensor.measure(&frame).clear_ground.region().is_empty()
    }
}
