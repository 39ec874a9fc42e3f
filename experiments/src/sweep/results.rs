//! All runs of a sweep, those that failed or are missing included.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::folder::{BadRun, SweepFolder};
use super::manifest::Manifest;
use super::metric::{DELIVERED, Metric, metric, metrics_of};
use super::plan::Run;
use super::record::{RunRecord, kind_of};
use super::seeds::Shard;
use crate::provenance::Build;

/// A sweep and what is known of its runs.
#[derive(Debug, Clone)]
pub struct Results {
    /// The sweep.
    pub manifest: Manifest,
    /// Every run, point by point, and its record if there is one.
    pub runs: Vec<(Run, Option<RunRecord>)>,
    /// Files that should be runs and are not; their runs are missing.
    pub bad: Vec<BadRun>,
}

/// How many runs ended how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Counts {
    /// All runs of the sweep.
    pub runs: usize,
    /// Flown to the end.
    pub flown: usize,
    /// Of those, with violations of what is guaranteed.
    pub violated: usize,
    /// Failed: an error or a panic.
    pub failed: usize,
    /// Not there.
    pub missing: usize,
}

/// Parts of a summary that say how fast the computer was, or what the row says anyway.
const LEFT_OUT: [&str; 6] =
    ["wall_s", "realtime_factor", "timing_ms", "scenario", "seed", "interrupted"];

impl Results {
    /// Reads what is in the folder of a sweep.
    pub fn read(folder: &SweepFolder, manifest: Manifest) -> Self {
        let mut order = manifest.runs(Shard::WHOLE);
        order.sort_by_key(|run| run.point);
        let mut bad = Vec::new();
        let mut runs = Vec::new();
        for run in order {
            let record = folder.run(&manifest, &run).unwrap_or_else(|flaw| {
                bad.push(flaw);
                None
            });
            runs.push((run, record));
        }
        Self { manifest, runs, bad }
    }

    /// Everything that is drawn of its runs.
    pub fn metrics(&self) -> Vec<Metric> {
        metrics_of(self.runs.iter().filter_map(|(_, record)| kind_of(record.as_ref()?)))
    }

    /// The programs that flew the runs, each with the number of runs.
    pub fn builds(&self) -> BTreeMap<&Build, usize> {
        let mut builds = BTreeMap::new();
        for record in self.runs.iter().filter_map(|(_, record)| record.as_ref()) {
            *builds.entry(&record.build).or_default() += 1;
        }
        builds
    }

    /// How many runs ended how.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts { runs: self.runs.len(), ..Counts::default() };
        for (_, record) in &self.runs {
            match record {
                None => counts.missing += 1,
                Some(record) if record.failed.is_some() => counts.failed += 1,
                Some(record) => {
                    counts.flown += 1;
                    counts.violated += usize::from(record.violations() > 0);
                }
            }
        }
        counts
    }

    /// The runs of a point.
    pub fn of(&self, point: usize) -> &[(Run, Option<RunRecord>)] {
        let start = self.runs.partition_point(|(run, _)| run.point < point);
        let end = self.runs.partition_point(|(run, _)| run.point <= point);
        &self.runs[start..end]
    }

    /// How many checks the monitor made in all runs.
    pub fn checks(&self) -> u64 {
        let records = self.runs.iter().filter_map(|(_, record)| record.as_ref());
        records.filter_map(|record| record.number("checks")).map(|n| n as u64).sum()
    }

    /// The flown runs of a point.
    pub fn flown(&self, point: usize) -> impl Iterator<Item = &RunRecord> {
        let here = self.of(point).iter().filter_map(|(_, record)| record.as_ref());
        here.filter(|record| record.summary.is_some())
    }

    /// The names of all values that some run has, in the order of the alphabet.
    pub fn columns(&self) -> BTreeSet<String> {
        let records = self.runs.iter().filter_map(|(_, record)| record.as_ref());
        records.flat_map(|record| values(record).into_keys()).collect()
    }
}

/// Values by dotted key.
pub type Values = BTreeMap<String, Value>;

