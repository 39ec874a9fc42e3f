//! docs/outputs.md and the files of a run: every column and every field that a run writes is described,
//! and what is described is written.

mod common;

use std::collections::BTreeSet;
use std::path::Path;

use common::docs::root;
use common::{csat, json, read, scratch, small_run, text};
use csat_agent::agent::Event;
use csat_experiments::bayes::Bayes;
use csat_experiments::clearing::Clearing;
use csat_experiments::flight::ViolationLine;
use csat_experiments::outputs::{File, files, own_files};
use csat_experiments::set_membership::SetMembership;
use csat_experiments::set_membership::judge::{ACCUSATION, GUARANTEE};
use csat_experiments::summary::NamedLiar;
use csat_mission::judge::{self, Broken};
use csat_mission::mission::Whole;
use csat_proto::ids::{AgentId, TargetId};
use csat_proto::time::Step;
use csat_world::truth::{Fault, MessageCounts, Promise, Violation};
use serde_json::Value;

/// Links that do everything a link can do to a message, and an agent that dies and comes back.
const STORM: &[&str] = &[
    "stations=[{x_m=10,y_m=0,z_m=2}]",
    "netem.trace=\"all\"",
    "netem.radio.range_m=60",
    "netem.radio.corruption=0.2",
    "netem.radio.duplication=0.2",
    "netem.radio.delay={model=\"constant\",mean_s=0.2}",
    "netem.outage=[{agent=1,from_s=2,until_s=3,kind=\"crash\"}]",
];

/// Adds the keys of a JSON value, those within others behind a dot.
fn keys(value: &Value, prefix: &str, into: &mut BTreeSet<String>) {
    let within =
        |key: &str| if prefix.is_empty() { key.to_owned() } else { format!("{prefix}.{key}") };
    match value {
        Value::Object(members) if members.is_empty() => _ = into.insert(within("*")),
        Value::Object(members) => {
            members.iter().for_each(|(key, value)| keys(value, &within(key), into));
        }
        Value::Array(elements) if elements.iter().any(Value::is_object) => {
            elements.iter().for_each(|element| keys(element, &format!("{prefix}[]"), into));
        }
        _ => {
            into.insert(prefix.to_owned());
        }
    }
}

/// The keys of a line of `events.jsonl`, behind its kind.
fn event_keys(event: &Value, into: &mut BTreeSet<String>) {
    keys(event, event["event"].as_str().expect("a line says what happened"), into);
}

fn header(path: &Path, into: &mut BTreeSet<String>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    into.extend(reader.headers().unwrap().iter().map(str::to_owned));
}

/// A fault that breaks a promise: what the monitor would write down.
fn broken(promise: Promise) -> Fault {
    let (target, location) = (TargetId(1), [1.0, 2.0]);
    let (distance_m, limit_m) = (1.0, 2.5);
    match promise {
        Promise::ObstacleDistance => {
            Fault::ObstacleDistance { target, obstacle: 3, distance_m, limit_m }
        }
        Promise::TargetDistance => {
            Fault::TargetDistance { a: TargetId(0), b: target, distance_m, limit_m }
        }
        Promise::OutsideRegion => Fault::OutsideRegion { target, location },
        Promise::Speed => Fault::Speed { target, moved_m: 3.0, limit_m },
        Promise::BuildingDistance => {
            Fault::BuildingDistance { agent: AgentId(0), obstacle: 3, distance_m, limit_m }
        }
        Promise::MessageConservation => {
            Fault::MessageConservation { counts: MessageCounts::default() }
        }
    }
}

/// The keys of what runs write, by file; what no sound run writes is written as it would be.
fn written() -> Vec<(&'static str, BTreeSet<String>)> {
    let base = scratch();
    let sets: Vec<&str> = STORM.iter().flat_map(|set| ["--set", set]).collect();
    let storm = small_run(base.path(), &[&sets[..], &["--out", "storm"]].concat());
    assert_eq!(storm.status.code(), Some(0), "{}", text(&storm.stderr));
    let folder = base.path().join("storm");
    let [mut metrics, mut links, mut events, mut summary] = [(); 4].map(|()| BTreeSet::new());
    header(&folder.join("metrics.csv"), &mut metrics);
    header(&folder.join("links.csv"), &mut links);
    for line in read(&folder.join("events.jsonl")).lines() {
        event_keys(&serde_json::from_str(line).expect(line), &mut events);
    }
    for promise in Promise::ALL {
        let violation = Violation { step: Step(3), fault: broken(promise) }.into();
        let line = serde_json::to_value(ViolationLine::new(&violation, 1.5)).unwrap();
        event_keys(&line, &mut events);
    }
    let wronged = Broken::new(ACCUSATION, AgentId(0), serde_json::json!({ "named": 1 }));
    let wronged = judge::Violation { step: Step(3), fault: judge::Fault::Mission(wronged) };
    event_keys(&serde_json::to_value(ViolationLine::new(&wronged, 1.5)).unwrap(), &mut events);
    let everywhere =
        [("target".to_owned(), 1.into()), ("location".to_owned(), vec![1.0, 2.0].into())];
    let outside = judge::Violation {
        step: Step(3),
        fault: judge::Fault::Mission(judge::Broken {
            promise: GUARANTEE,
            agent: AgentId(0),
            detail: everywhere.into_iter().collect(),
        }),
    };
    event_keys(&serde_json::to_value(ViolationLine::new(&outside, 1.5)).unwrap(), &mut events);
    let inconsistent = Event::Inconsistent { step: Step(3), target: TargetId(0) };
    let named = Event::Liar { step: Step(3), liar: AgentId(1) };
    for event in [inconsistent, named] {
        let mut line = serde_json::to_value(event).unwrap();
        line["agent"] = 0.into();
        line["time_s"] = 1.5.into();
        event_keys(&line, &mut events);
    }
    keys(&json(&folder.join("summary.json")), "", &mut summary);
    let liar = NamedLiar { agent: 1, first_s: 1.5, named_by: vec![0] };
    keys(&serde_json::json!({ "liars": [liar] }), "", &mut summary);
    vec![
        ("metrics.csv", metrics),
        ("links.csv", links),
        ("events.jsonl", events),
        ("summary.json", summary),
    ]
}

