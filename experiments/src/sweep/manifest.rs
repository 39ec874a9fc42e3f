//! `sweep.json`: what belongs to a sweep. Shards, threads and folders are no part of it.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::plan::{Point, Run};
use super::seeds::{Shard, seeds_text};
use super::vary::Axis;
use crate::provenance::Build;

/// Counts up when the files of a sweep change their meaning.
pub const FORMAT: u32 = 2;

/// A sweep in full.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// See [`FORMAT`].
    pub format: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// The scenario as the command line names it.
    pub source: String,
    /// `--set`, in order.
    pub sets: Vec<String>,
    /// `--vary`, in order.
    pub vary: Vec<Axis>,
    /// `--seeds`.
    pub seeds: String,
    /// Whether perfect links are flown for comparison.
    pub baseline: bool,
    /// What differences within a seed are from: `--against`; see [`super::pairs::Reference`].
    pub against: Option<String>,
    /// Every combination, then those with perfect links for comparison.
    pub points: Vec<Point>,
    /// The first combination in full, but for its seed.
    pub scenario_toml: String,
    /// Hash of the file of an imported town of the user's own, in the first combination.
    pub map_hash: Option<String>,
    /// The program that it was planned with.
    pub build: Build,
}

/// What the command line says.
#[derive(Debug, Clone)]
pub struct Request {
    /// A shipped name or a path.
    pub source: String,
    /// `--set`, in order.
    pub sets: Vec<String>,
    /// `--vary`, in order.
    pub axes: Vec<Axis>,
    /// `--seeds`, in order.
    pub seeds: Vec<u64>,
    /// Whether to fly perfect links for comparison.
    pub baseline: bool,
    /// `--against`.
    pub against: Option<String>,
}

/// What loading the points found out.
#[derive(Debug, Clone, Default)]
pub struct Checked {
    /// Name of the scenario.
    pub name: String,
    /// The scenario in full at the first point, but for its seed.
    pub scenario_toml: String,
    /// Hash of the file of an imported town of the user's own at the first point.
    pub map_hash: Option<String>,
    /// Distinct warnings.
    pub warnings: Vec<String>,
}

