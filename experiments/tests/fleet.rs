//! Fleets of processes (`csat spawn`, `csat world`, `csat agent`), on loopback.

#![cfg(unix)]

mod common;

use std::process::Stdio;

use common::fleet::{
    agent_process, end, endpoint, expect_nobody, mission, process, processes, signal, spawn,
    wait_for_flight, wait_until,
};
use common::{command, csat, json, names, read, scratch, text};

#[test]
fn lockstep_gives_to_the_last_byte_what_one_process_gives() {
    let bursty = "netem.radio.loss={model=\"gilbert-elliott\",p=0.05,r=0.2,h=0.0,k=1.0}";
    let slow = "netem.radio.delay={model=\"pareto\",mean_s=1.0}";
    let crash = "netem.outage=[{kind=\"crash\",agent=1,from_s=3.0,until_s=5.0}]";
    for sets in [
        &["exchange.mode=snapshot", "agents.count=3"][..],
        &["exchange.mode=facts", "netem.radio.range_m=60", bursty],
        &["exchange.mode=facts+repair", "agents.count=4", bursty, slow, crash],
        &["exchange.mode=none"],
    ] {
        let folder = scratch();
        let endpoint = endpoint();
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let mut alone = vec!["run", "--out", "alone"];
        let mission = mission("10");
        alone.extend(mission.iter().map(String::as_str));
        alone.extend(&sets);
        let output = csat(folder.path(), &alone);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let output = end(spawn(folder.path(), &endpoint, "10", &sets));
        assert_eq!(output.status.code(), Some(0), "{sets:?}: {}", text(&output.stderr));
        let digest =
            |name: &str| json(&folder.path().join(name).join("summary.json"))["digest"].clone();
        assert_eq!(digest("alone"), digest("out"), "{sets:?}");
        for file in ["metrics.csv", "events.jsonl", "links.csv", "view.json", "map.svg"] {
            let of = |name: &str| read(&folder.path().join(name).join(file));
            assert!(of("alone") == of("out"), "{sets:?}: {file} differs");
        }
        let log = read(&folder.path().join("out/agent-1.log"));
        assert!(log.contains("the mission is over"), "{log}");
        // What flies it again is what the user said, not what processes said to each other.
        let line = json(&folder.path().join("out/provenance.json"))["arguments"].clone();
        let length = ["csat", "spawn"].len() + mission.len() + ["--listen", "", "--out", ""].len();
        assert_eq!(line[1], "spawn", "{line}");
        assert_eq!(line.as_array().map(Vec::len), Some(length + sets.len()), "{line}");
        expect_nobody(&endpoint);
    }
}

#[test]
fn in_real_time_nobody_waits_and_the_guarantee_holds() {
    let (folder, endpoint) = (scratch(), endpoint());
    let output = end(spawn(folder.path(), &endpoint, "10", &["--realtime", "4", "--json"]));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&summary["violations"], &summary["steps"]), (&0.into(), &20.into()));
    assert!(summary["wall_s"].as_f64().unwrap() >= 2.5, "{}", summary["wall_s"]);
    assert!(summary["messages"]["delivered"].as_u64().unwrap() > 0);
    expect_nobody(&endpoint);
}

/// No process takes a frame in the half of a millisecond that this pace gives it.
#[test]
fn frames_that_were_missed_are_told() {
    let (folder, endpoint) = (scratch(), endpoint());
    let output = end(spawn(folder.path(), &endpoint, "60", &["--realtime", "1000"]));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let frames = json(&folder.path().join("out/summary.json"))["frames"].clone();
    let [shown, missed] = ["shown", "missed"].map(|key| frames[1][key].as_u64().unwrap());
    assert!(shown == 121 && (1..=121).contains(&missed), "{frames}");
    let told = format!("\nwarning: UAV 1 missed {missed} of 121 frames\n");
    assert!(text(&output.stdout).contains(&told), "{}", text(&output.stdout));
}

