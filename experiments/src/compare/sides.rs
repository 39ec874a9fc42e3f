//! Two folders of a kind.

use std::collections::{BTreeMap, BTreeSet};

use super::read::{Folder, Run};
use super::{Comparison, Digests, Kind, Number, Part};
use crate::scenario::MAP_FILE;
use crate::scenario::differences::{Difference, differences};
use crate::scenario::missions;
use crate::stats::stats;
use crate::sweep::SweepError;
use crate::sweep::growth;
use crate::sweep::manifest::Manifest;
use crate::sweep::metric::metrics_of;
use crate::sweep::pairs::Paired;
use crate::sweep::plan::Point;
use crate::sweep::record::RunRecord;
use crate::sweep::results::{Counts, Results, Values, values};
use crate::values::number;

type Tables = [(String, BTreeMap<String, f64>)];

/// Compares two folders of these names.
///
/// # Errors
/// When they are of different kinds or have nothing in common.
pub(super) fn compare(
    names: [String; 2],
    a: &Folder,
    b: &Folder,
) -> Result<Comparison, SweepError> {
    match (a, b) {
        (Folder::Run(a), Folder::Run(b)) => Ok(runs(names, a, b)),
        (Folder::Sweep(a), Folder::Sweep(b)) => sweeps(names, a, b),
        (Folder::Tables(a), Folder::Tables(b)) => Ok(tables(names, a, b)),
        _ => {
            let [a, b] = [(&names[0], a), (&names[1], b)]
                .map(|(name, folder)| format!("`{name}` is the folder of {}", what(folder)));
            let expected = "expected two runs, two sweeps or two reproductions";
            Err(SweepError::Refused(format!("error: {a}, {b}\n  = {expected}")))
        }
    }
}

fn what(folder: &Folder) -> &'static str {
    match folder {
        Folder::Run(_) => "a run",
        Folder::Sweep(_) => "a sweep",
        Folder::Tables(_) => "a reproduction without missions",
    }
}

fn runs([a, b]: [String; 2], first: &Run, second: &Run) -> Comparison {
    let mut scenario = differences(&first.scenario_toml, &second.scenario_toml);
    if let (Some(one), Some(two)) = (&first.map, &second.map)
        && one != two
    {
        let size = |text: &String| Some(format!("{} bytes", text.len()));
        scenario.push(Difference { key: MAP_FILE.to_owned(), a: size(one), b: size(two) });
    }
    let mut notes = Vec::new();
    for (name, run) in [(&a, first), (&b, second)] {
        let summary = run.record.summary.as_ref();
        if summary.is_some_and(|summary| summary["interrupted"] == true) {
            notes.push(format!("{name} was ended early by the user"));
        }
    }
    let mut digests = Digests::default();
    digests.count(&first.record, &second.record);
    // Two runs are a pair whatever their seeds.
    let [one, two] = [first, second].map(|run| BTreeMap::from([(0, values(&run.record))]));
    Comparison {
        kind: Kind::Run,
        builds_a: vec![first.record.build.to_string()],
        builds_b: vec![second.record.build.to_string()],
        scenario,
        digests: Some(digests),
        notes,
        parts: vec![Part { name: String::new(), numbers: numbers(&one, &two) }],
        a,
        b,
    }
}

fn sweeps([a, b]: [String; 2], one: &Results, two: &Results) -> Result<Comparison, SweepError> {
    let mut digests = Digests::default();
    let mut parts = Vec::new();
    let mut lonely = BTreeSet::from_iter(0..two.manifest.points.len());
    let mut notes = [(&a, one), (&b, two)].into_iter().filter_map(unfinished).collect::<Vec<_>>();
    for (index, point) in one.manifest.points.iter().enumerate() {
        let name = point.describe(&one.manifest.vary);
        let Some(other) = counterpart(&one.manifest, point, &two.manifest) else {
            notes.push(format!("only {a} has {name}"));
            continue;
        };
        lonely.remove(&other);
        let [here, there] = [one.flown(index), two.flown(other)]
            .map(|runs| runs.map(|record| (record.seed, record)).collect::<BTreeMap<_, _>>());
        for (seed, record) in &here {
            there.get(seed).iter().for_each(|other| digests.count(record, other));
        }
        let [here, there] = [here, there]
            .map(|runs| runs.into_iter().map(|(seed, record)| (seed, values(record))).collect());
        parts.push(Part { name, numbers: numbers(&here, &there) });
    }
    let names = lonely.iter().map(|p| two.manifest.points[*p].describe(&two.manifest.vary));
    notes.extend(names.map(|name| format!("only {b} has {name}")));
    if parts.is_empty() {
        let [first, second] = [&one.manifest, &two.manifest].map(growth::titles);
        return Err(SweepError::Refused(format!(
            "error: `{a}` (which varies {first}) and `{b}` (which varies {second}) have no combination in \
             common\n  = expected two sweeps with some equal values of the same keys"
        )));
    }
    let builds = |results: &Results| results.builds().keys().map(ToString::to_string).collect();
    Ok(Comparison {
        kind: Kind::Sweep,
        builds_a: builds(one),
        builds_b: builds(two),
        scenario: growth::scenarios(&one.manifest, &two.manifest),
        digests: Some(digests),
        notes,
        parts,
        a,
        b,
    })
}

