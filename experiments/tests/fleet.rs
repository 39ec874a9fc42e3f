//! Fleets of processes (`csat spawn`, `csat world`, `csat agent`), on loopback.

#![cfg(unix)]

mod common;

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use common::fleet::{
    agent_process, end, endpoint, expect_nobody, mission, process, processes, signal, spawn,
    wait_for_flight, wait_until,
};
use common::{command, csat, json, names, read, scratch, text};
use serde_json::json;
use zenoh::Wait;
use zenoh::handlers::{RingChannel, RingChannelHandler};
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;

/// What a run folder holds besides what is of the process that made it: equal however a mission is flown.
fn expect_equal_folders(folder: &Path, context: &str) {
    let of_the_process = |name: &String| {
        name.ends_with(".log") || ["provenance.json", "summary.json"].contains(&name.as_str())
    };
    let files = |name: &str| {
        let mut files = names(&folder.join(name));
        files.retain(|file| !of_the_process(file));
        files
    };
    assert_eq!(files("alone"), files("out"), "{context}");
    for file in files("alone") {
        let of = |name: &str| std::fs::read(folder.join(name).join(&file)).unwrap();
        assert!(of("alone") == of("out"), "{context}: {file} differs");
    }
    let summary = |name: &str| {
        let mut summary = json(&folder.join(name).join("summary.json"));
        let members = summary.as_object_mut().unwrap();
        for of_the_computer in ["timing_ms", "wall_s", "realtime_factor"] {
            assert!(members.remove(of_the_computer).is_some(), "{of_the_computer}");
        }
        summary
    };
    assert_eq!(summary("alone"), summary("out"), "{context}");
}

