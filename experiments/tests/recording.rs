//! `csat run --record` and `csat replay`.

#![cfg(unix)]

mod common;

use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use common::{command, csat, json, names, scratch, small_run, text};
use zenoh::{Config, Wait};

/// How long anything here may take.
const LIMIT: Duration = Duration::from_secs(60);

#[test]
fn a_recording_is_part_of_the_folder_and_changes_nothing_else() {
    let base = scratch();
    let plain = small_run(base.path(), &["--out", "plain"]);
    let recorded = small_run(base.path(), &["--out", "recorded", "--record"]);
    assert!(recorded.status.success(), "{}", text(&recorded.stderr));
    assert!(text(&recorded.stdout).contains("\nrecording.mcap: "), "{}", text(&recorded.stdout));
    assert!(!text(&plain.stdout).contains("recording"));
    let [plain, recorded] = ["plain", "recorded"].map(|name| base.path().join(name));
    let mut expected = names(&plain);
    expected.push("recording.mcap".to_owned());
    expected.sort();
    assert_eq!(names(&recorded), expected);
    for name in ["metrics.csv", "events.jsonl", "links.csv", "view.json"] {
        let [a, b] = [&plain, &recorded].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{name}");
    }
    let digests =
        [&plain, &recorded].map(|folder| json(&folder.join("summary.json"))["digest"].clone());
    assert_eq!(digests[0], digests[1]);
}

#[test]
fn periods_that_are_none_are_refused() {
    let base = scratch();
    for period in ["0", "-1", "inf", "often"] {
        let output = small_run(base.path(), &[&format!("--record={period}")]);
        assert_eq!(output.status.code(), Some(2));
        let said = text(&output.stderr);
        assert!(said.contains("expected a positive number"), "{said}");
    }
    assert!(names(base.path()).is_empty());
}

#[test]
fn replays_of_nothing_say_what_was_expected() {
    let base = scratch();
    let output = csat(base.path(), &["replay", "nowhere"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        text(&output.stderr),
        "error: nowhere/recording.mcap: not found; expected a run flown with --record\n"
    );
}

/// A session that listens, and where.
fn listener() -> (zenoh::Session, String) {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let endpoint = format!("tcp/127.0.0.1:{free}");
    let mut config = Config::default();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    config.insert_json5("listen/endpoints", &format!("[\"{endpoint}\"]")).unwrap();
    (zenoh::open(config).wait().unwrap(), endpoint)
}

#[test]
fn a_replay_is_heard_and_ends_with_ctrl_c() {
    let base = scratch();
    let flown = small_run(base.path(), &["--out", "run", "--record", "--seed", "7"]);
    assert!(flown.status.success(), "{}", text(&flown.stderr));
    let (session, endpoint) = listener();
    let (heard, hears) = mpsc::channel();
    let _subscriber = session
        .declare_subscriber("csat/7/**")
        .callback(move |sample| {
            let body = sample.payload().try_to_string().unwrap().into_owned();
            let key = sample.key_expr().as_str().to_owned();
            let _ = heard.send((key, sample.encoding().to_string(), body));
        })
        .wait()
        .unwrap();
    let arguments =
        ["replay", "run", "--loop", "--speed", "20", "--connect", &endpoint, "--listen"];
    let child = command(base.path(), &[&arguments[..], &["tcp/127.0.0.1:0"]].concat())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    for (wanted, encoding) in [
        ("csat/7/view/1/pose", "application/json"),
        ("csat/7/view/0/unexplored", "application/geo+json"),
        ("csat/7/truth/metrics", "application/json"),
        ("csat/7/truth/town", "application/geo+json"),
    ] {
        let (_, got, body) = loop {
            let sample = hears.recv_timeout(LIMIT).unwrap_or_else(|_| panic!("no {wanted}"));
            if sample.0 == wanted {
                break sample;
            }
        };
        assert_eq!(got, encoding, "{wanted}");
        serde_json::from_str::<serde_json::Value>(&body).unwrap();
    }
    for (key, part) in [("town", "\"building\""), ("layers", "\"unexplored\"")] {
        let replies = session.get(format!("csat/7/truth/{key}")).wait().unwrap();
        let reply = replies.recv_timeout(LIMIT).unwrap().expect("an answer");
        let said = reply.into_result().unwrap().payload().try_to_string().unwrap().into_owned();
        assert!(said.contains(part), "{key}");
    }
    let kill = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    assert!(said.contains("playing city with seed 7 under csat/7/view/**"), "{said}");
}
