//! Ctrl-C: a readable folder, and no process.

#![cfg(unix)]

mod common;

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use common::{SMALL, command, csat, json, names, read, scratch, text};

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
        assert_eq!(text(&output.stdout), read(&folder.join("summary.json")));
        let steps = summary["steps"].as_u64().unwrap();
        assert!((1..1_199_999).contains(&steps), "{steps}");
        let rows = csv::Reader::from_path(folder.join("metrics.csv")).unwrap().into_records();
        assert_eq!(rows.map(Result::unwrap).count() as u64, 2 * (steps + 1));
        assert_eq!(csat(base.path(), &["plot", "out"]).status.code(), Some(0));
    }
}

/// A step may take long: the second Ctrl-C does not wait for it.
#[test]
fn the_second_ctrl_c_ends_at_once() {
    let base = scratch();
    let child = long_run(base.path(), &[]);
    signal(&child, "INT");
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    // Whether the first one was in time or not: no folder under its final name, or a whole one.
    for name in names(base.path()) {
        assert!(name.starts_with(".out.partial-") || name == "out", "{name}");
    }
    if base.path().join("out").exists() {
        assert_eq!(json(&base.path().join("out/summary.json"))["interrupted"], true);
    }
}
