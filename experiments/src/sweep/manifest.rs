//! `sweep.json`: what belongs to a sweep. Shards, threads and folders are no part of it.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use super::check::Checked;
use super::plan::{Point, Run};
use super::seeds::{Shard, seeds_text};
use super::vary::Axis;
use crate::provenance::Provenance;

/// Counts up when the files of a sweep change their meaning.
pub const FORMAT: u32 = 1;

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
    /// Every combination, then those with perfect links for comparison.
    pub points: Vec<Point>,
    /// The first combination in full.
    pub scenario_toml: String,
    /// Version of `csat`.
    pub version: String,
    /// Git revision it was built from.
    pub git_revision: Option<String>,
    /// Whether that tree had changes that were not committed.
    pub git_dirty: Option<bool>,
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
}

impl Manifest {
    /// Of this program.
    pub fn new(request: Request, points: Vec<Point>, checked: Checked) -> Self {
        let program = Provenance::collect(&checked.name, 0, None);
        Self {
            format: FORMAT,
            scenario: checked.name,
            source: request.source,
            sets: request.sets,
            vary: request.axes,
            seeds: seeds_text(&request.seeds),
            baseline: request.baseline,
            points,
            scenario_toml: checked.scenario_toml,
            version: program.version,
            git_revision: program.git_revision,
            git_dirty: program.git_dirty,
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a manifest is JSON") + "\n"
    }

    /// What the run files of this sweep carry, so that none of another one is taken for theirs.
    pub fn fingerprint(&self) -> String {
        format!("{:016x}", xxh3_64(self.to_json().as_bytes()))
    }

    /// What is wrong with it, as it may be after somebody edited its file.
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
        command
    }

    /// What distinguishes it from the one that is there, one line each; none for equal ones.
    pub fn differences(&self, there: &Self) -> Vec<String> {
        let sets = |m: &Self| m.sets.join(" ");
        let vary = |m: &Self| m.vary.iter().map(Axis::argument).collect::<Vec<_>>().join(" ");
        let yes = |baseline: bool| if baseline { "yes" } else { "no" }.to_owned();
        let revision = |m: &Self| {
            let dirty = if m.git_dirty == Some(true) { ", with changes" } else { "" };
            format!("{}{dirty}", m.git_revision.as_deref().unwrap_or("unknown"))
        };
        let pairs = [
            ("format", there.format.to_string(), self.format.to_string()),
            ("scenario", there.source.clone(), self.source.clone()),
            ("--set", sets(there), sets(self)),
            ("--vary", vary(there), vary(self)),
            ("--seeds", there.seeds.clone(), self.seeds.clone()),
            ("--baseline", yes(there.baseline), yes(self.baseline)),
            ("version", there.version.clone(), self.version.clone()),
            ("git revision", revision(there), revision(self)),
        ];
        let mut lines: Vec<String> = pairs
            .into_iter()
            .filter(|(_, there, here)| there != here)
            .map(|(what, there, here)| format!("{what}: `{there}` there, `{here}` here"))
            .collect();
        if lines.is_empty() && self.scenario_toml != there.scenario_toml {
            let pairs = there.scenario_toml.lines().zip(self.scenario_toml.lines());
            let first = pairs.into_iter().find(|(there, here)| there != here);
            let (there, here) = first.unwrap_or(("more or less of it", "less or more of it"));
            lines.push(format!("the scenario's values: `{there}` there, `{here}` here"));
        }
        if lines.is_empty() && self != there {
            lines.push("the scenarios of the points, or the map".to_owned());
        }
        lines
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
        let seeds = crate::sweep::seeds::parse_seeds(seeds).unwrap();
        let sets = vec!["run.duration_s=9".to_owned()];
        let request = Request { source: "city".to_owned(), sets, axes, seeds, baseline };
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
            "point `02-a-2-b-c-1-2`: there is no value 9 of `a`, which has 2 (from 0)"
        );
        assert!(flaw(|m| m.points[0].choice = vec![Some(0)]).ends_with("1 choices for 2 axes"));
        assert!(flaw(|m| m.vary[1].values[0].texts.clear()).contains("0 texts for `b, c`"));
    }

    #[test]
    fn differences_are_named() {
        let one = sample(&["a=1,2"], "1..4");
        assert!(one.differences(&one).is_empty());
        let other = sample(&["a=1,3"], "1..5");
        assert_eq!(
            other.differences(&one),
            ["--vary: `a=1,2` there, `a=1,3` here", "--seeds: `1..4` there, `1..5` here"]
        );
        let edited = Manifest { scenario_toml: "x = 1\ny = 2".into(), ..one.clone() };
        let again = Manifest { scenario_toml: "x = 1\ny = 3".into(), ..one.clone() };
        assert_eq!(
            again.differences(&edited),
            ["the scenario's values: `y = 2` there, `y = 3` here"]
        );
        assert_ne!(edited.fingerprint(), again.fingerprint());
    }
}
