//! A recorded mission, for tests of what is shown.

use std::path::Path;

use csat_experiments::watch::document::Document;
use csat_experiments::watch::recorded;

use crate::common::{csat, scratch, text};

/// Flies a shipped scenario and records every step in a new folder.
#[track_caller]
pub fn record(folder: &Path, name: &str, sets: &[&str]) {
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let out = folder.to_str().expect("a scratch folder has a plain name");
    let mut arguments = vec!["run", name, "--record=0.5", "--out", out];
    arguments.extend(sets);
    let output = csat(Path::new("."), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

/// The documents of such a mission, by time.
#[track_caller]
pub fn documents(name: &str, sets: &[&str]) -> Vec<Document> {
    let folder = scratch();
    record(folder.path(), name, sets);
    recorded::load(folder.path()).expect("what was recorded can be read")
}
