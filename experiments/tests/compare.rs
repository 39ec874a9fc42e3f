//! `csat compare`: two runs, two sweeps or two reproductions side by side.

mod common;

use std::fs;
use std::path::Path;

use common::{SMALL, csat, names, scratch, small_run, text};
use serde_json::Value;

fn compared(folder: &Path, arguments: &[&str]) -> String {
    let output = csat(folder, &[&["compare"], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
    text(&output.stdout)
}

fn as_json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&compared(folder, &[arguments, &["--json"]].concat())).unwrap()
}

fn number<'a>(comparison: &'a Value, key: &str) -> &'a Value {
    let numbers = comparison["parts"][0]["numbers"].as_array().unwrap();
    numbers.iter().find(|number| number["key"] == key).expect(key)
}

#[test]
fn two_runs_are_compared_key_by_key_and_number_by_number() {
    let base = scratch();
    let lossy = ["--set", "netem.radio.loss={model=\"iid\",p=0.5}", "--seed", "2"];
    for (out, more) in [("one", &[][..]), ("again", &[]), ("lossy", &lossy)] {
        assert_eq!(
            small_run(base.path(), &[&["--out", out], more].concat()).status.code(),
            Some(0)
        );
    }
    let same = compared(base.path(), &["one", "again"]);
    assert!(same.starts_with("a: one\nb: again\ncsat: "), "{same}");
    assert!(
        same.contains("scenario: the same\ndigest: equal, the same to the last bit\n"),
        "{same}"
    );

    let other = compared(base.path(), &["one", "lossy"]);
    for line in
        ["scenario: 2 keys differ\n", "\ndigest: different\n", "  seed ", "  unexplored_pct "]
    {
        assert!(other.contains(line), "{line} in {other}");
    }
    let json = as_json(base.path(), &["one", "lossy"]);
    let keys: Vec<&str> =
        json["scenario"].as_array().unwrap().iter().map(|d| d["key"].as_str().unwrap()).collect();
    assert_eq!(keys, ["netem.radio.loss.p", "seed"]);
    assert_eq!((&json["kind"], &json["digests"]["equal"]), (&"run".into(), &0.into()));
    let [a, b] =
        ["one", "lossy"].map(|name| common::json(&base.path().join(name).join("summary.json")));
    let unexplored = number(&json, "unexplored_pct");
    let [a, b] = [a, b].map(|summary| summary["unexplored_pct"].as_f64().unwrap());
    assert_eq!((unexplored["a"].as_f64(), unexplored["b"].as_f64()), (Some(a), Some(b)));
    assert_eq!(unexplored["difference"].as_f64(), Some(b - a));
    assert!(unexplored["ci95_half_width"].is_null());
}

#[test]
fn two_sweeps_are_compared_within_seeds() {
    let base = scratch();
    let vary = ["--vary", "exchange.mode=facts,none", "--seeds"];
    for (out, seeds, speed) in [("a", "1..3", "5"), ("b", "2..4", "8")] {
        let speed = format!("agents.speed_m_s={speed}");
        let rest = [seeds, "--set", &speed, "--out", out];
        let sweep = csat(base.path(), &[&["sweep", "city"], SMALL, &vary, &rest].concat());
        assert_eq!(sweep.status.code(), Some(0), "{}", text(&sweep.stderr));
    }
    let said = compared(base.path(), &["a", "b"]);
    for line in [
        "scenario: 1 key differs\n",
        "  agents.speed_m_s  5.0  8.0\n",
        "\ndigests: 0 equal of 4 runs in common\n",
        "\nexchange.mode=facts\n",
        "\nexchange.mode=none\n",
    ] {
        assert!(said.contains(line), "{line} in {said}");
    }
    let json = as_json(base.path(), &["a", "b"]);
    assert_eq!((&json["kind"], json["parts"].as_array().unwrap().len()), (&"sweep".into(), 2));
    let unexplored = number(&json, "unexplored_pct");
    assert_eq!(unexplored["n"], 2);
    // From the tables: seeds 2 and 3 of both.
    let value = |sweep: &str, seed: &str| -> f64 {
        let mut table = csv::Reader::from_path(base.path().join(sweep).join("sweep.csv")).unwrap();
        let header = table.headers().unwrap().clone();
        let column = |name: &str| header.iter().position(|c| c == name).unwrap();
        let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
        let is_it = |row: &&csv::StringRecord| {
            &row[column("exchange.mode")] == "facts" && &row[column("seed")] == seed
        };
        rows.iter().find(is_it).unwrap()[column("unexplored_pct")].parse().unwrap()
    };
    let mean = ["2", "3"].map(|seed| value("b", seed) - value("a", seed)).iter().sum::<f64>() / 2.0;
    assert!((unexplored["difference"].as_f64().unwrap() - mean).abs() < 1e-9);
}

#[test]
fn what_cannot_be_compared_is_refused_with_its_name() {
    let base = scratch();
    assert_eq!(small_run(base.path(), &["--out", "run"]).status.code(), Some(0));
    fs::create_dir(base.path().join("empty")).unwrap();
    for (name, text) in [("cut", "{\"seed\": "), ("bare", "{}")] {
        fs::create_dir(base.path().join(name)).unwrap();
        fs::write(base.path().join(name).join("summary.json"), text).unwrap();
    }
    let table = "[{\"title\": \"T\", \"columns\": [], \"rows\": []}]";
    fs::create_dir(base.path().join("tables")).unwrap();
    fs::write(base.path().join("tables/tables.json"), table).unwrap();
    let before = names(base.path());
    for (other, message) in [
        ("nowhere", "error: there is no folder `nowhere`\n  = expected the folder of a run"),
        ("empty", "error: there is nothing to compare in `empty`\n"),
        ("cut", "error: `cut/summary.json` is not the summary of a run: EOF"),
        ("bare", "error: `bare/summary.json` is not the summary of a run: its summary is none: "),
        (
            "tables",
            "`tables` is the folder of a reproduction without missions\n  = expected two runs",
        ),
    ] {
        let output = csat(base.path(), &["compare", "run", other]);
        let said = text(&output.stderr);
        assert_eq!((output.status.code(), text(&output.stdout).as_str()), (Some(2), ""), "{said}");
        assert!(said.contains(message), "{message} in {said}");
    }
    assert_eq!(names(base.path()), before);
    assert_eq!(csat(base.path(), &["compare", "run"]).status.code(), Some(2));
}
