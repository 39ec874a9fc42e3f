//! What short radios cost, as the files of a run say it.

mod common;

use std::path::Path;

use common::shipped::{Key, Shipped, digest};
use common::{json, scratch};
use serde_json::Value;

/// `city` for a minute with small images.
const CITY: Shipped = Shipped {
    name: "city",
    sets: &["run.duration_s=60", "camera.columns=120", "camera.rows=90", "camera.min_pixels=1"],
};

/// Flies it and gives the summary in its folder.
fn flown(folder: &Path, sets: &[&str]) -> Value {
    CITY.flown(folder, "run", "out", sets);
    json(&folder.join("out/summary.json"))
}

fn number(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or_else(|| panic!("{key}: {}", summary[key]))
}

/// `unexplored_pct` and `fleet_unexplored_pct` of each row of `metrics.csv`.
fn unexplored(folder: &Path) -> Vec<[f64; 2]> {
    let mut metrics = csv::Reader::from_path(folder.join("out/metrics.csv")).unwrap();
    let header = metrics.headers().unwrap().clone();
    let place = |key: &str| header.iter().position(|name| name == key).expect(key);
    let places = ["unexplored_pct", "fleet_unexplored_pct"].map(place);
    let values = |row: csv::StringRecord| places.map(|place| row[place].parse().unwrap());
    metrics.records().map(|row| values(row.unwrap())).collect()
}

#[test]
fn with_perfect_links_the_fleet_knows_what_each_uav_knows() {
    let base = scratch();
    let summary = flown(base.path(), &[]);
    let untold = number(&summary, "unexplored_pct") - number(&summary, "fleet_unexplored_pct");
    assert!(untold.abs() < 1e-9, "{untold}");
    assert!(unexplored(base.path()).iter().all(|[own, fleet]| own == fleet));
    let contact = ["contact_pct", "components", "staleness_s"].map(|key| number(&summary, key));
    assert_eq!(contact, [100.0, 1.0, 0.0]);
}

#[test]
fn with_radios_of_100_m_it_knows_more_than_each_uav() {
    let base = scratch();
    let summary = flown(base.path(), &["netem.radio.range_m=100"]);
    let untold = number(&summary, "unexplored_pct") - number(&summary, "fleet_unexplored_pct");
    assert!(untold > 1.0, "{untold}");
    assert!(unexplored(base.path()).iter().all(|[own, fleet]| own >= fleet));
    assert!(number(&summary, "components") > 1.0, "{summary}");
    let contact_pct = number(&summary, "contact_pct");
    assert!((0.0..100.0).contains(&contact_pct), "{contact_pct}");
    assert!(number(&summary, "staleness_s") > 0.0, "{summary}");
}

/// `city` with short radios under `str5`.
const SHORT: Shipped = Shipped {
    name: "city",
    sets: &[
        "run.duration_s=40",
        "map.size_m=[300, 300]",
        "targets.count=3",
        "camera.columns=120",
        "camera.rows=90",
        "camera.min_pixels=1",
        "guidance.criterion=str5",
        "guidance.str4.beam=20",
        "netem.radio.range_m=60",
    ],
};

#[test]
fn every_key_of_str5_has_an_effect() {
    const KEYS: [Key; 3] = [
        ("guidance.criterion=str4", &[]),
        ("guidance.str4.n_mpc=8", &[]),
        ("guidance.str4.first_look=0", &[]),
    ];
    SHORT.every_key_changes(&KEYS, digest);
}

#[test]
fn whose_knowledge_counts_has_an_effect() {
    const KEYS: [Key; 2] = [
        ("guidance.objective=fleet", &["guidance.criterion=str4"]),
        ("guidance.str4.silent=0.5", &["guidance.criterion=str4", "guidance.objective=fleet"]),
    ];
    SHORT.every_key_changes(&KEYS, digest);
}

#[test]
fn str5_keeps_in_contact() {
    let base = scratch();
    let contact = |criterion: &str| {
        let sets = ["run.duration_s=90", &format!("guidance.criterion={criterion}")];
        number(&SHORT.flown(base.path(), "run", criterion, &sets), "contact_pct")
    };
    let [apart, together] = ["str4", "str5"].map(contact);
    assert!(together > apart + 10.0, "{together} % instead of {apart} %");
}

#[test]
fn without_a_range_it_is_str4() {
    let base = scratch();
    let flown = |criterion: &str| {
        let sets = ["netem.radio.range_m=inf", &format!("guidance.criterion={criterion}")];
        digest(&SHORT.flown(base.path(), "run", criterion, &sets))
    };
    assert_eq!(flown("str4"), flown("str5"));
}

/// Over perfect links nobody is silent.
#[test]
fn with_perfect_links_the_objectives_are_one() {
    let base = scratch();
    for schedule in ["sequential-loopback", "asynchronous"] {
        let flown = |objective: &str| {
            let name = format!("{schedule}-{objective}");
            let schedule = format!("guidance.schedule={schedule}");
            let objective = format!("guidance.objective={objective}");
            let sets =
                ["guidance.criterion=str4", "netem.radio.range_m=inf", &schedule, &objective];
            digest(&SHORT.flown(base.path(), "run", &name, &sets))
        };
        assert_eq!(flown("own"), flown("fleet"), "{schedule}");
    }
}

#[test]
fn one_process_and_many_come_to_the_same_with_short_radios() {
    let fleet = ["guidance.criterion=str4", "guidance.objective=fleet"];
    let cases: [(&str, &[&str]); 2] = [("short", &[]), ("fleet", &fleet)];
    SHORT.is_the_same_in_processes(&cases, &["digest", "violations", "unexplored_pct"]);
}
