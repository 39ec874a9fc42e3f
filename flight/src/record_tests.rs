use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use super::*;
use crate::scenario::{self, Request};
use crate::set_membership::SetMembership;
use crate::testing::scratch;
use csat_mission::measures::in_order;
use csat_mission::mission::Whole;
use csat_mission::timing::StageTimes;

fn start(folder: PathBuf) -> Recorder {
    let loaded = scenario::load(Request { seed: Some(5), ..Request::default() }).unwrap();
    let options = RecordOptions { destination: Destination::Numbered(folder), quiet: true };
    Recorder::create(&loaded, &options).unwrap()
}

fn fly(recorder: &mut Recorder) {
    for step in 0..4u32 {
        let row = |agent: u16| {
            let unexplored_pct = 100.0 - 10.0 * f64::from(step) - 2.0 * f64::from(agent);
            let identified = if step >= 2 { 8.0 } else { 1.0 };
            let values =
                [("unexplored_pct", Some(unexplored_pct)), ("identified_union", Some(identified))];
            Row {
                step,
                time_s: f64::from(step) * 0.5,
                agent,
                values: in_order(Whole::<SetMembership>::KIND.columns, values),
                times: StageTimes { render: Some(2.0 + f64::from(agent)), ..StageTimes::default() },
                ..Row::default()
            }
        };
        recorder.step(&[row(0), row(1)], 0).unwrap();
        recorder.event(&serde_json::json!({ "step": step, "kind": "identified" })).unwrap();
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_finished_run_has_every_file_and_its_numbers() {
    let base = scratch("record");
    let mut recorder = start(base.join("city-seed5"));
    fly(&mut recorder);
    let outcome = Outcome {
        steps: 4,
        sim_s: 1.5,
        digest: 0xabc,
        messages: Messages {
            sent: 3,
            delivered: 2,
            dropped: BTreeMap::from([("loss".into(), 1)]),
            ..Messages::default()
        },
        ..Outcome::default()
    };
    let Finished { folder, summary } = recorder.finish(outcome).unwrap();
    assert_eq!(folder, base.join("city-seed5"));
    assert_eq!(names(&base), ["city-seed5"]);
    assert_eq!(
        names(&folder),
        [
            "events.jsonl",
            "links.csv",
            "map.svg",
            "metrics.csv",
            "metrics.svg",
            "provenance.json",
            "scenario.resolved.toml",
            "summary.json",
            "view.json"
        ]
    );
    assert_eq!(summary.numbers.get("unexplored_pct"), Some(74.0));
    assert_eq!(summary.last.get("unexplored_pct"), Some(69.0));
    assert_eq!(summary.numbers.get("identified"), Some(8.0));
    assert_eq!(summary.numbers.get("all_identified_s"), Some(1.0));
    assert_eq!(summary.timing_ms.render.median, 2.5);
    assert_eq!(summary.digest, "0000000000000abc");
    let written: Summary =
        serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap();
    assert_eq!((written.digest, written.seed), (summary.digest, 5));
    let metrics = fs::read_to_string(folder.join("metrics.csv")).unwrap();
    assert_eq!(metrics.lines().count(), 9);
    assert!(metrics.starts_with("step,time_s,agent,x_m,"), "{metrics}");
    let events = fs::read_to_string(folder.join("events.jsonl")).unwrap();
    assert_eq!(events.lines().next(), Some("{\"kind\":\"identified\",\"step\":0}"));
    let provenance: Provenance =
        serde_json::from_str(&fs::read_to_string(folder.join("provenance.json")).unwrap()).unwrap();
    assert_eq!((provenance.scenario.as_str(), provenance.seed), ("city", 5));
    plot::redraw(&folder).unwrap();
}

#[test]
fn a_run_that_dies_leaves_nothing_under_its_name() {
    let base = scratch("dies");
    let mut recorder = start(base.join("run"));
    fly(&mut recorder);
    let partial = recorder.partial_folder().to_owned();
    drop(recorder);
    assert!(!base.join("run").exists());
    let left = names(&partial);
    for file in ["metrics.csv", "events.jsonl", "summary.json"] {
        assert!(!left.contains(&file.to_owned()), "{left:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_that_names_the_file() {
    let base = scratch("full");
    let mut recorder = start(base.join("run"));
    let path = recorder.partial_folder().join("metrics.csv");
    std::os::unix::fs::symlink("/dev/full", base.join("full")).unwrap();
    fs::rename(base.join("full"), recorder.partial_folder().join("metrics.csv.tmp")).unwrap();
    recorder.metrics = csv::Writer::from_writer(PartialFile::create(path).unwrap());
    let mut error = None;
    let values = vec![None; Whole::<SetMembership>::KIND.columns.len()];
    let row = Row { values, ..Row::default() };
    for _ in 0..10_000 {
        error = recorder.step(std::slice::from_ref(&row), 0).err();
        if error.is_some() {
            break;
        }
    }
    let text = error.expect("the disk is full").to_string();
    assert!(text.contains("metrics.csv`") && text.contains("No space left on device"), "{text}");
}
