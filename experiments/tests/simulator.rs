//! A simulator that is not csat's: `examples/simulator/world.py` flies a real `csat agent`.
//!
//! It takes Python 3.11 or newer with the packages `eclipse-zenoh` and `numpy`: `CSAT_PYTHON`, or else
//! `python3`. Without them these tests are skipped, unless `CSAT_PYTHON` promises them.

#![cfg(unix)]

mod common;

use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use common::{command, csat, read, scratch, text};
use csat_mission::timing::Stopwatch;

/// Long enough for some seconds of flight on a machine that has other things to do.
const LIMIT: Duration = Duration::from_secs(120);

/// A Python that can play the world; `None`, said loudly, if there is none.
fn python() -> Option<String> {
    common::python(&["numpy", "tomllib", "zenoh"], "eclipse-zenoh==1.10.2 numpy")
}

/// An endpoint that nobody listens on.
fn endpoint() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    format!("tcp/127.0.0.1:{}", listener.local_addr().unwrap().port())
}

/// A process that does not outlive its test. What it says goes to files, which never fill up.
struct Process {
    child: Child,
    name: String,
    folder: std::path::PathBuf,
}

impl Process {
    fn start(folder: &Path, name: &str, mut command: Command) -> Self {
        let file = |end: &str| std::fs::File::create(folder.join(format!("{name}.{end}"))).unwrap();
        let command = command.stdin(Stdio::null()).stdout(file("out")).stderr(file("err"));
        let child = command.spawn().unwrap_or_else(|error| panic!("{name}: {error}"));
        Self { child, name: name.to_owned(), folder: folder.to_owned() }
    }

    fn said(&self, end: &str) -> String {
        read(&self.folder.join(format!("{}.{end}", self.name)))
    }

    /// Waits for its end: its exit code, standard output and standard error.
    #[track_caller]
    fn end(mut self) -> (Option<i32>, String, String) {
        let watch = Stopwatch::start();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return (status.code(), self.said("out"), self.said("err"));
            }
            let said = || format!("{}{}", self.said("out"), self.said("err"));
            assert!(!watch.left(LIMIT).is_zero(), "{} does not end: {}", self.name, said());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until it says so.
    #[track_caller]
    fn wait_for(&self, line: &str) {
        let watch = Stopwatch::start();
        while !self.said("out").contains(line) {
            assert!(!watch.left(LIMIT).is_zero(), "{line:?} is not said: {}", self.said("err"));
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn world(folder: &Path, python: &str, endpoint: &str, more: &[&str]) -> Process {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/simulator/world.py");
    let mut command = Command::new(python);
    command.arg(script).args(["--listen", endpoint]).args(more).current_dir(folder);
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    Process::start(folder, "world", command)
}

fn agent(folder: &Path, endpoint: &str) -> Process {
    let command = command(folder, &["agent", "--id", "0", "--connect", endpoint]);
    Process::start(folder, "agent", command)
}

#[test]
fn a_foreign_world_flies_an_agent() {
    let Some(python) = python() else { return };
    let (folder, endpoint) = (scratch(), endpoint());
    let world = world(folder.path(), &python, &endpoint, &["--steps", "20"]);
    let agent = agent(folder.path(), &endpoint);
    let (code, out, err) = world.end();
    assert_eq!((code, &*err), (Some(0), ""), "{out}");
    assert!(out.contains("\nflown 20 steps; in all "), "{out}");
    assert!(out.contains(" steps shown the car was in its set"), "{out}");
    assert_eq!(out.lines().filter(|line| line.starts_with("step ")).count(), 20, "{out}");
    // It sees the car, and it turns.
    assert!(
        out.lines().any(|line| line.contains("px of the car") && !line.contains(" 0 px")),
        "{out}"
    );
    assert!(out.lines().any(|line| line.contains("commands [") && !line.contains("[]")), "{out}");
    let (code, _, err) = agent.end();
    assert_eq!(code, Some(0), "{err}");
}

#[test]
fn a_foreign_world_refuses_and_carries_on() {
    let Some(python) = python() else { return };
    let (folder, endpoint) = (scratch(), endpoint());
    let world = world(folder.path(), &python, &endpoint, &["--steps", "2"]);
    let Output { status, stderr, .. } =
        csat(folder.path(), &["agent", "--id", "1", "--connect", &endpoint]);
    let said = text(&stderr);
    assert_eq!(status.code(), Some(2), "{said}");
    assert!(said.contains("the world refuses agent 1: there is no UAV 1 here, only 0"), "{said}");
    let agent = agent(folder.path(), &endpoint);
    assert_eq!((world.end().0, agent.end().0), (Some(0), Some(0)));
}

#[test]
fn a_foreign_world_says_who_is_missing() {
    let Some(python) = python() else { return };
    let (folder, endpoint) = (scratch(), endpoint());
    let lonely = world(folder.path(), &python, &endpoint, &["--patience", "0.5"]);
    let (code, _, err) = lonely.end();
    assert_eq!(code, Some(1));
    assert_eq!(err, "world.py: waited 0.5 s for UAV 0 to join\n");

    let world = world(folder.path(), &python, &endpoint, &["--steps", "100000"]);
    let agent = agent(folder.path(), &endpoint);
    world.wait_for("step 3:");
    drop(agent);
    let (code, _, err) = world.end();
    assert_eq!(code, Some(1));
    assert!(err.starts_with("world.py: the process of UAV 0 ended; it was to "), "{err}");
}
