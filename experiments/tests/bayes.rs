//! The Bayesian search from outside: one process and many, keys and mistakes.

mod common;

use common::shipped::{Key, Shipped, check_places, digest};
use common::{csat, read, scratch, text};

/// `tisdale` over a small region.
const SMALL: Shipped = Shipped {
    name: "tisdale",
    sets: &[
        "map.size_m=[300, 300]",
        "run.duration_s=25",
        "agents.start=[{x_m=-130,y_m=-150,yaw_deg=90},{x_m=130,y_m=-150,yaw_deg=90}]",
    ],
};

/// A target that walks, and radios with which the rest is late or lost.
const WALKING: &str = "targets.driving=\"random-walk\"";
const LATE: &str = "netem.radio.delay={model=\"constant\",mean_s=2}";
const LOSSY: &str = "netem.radio.loss={model=\"iid\",p=0.5}";
const SNAPSHOT: &str = "exchange.mode=\"snapshot\"";
const PARTICLES: &str = "belief.kind=\"particles\"";
const LAWNMOWER: &str = "guidance.criterion=\"lawnmower\"";
const WAYPOINTS: &str = "guidance.criterion=\"waypoints\"";

#[test]
fn a_run_has_the_numbers_and_pictures_of_the_search() {
    let base = scratch();
    let summary = SMALL.flown(base.path(), "run", "out", &[]);
    assert_eq!((&summary["mission"], &summary["agents"]), (&"bayes".into(), &2.into()));
    for key in ["localization_error_m", "sigma_m", "cumulative_detection", "factors_held_pct"] {
        assert!(summary[key].is_f64(), "{key}: {summary}");
    }
    assert!(summary["in_95_region"].is_boolean() && summary.get("first_detection_s").is_some());
    assert!(summary["checked"]["posterior"]["checks"].as_u64() > Some(200), "{summary}");
    assert_eq!((&summary["violations"], &summary["inconsistencies"]), (&0.into(), &0.into()));
    assert!(summary.get("unexplored_pct").is_none(), "a number of another mission");
    let map = read(&base.path().join("out/map.svg"));
    assert!(map.contains("where the target may be") && !map.contains("building, darker"), "{map}");
    assert!(read(&base.path().join("out/metrics.svg")).contains("probability of detection"));
}

#[test]
fn processes_fly_the_same_search() {
    let crash = "netem.outage=[{agent=1,from_s=8,until_s=12,kind=\"crash\"}]";
    let storm = ["netem.radio.range_m=150", LOSSY, LATE, crash];
    let cases: [(&str, &[&str]); 4] = [
        ("perfect", &[]),
        ("storm", &storm),
        ("particles", &[PARTICLES, WALKING]),
        ("snapshot", &[SNAPSHOT, "belief.kind=\"grid\"", LOSSY]),
    ];
    SMALL.is_the_same_in_processes(
        &cases,
        &["digest", "messages", "checked", "sigma_m", "detections"],
    );
}

