//! Liars from outside: one process and many, what keys change, what a run tells of them, and mistakes.

mod common;

use common::shipped::{Key, Shipped, check_places, digest};
use common::{csat, read, scratch, text};

/// `city`, small, with four UAVs.
const SMALL: Shipped = Shipped {
    name: "city",
    sets: &[
        "run.duration_s=30",
        "map.size_m=[150, 150]",
        "camera.columns=96",
        "camera.rows=72",
        "camera.min_pixels=1",
        "targets.count=4",
    ],
};

const ALLOWED: &str = "exchange.liars=1";
const LIAR: &str = "faults.liar=[{agent=2,from_s=5,kind=\"phantom\"}]";

#[test]
fn processes_fly_the_same_mission_with_a_liar() {
    let cases: [(&str, &[&str]); 2] = [
        ("liar", &[ALLOWED, LIAR]),
        ("mistaken", &[ALLOWED, "camera.misidentify=0.02", "run.duration_s=12"]),
    ];
    SMALL.is_the_same_in_processes(&cases, &["digest", "messages", "checked", "liars"]);
}

#[test]
fn a_run_tells_who_lied_who_named_it_and_when() {
    let base = scratch();
    let summary = SMALL.flown(base.path(), "run", "out", &[ALLOWED, LIAR]);
    assert_eq!((&summary["violations"], &summary["false_agents"]), (&0.into(), &1.into()));
    let liar = &summary["liars"][0];
    assert_eq!(liar["agent"], 2, "{summary}");
    assert!(liar["first_s"].as_f64() >= Some(5.0) && liar["named_by"].is_array(), "{liar}");
    assert!(summary["checked"]["accusation"]["checks"].as_u64() > Some(0), "{summary}");
    assert!(summary["messages"]["rejected"]["liar"].as_u64() > Some(0), "{summary}");
    let events = read(&base.path().join("out/events.jsonl"));
    assert!(events.contains("\"event\":\"liar\""), "{events}");
    let metrics = read(&base.path().join("out/metrics.csv"));
    assert!(metrics.lines().next().is_some_and(|head| head.contains(",liars_named,")));
    let again =
        csat(base.path(), &["run", "out/scenario.resolved.toml", "--json", "--out", "again"]);
    let again: serde_json::Value = serde_json::from_slice(&again.stdout).expect("a summary");
    assert_eq!(again["digest"], summary["digest"]);
}

/// More liars than are allowed for: what they break is counted, and the run fails.
#[test]
fn who_allows_for_no_liar_is_told_of_violations() {
    let base = scratch();
    let output = SMALL.ended(base.path(), "run", "out", &[LIAR]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a summary");
    assert!(summary["violations"].as_u64() > Some(0), "{summary}");
}

/// A key, and the values of others with which it has an effect.
const KEYS: [Key; 5] = [
    (ALLOWED, &[]),
    ("faults.liar=[{agent=1,kind=\"clear\"}]", &[ALLOWED]),
    ("faults.liar=[{agent=3,from_s=5,kind=\"phantom\"}]", &[ALLOWED, LIAR]),
    ("faults.liar=[{agent=2,from_s=8,kind=\"phantom\"}]", &[ALLOWED, LIAR]),
    ("faults.liar=[{agent=2,from_s=5,kind=\"misidentify\"}]", &[ALLOWED, LIAR]),
];

#[test]
fn every_key_has_an_effect() {
    SMALL.every_key_changes(&KEYS, digest);
    let base = scratch();
    // Mistakes may break the guarantee of the others.
    let ended = |out: &str, sets: &[&str]| {
        let output = SMALL.ended(base.path(), "run", out, sets);
        digest(&serde_json::from_slice(&output.stdout).expect("a summary"))
    };
    assert_ne!(ended("exact", &[]), ended("mistaken", &["camera.misidentify=0.1"]));
}

#[test]
fn all_mistakes_are_told_with_their_places() {
    let base = scratch();
    let scenario = r#"[agents]
count = 3
[targets]
count = 1
[[stations]]
x_m = 0
y_m = 0
z_m = 80
[camera]
misidentify = 1.5
[exchange]
liars = 3
[[faults.liar]]
agent = 3
kind = "clear"
[[faults.liar]]
agent = 0
from_s = -1
kind = "phantom"
[[faults.liar]]
agent = 0
from_s = inf
kind = "misidentify"
"#;
    check_places(
        scenario,
        &[
            (10, "`camera.misidentify` cannot be 1.5"),
            (12, "fewer liars than UAVs, agents.count = 3"),
            (14, "below agents.count = 3: stations see nothing"),
            (18, "`faults.liar[1].from_s` cannot be -1"),
            (21, "each UAV once"),
            (22, "`faults.liar[2].from_s` cannot be inf"),
            (23, "2 cars or more"),
        ],
    );
    let set = |scenario: &str, set: &str| {
        let output = csat(base.path(), &["check", scenario, "--set", set]);
        assert_eq!(output.status.code(), Some(2), "{set}");
        text(&output.stderr)
    };
    let unknown = set("city", "faults.liar=[{agent=1,kind=\"bribe\"}]");
    assert!(unknown.contains("`clear`") && unknown.contains("`phantom`"), "{unknown}");
    let whole = set("city", "exchange.liars=0.5");
    assert!(whole.contains("a whole number, fewer than agents.count"), "{whole}");
    let negative = set("city", "exchange.liars=-1");
    assert!(negative.contains("a whole number, fewer than agents.count"), "{negative}");
    let other = set("tisdale", "faults.liar=[{agent=1,kind=\"clear\"}]");
    assert!(other.contains("`faults` belongs to the mission `set-membership`"), "{other}");
    let nameless = set("tisdale", "camera.misidentify=0.1");
    assert!(nameless.contains("identify no targets"), "{nameless}");
    let key = set("clearing", "exchange.liars=1");
    assert!(key.contains("liars") || key.contains("exchange"), "{key}");
}