fn unfinished((name, results): (&String, &Results)) -> Option<String> {
    let Counts { runs, failed, missing, .. } = results.counts();
    (failed + missing > 0)
        .then(|| format!("{name}: {failed} of {runs} runs failed, {missing} are missing"))
}

/// The point of `there` with the same values; by its whole scenario where other keys vary.
fn counterpart(here: &Manifest, point: &Point, there: &Manifest) -> Option<usize> {
    if growth::keys(here) != growth::keys(there) {
        return there.point_of(&point.scenario_hash);
    }
    let choice = growth::choice_of(&there.vary, here, point);
    let is_lost = |(axis, index): (&crate::sweep::vary::Axis, &Option<usize>)| {
        let own = here.vary.iter().position(|other| other.keys == axis.keys);
        index.is_none() && own.is_none_or(|own| point.choice[own].is_some())
    };
    if there.vary.iter().zip(&choice).any(is_lost) {
        return None;
    }
    let same = |other: &Point| other.choice == choice && other.is_baseline == point.is_baseline;
    there.points.iter().position(same)
}

fn tables([a, b]: [String; 2], one: &Tables, two: &Tables) -> Comparison {
    let single = |means: &BTreeMap<String, f64>, key: &String| means.get(key).copied();
    let parts = one.iter().map(|(title, here)| {
        let nothing = BTreeMap::new();
        let there = two.iter().find(|(other, _)| other == title).map_or(&nothing, |(_, t)| t);
        let keys: BTreeSet<&String> = here.keys().chain(there.keys()).collect();
        let [one, two] = [here, there].map(|means| {
            move |key: &String| single(means, key).map(|mean| BTreeMap::from([(0, mean)]))
        });
        let number = |key: &String| {
            let [a, b] = [one(key), two(key)].map(Option::unwrap_or_default);
            Number::new(key, &a, &b)
        };
        Part { name: title.clone(), numbers: keys.into_iter().map(number).collect() }
    });
    let parts = parts.collect();
    Comparison {
        kind: Kind::Tables,
        builds_a: Vec::new(),
        builds_b: Vec::new(),
        scenario: Vec::new(),
        digests: None,
        notes: Vec::new(),
        parts,
        a,
        b,
    }
}

/// All numbers of the runs of two points, by seed: those that reports show first, then the others in the
/// order of the alphabet.
fn numbers(a: &BTreeMap<u64, Values>, b: &BTreeMap<u64, Values>) -> Vec<Number> {
    let is_number =
        |(key, value): (&String, &serde_json::Value)| value.is_number().then(|| key.clone());
    let all = a.values().chain(b.values()).flat_map(|values| values.iter().filter_map(is_number));
    let mut keys: BTreeSet<String> = all.collect();
    let metrics = metrics_of(missions::all().iter().map(|mission| mission.kind()));
    let first = metrics.iter().filter_map(|metric| keys.take(metric.key)).collect::<Vec<_>>();
    let by_seed = |runs: &BTreeMap<u64, Values>, key: &str| {
        let values = runs.iter().filter_map(|(seed, v)| Some((*seed, number(v.get(key)?)?)));
        values.collect::<BTreeMap<u64, f64>>()
    };
    let number = |key: String| Number::new(&key, &by_seed(a, &key), &by_seed(b, &key));
    first.into_iter().chain(keys).map(number).collect()
}

impl Number {
    /// Of values by seed.
    fn new(key: &str, a: &BTreeMap<u64, f64>, b: &BTreeMap<u64, f64>) -> Self {
        let mean = |of: &BTreeMap<u64, f64>| {
            stats(&of.values().copied().collect::<Vec<_>>()).map(|s| s.mean)
        };
        let paired = Paired::new(b, a);
        let of = |get: fn(&Paired) -> usize| paired.as_ref().map_or(0, get);
        Self {
            key: key.to_owned(),
            a: mean(a),
            b: mean(b),
            n: of(|p| p.stats.n),
            difference: paired.as_ref().map(|p| p.stats.mean),
            ci95_half_width: paired.as_ref().and_then(|p| p.stats.half_width),
            lower: of(|p| p.lower),
            higher: of(|p| p.higher),
        }
    }

    /// Whether there is any difference.
    pub fn differs(&self) -> bool {
        self.a != self.b || self.lower + self.higher > 0
    }
}

impl Digests {
    fn count(&mut self, a: &RunRecord, b: &RunRecord) {
        let is_equal = a.digest().is_some() && a.digest() == b.digest();
        *(if is_equal { &mut self.equal } else { &mut self.different }) += 1;
    }
}
