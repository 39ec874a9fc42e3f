//! Ctrl-C: a readable folder, and no process.

#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use common::fleet::wait_until;
use common::{SMALL, command, csat, json, names, scratch, text};

/// Looks for the mission's first rows, 20 ms apart.
const LOOKS: u32 = 3000;

/// A mission of a week, once it flies.
fn long_run(folder: &Path, arguments: &[&str]) -> Child {
    let week = ["--set", "run.duration_s=600000", "--out", "out"];
    let child = command(folder, &[&["run"], SMALL, &week[..], arguments].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("csat starts");
    let flies = || {
        let partial = folder.join(format!(".out.partial-{}", child.id()));
        std::fs::metadata(partial.join("metrics.csv.tmp")).is_ok_and(|m| m.len() > 0)
    };
    let begins = (0..LOOKS).any(|_| {
        std::thread::sleep(Duration::from_millis(20));
        flies()
    });
    assert!(begins, "the mission does not begin");
    child
}

fn signal(child: &Child, name: &str) {
    let kill = format!("kill -{name} {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}

#[test]
fn the_first_ctrl_c_ends_the_mission_and_leaves_a_whole_folder() {
    for name in ["INT", "TERM"] {
        let base = scratch();
        let child = long_run(base.path(), &["--json"]);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.contains("ending after this step; Ctrl-C again ends at once"), "{said}");
        assert_eq!(names(base.path()), ["out"]);
        let folder = base.path().join("out");
        assert!(names(&folder).iter().all(|file| !file.ends_with(".tmp")));
        let summary = json(&folder.join("summary.json"));
        assert_eq!(summary["interrupted"], true);
        let mut shown: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(shown.as_object_mut().unwrap().remove("folder"), Some("out".into()));
        assert_eq!(shown, summary);
        let steps = summary["steps"].as_u64().unwrap();
        assert!((1..1_199_999).contains(&steps), "{steps}");
        let rows = csv::Reader::from_path(folder.join("metrics.csv")).unwrap().into_records();
        assert_eq!(rows.map(Result::unwrap).count() as u64, 2 * (steps + 1));
        assert_eq!(csat(base.path(), &["plot", "out"]).status.code(), Some(0));
    }
}

/// A step of this mission lasts tens of seconds: the second Ctrl-C does not wait for it.
#[test]
fn the_second_ctrl_c_ends_at_once() {
    let base = scratch();
    let huge = [
        "agents.count=400",
        "agents.altitude_band_m=50",
        "map.size_m=[1500, 1500]",
        "camera.columns=96",
        "camera.rows=72",
        "camera.min_pixels=1",
    ];
    let sets = huge.iter().flat_map(|set| ["--set", set]);
    let mut arguments = vec!["run", "--out", "out", "--threads", "1"];
    arguments.extend(sets);
    let mut child = command(base.path(), &arguments)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    wait_until("the mission is about to begin", || {
        names(base.path()).iter().any(|name| name.starts_with(".out.partial-"))
    });
    signal(&child, "INT");
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(said.any(|line| line.starts_with("ending after this step")));
    signal(&child, "INT");
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    let left = names(base.path());
    assert!(left.iter().all(|name| name.starts_with(".out.partial-")), "it waited: {left:?}");
}
