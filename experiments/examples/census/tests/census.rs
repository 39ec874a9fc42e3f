//! The census from outside: the command of its own program, and its agents in processes.

#[path = "../../../tests/common/browser.rs"]
#[allow(dead_code, reason = "this test uses its part")]
mod browser;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use browser::Browser;
use serde_json::Value;
use tempfile::TempDir;

/// The shipped scenario of the census, made short.
fn small(command: &str, folder: &Path, more: &[&str]) -> Output {
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/census.toml");
    let sets = ["run.duration_s=10", "map.size_m=[200, 200]", "targets.count=3", "agents.count=2"];
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> = [command, scenario].into_iter().chain(sets).collect();
    census(folder, &[&arguments[..], more].concat())
}

fn census(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_census"));
    command.args(arguments).current_dir(folder).output().expect("it starts")
}

fn scratch() -> TempDir {
    tempfile::tempdir().expect("a scratch folder")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a summary")
}

#[test]
fn a_run_has_the_numbers_and_pictures_of_the_census() {
    let base = scratch();
    let summary = json(&small("run", base.path(), &["--json", "--out", "out"]));
    assert_eq!(summary["mission"], "census");
    assert!(summary["counted_at_end"].as_u64().unwrap() > 0, "{summary}");
    assert!(summary["looked_at_pct"].as_f64().unwrap() > 1.0, "{summary}");
    assert!(summary["checked"]["in_view"]["checks"].as_u64().unwrap() > 0, "{summary}");
    assert_eq!(summary["violations"], 0);
    for key in ["unexplored_pct", "identified", "all_identified_s"] {
        assert!(summary.get(key).is_none(), "`{key}` belongs to another mission");
    }
    let read = |name: &str| std::fs::read_to_string(base.path().join("out").join(name)).unwrap();
    let header = "step,time_s,agent,x_m,y_m,z_m,yaw_rad,counted,own,error_m,bytes_sent,violations,\
                  counted_union,looked_at_pct,staleness_s,contact_pct,components,role\n";
    assert!(read("metrics.csv").starts_with(header));
    let map = read("map.svg");
    assert!(map.contains("cars where they were counted") && map.contains("looked at the ground"));
    assert!(read("metrics.svg").contains("Cars counted"));
    let told = text(&small("run", base.path(), &[]).stdout);
    assert!(told.contains("counted ") && told.contains("second half: looked at "), "{told}");
    let drawn = census(base.path(), &["plot", "out"]);
    assert_eq!(drawn.status.code(), Some(0), "{}", text(&drawn.stderr));
}

#[test]
fn processes_fly_the_same_mission() {
    let base = scratch();
    let one = json(&small("run", base.path(), &["--json", "--out", "one"]));
    let many = json(&small("spawn", base.path(), &["--json", "--out", "many"]));
    for key in ["digest", "counted_at_end", "looked_at_pct", "messages", "checked"] {
        assert_eq!(one[key], many[key], "{key}");
    }
    let metrics = |run: &str| std::fs::read(base.path().join(run).join("metrics.csv")).unwrap();
    assert_eq!(metrics("one"), metrics("many"));
}

/// Every key of its table changes something.
#[test]
fn keys_of_the_census_have_effects() {
    let base = scratch();
    let digest = |sets: &[&str]| {
        let long = ["run.duration_s=60"];
        let sets: Vec<&str> = long.iter().chain(sets).flat_map(|set| ["--set", set]).collect();
        json(&small("run", base.path(), &[&["--json"], &sets[..]].concat()))["digest"].clone()
    };
    let usual = digest(&[]);
    assert_eq!(
        digest(&["census.margin_m=60", "census.share=true"]),
        usual,
        "the scenario's values"
    );
    assert_ne!(digest(&["census.share=false"]), usual);
    assert_ne!(digest(&["census.spread_deg=60"]), usual);
    assert_ne!(digest(&["census.margin_m=95"]), usual);
}

#[test]
fn mistakes_are_told_with_their_places() {
    let base = scratch();
    let told = |sets: &[&str]| {
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let output = small("check", base.path(), &sets);
        assert_eq!(output.status.code(), Some(2));
        text(&output.stderr)
    };
    for (set, expected) in [
        ("census.margin_m=100", "`census.margin_m` cannot be 100"),
        ("census.spread_deg=-1", "`census.spread_deg` cannot be -1"),
        ("census.margin=10", "unknown key `margin` in [census]"),
        ("census.share=1", "`census.share` cannot be 1"),
        ("guidance.kappa=1", "`guidance` belongs to the mission `set-membership`"),
        ("mission=sensus", "`mission` cannot be `sensus`"),
    ] {
        let told = told(&[set]);
        assert!(told.contains(expected), "{set}: {told}");
    }
    let misspelled = told(&["mission=sensus"]);
    assert!(misspelled.contains("did you mean `census`?"), "{misspelled}");
    assert!(!misspelled.contains("belongs to"), "one mistake: {misspelled}");
    let unknown = told(&["sensus.share=true"]);
    assert!(unknown.contains("`netem`, `census`") && !unknown.contains("`guidance`"), "{unknown}");
    let other = census(base.path(), &["check", "city", "--set", "census.share=false"]);
    let told = text(&other.stderr);
    assert!(told.contains("`census` belongs to the mission `census`"), "{told}");
}

#[test]
fn sweeps_and_comparisons_show_the_numbers_of_the_census() {
    let base = scratch();
    let vary = ["--vary", "census.share=true,false", "--seeds", "1..2", "--out", "sweep"];
    let output = small("sweep", base.path(), &vary);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("counted "), "{}", text(&output.stderr));
    let report = std::fs::read_to_string(base.path().join("sweep/report.html")).unwrap();
    assert!(report.contains("Ground that was looked at") && !report.contains("Unexplored"));
    let means = std::fs::read_to_string(base.path().join("sweep/sweep_means.csv")).unwrap();
    assert!(means.contains("all_counted_restricted_s") && means.contains(",looked_at_pct,"));
}

/// The page draws the layers and the curves of a mission that it has never heard of.
#[test]
fn the_live_page_shows_the_census() {
    let Some(mut browser) = Browser::start() else {
        eprintln!("SKIPPED: no Chromium is installed");
        return;
    };
    let base = scratch();
    let recorded = small("run", base.path(), &["--record", "--json", "--out", "out"]);
    assert_eq!(recorded.status.code(), Some(0), "{}", text(&recorded.stderr));
    let mut watch = Command::new(env!("CARGO_BIN_EXE_census"))
        .args(["watch", "out", "--port", "0"])
        .current_dir(base.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let line = BufReader::new(watch.stdout.take().unwrap()).lines().find_map(|line| {
        let line = line.unwrap();
        line.split_whitespace().find(|word| word.starts_with("http://")).map(str::to_owned)
    });
    browser.open(&line.expect("its address"));
    browser.wait_for("document.querySelectorAll('.curve canvas').length === 6");
    browser.wait_for("document.body.textContent.includes('cars where they were counted')");
    browser.wait_for("document.getElementById('headline-name').textContent === 'counted'");
    browser.wait_for("document.getElementById('details').textContent.includes('by itself')");
    let complaints = std::mem::take(&mut browser.complaints);
    watch.kill().unwrap();
    watch.wait().unwrap();
    assert!(complaints.is_empty(), "{complaints:?}");
}