impl Manifest {
    /// Of this program.
    pub fn new(request: Request, points: Vec<Point>, checked: Checked) -> Self {
        Self {
            format: FORMAT,
            scenario: checked.name,
            source: request.source,
            sets: request.sets,
            vary: request.axes,
            seeds: seeds_text(&request.seeds),
            baseline: request.baseline,
            against: request.against,
            points,
            scenario_toml: checked.scenario_toml,
            map_hash: checked.map_hash,
            build: Build::this(),
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a manifest is JSON") + "\n"
    }

    /// What is wrong with it, as it may be after a user edited its file.
    pub fn flaw(&self) -> Option<String> {
        if let Err(error) = super::seeds::parse_seeds(&self.seeds) {
            return Some(format!("seeds: {error}"));
        }
        let mut names = BTreeSet::new();
        self.points.iter().find_map(|point| {
            if !names.insert(&point.name) {
                return Some(format!("two points are called `{}` and share files", point.name));
            }
            let flaw = point.flaw(&self.vary)?;
            Some(format!("point `{}`: {flaw}", point.name))
        })
    }

    /// The seeds.
    pub fn seed_list(&self) -> Vec<u64> {
        super::seeds::parse_seeds(&self.seeds).expect("a manifest without flaws has seeds")
    }

    /// All runs, seed by seed: what is there of an unfinished sweep covers every point.
    pub fn runs(&self, shard: Shard) -> Vec<Run> {
        let seeds = self.seed_list();
        // Points count fastest in time and slowest among shards: they cost differently.
        let numbered = (0..self.points.len())
            .flat_map(|point| seeds.iter().enumerate().map(move |(s, &seed)| (s, point, seed)));
        let mut runs: Vec<(usize, Run)> = numbered
            .enumerate()
            .filter(|(number, _)| shard.has(*number))
            .map(|(_, (s, point, seed))| (s, Run { seed, point }))
            .collect();
        runs.sort_by_key(|(s, run)| (*s, run.point));
        runs.into_iter().map(|(_, run)| run).collect()
    }

    /// The point that is this mission, whatever its seed.
    pub fn point_of(&self, scenario_hash: &str) -> Option<usize> {
        self.points.iter().position(|point| point.scenario_hash == scenario_hash)
    }

    /// The combination of these values.
    pub fn combination(&self, choice: &[Option<usize>]) -> Option<usize> {
        self.points.iter().position(|point| point.choice == choice && !point.is_baseline)
    }

    /// The point with perfect links that has all else in common with a choice.
    pub fn perfect_like(&self, choice: &[Option<usize>]) -> Option<usize> {
        let same = |point: &Point| {
            let pairs = point.choice.iter().zip(choice).zip(&self.vary);
            point.perfect && pairs.into_iter().all(|((a, b), axis)| axis.is_netem() || a == b)
        };
        self.points.iter().position(same)
    }

    /// The runs of a part of `asked`, a sweep that this one covers, as runs of this one.
    pub fn runs_of(&self, asked: &Self, shard: Shard) -> Vec<Run> {
        let ours = self.points.iter().enumerate();
        let ours: BTreeMap<&str, usize> =
            ours.map(|(index, point)| (point.scenario_hash.as_str(), index)).collect();
        let point = |run: &Run| ours.get(asked.points[run.point].scenario_hash.as_str()).copied();
        let runs = asked.runs(shard).into_iter();
        runs.filter_map(|run| Some(Run { point: point(&run)?, ..run })).collect()
    }

    /// The name of a run's file, without its ending.
    pub fn run_name(&self, run: &Run) -> String {
        self.points[run.point].run_name(run.seed)
    }

    /// The command that flies one run again.
    pub fn replay(&self, run: &Run) -> String {
        let mut command = format!("csat run {} --seed {}", quoted(&self.source), run.seed);
        for set in self.sets.iter().chain(&self.points[run.point].sets) {
            command += &format!(" --set {}", quoted(set));
        }
        command
    }

    /// The command that flies all of it again.
    pub fn command(&self) -> String {
        let mut command = format!("csat sweep {}", quoted(&self.source));
        for axis in &self.vary {
            command += &format!(" --vary {}", quoted(&axis.argument()));
        }
        command += &format!(" --seeds {}", self.seeds);
        for set in &self.sets {
            command += &format!(" --set {}", quoted(set));
        }
        let usual = self.vary.iter().any(Axis::is_netem);
        match (self.baseline, usual) {
            (true, false) => command += " --baseline",
            (false, true) => command += " --no-baseline",
            _ => {}
        }
        if let Some(against) = &self.against {
            command += &format!(" --against {}", quoted(against));
        }
        command
    }
}

impl Axis {
    /// What `--vary` gets.
    pub fn argument(&self) -> String {
        let value = |choice: &super::vary::Choice| {
            let texts = choice.texts.join(",");
            let text = if self.keys.len() == 1 { texts } else { format!("({texts})") };
            choice.label.as_ref().map_or(text.clone(), |label| format!("{label}:{text}"))
        };
        let values: Vec<String> = self.values.iter().map(value).collect();
        format!("{}={}", self.keys.join(","), values.join(","))
    }
}

/// A word of a shell's command line.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+,:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::sweep::plan;

    /// As if each value made another mission, whatever the order of keys, and perfect links the same one
    /// however they come about.
    pub(crate) fn identify(points: &mut [Point]) {
        for point in points {
            let counts = |set: &&String| !(point.perfect && set.starts_with("netem."));
            let mut sets: Vec<&str> =
                point.sets.iter().filter(counts).map(String::as_str).collect();
            sets.sort_unstable();
            let text = format!("{} {}", point.perfect, sets.join(" "));
            point.identify(&format!("{:016x}", xxhash_rust::xxh3::xxh3_64(text.as_bytes())));
        }
    }

