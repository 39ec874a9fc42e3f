//! The file of one run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use csat_mission::measures::Column;
use csat_mission::mission::Kind;

use super::manifest::Manifest;
use super::plan::Run;
use crate::provenance::Build;
use crate::scenario::missions;
use crate::summary::{self, Summary};
use crate::values::{in_words, number};

/// What became of one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Together with the seed, which mission it is: [`super::plan::Point::scenario_hash`].
    pub scenario_hash: String,
    /// The seed.
    pub seed: u64,
    /// What flew it.
    pub build: Build,
    /// The point's values by key.
    pub vary: BTreeMap<String, String>,
    /// The command that flies it again.
    pub replay: String,
    /// Why there is no summary.
    pub failed: Option<String>,
    /// `summary.json` of the run.
    pub summary: Option<Value>,
}

impl RunRecord {
    /// Of a run; `outcome` is its summary, or why there is none.
    pub fn new(manifest: &Manifest, run: &Run, outcome: Result<Value, String>) -> Self {
        let point = &manifest.points[run.point];
        let mut vary = BTreeMap::new();
        for (axis, choice) in manifest.vary.iter().zip(&point.choice) {
            if let Some(index) = choice {
                let texts = &axis.values[*index].texts;
                vary.extend(axis.keys.iter().cloned().zip(texts.iter().cloned()));
            }
        }
        let (summary, failed) = match outcome {
            Ok(summary) => (Some(summary), None),
            Err(why) => (None, Some(why)),
        };
        Self {
            scenario_hash: point.scenario_hash.clone(),
            seed: run.seed,
            build: Build::this(),
            vary,
            replay: manifest.replay(run),
            failed,
            summary,
        }
    }

    /// Checks that it tells how the run went.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(&self) -> Result<(), String> {
        match (&self.summary, &self.failed) {
            (None, None) => Err("it has neither a summary nor why there is none".to_owned()),
            (None, Some(_)) => Ok(()),
            (Some(summary), _) => Summary::check(summary),
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a record is JSON") + "\n"
    }

    /// What the monitor found; 0 for a run that failed.
    pub fn violations(&self) -> u64 {
        self.number("violations").map_or(0, |n| n as u64)
    }

    /// A number of the summary by its dotted key.
    pub fn number(&self, key: &str) -> Option<f64> {
        let summary = self.summary.as_ref()?;
        number(key.split('.').try_fold(summary, |value, key| value.get(key))?)
    }

    /// Hash of the whole run.
    pub fn digest(&self) -> Option<&str> {
        self.summary.as_ref()?.get("digest")?.as_str()
    }

    /// In a line for a person.
    pub fn describe(&self) -> String {
        if let Some(why) = &self.failed {
            return format!("FAILED: {}", why.lines().next().unwrap_or_default());
        }
        let columns = kind_of(self)
            .into_iter()
            .flat_map(|kind| kind.headline.iter().filter_map(|key| kind.column(key)));
        let targets = self.number("targets").map_or(0, |n| n as u16);
        let value = |column: &'static Column| {
            let value = self.number(column.last_as.unwrap_or(column.key));
            format!("{} {}", column.name, in_words(column, value, targets))
        };
        let mut told: Vec<String> = columns.map(value).collect();
        if self.violations() > 0 {
            told.push(format!("VIOLATIONS {}", self.violations()));
        }
        told.join(", ")
    }
}

/// The kind of mission of a run; `None` for one that failed, or of a kind that this program does not know.
pub fn kind_of(record: &RunRecord) -> Option<&'static Kind> {
    let summary = record.summary.as_ref()?;
    missions::kind(summary.get("mission").map_or(Some(summary::FIRST), |name| name.as_str())?)
}
