//! `[targets]`.

use csat_proto::model::{Driving, TargetsModel};

use super::Check;

/// Judges `[targets]`.
pub(super) fn judge(check: &mut Check, targets: &TargetsModel) {
    check.whole("targets.count", targets.count);
    check.that(
        targets.tracks.is_none() || targets.driving == Driving::Roads,
        &["targets.driving", "targets.tracks"],
        &format!("`{}` with targets.tracks", name(targets.driving)),
        "no such key: cars follow their tracks",
    );
    let v_max = targets.v_max_m_s;
    let holds = (0.0..=100.0).contains(&v_max);
    check.that(holds, &["targets.v_max_m_s"], &v_max.to_string(), "a speed from 0 to 100 m/s");
    walk(check, targets);
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
    body(check, targets);
}

/// The walk matters to targets that walk.
fn walk(check: &mut Check, targets: &TargetsModel) {
    const KEY: &str = "targets.walk_m_sqrt_s";
    let (walk, is_sound) = (targets.walk_m_sqrt_s, targets.walk_m_sqrt_s >= 0.0);
    check.not_negative(KEY, walk);
    if is_sound && targets.driving != Driving::RandomWalk {
        let why = format!("with targets.driving = \"{}\"", name(targets.driving));
        let usual = TargetsModel::default().walk_m_sqrt_s;
        check.unused(&[KEY, "targets.driving"], [walk, usual], &why);
    }
}

/// The name of a way of driving in a scenario.
fn name(driving: Driving) -> &'static str {
    match driving {
        Driving::Roads => "roads",
        Driving::Evasive => "evasive",
        Driving::Static => "static",
        Driving::RandomWalk => "random-walk",
    }
}

fn body(check: &mut Check, targets: &TargetsModel) {
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
