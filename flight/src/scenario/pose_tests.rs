//! `[pose]` of the set-membership mission: what is refused, and what is warned of.

use super::tests::{load_with, set_mistake, warning};

const ERROR: &str = "pose.error=[1, 1, 0.1, 0.1, 0.1, 0.1]";

#[test]
fn impossible_values_name_their_key() {
    let finite = "expected six finite half-widths from 0 on: x, y, z in metres";
    let time = "expected at least a hundredth of run.period_s = 0.5 s, and at most 1000000 s";
    for (set, found, expected) in [
        ("pose.error=[1, nan, 0, 0, 0, 0]", "`pose.error` cannot be [1.0, NaN, 0.0", finite),
        ("pose.error=[1, 1, 0, 0, 0, inf]", "`pose.error` cannot be [1.0, 1.0, 0.0", finite),
        ("pose.error=[-1, 1, 0, 0, 0, 0]", "`pose.error` cannot be [-1.0", finite),
        ("pose.time_constant_s=inf", "`pose.time_constant_s` cannot be inf", time),
        ("pose.time_constant_s=nan", "`pose.time_constant_s` cannot be NaN", time),
        ("pose.time_constant_s=0.004", "`pose.time_constant_s` cannot be 0.004", time),
        (
            "pose.fix_period_s=inf",
            "`pose.fix_period_s` cannot be inf",
            "a time from 0 to 1000000 s",
        ),
        ("pose.drift=1", "`pose.drift` cannot be 1", "a share of the path, from 0 to below 1"),
        ("pose.drift=nan", "`pose.drift` cannot be NaN", "from 0 to below 1"),
    ] {
        let said = set_mistake(&[set]);
        assert!(said.contains(found) && said.contains(expected), "{set}: {said}");
    }
}

#[test]
fn a_zone_that_cannot_be_is_blamed_on_the_value_that_is_wrong() {
    for (zone, key, found, expected) in [
        ("min_m=[nan,0],max_m=[1,1]", "min_m", "[NaN, 0]", "two numbers, east and north"),
        ("min_m=[0,0],max_m=[1,nan]", "max_m", "[1, NaN]", "two numbers, east and north"),
        ("min_m=[5,0],max_m=[1,1]", "max_m", "[1, 1]", "to the north-east of min_m = [5, 0]"),
        ("min_m=[300,0],max_m=[400,1]", "min_m", "[300, 0]", "meets the region, +-250 m x +-250 m"),
        ("min_m=[0,0],max_m=[1,1],from_s=-1", "from_s", "-1", "a time from 0 to 1000000 s"),
        ("min_m=[0,0],max_m=[1,1],from_s=nan", "from_s", "NaN", "a time from 0 to 1000000 s"),
        ("min_m=[0,0],max_m=[1,1],until_s=nan", "until_s", "NaN", "after from_s = 0 s, or inf"),
        ("min_m=[0,0],max_m=[1,1],from_s=5,until_s=5", "until_s", "5", "after from_s = 5 s"),
    ] {
        let said = set_mistake(&[ERROR, &format!("pose.denied=[{{{zone}}}]")]);
        let start = format!("error: `pose.denied[0].{key}` cannot be {found}\n");
        assert!(said.starts_with(&start) && said.contains(expected), "{zone}: {said}");
    }
}

/// Whatever else is wrong, `[pose]` is judged.
#[test]
fn mistakes_elsewhere_hide_none_of_a_pose() {
    let sets = [
        "camera.misidentify=1.5",
        "exchange.liars=9",
        "agents.count=0",
        "pose.error=[0, 0, 99, 0, 0, 60]",
        "pose.drift=2",
    ];
    let mistakes = load_with("city", &sets).unwrap_err().mistakes;
    let said: String = mistakes.iter().map(ToString::to_string).collect();
    for part in [
        "`camera.misidentify` cannot be 1.5",
        "`exchange.liars` cannot be 9",
        "`agents.count` cannot be 0",
        "below the lowest altitude, 52 m",
        "the error of the yaw, up to 57 degrees",
        "`pose.drift` cannot be 2",
    ] {
        assert!(said.contains(part), "{part} in {said}");
    }
    assert_eq!(mistakes.len(), 6, "{said}");
}

/// What is said of errors with which frames prove no clear ground, of a city with a camera of another tilt.
fn told_of_clear_ground(tilt_deg: u32, error: &str) -> &'static str {
    // A coarse camera is warned of, too.
    let sets = [&format!("camera.tilt_deg={tilt_deg}"), &format!("pose.error={error}")];
    match load_with("city", &sets.map(String::as_str)) {
        Ok(loaded) if loaded.warnings.iter().any(|w| w.message.contains("no clear ground")) => {
            "warned"
        }
        Ok(_) => "fine",
        Err(_) => "refused",
    }
}

