//! Poses that are known to a box: `[pose]` of the set-membership mission.

mod common;

use common::shipped::{Key, Shipped, check_places, digest};
use common::{csat, scratch, text};

const SMALL: Shipped = Shipped {
    name: "city",
    sets: &[
        "run.duration_s=20",
        "map.size_m=[200, 200]",
        "agents.count=2",
        "targets.count=3",
        "camera.columns=120",
        "camera.rows=90",
        "camera.min_pixels=1",
        "pose.error=[1, 2, 0.1, 0.2, 0.2, 1]",
    ],
};

const JAMMED: &str = "pose.denied=[{min_m=[-100, -100], max_m=[100, 100], from_s=5, until_s=15}]";

#[test]
fn every_key_has_an_effect() {
    const KEYS: [Key; 9] = [
        ("pose.error=[0, 0, 0, 0, 0, 0]", &[]),
        ("pose.error=[1, 2, 0.1, 0.2, 0.2, 1.5]", &[]),
        ("pose.time_constant_s=4", &[]),
        ("pose.fix_period_s=5", &[]),
        ("pose.drift=0.2", &[]),
        (JAMMED, &[]),
        ("pose.denied=[{min_m=[-100, -100], max_m=[100, 0], from_s=5, until_s=15}]", &[JAMMED]),
        ("pose.denied=[{min_m=[-100, -100], max_m=[100, 100], from_s=9, until_s=15}]", &[JAMMED]),
        ("pose.denied=[{min_m=[-100, -100], max_m=[100, 100], from_s=5, until_s=12}]", &[JAMMED]),
    ];
    SMALL.every_key_changes(&KEYS, digest);
}

#[test]
fn a_box_without_width_is_no_box() {
    let base = scratch();
    let none = ["pose.error=[0, 0, 0, 0, 0, 0]"];
    let usual = SMALL.flown(base.path(), "run", "usual", &none);
    let idle = ["pose.time_constant_s=3", "pose.drift=0.3"];
    let other = SMALL.flown(base.path(), "run", "other", &[&none[..], &idle].concat());
    assert_eq!(digest(&usual), digest(&other));
}

#[test]
fn one_process_and_many_come_to_the_same() {
    const LOSSY: &str = "netem.radio.loss={model=\"iid\", p=0.3}";
    let cases: [(&str, &[&str]); 2] =
        [("perfect", &[]), ("lossy", &[LOSSY, "netem.radio.range_m=90", "pose.fix_period_s=4"])];
    SMALL.is_the_same_in_processes(&cases, &["digest", "violations", "unexplored_pct"]);
}

#[test]
fn all_mistakes_are_told_with_their_places() {
    let scenario = r#"
[pose]
error = [1, -1, 0, 0, 0, 0]
time_constant_s = 0
fix_period_s = -2
drift = 1.5
[[pose.denied]]
min_m = [900, 0]
max_m = [950, 10]
[[pose.denied]]
min_m = [10, 0]
max_m = [0, 10]
from_s = 5
until_s = 5
"#;
    let places = [
        (3, "six finite half-widths from 0 on"),
        (4, "`pose.time_constant_s` cannot be 0"),
        (5, "`pose.fix_period_s` cannot be -2"),
        (6, "`pose.drift` cannot be 1.5"),
        (8, "`pose.denied[0].min_m` cannot be [900, 0]"),
        (12, "`pose.denied[1].max_m` cannot be [0, 10]"),
        (14, "`pose.denied[1].until_s` cannot be 5"),
    ];
    check_places(scenario, &places);
}

#[test]
fn boxes_that_are_too_large_are_refused_with_the_value_at_which_they_are() {
    let base = scratch();
    for (sets, what) in [
        (&["pose.error=[0, 0, 0, 0, 13, 0]"][..], "a frame proves no clear ground"),
        (&["pose.error=[1e300, 1, 0, 0, 0, 0]"], "up to 500 m, the longer side of the region"),
        (&["pose.error=[0, 0, 0, 0, 0, 60]"], "up to 57 degrees"),
        (&["pose.error=[0, 0, 52, 0, 0, 0]"], "below the lowest altitude, 52 m"),
        (
            &["pose.error=[1, 0, 0, 0, 0, 0]", "agents.avoid_buildings=true"],
            "`agents.avoid_buildings` cannot be true where poses are not exact",
        ),
    ] {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let arguments: Vec<&str> = ["check", "city"].into_iter().chain(sets).collect();
        let output = csat(base.path(), &arguments);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(what), "{what} in {told}");
    }
    let wide = csat(base.path(), &["check", "city", "--set", "pose.error=[1.5, 1.5, 0, 0, 0, 0]"]);
    let told = text(&wide.stderr);
    assert_eq!(wide.status.code(), Some(0), "{told}");
    assert!(told.contains("less than 1.875 m together"), "{told}");
}