/// A key, and the values of others with which it has an effect.
const KEYS: [Key; 44] = [
    ("belief.kind=\"grid\"", &[]),
    ("belief.cell_m=30", &[]),
    ("belief.min_cell_m=4", &["run.duration_s=40"]),
    ("belief.particles=900", &[PARTICLES]),
    ("belief.process_noise_m=3", &[PARTICLES]),
    ("belief.lag_s=0.5", &[WALKING, LATE]),
    ("detector.p_detection=0.6", &[]),
    ("detector.p_false=0.03", &[]),
    ("detector.detected_resolution=[60, 38]", &[]),
    ("detector.missed_resolution=[60, 70]", &[]),
    ("exchange.mode=\"none\"", &[]),
    ("exchange.fusion=\"product\"", &[SNAPSHOT]),
    ("exchange.snapshot_period_s=5", &[SNAPSHOT]),
    ("exchange.repair_period_s=6", &[LOSSY]),
    ("exchange.repair_delay_s=8", &[LOSSY]),
    ("exchange.budget_bytes_s=90", &[]),
    ("exchange.max_age_s=1", &[LATE]),
    ("guidance.criterion=\"lawnmower\"", &[]),
    ("guidance.lane_m=30", &[LAWNMOWER]),
    (
        "guidance.waypoints=[[[-100, 100], [100, 100]]]",
        &[WAYPOINTS, "guidance.waypoints=[[[0, 0], [9, 120]]]"],
    ),
    ("guidance.period_s=3", &[]),
    ("guidance.horizon_s=6", &[]),
    ("guidance.beam=1", &[]),
    ("guidance.attraction_m=900", &[]),
    ("guidance.attraction=0", &[]),
    ("guidance.discount_s=5", &[]),
    ("guidance.edge_worth=0", &[]),
    ("pose.sigma=[5, 5, 5, 0.01, 0.02, 0.02]", &[]),
    ("pose.noise=\"gauss-markov\"", &[]),
    ("pose.time_constant_s=4", &["pose.noise=\"gauss-markov\""]),
    ("agents.fixed_wing.roll_max_deg=20", &[]),
    ("agents.fixed_wing.roll_time_constant_s=1.5", &[]),
    ("agents.fixed_wing.heading_time_constant_s=4", &[]),
    ("agents.fixed_wing.pitch_trim_deg=0", &[]),
    ("agents.fixed_wing.pitch_time_constant_s=3", &[]),
    ("agents.fixed_wing.wind_m_s=[4, 0]", &[]),
    ("agents.speed_m_s=25", &[]),
    ("agents.altitude_m=80", &[]),
    ("targets.driving=\"random-walk\"", &[]),
    ("targets.walk_m_sqrt_s=5", &[WALKING]),
    ("camera.columns=480", &[]),
    ("camera.rows=400", &[]),
    ("camera.aperture_deg=40", &[]),
    ("camera.tilt_deg=80", &[]),
];

#[test]
fn every_key_has_an_effect() {
    SMALL.every_key_changes(&KEYS, digest);
    let base = scratch();
    // A radio of another name.
    let other = ["netem.far.range_m=inf", "exchange.channel=\"far\""];
    let silent = "netem.radio.loss={model=\"iid\",p=1.0}";
    let near = SMALL.flown(base.path(), "run", "near", &[silent]);
    let far = SMALL.flown(base.path(), "run", "far", &[&other[..], &[silent]].concat());
    assert_ne!(near["digest"], far["digest"]);
}

#[test]
fn all_mistakes_are_told_with_their_places() {
    let base = scratch();
    let scenario = r#"mission = "bayes"
[map]
kind = "open"
size_m = [1000, 1000]
[targets]
count = 2
driving = "roads"
[agents]
vehicle = "quadcopter"
altitude_m = 90
[camera]
tilt_deg = 10
[belief]
cell_m = 0.01
min_cell_m = 0.01
kind = "particles"
[detector]
p_false = 1.5
[pose]
sigma = [0, -1, 1, 1, 1, nan]
[exchange]
mode = "snapshot"
[netem.far]
range_m = 100
[estimator]
disc_vertices = 8
"#;
    check_places(
        scenario,
        &[
            (6, "`targets.count` cannot be 2"),
            (7, "`targets.driving`"),
            (9, "`agents.vehicle` cannot be `quadcopter`"),
            (12, "above the horizon"),
            (14, "0.54 GB for each agent"),
            (18, "`detector.p_false` cannot be 1.5"),
            (20, "six deviations above 0"),
            (22, "particles cannot be fused"),
            (23, "radio `far` carries nothing"),
            (25, "`estimator` belongs to the mission `set-membership`"),
        ],
    );
    let reverse = csat(base.path(), &["check", "city", "--set", "belief.cell_m=1"]);
    assert_eq!(reverse.status.code(), Some(2));
    assert!(text(&reverse.stderr).contains("`belief` belongs to the mission `bayes`"));
}
