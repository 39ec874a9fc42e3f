//! Fleets of processes, for tests: started on a free port, found again by it, ended.

#![allow(dead_code, reason = "each test program uses its part")]

use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use csat_mission::timing::Stopwatch;

use super::{SMALL, command};

/// Long enough for a small mission on a machine that has other things to do.
pub const LIMIT: Duration = Duration::from_secs(120);

/// An endpoint that nobody listens on.
pub fn endpoint() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    format!("tcp/127.0.0.1:{}", listener.local_addr().unwrap().port())
}

/// The processes that know of an endpoint, by pid, with their command lines.
pub fn processes(endpoint: &str) -> Vec<(u32, String)> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    pids.filter_map(|pid: u32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).ok()?;
        let line = String::from_utf8_lossy(&line).replace('\0', " ");
        line.contains(endpoint).then_some((pid, line))
    })
    .collect()
}

/// Waits until `happens`.
#[track_caller]
pub fn wait_until(what: &str, mut happens: impl FnMut() -> bool) {
    let watch = Stopwatch::start();
    while !happens() {
        assert!(!watch.left(LIMIT).is_zero(), "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[track_caller]
pub fn expect_nobody(endpoint: &str) {
    wait_until("no process is left", || processes(endpoint).is_empty());
}

pub fn signal(pid: u32, signal: &str) {
    let status = Command::new("kill").args([signal, &pid.to_string()]).status();
    assert!(status.unwrap().success(), "kill {signal} {pid}");
}

/// The process that flies a UAV.
pub fn agent_process(endpoint: &str, id: u16) -> Option<u32> {
    let wanted = format!("--id {id} ");
    let all = processes(endpoint);
    all.into_iter().find(|(_, line)| line.contains(&wanted)).map(|(pid, _)| pid)
}

/// A small mission of this many seconds.
pub fn mission(seconds: &str) -> Vec<String> {
    let mut arguments: Vec<String> = SMALL.iter().map(ToString::to_string).collect();
    arguments.extend(["--set".to_owned(), format!("run.duration_s={seconds}")]);
    arguments
}

/// Starts a small mission with its run folder in `out`.
pub fn spawn(folder: &Path, endpoint: &str, seconds: &str, more: &[&str]) -> Child {
    let mission = mission(seconds);
    let mut all: Vec<&str> = vec!["spawn"];
    all.extend(mission.iter().map(String::as_str));
    all.extend(["--listen", endpoint, "--out", "out"]);
    all.extend(more);
    process(folder, &all)
}

/// Starts a command whose output is kept.
pub fn process(folder: &Path, arguments: &[&str]) -> Child {
    command(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for the end of a process.
pub fn end(child: Child) -> Output {
    child.wait_with_output().unwrap()
}

/// Waits until the mission flies: its world writes metrics before its folder has its final name.
#[track_caller]
pub fn wait_for_flight(folder: &Path) {
    wait_until("the mission flies", || {
        let partial = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let files = partial.map(|entry| entry.path().join("metrics.csv.tmp"));
        files.into_iter().any(|file| std::fs::metadata(file).is_ok_and(|m| m.len() > 0))
            || folder.join("out/summary.json").exists()
    });
}
