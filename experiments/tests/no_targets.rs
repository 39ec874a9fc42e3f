//! A search in a town without cars is an experiment, too: it flies, and what is not defined without
//! cars is absent from all that is written.

mod common;

use std::path::Path;

use common::{SMALL, csat, json, names, read, scratch, text};

const NONE: &[&str] = &["--set", "targets.count=0"];

/// What of `summary.json` is about cars that there are none of.
fn check_summary(folder: &Path) {
    let summary = json(&folder.join("summary.json"));
    for key in ["targets", "identified", "violations"] {
        assert_eq!(summary[key], 0, "{key}");
    }
    for object in [&summary, &summary["final"]] {
        for key in ["localization_error_m", "target_radius_m"] {
            assert!(object[key].is_null(), "{key}: {}", object[key]);
        }
        let unexplored = object["unexplored_pct"].as_f64().unwrap();
        assert!(unexplored > 0.0 && unexplored < 100.0, "{unexplored}");
    }
    assert!(summary["all_identified_s"].is_null());
}

/// Cells about cars are empty, counts of cars 0, and no cell is a non-number.
fn check_metrics(folder: &Path) {
    let mut metrics = csv::Reader::from_path(folder.join("metrics.csv")).unwrap();
    let header = metrics.headers().unwrap().clone();
    for row in metrics.records() {
        for (name, cell) in header.iter().zip(&row.unwrap()) {
            let expected = match name {
                "localization_error_m" | "target_area_m2" | "target_radius_m" => "",
                "identified" | "identified_union" | "targets_in_fov" | "targets_detected" => "0",
                _ => cell,
            };
            assert_eq!(cell, expected, "{name}");
            assert!(!cell.contains("NaN") && !cell.contains("inf"), "{name}: {cell}");
        }
    }
}

#[test]
fn a_mission_without_targets_flies_and_says_nothing_about_them() {
    let base = scratch();
    let output = csat(base.path(), &[&["run", "--out", "flown", "--record"], SMALL, NONE].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("identified 0/0 (no targets), violations 0"), "{said}");
    assert!(said.contains("localisation error -, target radius -"), "{said}");
    let flown = base.path().join("flown");
    check_summary(&flown);
    check_metrics(&flown);
    for picture in ["map.svg", "metrics.svg"] {
        let svg = read(&flown.join(picture));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{picture}");
    }
    assert!(!read(&flown.join("map.svg")).contains("of 0 cars"));
    assert_eq!(csat(base.path(), &["plot", "flown"]).status.code(), Some(0));
    let again = csat(base.path(), &["run", "flown/scenario.resolved.toml", "--out", "again"]);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    let digest =
        |folder: &str| json(&base.path().join(folder).join("summary.json"))["digest"].clone();
    assert_eq!(digest("again"), digest("flown"));
    let spawned = csat(base.path(), &[&["spawn", "--out", "spawned"], SMALL, NONE].concat());
    assert_eq!(spawned.status.code(), Some(0), "{}", text(&spawned.stderr));
    assert_eq!(digest("spawned"), digest("flown"));
}

#[test]
fn a_sweep_over_the_number_of_targets_begins_at_none() {
    let base = scratch();
    let vary =
        ["sweep", "city", "--vary", "targets.count=0,2", "--seeds", "1..2", "--out", "swept"];
    let is_free = |set: &&[&str]| set[1] != "targets.count=2";
    let rest: Vec<&str> = SMALL.chunks(2).filter(is_free).flatten().copied().collect();
    let output = csat(base.path(), &[&vary[..], &rest].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut table = csv::Reader::from_path(base.path().join("swept/sweep.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let at = |name: &str| header.iter().position(|column| column == name).unwrap();
    for row in table.records() {
        let row = row.unwrap();
        let is_none = row[at("targets")] == *"0";
        for column in ["localization_error_m", "all_identified_restricted_s", "all_identified_s"] {
            assert!(!is_none || row[at(column)].is_empty(), "{column}: {}", &row[at(column)]);
        }
        assert!(!row[at("unexplored_pct")].is_empty());
        assert!(is_none || !row[at("all_identified_restricted_s")].is_empty());
    }
    let report = read(&base.path().join("swept/report.html"));
    assert!(!report.contains("NaN"), "the report has no number where there is none");
    assert!(names(&base.path().join("swept")).contains(&"sweep_means.csv".to_owned()));
}

/// Nor does it need roads: a town of buildings only will do.
#[test]
fn without_targets_a_town_needs_no_roads() {
    let base = scratch();
    let town = r#"{"type": "FeatureCollection", "center": [24.94, 60.17], "features": []}"#;
    std::fs::write(base.path().join("bare.geojson"), town).unwrap();
    let bare = ["--set", "map.file=bare.geojson"];
    let output = csat(base.path(), &[&["run"], SMALL, NONE, &bare].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}