#[test]
fn a_killed_agent_is_noticed_and_comes_back() {
    let (folder, endpoint) = (scratch(), endpoint());
    let child = spawn(folder.path(), &endpoint, "600", &["--restart"]);
    wait_for_flight(folder.path());
    signal(agent_process(&endpoint, 1).expect("UAV 1 has a process"), "-KILL");
    let output = end(child);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("the process of UAV 1 ended (signal: 9 (SIGKILL)); starting it again"),
        "{said}"
    );
    let events = read(&folder.path().join("out/events.jsonl"));
    assert!(events.contains(r#"{"agent":1,"event":"crashed""#), "{events}");
    let back = events.lines().find(|line| line.contains(r#""event":"restarted""#));
    assert!(back.is_some_and(|line| line.ends_with("\"incarnation\":1}")), "{events}");
    let summary = json(&folder.path().join("out/summary.json"));
    assert_eq!(summary["violations"], 0);
    // Links count on across the processes at their ends.
    let mut links = csv::Reader::from_path(folder.path().join("out/links.csv")).unwrap();
    let column = links.headers().unwrap().iter().position(|name| name == "sent").unwrap();
    let sent = links.records().map(|row| row.unwrap()[column].parse::<u64>().unwrap());
    assert_eq!(sent.sum::<u64>(), summary["messages"]["sent"].as_u64().unwrap());
    expect_nobody(&endpoint);
}

#[test]
fn the_others_carry_on_without_a_killed_agent() {
    let (folder, endpoint) = (scratch(), endpoint());
    let child = spawn(folder.path(), &endpoint, "300", &[]);
    wait_for_flight(folder.path());
    signal(agent_process(&endpoint, 0).expect("UAV 0 has a process"), "-KILL");
    let output = end(child);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("the others carry on"), "{said}");
    let summary = json(&folder.path().join("out/summary.json"));
    assert_eq!((&summary["violations"], &summary["steps"]), (&0.into(), &600.into()));
    expect_nobody(&endpoint);
}

#[test]
fn ctrl_c_leaves_a_readable_folder_and_no_process() {
    let (folder, endpoint) = (scratch(), endpoint());
    let child = spawn(folder.path(), &endpoint, "3000", &[]);
    wait_for_flight(folder.path());
    signal(child.id(), "-INT");
    let output = end(child);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert_eq!(json(&folder.path().join("out/summary.json"))["interrupted"], true);
    expect_nobody(&endpoint);
}

#[test]
fn nobody_outlives_a_killed_spawner() {
    let (folder, endpoint) = (scratch(), endpoint());
    let mut child = spawn(folder.path(), &endpoint, "3000", &[]);
    wait_for_flight(folder.path());
    child.kill().unwrap();
    child.wait().unwrap();
    expect_nobody(&endpoint);
    assert_eq!(json(&folder.path().join("out/summary.json"))["interrupted"], true);
}

/// Its world is not there yet, and its patience is long.
#[test]
fn an_agent_that_looks_for_its_world_is_on_the_leash() {
    let (folder, endpoint) = (scratch(), endpoint());
    let arguments = ["agent", "--leashed", "--id", "0", "--patience", "86400"];
    let mut agent = command(folder.path(), &[&arguments[..], &["--connect", &endpoint]].concat())
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(agent.stdin.take());
    let output = end(agent);
    let said = text(&output.stderr);
    assert!(said.contains("ended by whoever spawned it"), "{said}");
    expect_nobody(&endpoint);
}

#[test]
fn agents_end_with_a_message_when_their_world_is_killed() {
    let (folder, endpoint) = (scratch(), endpoint());
    let child = spawn(folder.path(), &endpoint, "3000", &[]);
    wait_for_flight(folder.path());
    let all = processes(&endpoint);
    let world = all.iter().find(|(_, line)| line.contains(" world "));
    signal(world.expect("the world has a process").0, "-KILL");
    let output = end(child);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "nobody pressed Ctrl-C: {said}");
    assert!(said.contains("the world ended without a word"), "{said}");
    let kept = said.split("the world was killed (signal: 9 (SIGKILL)); the agents' logs are in `");
    let kept = kept.last().and_then(|rest| rest.split('`').next()).expect(&said);
    assert_eq!(names(std::path::Path::new(kept)), ["agent-0.log", "agent-1.log"]);
    std::fs::remove_dir_all(kept).unwrap();
    expect_nobody(&endpoint);
}

/// Asks to take part as UAV 1 with these words; the refusal.
fn join_as(endpoint: &str, words: &str) -> String {
    use zenoh::Wait;
    let mut config = zenoh::Config::default();
    config.insert_json5("mode", "'client'").unwrap();
    config.insert_json5("connect/endpoints", &format!("[\"{endpoint}\"]")).unwrap();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    let session = zenoh::open(config).wait().unwrap();
    let replies = session.get("csat/*/join/1").payload(words).wait().unwrap();
    let reply = replies.recv().expect("the world answers").into_result();
    let refusal = reply.expect_err("the world refuses").payload().to_bytes().into_owned();
    let _ = session.close().wait();
    text(&refusal)
}

#[test]
fn whoever_does_not_belong_is_refused_with_a_reason() {
    let (folder, endpoint) = (scratch(), endpoint());
    let fleet = spawn(folder.path(), &endpoint, "3000", &[]);
    wait_for_flight(folder.path());
    for (arguments, code, expected) in [
        (&["agent", "--id", "1"][..], 2, "UAV 1 is flown by another process"),
        (&["agent", "--id", "7"], 2, "there is no UAV 7 in a fleet of 2"),
        (&["agent", "--id", "1", "--run", "99", "--patience", "1"], 1, "waited 1 s for a world"),
    ] {
        let output = csat(folder.path(), &[arguments, &["--connect", &endpoint]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(expected), "{said}");
    }
    // Another version of the protocol.
    let refused = join_as(&endpoint, r#"{"protocol":99,"program":"x","agent":1,"process":1}"#);
    assert!(
        refused.contains("x speaks version 99 of the protocol, this world version"),
        "{refused}"
    );
    let refused = join_as(&endpoint, "hello");
    assert!(refused.contains("not understood"), "{refused}");
    // The same run again, at a world that knows the first one.
    let other = common::fleet::endpoint();
    let mission = mission("5");
    let mut again = vec!["world", "--listen", &other, "--connect", &endpoint, "--out", "again"];
    again.extend(mission.iter().map(String::as_str));
    let output = csat(folder.path(), &again);
    assert!(text(&output.stderr).contains("has a world already"), "{}", text(&output.stderr));
    // The same port.
    let output = csat(folder.path(), &["world", "--listen", &endpoint, "--out", "port"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("expected free ports"), "{}", text(&output.stderr));
    signal(fleet.id(), "-INT");
    assert_eq!(end(fleet).status.code(), Some(130), "the fleet was not disturbed");
    expect_nobody(&endpoint);
}

#[test]
fn whoever_is_missing_is_named() {
    let (folder, endpoint) = (scratch(), endpoint());
    let mission = mission("5");
    let mut world = vec!["world", "--listen", &endpoint, "--out", "out", "--patience", "2"];
    world.extend(mission.iter().map(String::as_str));
    let world = process(folder.path(), &world);
    let agent = process(folder.path(), &["agent", "--id", "0", "--connect", &endpoint]);
    let output = end(world);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("waited 2 s for UAVs 0, 1 to join"), "{said}");
    let output = end(agent);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    expect_nobody(&endpoint);
}

/// Nothing flew: there is nothing to keep.
#[test]
fn ctrl_c_while_somebody_is_missing_leaves_nothing() {
    let (folder, endpoint) = (scratch(), endpoint());
    let mission = mission("5");
    let mut world = vec!["world", "--listen", &endpoint, "--out", "out", "--patience", "600"];
    world.extend(mission.iter().map(String::as_str));
    let world = process(folder.path(), &world);
    wait_until("the world waits", || {
        names(folder.path()).iter().any(|name| name.starts_with(".out.partial-"))
    });
    signal(world.id(), "-INT");
    let output = end(world);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert_eq!(names(folder.path()), Vec::<String>::new());
    expect_nobody(&endpoint);
}

#[test]
fn a_fleet_that_fails_leaves_its_agents_logs() {
    let (folder, endpoint) = (scratch(), endpoint());
    let logs = folder.path().join("logs");
    std::fs::create_dir(&logs).unwrap();
    std::fs::write(logs.join("agent-0.log"), "what went wrong").unwrap();
    let mission = mission("5");
    let mut world = vec!["world", "--listen", &endpoint, "--out", "out", "--patience", "1"];
    world.extend(["--logs", "logs"]);
    world.extend(mission.iter().map(String::as_str));
    let output = csat(folder.path(), &world);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let partial = names(folder.path()).into_iter().find(|name| name.starts_with(".out.partial-"));
    let log = folder.path().join(partial.expect("pieces stay")).join("agent-0.log");
    assert_eq!(read(&log), "what went wrong");
    assert!(!logs.exists());
}

#[test]
fn bad_configurations_of_zenoh_are_refused() {
    let folder = scratch();
    std::fs::write(folder.path().join("zenoh.json5"), "{mode: 'queen'}").unwrap();
    for (arguments, expected) in [
        (&["--zenoh-config", "zenoh.json5"][..], "cannot use the Zenoh configuration"),
        (&["--zenoh-config", "none.json5"], "cannot use the Zenoh configuration"),
        (&["--connect", "somewhere"], "`somewhere` is no Zenoh endpoint"),
    ] {
        let output = csat(folder.path(), &[&["agent", "--id", "0"], arguments].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}

/// Says what nobody understands, as fast as it goes.
fn flood(endpoint: &str, seed: u64) {
    use zenoh::Wait;
    let mut config = zenoh::Config::default();
    config.insert_json5("connect/endpoints", &format!("[\"{endpoint}\"]")).unwrap();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    let session = zenoh::open(config).wait().unwrap();
    for number in 0..4_000u32 {
        for name in ["link/1/0", "uav/0/command", "uav/1/report", "clock"] {
            let junk = [&number.to_le_bytes()[..], b"{not a message"].concat();
            session.put(format!("csat/{seed}/{name}"), junk).wait().unwrap();
        }
    }
    // It may take its time, with all that is still to be sent.
    let _ = session.close().wait();
}

#[test]
fn a_peer_that_floods_changes_nothing() {
    let digest = |flooded: bool| {
        let (folder, endpoint) = (scratch(), endpoint());
        let child = spawn(folder.path(), &endpoint, "600", &["--seed", "5"]);
        if flooded {
            wait_for_flight(folder.path());
            flood(&endpoint, 5);
        }
        let output = end(child);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert_eq!(said.contains("not understood"), flooded, "{said}");
        assert!(said.lines().count() < 200, "a flood of complaints: {said}");
        json(&folder.path().join("out/summary.json"))["digest"].clone()
    };
    assert_eq!(digest(true), digest(false));
}
