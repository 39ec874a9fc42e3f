//! Sweeps of missions that take a moment.

use std::path::{Path, PathBuf};
use std::process::Output;

use super::{SMALL, csat, json, names, read, text};

/// What the folder of a sweep holds when all is done.
pub const FILES: [&str; 6] =
    ["report.html", "runs", "sweep.csv", "sweep.json", "sweep_means.csv", "sweep_pairs.csv"];

/// `csat sweep` of the small mission to its end.
pub fn sweep(folder: &Path, arguments: &[&str]) -> Output {
    csat(folder, &[&["sweep"], SMALL, arguments].concat())
}

/// What a sweep says that is to succeed.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = sweep(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// All that is a function of the runs.
pub fn results(folder: &Path) -> [String; 5] {
    ["sweep.json", "sweep.csv", "sweep_means.csv", "sweep_pairs.csv", "report.html"]
        .map(|name| read(&folder.join(name)))
}

/// The files of runs without what a clock says.
pub fn runs(folder: &Path) -> Vec<(String, serde_json::Value)> {
    let folder = folder.join("runs");
    let timeless = |name: String| {
        let mut run = json(&folder.join(&name));
        for clock in ["wall_s", "realtime_factor", "timing_ms"] {
            let summary = run["summary"].as_object_mut().expect(&name);
            assert!(summary.remove(clock).is_some(), "{clock}");
        }
        (name, run)
    };
    names(&folder).into_iter().map(timeless).collect()
}

/// The name of the file of a run, whose values `start` begins with.
pub fn run_file(sweep: &Path, start: &str, seed: u64) -> String {
    let ending = format!("-seed{seed}.json");
    let mut all = names(&sweep.join("runs")).into_iter();
    all.find(|name| name.starts_with(start) && name.ends_with(&ending)).expect(start)
}

/// The file of a run.
pub fn run_path(sweep: &Path, start: &str, seed: u64) -> PathBuf {
    sweep.join("runs").join(run_file(sweep, start, seed))
}

/// The name of a run's folder.
pub fn run_name(sweep: &Path, start: &str, seed: u64) -> String {
    run_file(sweep, start, seed).replace(".json", "")
}

/// A sweep that is refused, and what must be said of it.
pub fn refused(folder: &Path, arguments: &[&str], messages: &[&str]) {
    let output = sweep(folder, arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    for message in messages {
        assert!(said.contains(message), "{arguments:?}: {message} in {said}");
    }
}
