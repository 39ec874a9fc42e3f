//! `[camera]`.

use csat_proto::camera::{CameraModel, CameraView};
use csat_proto::model::FleetModel;

use super::fleet::altitudes;
use super::{Check, Issue, MAX_PIXELS, Scenario, owned};
use crate::scenario::camera_check::car_coverage;
use crate::scenario::mistake::Mistake;

/// Steps of depth that are told no finer than this are warned of, metres.
const COARSE_DEPTH_M: f64 = 0.1;

/// Judges what every mission has of `[camera]`; tells whether nothing is wrong with it.
pub(super) fn judge(check: &mut Check, camera: &CameraModel) -> bool {
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
    check.whole("camera.min_pixels", camera.min_pixels);
    let [lo, hi] = camera.depth_noise;
    check.that(
        lo > -1.0 && lo <= 0.0 && hi >= 0.0 && hi.is_finite(),
        &["camera.depth_noise"],
        &format!("[{lo}, {hi}]"),
        "an interval around 0 that begins above -1",
    );
    let p = camera.misidentify;
    check.that(
        (0.0..=1.0).contains(&p),
        &["camera.misidentify"],
        &p.to_string(),
        "a probability from 0 to 1",
    );
    check.0.len() == before
}

/// Refuses mistakes of identity in a mission in which cameras do not identify targets.
pub(super) fn judge_nameless(check: &mut Check, scenario: &Scenario) {
    let (p, mission) = (scenario.camera.misidentify, &scenario.mission);
    if (0.0..=1.0).contains(&p) {
        let why = format!("in the mission `{mission}`, whose cameras identify no targets");
        check.unused(&["camera.misidentify"], [p, 0.0], &why);
    }
}

/// Judges a camera whose pixels are labelled: cars to be taken for each other, the steps of its depths, and its pixels
/// on a car if the rest is in order.
pub(super) fn judge_labels(check: &mut Check, scenario: &Scenario, is_in_order: bool) {
    let camera = &scenario.camera;
    let (p, cars) = (camera.misidentify, scenario.targets.count);
    check.that(
        !(p > 0.0 && p <= 1.0) || cars >= 2,
        &["camera.misidentify", "targets.count"],
        &format!("{p} with targets.count = {cars}"),
        "2 cars or more to be taken for each other",
    );
    let depth_step_m = camera.depth_step_m();
    let is_coarse = depth_step_m > COARSE_DEPTH_M && depth_step_m.is_finite();
    if is_coarse {
        let text = format!(
            "depths are told in steps of {depth_step_m:.2} m, a 65535th of `camera.d_max_m`"
        );
        let expected = format!("steps of at most {COARSE_DEPTH_M} m: sets of cars are as coarse");
        check.warn(&["camera.d_max_m"], Mistake::new(text).expected(expected));
    }
    let fleet_ok = altitudes(&scenario.agents).iter().all(|a| *a > 0.0 && a.is_finite());
    if is_in_order && !is_coarse && fleet_ok {
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

/// The least angle below the horizon of a corner of the image, degrees; negative above it.
pub(super) fn least_corner_dip_deg(view: &CameraView) -> f64 {
    let (columns, rows) = (f64::from(view.model().columns), f64::from(view.model().rows));
    let corners = [[0.0, 0.0], [columns, 0.0], [columns, rows], [0.0, rows]];
    let dip = |[c, r]: [f64; 2]| {
        let ray = view.ray_world(c, r);
        (-ray.z / ray.norm()).asin().to_degrees()
    };
    corners.map(dip).into_iter().fold(f64::INFINITY, f64::min)
}