    /// A manifest of these axes, as if perfect links were flown for comparison when needed.
    pub(crate) fn sample(vary: &[&str], seeds: &str) -> Manifest {
        let axes: Vec<Axis> = vary.iter().map(|a| Axis::parse(a).unwrap()).collect();
        let mut points = plan::points(&axes);
        for point in &mut points {
            point.perfect = point.sets.iter().any(|s| s.ends_with("range_m=inf"));
        }
        let baseline = axes.iter().any(Axis::is_netem);
        if baseline {
            points.extend(plan::baselines(&axes, &points));
        }
        identify(&mut points);
        let seeds = crate::sweep::seeds::parse_seeds(seeds).unwrap();
        let sets = vec!["run.duration_s=9".to_owned()];
        let source = "city".to_owned();
        let request = Request { source, sets, axes, seeds, baseline, against: None };
        let checked = Checked { name: "city".to_owned(), ..Checked::default() };
        Manifest::new(request, points, checked)
    }

    #[test]
    fn shards_part_the_runs_and_every_seed_covers_all_points() {
        let manifest = sample(&["netem.radio.range_m=25,inf", "agents.count=1,2,3"], "1..4");
        let all = manifest.runs(Shard::WHOLE);
        assert_eq!(all.len(), 24);
        assert!(all[..6].iter().all(|run| run.seed == 1));
        let mut parts: Vec<Run> =
            (1..=5).flat_map(|index| manifest.runs(Shard { index, count: 5 })).collect();
        parts.sort();
        let mut sorted = all;
        sorted.sort();
        assert_eq!(parts, sorted);
    }

    #[test]
    fn commands_fly_it_again() {
        let manifest = sample(&["netem.radio.loss=bad:{model='iid',p=1}", "a,b=(1,2)"], "1..4,9");
        let run = manifest.runs(Shard::WHOLE)[0];
        assert_eq!(
            manifest.replay(&run),
            r"csat run city --seed 1 --set run.duration_s=9 --set 'netem.radio.loss={model='\''iid'\'',p=1}' --set a=1 --set b=2"
        );
        assert_eq!(
            manifest.command(),
            r"csat sweep city --vary 'netem.radio.loss=bad:{model='\''iid'\'',p=1}' --vary 'a,b=(1,2)' --seeds 1..4,9 --set run.duration_s=9"
        );
        for axis in &manifest.vary {
            assert_eq!(Axis::parse(&axis.argument()).unwrap(), *axis);
        }
    }

    #[test]
    fn points_that_share_files_are_a_flaw() {
        let mut manifest = sample(&["netem.radio.range_m=25,50", "a=3,-3"], "1");
        assert_eq!(manifest.flaw(), None);
        let name = manifest.points[4].name.clone();
        manifest.points[5].name.clone_from(&name);
        assert!(manifest.flaw().is_some_and(|flaw| flaw.contains(&name)));
    }

    #[test]
    fn what_an_editor_may_break_is_a_flaw() {
        let good = sample(&["a=1,2", "b,c=(1,2)"], "1..4");
        let flaw = |edit: fn(&mut Manifest)| {
            let mut manifest = good.clone();
            edit(&mut manifest);
            manifest.flaw().unwrap_or_default()
        };
        assert_eq!(flaw(|_| ()), "");
        assert!(flaw(|m| m.seeds = "5..1".into()).starts_with("seeds: `5..1` has no seed"));
        assert_eq!(
            flaw(|m| m.points[1].choice = vec![Some(9), Some(0)]),
            format!(
                "point `{}`: there is no value 9 of `a`, which has 2 (from 0)",
                good.points[1].name
            )
        );
        assert!(flaw(|m| m.points[0].choice = vec![Some(0)]).ends_with("1 choices for 2 axes"));
        assert!(flaw(|m| m.vary[1].values[0].texts.clear()).contains("0 texts for `b, c`"));
    }
}