#[test]
fn errors_with_which_frames_prove_nothing_are_told() {
    let some = warning(&["pose.error=[0, 0, 0, 0, 6.5, 0]"]);
    let start = "warning: with this `pose.error`, some frames at 52 m altitude prove no clear ground, even over \
                 open ground\n";
    assert!(some.starts_with(start), "{some}");
    let most = set_mistake(&["pose.error=[0, 0, 0, 0, 13, 0]"]);
    assert!(most.contains("at 52 m altitude, even over open ground and with an exact"), "{most}");
    for (error, told) in [
        ("[0, 0, 0, 2.9, 2.9, 0]", "fine"),
        ("[0, 0, 0, 5, 5, 0]", "warned"),
        // A roll lifts a corner of the image by less than its own angle.
        ("[0, 0, 0, 12, 0, 0]", "fine"),
        // No ground is in the image at all yaws, or from all places.
        ("[0, 0, 0, 0, 0, 40]", "refused"),
        ("[300, 300, 0, 0, 0, 0]", "refused"),
    ] {
        assert_eq!(told_of_clear_ground(30, error), told, "{error}");
    }
}

/// With the horizon in the image, the farthest ground is that at `d_max`: 10 degrees below the horizon at 52 m.
#[test]
fn the_farthest_ground_counts_and_not_the_image() {
    for tilt_deg in [10, 20] {
        for (error, told) in [
            ("[1, 1, 0.1, 0.1, 0.1, 0.1]", "fine"),
            ("[0, 0, 0, 0, 4.5, 0]", "fine"),
            ("[0, 0, 0, 0, 5.1, 0]", "warned"),
            ("[0, 0, 0, 0, 10, 0]", "refused"),
        ] {
            assert_eq!(told_of_clear_ground(tilt_deg, error), told, "{tilt_deg}: {error}");
        }
    }
    assert_eq!(told_of_clear_ground(90, "[0, 0, 0, 10, 10, 0]"), "fine");
    // A camera that sees to the end of the grid.
    let far =
        set_mistake(&["camera.tilt_deg=15", "camera.d_max_m=6000", "pose.error=[1,1,0,0,0,0]"]);
    assert!(far.contains("a camera that sees less far"), "{far}");
}

#[test]
fn fixes_between_frames_are_a_warning() {
    let said = warning(&[ERROR, "pose.fix_period_s=0.7"]);
    let start = "warning: `pose.fix_period_s` = 0.7 s is no multiple of run.period_s = 0.5 s\n";
    assert!(said.starts_with(start), "{said}");
    assert!(said.contains("a fix comes with the first frame at or after each multiple"), "{said}");
    assert!(
        warning(&[ERROR, "pose.fix_period_s=1e-9"]).starts_with("warning: `pose.fix_period_s`")
    );
    assert_eq!(warning(&[ERROR, "pose.fix_period_s=1.5"]), "");
    let tenths = ["run.period_s=0.1", "guidance.plan_timeout_s=0", ERROR, "pose.fix_period_s=0.3"];
    assert_eq!(warning(&tenths), "");
}

#[test]
fn zones_without_errors_are_a_warning() {
    const ZONE: &str = "pose.denied=[{min_m=[0,0],max_m=[9,9]}]";
    let said = warning(&[ZONE]);
    assert!(said.starts_with("warning: outside `pose.denied` poses are exact: pose.error is 0\n"));
    let said = warning(&[ZONE, "pose.drift=0"]);
    let start = "warning: `pose.denied` has no effect: pose.error and pose.drift are 0\n";
    assert!(said.starts_with(start), "{said}");
    assert_eq!(warning(&[ZONE, ERROR]), "");
}

#[test]
fn a_zone_lacks_both_corners() {
    let said = set_mistake(&["pose.denied=[{}]"]);
    assert!(
        said.starts_with("error: `pose.denied[0]` lacks the keys `min_m`, `max_m`\n"),
        "{said}"
    );
}

#[test]
fn a_zone_after_the_end_has_no_effect() {
    let zone = "pose.denied=[{min_m=[0,0],max_m=[1,1],from_s=6}]";
    let said = warning(&[ERROR, zone, "run.duration_s=5"]);
    let start = "warning: `pose.denied[0].from_s` = 6 s is after the mission's end, 5 s\n";
    assert!(said.starts_with(start) && said.contains(" = the zone has no effect\n"), "{said}");
    assert_eq!(warning(&[ERROR, zone, "run.duration_s=6"]), "");
}

/// A list that is too long by one among thousands is found soon.
#[test]
fn the_wrong_element_of_a_long_list_is_named() {
    let numbers = vec!["0.0"; 3000].join(",");
    let said = set_mistake(&[&format!("agents.start=[{numbers}]")]);
    assert!(said.starts_with("error: `agents.start[0]` cannot be "), "{said}");
}
