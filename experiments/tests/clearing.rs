//! Road clearing from outside: one process and many, keys and mistakes.

mod common;

use common::docs::root;
use common::shipped::{Key, Shipped, check_places};
use common::{csat, read, scratch, text};
use serde_json::Value;

/// `clearing` in a small region with fewer UAVs.
const SMALL: Shipped = Shipped {
    name: "clearing",
    sets: &[
        "map.size_m=[240, 240]",
        "map.road_spacing_m=75",
        "agents.count=5",
        "run.duration_s=60",
    ],
};

const LOSSY: [&str; 2] = [
    "netem.hbsr.loss={model=\"iid\",p=0.6}",
    "netem.hbsr.delay={model=\"uniform\",mean_s=1,spread_s=1}",
];

#[test]
fn a_run_has_the_numbers_and_pictures_of_the_clearing() {
    let base = scratch();
    let summary = SMALL.flown(base.path(), "run", "out", &["run.duration_s=400"]);
    assert_eq!((&summary["mission"], &summary["agents"]), (&"clearing".into(), &5.into()));
    assert_eq!((&summary["violations"], &summary["inconsistencies"]), (&0.into(), &0.into()));
    for key in ["cleared_pct", "cleared_by_uav_pct", "path_m", "contaminated_pct"] {
        assert!(summary[key].is_f64(), "{key}: {summary}");
    }
    for key in ["cleaners_max", "splits", "encounters", "merges"] {
        assert!(summary[key].is_u64(), "{key}: {summary}");
    }
    let searchers = |key: &str| summary[key].as_u64().unwrap_or_else(|| panic!("{key}: {summary}"));
    for kind in ["edge", "node"] {
        let [least, most] =
            ["least", "most"].map(|bound| searchers(&format!("{kind}_search_at_{bound}")));
        assert!(1 <= least && least <= most && most <= 6, "{kind}: {least} to {most}");
    }
    assert!(summary["cleared_s"].is_f64(), "{summary}");
    assert!(summary["cleared_pct"].as_f64() >= Some(99.5), "{summary}");
    assert_eq!((&summary["stalled"], &summary["lost"]), (&false.into(), &false.into()));
    assert!(summary["checked"]["cleared"]["checks"].as_u64() > Some(100_000), "{summary}");
    assert!(summary.get("unexplored_pct").is_none(), "a number of another mission");
    let map = read(&base.path().join("out/map.svg"));
    assert!(map.contains("road that it has cleared so far"), "{map}");
    assert!(read(&base.path().join("out/metrics.svg")).contains("Cleared share of the roads"));
}

/// The map of docs/concepts/clearing.md.
#[test]
fn the_rear_end_of_a_road_that_joins_later_leaks_by_the_rules_of_the_paper() {
    let base = scratch();
    let map = format!("map.file={:?}", root().join("docs/concepts/rear-end.geojson"));
    let town = [&map, "map.kind=geojson", "map.size_m=[400, 200]", "agents.count=1"];
    for (rules, code) in [("paper", 3), ("acknowledged", 0)] {
        let rules = format!("clearing.rules={rules}");
        let sets = [&town[..], &[&rules, "run.duration_s=260"]].concat();
        let sets = sets.into_iter().flat_map(|set| ["--set", set]);
        let arguments: Vec<&str> = ["run", "clearing"].into_iter().chain(sets).collect();
        let output = csat(base.path(), &arguments);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{rules}: {told}");
        let leak = "a road called cleared that is contaminated";
        assert_eq!(told.contains(leak), code == 3, "{rules}: {told}");
    }
}

#[test]
fn processes_clear_the_same_roads() {
    let crash = "netem.outage=[{agent=1,from_s=8,until_s=12,kind=\"crash\"}]";
    let storm = [LOSSY[0], LOSSY[1], "netem.hbsr.range_m=90", crash];
    let cases: [(&str, &[&str]); 2] = [("perfect", &[]), ("storm", &storm)];
    SMALL.is_the_same_in_processes(
        &cases,
        &["digest", "messages", "checked", "cleared_pct", "splits"],
    );
}

/// A key, and the values of others with which it has an effect.
const KEYS: [Key; 30] = [
    ("clearing.give=\"paper\"", &["seed=2", "run.duration_s=200"]),
    ("clearing.guard_px=16", &[]),
    (
        "netem.lblr.bearing_error_deg=60",
        &["netem.hbsr.range_m=10", "netem.lblr.bearing_error_deg=0"],
    ),
    ("clearing.coding=\"bitmap\"", &["netem.hbsr.rate={bytes_s=20000,burst_bytes=9000}"]),
    ("clearing.margin_px=30", &[]),
    ("clearing.step_m=0.1", &[]),
    ("clearing.spacing_m=15", &[]),
    ("clearing.lost_after_s=5", &["netem.outage=[{agent=0,from_s=8,until_s=60,kind=\"crash\"}]"]),
    ("clearing.beat_period_s=1", &[]),
    ("clearing.safe_period_s=3", &[]),
    ("clearing.call_period_s=2", &["netem.hbsr.range_m=60"]),
    ("clearing.max_age_s=0.5", &LOSSY),
    ("odometry.jitter_m=0", &[]),
    ("odometry.drift_share=0", &[]),
    ("segmentation.gap_px=0", &["segmentation.gap_share=0"]),
    ("segmentation.gap_share=0.3", &[]),
    ("segmentation.edge_share=0.5", &[]),
    ("segmentation.speckle_share=0.01", &[]),
    ("agents.multirotor.motion_error_m=0.05", &[]),
    ("agents.speed_m_s=2", &[]),
    ("agents.altitude_m=65", &[]),
    ("agents.count=4", &[]),
    ("camera.aperture_deg=75", &[]),
    ("map.road_spacing_m=110", &[]),
    ("map.desert.loop_share=0.6", &[]),
    ("map.desert.dead_end_share=0.8", &[]),
    ("map.kind=\"generated\"", &[]),
    ("netem.hbsr.range_m=20", &[]),
    ("netem.hbsr.offset_error_m=0", &[]),
    ("netem.lblr.range_m=400", &["clearing.allow_short_lblr=true", "netem.lblr.range_m=5"]),
];