#[test]
fn what_is_written_is_described_and_what_is_described_is_written() {
    let described = files(&Whole::<SetMembership>::KIND);
    let mut complaints = Vec::new();
    for (name, keys) in written() {
        let file: &File = described.iter().find(|file| file.name == name).expect(name);
        let mut seen = BTreeSet::new();
        for key in &keys {
            // Whole arrays of numbers and empty maps are themselves.
            match file.describes(key) {
                Some(field) => _ = seen.insert(field.key.clone()),
                None => complaints.push(format!("{name}: no description of `{key}`")),
            }
        }
        let missing = file.fields.iter().filter(|field| !seen.contains(&field.key));
        complaints.extend(missing.map(|field| format!("{name}: `{}` is not written", field.key)));
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn columns_are_in_the_order_of_their_description() {
    let base = scratch();
    small_run(base.path(), &["--out", "two"]);
    let alone = csat(
        base.path(),
        &["run", "--set", "agents.count=1", "--set", "run.duration_s=1", "--out", "one"],
    );
    assert_eq!(alone.status.code(), Some(0), "{}", text(&alone.stderr));
    for name in ["metrics.csv", "links.csv"] {
        let file = files(&Whole::<SetMembership>::KIND)
            .into_iter()
            .find(|file| file.name == name)
            .unwrap();
        let expected: Vec<String> = file.fields.into_iter().map(|field| field.key).collect();
        // One agent has no links: the table has its head all the same.
        for run in ["one", "two"] {
            let table = read(&base.path().join(run).join(name));
            assert_eq!(table.lines().next(), Some(expected.join(",").as_str()), "{run}/{name}");
        }
    }
}

#[test]
fn the_document_has_the_descriptions() {
    let path = root().join("docs/outputs.md");
    if std::env::var_os("CSAT_WRITE_DOCS").is_some() {
        write_tables(&path);
    }
    let document = read(&path);
    for (name, file) in sections() {
        let heading = format!("\n## {name}\n");
        let (_, rest) = document.split_once(&heading).unwrap_or_else(|| panic!("no {heading}"));
        let section = rest.split("\n## ").next().unwrap_or_default();
        let table: Vec<&str> = section.lines().filter(|line| line.starts_with('|')).collect();
        let expected = file.markdown();
        assert!(table.join("\n") + "\n" == expected, "expected in docs/outputs.md:\n{expected}");
    }
}

#[test]
fn events_say_when() {
    let base = scratch();
    small_run(base.path(), &["--set", "netem.radio.loss={model=\"iid\",p=0.5}", "--out", "lossy"]);
    let events = read(&base.path().join("lossy/events.jsonl"));
    assert!(events.contains("\"drop\"") && events.contains("\"identified\""), "{events}");
    for line in events.lines() {
        let event: Value = serde_json::from_str(line).unwrap();
        let (step, time_s) = (event["step"].as_f64().unwrap(), event["time_s"].as_f64().unwrap());
        assert!(time_s >= step * 0.5 && time_s < (step + 1.0) * 0.5, "{line}");
    }
}

/// Bytes that were handed over and not lost arrived, link by link.
#[test]
fn links_account_for_their_bytes() {
    let base = scratch();
    small_run(base.path(), &["--out", "perfect"]);
    small_run(base.path(), &["--set", "netem.radio.loss={model=\"iid\",p=0.5}", "--out", "lossy"]);
    for (run, is_perfect) in [("perfect", true), ("lossy", false)] {
        let mut reader = csv::Reader::from_path(base.path().join(run).join("links.csv")).unwrap();
        let header = reader.headers().unwrap().clone();
        for row in reader.records().map(Result::unwrap) {
            let number = |name: &str| -> u64 {
                row[header.iter().position(|column| column == name).unwrap()].parse().unwrap()
            };
            let (sent, arrived) = (number("bytes_sent"), number("bytes_delivered"));
            assert!(arrived > 0 && (arrived == sent) == is_perfect && arrived <= sent, "{row:?}");
        }
    }
}

/// The document's sections: the files of the set-membership mission, then what others have of their own.
fn sections() -> Vec<(String, File)> {
    let usual = &Whole::<SetMembership>::KIND;
    let of_usual = files(usual).into_iter().map(|file| (format!("`{}`", file.name), file));
    let own = [&Whole::<Bayes>::KIND, &Whole::<Clearing>::KIND].into_iter().flat_map(|kind| {
        let own = own_files(kind, usual).into_iter();
        own.map(|file| (format!("`{}` of `{}`", file.name, kind.name), file))
    });
    of_usual.chain(own).collect()
}

/// Puts the tables into the document: after a change of columns, `CSAT_WRITE_DOCS=1 cargo test --test outputs`.
fn write_tables(path: &Path) {
    let mut document = read(path);
    for (name, file) in sections() {
        let heading = format!("\n## {name}\n");
        let section = document.find(&heading).unwrap_or_else(|| panic!("no {heading}"));
        let from = section + document[section..].find("\n|").expect("a table") + 1;
        let to = document[from..].find("\n\n").map_or(document.len(), |end| from + end + 1);
        document.replace_range(from..to, &file.markdown());
    }
    std::fs::write(path, document).unwrap();
}