/// Some of these end while an agent is down.
#[test]
fn lockstep_gives_to_the_last_byte_what_one_process_gives() {
    let bursty = "netem.radio.loss={model=\"gilbert-elliott\",p=0.05,r=0.2,h=0.0,k=1.0}";
    let slow = "netem.radio.delay={model=\"pareto\",mean_s=1.0}";
    let crash = "netem.outage=[{kind=\"crash\",agent=1,from_s=3.0,until_s=5.0}]";
    let storm = "netem.outage=[{kind=\"crash\",agent=0,from_s=2.0,until_s=4.0},\
                 {kind=\"crash\",agent=2,from_s=8.0,until_s=99.0}]";
    // Agents 2 and 3, on the ground, to the west and to the north.
    let stations = "stations=[{x_m=-80,y_m=0,z_m=0},{x_m=0,y_m=80,z_m=3}]";
    let station_crash = "netem.outage=[{kind=\"crash\",agent=2,from_s=3.0,until_s=5.0}]";
    for sets in [
        &["agents.count=1"][..],
        &["exchange.mode=snapshot", "agents.count=3"],
        &["exchange.mode=facts", "netem.radio.range_m=60", bursty],
        &["exchange.mode=facts+repair", "agents.count=4", bursty, slow, crash],
        &["exchange.mode=facts+repair", "agents.count=3", bursty, storm],
        &["exchange.mode=none"],
        &[stations, "netem.radio.propagation={obstruction_db=40}", station_crash],
        &[stations, "exchange.mode=snapshot", slow],
    ] {
        let folder = scratch();
        let endpoint = endpoint();
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let mut alone = vec!["run", "--record=2", "--out", "alone"];
        let mission = mission("10");
        alone.extend(mission.iter().map(String::as_str));
        alone.extend(&sets);
        let output = csat(folder.path(), &alone);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let more = [&sets[..], &["--record=2", "--patience", "20"]].concat();
        let output = end(spawn(folder.path(), &endpoint, "10", &more));
        assert_eq!(output.status.code(), Some(0), "{sets:?}: {}", text(&output.stderr));
        expect_equal_folders(folder.path(), &format!("{sets:?}"));
        let log = read(&folder.path().join("out/agent-0.log"));
        assert!(log.contains("the mission is over"), "{log}");
        // What flies it again is what the user said, not what processes said to each other.
        let line = json(&folder.path().join("out/provenance.json"))["arguments"].clone();
        let length = ["csat", "spawn"].len() + mission.len() + ["--listen", "", "--out", ""].len();
        assert_eq!(line[1], "spawn", "{line}");
        assert_eq!(line.as_array().map(Vec::len), Some(length + more.len()), "{line}");
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
    assert_eq!(summary["refused"], json!({}), "nothing but the fleet's own was said");
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
    assert!(back.is_some_and(|line| line.contains("\"incarnation\":1,")), "{events}");
    let summary = json(&folder.path().join("out/summary.json"));
    assert_eq!(summary["violations"], 0);
    assert_eq!(summary["refused"], json!({}), "nothing but the fleet's own was said");
    // Links count on across the processes at their ends.
    let mut links = csv::Reader::from_path(folder.path().join("out/links.csv")).unwrap();
    let column = links.headers().unwrap().iter().position(|name| name == "sent").unwrap();
    let sent = links.records().map(|row| row.unwrap()[column].parse::<u64>().unwrap());
    assert_eq!(sent.sum::<u64>(), summary["messages"]["sent"].as_u64().unwrap());
    expect_nobody(&endpoint);
}

/// None is left: the fleet waits for them.
#[test]
fn agents_that_are_killed_together_come_back() {
    for more in [&["--restart"][..], &["--restart", "--realtime", "40"]] {
        let (folder, endpoint) = (scratch(), endpoint());
        let child = spawn(folder.path(), &endpoint, "600", more);
        wait_for_flight(folder.path());
        for id in [0, 1] {
            signal(agent_process(&endpoint, id).expect("it has a process"), "-KILL");
        }
        let output = end(child);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        let events = read(&folder.path().join("out/events.jsonl"));
        for id in [0, 1] {
            let back = format!("{{\"agent\":{id},\"event\":\"restarted\"");
            assert!(events.contains(&back), "{events}");
        }
        assert_eq!(json(&folder.path().join("out/summary.json"))["violations"], 0);
        expect_nobody(&endpoint);
    }
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
    // All frames count, also those that no process was there to look at.
    let [shown, missed] =
        ["shown", "missed"].map(|key| summary["frames"][0][key].as_u64().unwrap());
    assert!(shown == 601 && missed > 0, "{summary}");
    let silent_s = &summary["frames"][0]["silent_s"];
    assert_eq!(silent_s[0][1], 300.5, "{silent_s}");
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

/// They are told at the start, for whoever wants to end one.
fn pids(said: &str) -> Vec<u32> {
    let line = said.lines().find(|line| line.starts_with("processes: world ")).expect(said);
    line.split([' ', ',']).filter_map(|word| word.parse().ok()).filter(|pid| *pid > 0).collect()
}

/// Agents that wait for their world to answer are let go of, whatever it does.
#[test]
fn ctrl_c_before_all_have_joined_ends_at_once() {
    let (folder, endpoint) = (scratch(), endpoint());
    let child = spawn(folder.path(), &endpoint, "3000", &["--set", "agents.count=3"]);
    // A process that was forked and has not begun looks like its parent.
    wait_until("there are processes", || {
        processes(&endpoint).len() == 5 && agent_process(&endpoint, 2).is_some()
    });
    // It is welcomed, and hears nothing more.
    let late = agent_process(&endpoint, 2).expect("UAV 2 has a process");
    signal(late, "-STOP");
    signal(child.id(), "-INT");
    let output = end(child);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(pids(&said).contains(&late), "{said}");
    expect_nobody(&endpoint);
}

/// A process that is stopped cannot end in order.
#[test]
fn ctrl_c_wakes_a_world_that_is_stopped() {
    let (folder, endpoint) = (scratch(), endpoint());
    let child = spawn(folder.path(), &endpoint, "3000", &[]);
    wait_for_flight(folder.path());
    let all = processes(&endpoint);
    let world = all.iter().find(|(_, line)| line.contains(" world ")).expect("it has a process");
    signal(world.0, "-STOP");
    signal(child.id(), "-INT");
    let output = end(child);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert_eq!(json(&folder.path().join("out/summary.json"))["interrupted"], true);
    expect_nobody(&endpoint);
}

/// One that is stopped is missed, its frames are counted, and it is told from when to when it was silent.
#[test]
fn an_agent_that_is_stopped_is_named_with_its_silence() {
    let (folder, endpoint) = (scratch(), endpoint());
    let more = ["--realtime", "10", "--set", "agents.count=3"];
    let child = spawn(folder.path(), &endpoint, "60", &more);
    wait_for_flight(folder.path());
    let stopped = agent_process(&endpoint, 1).expect("UAV 1 has a process");
    signal(stopped, "-STOP");
    std::thread::sleep(Duration::from_secs(3));
    signal(stopped, "-CONT");
    signal(agent_process(&endpoint, 2).expect("UAV 2 has a process"), "-KILL");
    let output = end(child);
    let (out, said) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{said}");
    let frames = json(&folder.path().join("out/summary.json"))["frames"].clone();
    for agent in [1, 2] {
        let [shown, missed] = ["shown", "missed"].map(|key| frames[agent][key].as_u64().unwrap());
        assert!(shown == 121 && missed >= 10, "{frames}");
        let span = frames[agent]["silent_s"].as_array().unwrap().last().expect("it was silent");
        let [from_s, to_s] = [0, 1].map(|end| span[end].as_f64().unwrap());
        // A period is half a second.
        assert!((to_s - from_s) * 2.0 <= missed as f64 + 1.0 && to_s - from_s > 10.0, "{frames}");
        let told = format!("warning: UAV {agent} missed {missed} of 121 frames, silent from ");
        assert!(out.contains(&told) && out.contains(&format!(" to {to_s} s")), "{out}");
    }
    assert_eq!(frames[2]["silent_s"][0][1], 60.5, "until the end: {frames}");
    assert!(said.contains("nothing is heard of its process"), "{said}");
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
fn an_agent_that_looks_for_its_world_ends_with_its_parent() {
    let (folder, endpoint) = (scratch(), endpoint());
    let arguments = ["agent", "--end-with-parent", "--id", "0", "--patience", "86400"];
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
        (&["agent", "--id", "1"][..], 2, "agent 1 is flown by another process"),
        (&["agent", "--id", "7"], 2, "there is no agent 7 among 2"),
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

/// An agent that nobody answers says what came of connecting.
#[test]
fn an_agent_without_a_world_names_the_cause() {
    let folder = scratch();
    let (nowhere, other) = (endpoint(), std::net::TcpListener::bind("127.0.0.1:0").unwrap());
    let other = format!("tcp/{}", other.local_addr().unwrap());
    for (endpoint, expected) in [
        (&nowhere, "connection refused, nobody listens there"),
        (&other, "connected to nobody: whoever takes the connection is no Zenoh"),
    ] {
        let arguments = ["agent", "--id", "0", "--patience", "1", "--connect", endpoint];
        let said = text(&csat(folder.path(), &arguments).stderr);
        assert!(said.contains("waited 1 s for a world to answer"), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn whoever_is_missing_is_named() {
    let (folder, endpoint) = (scratch(), endpoint());
    let mission = mission("5");
    let mut world = vec!["world", "--listen", &endpoint, "--out", "out", "--patience", "8"];
    world.extend(mission.iter().map(String::as_str));
    let world = process(folder.path(), &world);
    let agent = process(folder.path(), &["agent", "--id", "0", "--connect", &endpoint]);
    let output = end(world);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("waited 8 s for UAV 1 to join"), "{said}");
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
    std::fs::write(folder.path().join("client.json5"), "{mode: 'client'}").unwrap();
    std::fs::write(folder.path().join("deaf.json5"), "{listen: 7, connect: []}").unwrap();
    for (arguments, expected) in [
        (&["--zenoh-config", "zenoh.json5"][..], "cannot use the Zenoh configuration"),
        (&["--zenoh-config", "none.json5"], "cannot use the Zenoh configuration"),
        (&["--zenoh-config", "deaf.json5"], "cannot use the Zenoh configuration"),
        (&["--zenoh-config", "client.json5"], "expected mode: \"peer\""),
        (&["--connect", "somewhere"], "`somewhere` is no Zenoh endpoint"),
        (&["--connect", "quic/127.0.0.1:1"], "only, not for quic\n  = expected such as tcp/"),
    ] {
        let output = csat(folder.path(), &[&["agent", "--id", "0"], arguments].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}

/// Whoever is to connect must be told which.
#[test]
fn any_free_port_will_do() {
    let folder = scratch();
    let output = end(spawn(folder.path(), "tcp/127.0.0.1:0", "2", &[]));
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("2 agents on tcp/127.0.0.1:") && !said.contains(":0;"), "{said}");
    let mission = mission("2");
    let mut world =
        vec!["world", "--listen", "tcp/127.0.0.1:0", "--out", "lone", "--patience", "1"];
    world.extend(mission.iter().map(String::as_str));
    let output = csat(folder.path(), &world);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let told = said.lines().find_map(|line| line.strip_prefix("listens on tcp/127.0.0.1:"));
    assert!(told.is_some_and(|port| port != "0"), "{said}");
}

/// A peer that belongs to no fleet.
fn stranger(endpoint: &str) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    config.insert_json5("connect/endpoints", &format!("[\"{endpoint}\"]")).unwrap();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    zenoh::open(config).wait().unwrap()
}

/// The digest and what was refused of a mission in which a stranger does something.
fn disturbed(disturb: impl FnOnce(&str)) -> (String, serde_json::Value, String) {
    let (folder, endpoint) = (scratch(), endpoint());
    let child = spawn(folder.path(), &endpoint, "600", &["--seed", "5"]);
    wait_for_flight(folder.path());
    disturb(&endpoint);
    let output = end(child);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let summary = json(&folder.path().join("out/summary.json"));
    expect_nobody(&endpoint);
    (summary["digest"].to_string(), summary["refused"].clone(), said)
}

/// Says what nobody understands, as fast as it goes.
fn flood(endpoint: &str) {
    let session = stranger(endpoint);
    for number in 0..4_000u32 {
        for name in ["link/1/0", "uav/0/command", "uav/1/report", "clock"] {
            let junk = [&number.to_le_bytes()[..], b"{not a message"].concat();
            session.put(format!("csat/5/{name}"), junk).wait().unwrap();
        }
    }
    csat_peer::wire::session::close(session);
}

/// Says what others say, in their names and with all that can be heard of them, at the wrong time.
fn forge(endpoint: &str) {
    let session = stranger(endpoint);
    // It forgets what it is too slow to read: a full queue would hold up the fleet.
    let listen = |key: &str| {
        let subscriber = session.declare_subscriber(format!("csat/5/{key}"));
        subscriber.with(RingChannel::new(4)).wait().unwrap()
    };
    let (orders, answers) = (listen("clock"), listen("uav/0/command"));
    let heard = |sample: Sample| -> serde_json::Value {
        serde_json::from_slice(&sample.payload().to_bytes()).unwrap()
    };
    let put = |key: &str, what: &serde_json::Value| {
        session.put(format!("csat/5/{key}"), what.to_string()).wait().unwrap();
    };
    let envelope = |sequence| csat_proto::envelope::Envelope {
        run: csat_proto::ids::RunId(5),
        src: csat_proto::ids::AgentId(1),
        incarnation: csat_proto::ids::Incarnation(0),
        channel: csat_proto::ids::ChannelId(0),
        sequence,
        step: csat_proto::time::Step(0),
        time: csat_proto::time::SimTime(0),
        pose: csat_proto::camera::Pose::level([0.0, 0.0, 50.0], 0.0).into(),
        body: b"forged".to_vec(),
    };
    for _ in 0..50 {
        let next = |said: &Subscriber<RingChannelHandler<Sample>>| {
            said.recv_timeout(Duration::from_secs(60)).ok().flatten()
        };
        let (order, answer) =
            (next(&orders).expect("an order"), next(&answers).expect("an answer"));
        let (order, answer) = (heard(order), heard(answer));
        let (world, process, step) = (&order["world"], &answer["process"], &order["step"]);
        for (world, step) in [(world, &json!(9_999)), (&json!(1), step)] {
            let pose = json!({"p_world": [0, 0, 50], "yaw_rad": 0, "pitch_rad": 0, "roll_rad": 0});
            let header = json!({"world": world, "step": step, "time": 0, "next": 0, "pose": pose,
                "incarnation": 0, "detections": [], "said": []});
            let frame = session.put("csat/5/uav/0/frame", [0; 4]).attachment(header.to_string());
            frame.wait().unwrap();
            put("clock", &json!({"world": world, "order": "show", "step": step}));
            let said = json!([{"agent": 1, "incarnation": 0, "next": [u64::MAX]}]);
            put(
                "clock",
                &json!({"world": world, "order": "turn", "step": step, "round": 1, "now": 0,
                "said": said}),
            );
        }
        // What it really asks for, but too early, and a pattern of keys that includes that of the clock.
        put("clock", &json!({"world": world, "order": "close", "step": step, "full": true}));
        put("clock", &json!({"world": 1, "order": "end", "reason": "forged"}));
        put("*", &json!({"world": world, "order": "end", "reason": "forged"}));
        for (step, next) in [(&json!(9_999), 1), (step, u64::MAX)] {
            let said = json!({"agent": 0, "incarnation": 0, "next": [next]});
            put(
                "uav/0/command",
                &json!({"process": process, "step": step, "round": 0, "said": said,
                "due": 0, "commands": [{"yaw_rad": 1}]}),
            );
        }
        for sequence in [0, 1 << 40, u64::MAX] {
            session.put("csat/5/link/1/0", envelope(sequence).encode()).wait().unwrap();
        }
    }
    drop((orders, answers));
    csat_peer::wire::session::close(session);
}

#[test]
fn strangers_change_nothing_by_what_cannot_be_and_it_is_counted() {
    let (digest, refused, _) = disturbed(|_| ());
    assert_eq!(refused, json!({}));
    let (flooded, refused, said) = disturbed(flood);
    assert_eq!(flooded, digest, "{refused}");
    assert!(refused["not-understood"].as_u64().unwrap() > 1_000, "{refused}");
    assert!(said.contains("not-understood") && said.lines().count() < 300, "too long: {said}");
    let (forged, refused, _) = disturbed(forge);
    for kind in ["frame", "order", "answer", "message", "key"] {
        assert!(refused[kind].as_u64().is_some_and(|count| count > 0), "{kind}: {refused}");
    }
    assert_eq!(forged, digest, "{refused}");
}