/// The values of a run by dotted key: numbers, texts and nulls of its summary but none of a clock,
/// and what follows from them.
pub fn values(record: &RunRecord) -> Values {
    let mut values = BTreeMap::new();
    if let Some(Value::Object(summary)) = &record.summary {
        for (key, value) in summary.iter().filter(|(key, _)| !LEFT_OUT.contains(&key.as_str())) {
            flatten(key, value, &mut values);
        }
        let delivered = metric(record, DELIVERED).map_or(Value::Null, Value::from);
        values.insert(DELIVERED.to_owned(), delivered);
        let milestones = kind_of(record).map_or(&[][..], |kind| kind.milestones);
        for restricted in milestones.iter().map(|milestone| milestone.restricted) {
            let value = metric(record, restricted).map_or(Value::Null, Value::from);
            values.insert(restricted.to_owned(), value);
        }
    }
    values
}

fn flatten(key: &str, value: &Value, into: &mut BTreeMap<String, Value>) {
    match value {
        Value::Object(inner) => {
            inner.iter().for_each(|(name, value)| flatten(&format!("{key}.{name}"), value, into));
        }
        Value::Array(inner) => {
            inner.iter().enumerate().for_each(|(i, v)| flatten(&format!("{key}.{i}"), v, into));
        }
        value => {
            into.insert(key.to_owned(), value.clone());
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::summary::Summary;
    use crate::sweep::manifest::tests::sample;

    /// Made-up results: the more of the first value, the less unexplored; every 7th run never finds
    /// all, one failed, one is missing.
    pub(crate) fn made_up(vary: &[&str], seeds: &str) -> Results {
        let manifest = sample(vary, seeds);
        let mut order = manifest.runs(Shard::WHOLE);
        order.sort_by_key(|run| run.point);
        let record = |number: usize, run: &Run| {
            let first = manifest.points[run.point].choice.first().copied().flatten();
            let level = first.map_or(0.0, |f| 30.0 - 4.0 * f as f64);
            let noise = (run.seed as f64 * 2.7 + number as f64).sin();
            let mut summary =
                Summary { violations: u64::from(number == 5), ..crate::testing::summary() };
            let all_s = (number % 7 != 3).then_some(100.0 + 5.0 * level + 20.0 * noise);
            let error_m = (number % 11 != 4).then_some(2.0 + noise);
            summary.numbers.set("all_identified_s", all_s);
            summary.numbers.set("unexplored_pct", Some(20.0 + level + 2.0 * noise));
            summary.numbers.set("explored_pct", Some(80.0 - level - 2.0 * noise));
            summary.numbers.set("localization_error_m", error_m);
            let outcome = match number {
                2 => Err("panicked at x.rs:1: <wing> & \"tail\"".to_owned()),
                _ => Ok(serde_json::to_value(&summary).unwrap()),
            };
            (number != 9).then(|| RunRecord::new(&manifest, run, outcome))
        };
        let numbered = order.into_iter().enumerate();
        let runs = numbered.map(|(n, run)| (run, record(n, &run))).collect();
        Results { manifest, runs, bad: Vec::new() }
    }

    #[test]
    fn runs_are_counted_by_how_they_ended() {
        let results = made_up(&["netem.radio.range_m=25,50"], "1..4");
        let counts = results.counts();
        assert_eq!((counts.runs, counts.flown, counts.violated), (12, 10, 1));
        assert_eq!((counts.failed, counts.missing), (1, 1));
        assert_eq!(results.flown(0).count(), 3);
    }

    #[test]
    fn values_are_flat_and_have_no_clock() {
        let results = made_up(&["a=1"], "1");
        let record = results.runs[0].1.as_ref().unwrap();
        let values = values(record);
        assert_eq!(values["messages.dropped.range"], 3);
        assert_eq!(values["final.unexplored_pct"], 20.0);
        assert_eq!(values[DELIVERED], 75.0);
        for key in values.keys() {
            assert!(!key.contains("wall") && !key.contains("timing") && !key.contains("real"));
        }
    }
}
