//! Help for the tests of the `csat` command.

#![allow(dead_code, reason = "each test program uses its part")]

pub mod docs;
pub mod fleet;
pub mod shipped;
pub mod sweeps;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A mission that takes a fraction of a second in the development profile.
pub const SMALL: &[&str] = &[
    "--set",
    "run.duration_s=5",
    "--set",
    "map.size_m=[150, 150]",
    "--set",
    "camera.columns=96",
    "--set",
    "camera.rows=72",
    "--set",
    "camera.min_pixels=1",
    "--set",
    "targets.count=2",
    "--set",
    "agents.count=2",
];

/// A new empty folder that goes away with its test.
pub fn scratch() -> TempDir {
    tempfile::Builder::new().prefix("csat-cli-").tempdir().expect("a scratch folder")
}

/// The command, about to start in a folder.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_csat"));
    command.args(arguments).current_dir(folder).env_remove("RUST_LOG");
    command
}

/// Runs the command in a folder to its end.
pub fn csat(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("csat starts")
}

/// `csat run`, the small mission and these arguments.
pub fn small_run(folder: &Path, arguments: &[&str]) -> Output {
    csat(folder, &[&["run"], SMALL, arguments].concat())
}

/// What a command wrote.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("csat writes UTF-8")
}

/// The names in a folder, hidden ones included, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// The text of a file.
pub fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A file that must be JSON.
pub fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&read(path)).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A Python 3.11 or newer with some modules, which these packages have: `CSAT_PYTHON`, or else `python3`;
/// `None`, said loudly, if there is none.
///
/// # Panics
/// When `CSAT_PYTHON` promises it and has them not.
pub fn python(modules: &[&str], packages: &str) -> Option<String> {
    let promised = std::env::var("CSAT_PYTHON").ok();
    let python = promised.clone().unwrap_or_else(|| "python3".to_owned());
    let imports = format!("import {}", modules.join(", "));
    let reason = match Command::new(&python).args(["-c", &imports]).output() {
        Ok(output) if output.status.success() => return Some(python),
        Ok(output) => text(&output.stderr).lines().last().unwrap_or_default().to_owned(),
        Err(error) => error.to_string(),
    };
    let message = format!(
        "`{python}` does not do ({reason}); `python3 -m venv DIR && DIR/bin/pip install {packages}`, then \
         CSAT_PYTHON=DIR/bin/python"
    );
    assert!(promised.is_none(), "CSAT_PYTHON: {message}");
    skipped(&message);
    None
}

/// Says that a test could not look at anything: not by `eprintln!`, which the harness keeps to itself.
pub fn skipped(why: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {why}");
}
