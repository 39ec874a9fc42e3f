//! `csat echo` and `csat doctor`, against a fleet that flies and against nothing.

#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Output, Stdio};

use common::fleet::{
    self, agent_process, end, endpoint, expect_nobody, processes, signal, spawn, wait_for_flight,
};
use common::{command, csat, scratch, text};
use serde_json::Value;
use tempfile::TempDir;

/// A fleet that flies until its test is over.
struct Fleet {
    folder: TempDir,
    endpoint: String,
    child: Option<Child>,
}

impl Fleet {
    fn start() -> Self {
        let (folder, endpoint) = (scratch(), endpoint());
        // In real time, so that nobody waits for a process that is stopped.
        let child = spawn(folder.path(), &endpoint, "3000", &["--realtime", "2"]);
        wait_for_flight(folder.path());
        Self { folder, endpoint, child: Some(child) }
    }

    fn arguments<'a>(&'a self, arguments: &[&'a str]) -> Vec<&'a str> {
        [arguments, &["--connect", &self.endpoint]].concat()
    }

    fn csat(&self, arguments: &[&str]) -> Output {
        csat(self.folder.path(), &self.arguments(arguments))
    }

    /// The JSON lines of `csat echo`, which must end well.
    #[track_caller]
    fn echo(&self, arguments: &[&str]) -> Vec<Value> {
        let output = self.csat(&[&["echo", "--json", "--patience", "60"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    fn start_csat(&self, arguments: &[&str]) -> Child {
        let mut command = command(self.folder.path(), &self.arguments(arguments));
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn end(mut self) {
        if let Some(child) = self.child.take() {
            signal(child.id(), "-INT");
            let output = end(child);
            assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
        }
        expect_nobody(&self.endpoint);
    }
}

impl Drop for Fleet {
    /// A test that fails leaves no process behind either.
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// The findings of `csat doctor --json`, as `level check: text = advice`.
#[track_caller]
fn findings(output: &Output) -> (Value, Vec<String>) {
    let diagnosis: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {} {}", text(&output.stdout), text(&output.stderr)));
    let all = diagnosis["findings"].as_array().unwrap().iter().map(|finding| {
        let of = |key: &str| finding[key].as_str().unwrap_or_default();
        format!("{} {}: {} = {}", of("level"), of("check"), of("text"), of("advice"))
    });
    let all = all.collect();
    (diagnosis, all)
}

#[track_caller]
fn expect(findings: &[String], beginning: &str, part: &str) {
    let found = findings.iter().any(|f| f.starts_with(beginning) && f.contains(part));
    assert!(found, "expected {beginning}…{part} among {findings:#?}");
}

#[test]
fn what_a_fleet_says_is_shown() {
    let fleet = Fleet::start();
    let clock = &fleet.echo(&["clock", "--once"])[0];
    assert_eq!(
        (&clock["key"], &clock["encoding"]),
        (&"csat/1/clock".into(), &"application/json".into())
    );
    assert!(clock["body"]["order"].is_string(), "{clock}");
    let message = &fleet.echo(&["csat/1/link/*/0", "--once"])[0];
    assert!(message["body"]["message"].is_object(), "{message}");
    assert!(message["body"]["sequence"].is_u64(), "{message}");
    let frame = &fleet.echo(&["uav/1/frame", "--once"])[0];
    assert!(frame["attachment"]["step"].is_u64() && frame.get("body").is_none(), "{frame}");
    let report = &fleet.echo(&["uav/*/report", "--once"])[0];
    assert!(report["bytes"].as_u64() > Some(0) && report.get("body").is_none(), "{report}");
    let view = &fleet.echo(&["view/1/targets", "--once"])[0];
    assert_eq!(
        (&view["body"]["type"], &view["body"]["agent"]),
        (&"FeatureCollection".into(), &1.into())
    );
    let tokens = fleet.echo(&["alive/world", "--alive", "--once"]);
    assert_eq!(tokens, [serde_json::json!({"key": "csat/1/alive/world", "alive": true})]);
    fleet.end();
}

#[test]
fn echo_ends_as_it_is_asked_to() {
    let fleet = Fleet::start();
    // A reader that has seen enough.
    let mut child = fleet.start_csat(&["echo"]);
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().starts_with("csat/1/"));
    drop(lines);
    let output = end(child);
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
    // Ctrl-C, and the sums.
    let mut child = fleet.start_csat(&["echo", "--rates"]);
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.ends_with("  csat/1/uav/0/frame")));
    signal(child.id(), "-INT");
    let rest: Vec<String> = lines.collect();
    assert!(
        rest.iter().any(|line| line.starts_with("in ") && line.contains(" messages, ")),
        "{rest:?}"
    );
    assert_eq!(end(child).status.code(), Some(0));
    // Nothing to hear, and a time limit.
    let output = fleet.csat(&["echo", "csat/2/**", "--patience", "1"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("nothing on `csat/2/**` within 1 s"), "{said}");
    assert!(said.contains("csat doctor --key 'csat/2/**'"), "{said}");
    fleet.end();
}

#[test]
fn the_doctor_knows_a_fleet_that_flies_and_one_that_lost_somebody() {
    let fleet = Fleet::start();
    let output = fleet.csat(&["doctor", "--json", "--key", "link/**"]);
    let (diagnosis, all) = findings(&output);
    assert_eq!(output.status.code(), Some(0), "{all:#?}");
    assert_eq!(diagnosis["problems"], 0);
    expect(&all, "ok config: Zenoh v1.", "multicast off");
    expect(&all, "ok endpoint: ", "takes connections");
    expect(&all, "ok session: ", "connected to 3 processes");
    expect(&all, "ok run 1: the world and all 2 agents are alive", "");
    expect(&all, "ok run 1: the clock ticks: ", " orders/s, at step ");
    expect(&all, "ok run 1: published: clock ", "uav ");
    expect(&all, "ok run 1: UAVs 0, 1 show what they know", "");
    expect(&all, "ok key: `csat/*/link/**` is heard: ", "csat/1/link/");
    let run = &diagnosis["runs"][0];
    assert_eq!((&run["world"], &run["expected"]), (&true.into(), &2.into()));
    // In words.
    let output = fleet.csat(&["doctor", "--run", "9", "--key", "views/0/pose"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("problem  runs       run 9 is not here; got 1\n  = "), "{said}");
    assert!(said.contains("nothing on `csat/*/views/0/pose`"), "{said}");
    assert!(said.lines().last().unwrap().starts_with("2 problems"), "{said}");
    // One is gone.
    signal(agent_process(&fleet.endpoint, 0).expect("UAV 0 has a process"), "-KILL");
    let output = fleet.csat(&["doctor", "--json", "--key", "alive/0"]);
    let (_, all) = findings(&output);
    assert_eq!(output.status.code(), Some(0), "{all:#?}");
    expect(&all, "warning run 1: processes of UAV 0 are gone", "csat agent --id 0");
    expect(&all, "warning key: ", "csat echo --alive");
    fleet.end();
}

#[test]
fn the_doctor_knows_worlds_that_wait_or_are_gone() {
    let (folder, endpoint) = (scratch(), endpoint());
    let start = |arguments: &[&str]| {
        let mut command = command(folder.path(), arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let mut world = start(&["world", "city", "--listen", &endpoint, "--out", "out"]);
    fleet::wait_until("the world listens", || {
        std::net::TcpStream::connect(endpoint.trim_start_matches("tcp/")).is_ok()
    });
    let doctor = |more: &[&str]| {
        let all = [&["doctor", "--json", "--connect", &endpoint], more].concat();
        let output = csat(folder.path(), &all);
        (output.status.code(), findings(&output).1)
    };
    let (code, all) = doctor(&[]);
    assert_eq!(code, Some(1), "{all:#?}");
    expect(&all, "problem run 1: the clock is silent", "");
    expect(&all, "", "csat agent --id 0");
    world.kill().unwrap();
    world.wait().unwrap();
    expect_nobody(&endpoint);
    let (code, all) = doctor(&[]);
    assert_eq!(code, Some(1), "{all:#?}");
    expect(&all, "problem endpoint: ", "connection refused, nobody listens there");
    expect(&all, "problem session: ", "connected to nobody = no endpoint takes connections");
    // Somebody who is no Zenoh, and somebody who is no csat.
    let other = TcpListener::bind(endpoint.trim_start_matches("tcp/")).unwrap();
    let (code, all) = doctor(&[]);
    assert_eq!(code, Some(1), "{all:#?}");
    expect(&all, "ok endpoint: ", "takes connections");
    expect(&all, "problem session: ", "another program's port");
    drop(other);
    assert!(processes(&endpoint).is_empty());
}

#[test]
fn two_onlookers_are_no_fleet() {
    let (folder, endpoint) = (scratch(), endpoint());
    let mut child = command(folder.path(), &["echo", "--listen", &endpoint])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let hint = "nothing on `csat/**` yet; `csat doctor --key 'csat/**'` tells why";
    assert_eq!(said.next().as_deref(), Some(hint));
    let output = csat(folder.path(), &["doctor", "--json", "--connect", &endpoint]);
    let (_, all) = findings(&output);
    assert_eq!(output.status.code(), Some(1), "{all:#?}");
    expect(&all, "problem runs: no run of csat among 1 connected processes", "csat spawn");
    // Its port is taken for another one that listens.
    let output = csat(folder.path(), &["doctor", "--json", "--listen", &endpoint]);
    let (_, all) = findings(&output);
    assert_eq!(output.status.code(), Some(1), "{all:#?}");
    expect(&all, "warning config: ", "waits for others to connect");
    expect(&all, "problem session: cannot open", "expected free ports");
    signal(child.id(), "-TERM");
    assert_eq!(end(child).status.code(), Some(0));
    expect_nobody(&endpoint);
}

/// Runs a command that must be refused, with this message.
#[track_caller]
fn expect_refusal(folder: &Path, arguments: &[&str], code: i32, expected: &str) {
    let output = csat(folder, arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    assert!(said.contains(expected), "{arguments:?}: {said}");
}

#[test]
fn mistakes_are_refused_with_what_was_expected() {
    let folder = scratch();
    let nowhere = endpoint();
    for (arguments, code, expected) in [
        (&["echo", "view/a*"][..], 2, "`csat/*/view/a*` is no key expression: `*` may only be"),
        (&["doctor", "--key", "/clock"], 2, "expected such as `view/0/targets`"),
        (&["echo", "--connect", "here"], 2, "`here` is no Zenoh endpoint"),
        (&["doctor", "--connect", "here"], 2, "`here` is no Zenoh endpoint"),
        (&["doctor", "--zenoh-config", "none.json5"], 2, "cannot use the Zenoh configuration"),
        (&["echo", "--rates", "--once"], 2, "cannot be used with"),
        (&["echo", "--patience", "0"], 2, "1..=86400"),
        (
            &["echo", "--patience", "1", "--connect", &nowhere],
            1,
            "got nothing on `csat/**` within 1 s",
        ),
    ] {
        expect_refusal(folder.path(), arguments, code, expected);
    }
    std::fs::write(folder.path().join("alone.json5"), "{scouting: {multicast: {enabled: false}}}")
        .unwrap();
    let output = csat(folder.path(), &["doctor", "--json", "--zenoh-config", "alone.json5"]);
    let (_, all) = findings(&output);
    assert_eq!(output.status.code(), Some(1), "{all:#?}");
    expect(&all, "", "Zenoh v1.");
}
