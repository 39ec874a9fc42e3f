//! Processes started by hand say what they wait for while they wait.

mod common;

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};

use common::fleet::{LIMIT, endpoint, expect_nobody};
use common::{SMALL, command, scratch};

/// A process and the lines of its standard error as they come.
struct Talker {
    child: Child,
    lines: Receiver<String>,
}

impl Talker {
    fn start(folder: &std::path::Path, arguments: &[&str]) -> Self {
        let mut command = command(folder, arguments);
        let command = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("csat starts");
        let stderr = BufReader::new(child.stderr.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            stderr.lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        Self { child, lines }
    }

    /// Waits until it says so.
    #[track_caller]
    fn expect(&self, words: &str) {
        let mut said = Vec::new();
        while let Ok(line) = self.lines.recv_timeout(LIMIT) {
            if line.contains(words) {
                return;
            }
            said.push(line);
        }
        panic!("`{words}` is not in {said:#?}");
    }
}

impl Drop for Talker {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn worlds_and_agents_say_who_is_missing() {
    let (folder, endpoint) = (scratch(), endpoint());
    let agent = |id: &str| {
        let arguments = ["agent", "--id", id, "--patience", "600", "--connect", &endpoint];
        Talker::start(folder.path(), &arguments)
    };
    let first = agent("0");
    let world = format!("waiting for a world to answer on `csat/*/join/0` at [\"{endpoint}\"]");
    first.expect(&world);
    let world = ["world", "--patience", "600", "--listen", &endpoint, "--out", "out"];
    let world = Talker::start(folder.path(), &[&world[..], SMALL].concat());
    first.expect("waiting for UAV 1 to be heard by UAV 0");
    world.expect("waiting for UAV 1 to join: `csat agent --id N --connect ENDPOINT`");
    // The mission flies once all are there.
    let _second = agent("1");
    common::fleet::wait_until("the mission flies", || folder.path().join("out").exists());
    drop((first, world, _second));
    expect_nobody(&endpoint);
}