/// What a key can change: what agents know, and what they say and hear.
fn traces(summary: &Value) -> [Value; 3] {
    ["digest", "messages", "bytes_sent"].map(|key| summary[key].clone())
}

#[test]
fn every_key_has_an_effect() {
    SMALL.every_key_changes(&KEYS, traces);
    let base = scratch();
    // A UAV alone cannot split its frontier.
    let alone = ["agents.count=1", "run.duration_s=200"];
    for (patience_s, is_stalled) in [("1", true), ("1000", false)] {
        let patience = format!("clearing.patience_s={patience_s}");
        let summary =
            SMALL.flown(base.path(), "run", patience_s, &[&alone[..], &[&patience]].concat());
        assert_eq!(summary["stalled"], is_stalled, "{patience}");
    }
    // The rules of the paper leak, which is a violation.
    let paper = ["clearing.rules=\"paper\"", "run.duration_s=200"];
    let output = SMALL.ended(base.path(), "run", "paper", &paper);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("a road called cleared that is contaminated"));
    // The radios change places.
    let both = ["netem.lblr.offset_error_m=0.3", "netem.hbsr.range_m=1000"];
    let swapped = ["clearing.hbsr=\"lblr\"", "clearing.lblr=\"hbsr\""];
    let usual = SMALL.flown(base.path(), "run", "usual", &both);
    let other = SMALL.flown(base.path(), "run", "other", &[&both[..], &swapped].concat());
    assert_ne!(usual["digest"], other["digest"]);
}

#[test]
fn all_mistakes_are_told_with_their_places() {
    let scenario = r#"mission = "clearing"
[map]
kind = "open"
[targets]
count = 3
[agents]
count = 0
vehicle = "quadcopter"
altitude_m = 70
altitude_step_m = 2
[camera]
columns = 256
rows = 256
tilt_deg = 45
[clearing]
margin_px = 200
hbsr = "near"
[netem.hbsr]
range_m = 100
[netem.lblr]
range_m = 100
[exchange]
mode = "none"
"#;
    check_places(
        scenario,
        &[
            (3, "`map.kind` cannot be `open`"),
            (5, "`targets.count` cannot be 3"),
            (7, "`agents.count` cannot be 0"),
            (8, "`agents.vehicle` cannot be `quadcopter`"),
            (10, "`agents.altitude_step_m`"),
            (14, "tilt_deg = 90"),
            (17, "the name of a radio"),
            (21, "`netem.lblr.range_m` cannot be 100"),
            (22, "`exchange` belongs to the mission `set-membership`"),
        ],
    );
}

#[test]
fn what_the_method_assumes_is_demanded() {
    let base = scratch();
    let refused = |sets: &[&str], what: &str| {
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let output = csat(base.path(), &[&["check", "clearing"], &sets[..]].concat());
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{sets:?}: {told}");
        assert!(told.contains(what), "{what} in {told}");
    };
    refused(&["map.start_line=[0, 0]"], "expected a point on a road at the region's border");
    refused(&["camera.columns=128", "camera.rows=128"], "condition (1)");
    refused(&["clearing.margin_px=128"], "`clearing.margin_px`");
    refused(&["netem.lblr.range_m=300"], "across the region");
    refused(&["clearing.guard_px=1"], "`clearing.guard_px`");
    refused(&["clearing.rules=3"], "expected one of `acknowledged`, `paper`");
    refused(&["odometry=[0.1, 0.1]"], "`odometry` cannot be a list");
    refused(&["agents.multirotor.motion_error_m=0.2"], "a cleaner cannot keep its place");
    refused(&["netem.hbsr.offset_error_m=1e300"], "no mask is safe");
    refused(&["odometry.jitter_m=-1"], "`odometry.jitter_m`");
    refused(&["agents.speed_m_s=0.5"], "1.414 m/s");
    let roads = r#"{"type":"FeatureCollection","features":[]}"#;
    std::fs::write(base.path().join("none.geojson"), roads).unwrap();
    refused(
        &["map.kind=\"geojson\"", "map.file=\"none.geojson\"", "map.road_spacing_m=95"],
        "map without roads",
    );
}
