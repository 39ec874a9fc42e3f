//! What is in a folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::provenance::{Build, Provenance};
use crate::scenario::MAP_FILE;
use crate::summary::Summary;
use crate::sweep::SweepError;
use crate::sweep::folder::SweepFolder;
use crate::sweep::record::RunRecord;
use crate::sweep::results::Results;

/// A folder that can be compared with another one.
pub(super) enum Folder {
    /// Of one mission.
    Run(Box<Run>),
    /// Of a sweep, or of a reproduction that is one.
    Sweep(Box<Results>),
    /// Of a reproduction without missions: means by row and column, table by table.
    Tables(Vec<(String, BTreeMap<String, f64>)>),
}

/// One mission.
pub(super) struct Run {
    /// Its numbers.
    pub record: RunRecord,
    /// The scenario in full.
    pub scenario_toml: String,
    /// The file of an imported town of the user's own.
    pub map: Option<String>,
}

/// Reads a folder.
///
/// # Errors
/// When it is none of these.
pub(super) fn read(path: &Path) -> Result<Folder, SweepError> {
    let has = |name: &str| path.join(name).exists();
    if has("sweep.json") {
        let folder = SweepFolder::at(path);
        let manifest = folder.manifest()?;
        return Ok(Folder::Sweep(Box::new(Results::read(&folder, manifest))));
    }
    if has("summary.json") {
        return Ok(Folder::Run(Box::new(run(path)?)));
    }
    if has(TABLES) {
        let text = file(path, TABLES, "the tables of a reproduction")?;
        let tables = serde_json::from_str::<Value>(&text).ok().and_then(|value| tables(&value));
        return tables.map(Folder::Tables).ok_or_else(|| SweepError::Unreadable {
            path: path.join(TABLES),
            expected: "the tables of a reproduction",
            reason: "it has no titles, columns and rows".to_owned(),
        });
    }
    let what = if path.is_dir() { "there is nothing to compare in" } else { "there is no folder" };
    Err(SweepError::Refused(format!(
        "error: {what} `{}`\n  = expected the folder of a run (with its summary.json), of a sweep or of a \
         reproduction (sweep.json or {TABLES})",
        path.display()
    )))
}

/// The tables of `csat reproduce`.
pub(super) const TABLES: &str = "tables.json";

fn file(folder: &Path, name: &str, expected: &'static str) -> Result<String, SweepError> {
    let path = folder.join(name);
    fs::read_to_string(&path).map_err(|e| SweepError::Unreadable {
        path,
        expected,
        reason: e.to_string(),
    })
}

fn run(folder: &Path) -> Result<Run, SweepError> {
    let summary = json::<Value>(folder, "summary.json", "the summary of a run")?;
    Summary::check(&summary).map_err(|reason| SweepError::Unreadable {
        path: folder.join("summary.json"),
        expected: "the summary of a run",
        reason,
    })?;
    let Provenance { version, git_revision, git_dirty, machine, arguments, .. } =
        json(folder, "provenance.json", "the provenance of a run")?;
    let record = RunRecord {
        scenario_hash: String::new(),
        seed: summary["seed"].as_u64().unwrap_or_default(),
        build: Build { version, git_revision, git_dirty, platform: machine.platform },
        vary: BTreeMap::new(),
        replay: arguments.join(" "),
        failed: None,
        summary: Some(summary),
    };
    let scenario_toml = file(folder, "scenario.resolved.toml", "the scenario of a run")?;
    Ok(Run { record, scenario_toml, map: fs::read_to_string(folder.join(MAP_FILE)).ok() })
}

fn json<T: serde::de::DeserializeOwned>(
    folder: &Path,
    name: &str,
    expected: &'static str,
) -> Result<T, SweepError> {
    let text = file(folder, name, expected)?;
    serde_json::from_str(&text).map_err(|e| SweepError::Unreadable {
        path: folder.join(name),
        expected,
        reason: e.to_string(),
    })
}

/// Our means by row and column, in the form in which [`crate::reproduce::table::Table`] is written.
fn tables(value: &Value) -> Option<Vec<(String, BTreeMap<String, f64>)>> {
    let table = |table: &Value| {
        let columns = table["columns"].as_array()?;
        let mut means = BTreeMap::new();
        for row in table["rows"].as_array()? {
            let name = row[0].as_str()?;
            for (cell, column) in row[1].as_array()?.iter().zip(columns) {
                let key = format!("{name}: {}", column["name"].as_str()?);
                means.extend(cell["ours"]["mean"].as_f64().map(|mean| (key, mean)));
            }
        }
        Some((table["title"].as_str()?.to_owned(), means))
    };
    value.as_array()?.iter().map(table).collect()
}
