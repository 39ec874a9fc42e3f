//! docs/scenario.md names the keys that there are, with the defaults that they have.

use std::collections::BTreeSet;

use super::keys::{Row, Section, sections};
use super::missions::{Entry, Listed};
use super::read::Form;
use super::unit::default_table;
use super::*;
use crate::set_membership::SetMembership;

/// A scenario in which the section has a key that nobody knows.
fn with_stranger(heading: &str) -> String {
    match heading {
        "Top level" => "stranger = 1".to_owned(),
        tagged if tagged.contains("model") => {
            format!("netem.radio.{}", tagged.replace(" }", ", stranger = 1 }"))
        }
        table => format!("{table}\nstranger = 1"),
    }
}

/// The keys that the program knows there: what it expected instead of the stranger.
fn known(heading: &str, mission: &dyn Listed) -> BTreeSet<String> {
    let table = toml::from_str(&with_stranger(heading)).unwrap();
    let error = Form { mission }.scenario(table).unwrap_err();
    let (first, expected) = error.message().split_once(", expected ").unwrap();
    assert!(first.contains("`stranger`"), "{heading}: {error}");
    expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn every_key_is_documented_and_every_documented_key_is_there() {
    let tables: BTreeSet<&str> = [
        "run",
        "map",
        "targets",
        "agents",
        "camera",
        "estimator",
        "guidance",
        "exchange",
        "faults",
        "netem",
    ]
    .into();
    for Section { heading, mission, rows } in sections() {
        let mut documented: BTreeSet<String> =
            rows.into_iter().map(|row| row.key.to_owned()).collect();
        let mission = mission_of(mission);
        // Tables inside a table have sections of their own.
        match heading {
            _ if mission.kind().name != SET_MEMBERSHIP => {
                documented
                    .extend(tables_in(&lookup(&mission.tables(), heading).unwrap_or_default()));
            }
            "Top level" => documented.extend(tables.iter().map(|table| (*table).to_owned())),
            "[agents]" => {
                documented.extend(["start", "fixed_wing", "multirotor"].map(str::to_owned));
            }
            "[guidance]" => documented.extend(["str4".to_owned()]),
            "[exchange]" => documented.extend(["channels".to_owned()]),
            // Any other name is a radio.
            "[netem]" => {
                assert_eq!(documented, ["trace".to_owned()].into());
                continue;
            }
            _ => {}
        }
        assert_eq!(documented, known(heading, mission), "{heading}");
    }
}

/// The mission of a section: those of every scenario are judged by the first one.
fn mission_of(name: Option<&str>) -> &'static dyn Listed {
    const USUAL: &dyn Listed = &Entry::<SetMembership>::new();
    name.map_or(USUAL, |name| missions::find(name).unwrap())
}

/// The table of a heading.
fn lookup(whole: &toml::Table, heading: &str) -> Option<toml::Table> {
    let path = if heading == "Top level" { "" } else { heading.trim_matches(['[', ']']) };
    let mut parts = path.split('.').filter(|part| !part.is_empty());
    parts.try_fold(whole, |table, part| table.get(part)?.as_table()).cloned()
}

fn tables_in(table: &toml::Table) -> Vec<String> {
    table.iter().filter(|(_, value)| value.is_table()).map(|(key, _)| key.clone()).collect()
}

/// Every table of every mission has a section, with the tables in it.
#[test]
fn every_table_of_a_mission_is_documented() {
    fn check(sections: &[Section], mission: &str, path: &str, tables: &toml::Table) {
        for key in tables_in(tables) {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            let is_it =
                |s: &Section| s.mission == Some(mission) && s.heading == format!("[{path}]");
            assert!(sections.iter().any(is_it), "[{path}] of {mission}");
            check(sections, mission, &path, tables[&key].as_table().unwrap());
        }
    }
    for mission in missions::all() {
        check(&sections(), mission.kind().name, "", &mission.tables());
    }
}

/// Every model of losses and delays has a section.
#[test]
fn every_model_is_documented() {
    let sections = sections();
    for key in ["loss", "delay"] {
        let wrong = format!("netem.radio.{key} = {{ model = \"stranger\" }}");
        let error = toml::from_str::<Scenario>(&wrong).unwrap_err();
        let models = error.message().split_once(", expected ").unwrap().1;
        for model in models.split('`').skip(1).step_by(2) {
            let heading = format!("{key} = {{ model = \"{model}\" }}");
            assert!(sections.iter().any(|section| section.heading == heading), "{heading}");
        }
    }
}

#[test]
fn documented_defaults_are_those_of_the_program() {
    let mut usual = default_table();
    let propagation = csat_netem::config::PropagationConfig::default();
    let radio = usual["netem"]["radio"].as_table_mut().unwrap();
    radio.insert("propagation".to_owned(), toml::Value::try_from(propagation).unwrap());
    let desert = csat_world::map::DesertModel::default();
    let map = usual["map"].as_table_mut().unwrap();
    map.insert("desert".to_owned(), toml::Value::try_from(desert).unwrap());
    for Section { heading, mission, rows } in sections() {
        if heading.starts_with("[[") || heading.contains("model") {
            continue;
        }
        let own = mission.map(|name| mission_of(Some(name)).tables());
        let table = lookup(own.as_ref().unwrap_or(&usual), heading).unwrap();
        for Row { key, default, .. } in rows {
            let documented = toml::from_str::<toml::Table>(&format!("x = {default}"));
            match (table.get(key), documented) {
                (Some(value), Ok(documented)) => {
                    assert_eq!(*value, documented["x"], "{heading} {key}");
                }
                (Some(value), Err(_)) => assert!(value.is_table(), "{heading} {key}: {default}"),
                (None, _) => assert_eq!(default, "none", "{heading} {key}"),
            }
        }
    }
}
