//! A shipped scenario, made small: one process and many, and what keys change.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use super::{csat, scratch, text};

/// A shipped scenario with these values.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    pub name: &'static str,
    pub sets: &'static [&'static str],
}

/// A key with a value, and the values of others with which it has an effect.
pub type Key = (&'static str, &'static [&'static str]);

impl Shipped {
    /// The summary of a mission with more values.
    pub fn flown(&self, folder: &Path, command: &str, out: &str, sets: &[&str]) -> Value {
        let output = self.ended(folder, command, out, sets);
        assert_eq!(output.status.code(), Some(0), "{sets:?}: {}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("a summary")
    }

    /// How the command for a mission with more values ends.
    pub fn ended(&self, folder: &Path, command: &str, out: &str, sets: &[&str]) -> Output {
        let sets = self.sets.iter().chain(sets).flat_map(|set| ["--set", set]);
        let arguments: Vec<&str> =
            [command, self.name, "--json", "--out", out].into_iter().chain(sets).collect();
        csat(folder, &arguments)
    }

    /// One process and many come to the same, in each case: `keys` of the summary, and every measured value.
    pub fn is_the_same_in_processes(&self, cases: &[(&str, &[&str])], keys: &[&str]) {
        for (name, sets) in cases {
            let base = scratch();
            let one = self.flown(base.path(), "run", "one", sets);
            let many = self.flown(base.path(), "spawn", "many", sets);
            for key in keys {
                assert_eq!(one[key], many[key], "{name}: {key}");
            }
            let metrics =
                |run: &str| std::fs::read(base.path().join(run).join("metrics.csv")).unwrap();
            assert!(metrics("one") == metrics("many"), "{name}");
        }
    }

    /// Demands that each key changes what `traces` takes from a summary.
    pub fn every_key_changes<T: PartialEq>(&self, keys: &[Key], traces: fn(&Value) -> T) {
        let base = scratch();
        let mut idle: Vec<&str> = Vec::new();
        let mut usual: BTreeMap<Vec<&str>, T> = BTreeMap::new();
        for (index, (set, others)) in keys.iter().enumerate() {
            let without = usual.entry(others.to_vec()).or_insert_with(|| {
                traces(&self.flown(base.path(), "run", &format!("{index}-without"), others))
            });
            let all = [others, &[*set][..]].concat();
            let with = self.flown(base.path(), "run", &format!("{index}-with"), &all);
            idle.extend((*without == traces(&with)).then_some(*set));
        }
        assert!(idle.is_empty(), "these change nothing: {idle:?}");
    }
}

/// The digest in a summary.
pub fn digest(summary: &Value) -> Value {
    summary["digest"].clone()
}

/// Demands that this scenario is bad input, and that each of these lines of it is blamed with these words.
pub fn check_places(scenario: &str, places: &[(u32, &str)]) {
    let base = scratch();
    std::fs::write(base.path().join("bad.toml"), scenario).unwrap();
    let output = csat(base.path(), &["run", "bad.toml"]);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    for (line, what) in places {
        assert!(told.contains(what), "{what} in {told}");
        assert!(told.contains(&format!("--> bad.toml:{line}:")), "line {line} in {told}");
    }
}
