//! What a sweep flies: points (one combination of values each) with every seed.

use std::collections::BTreeSet;

use csat_netem::config::NetemConfig;
use serde::{Deserialize, Serialize};

use super::vary::Axis;
use crate::scenario::Mistake;

/// The most missions of one sweep.
pub const MAX_RUNS: usize = 1_000_000;
/// The longest part of a file's name that values give, characters.
const SLUG: usize = 60;
/// What the names of points begin with that are flown for comparison only.
const BASELINE: &str = "baseline";

/// A combination of values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Point {
    /// Its name, and that of its files before `-seedN`: its values and its hash, so that it stays the
    /// same when the sweep grows.
    pub name: String,
    /// Whether it stands for perfect links only, outside of the combinations asked for.
    pub is_baseline: bool,
    /// Per axis, which of its values; `None` where perfect links stand instead of one.
    pub choice: Vec<Option<usize>>,
    /// What `--set` gets besides the sweep's own sets.
    pub sets: Vec<String>,
    /// Whether its links are perfect.
    pub perfect: bool,
    /// [`super::check::hash`]: together with the seed, which mission it is.
    pub scenario_hash: String,
}

impl Point {
    /// The name of its run with this seed.
    pub fn run_name(&self, seed: u64) -> String {
        format!("{}-seed{seed}", self.name)
    }

    /// Gives it its hash, which becomes a part of its name.
    pub fn identify(&mut self, hash: &str) {
        let values = self.name.strip_suffix(&self.scenario_hash).unwrap_or(&self.name);
        let values = values.trim_end_matches('-');
        let dash = if values.is_empty() { "" } else { "-" };
        self.name = format!("{values}{dash}{hash}");
        hash.clone_into(&mut self.scenario_hash);
    }

    /// What in it does not belong to these axes, as it may be after a user edited its file.
    pub fn flaw(&self, axes: &[Axis]) -> Option<String> {
        if self.choice.len() != axes.len() {
            return Some(format!("{} choices for {} axes", self.choice.len(), axes.len()));
        }
        axes.iter().zip(&self.choice).find_map(|(axis, choice)| {
            let (index, title, count) = ((*choice)?, axis.title(), axis.values.len());
            let Some(value) = axis.values.get(index) else {
                return Some(format!(
                    "there is no value {index} of `{title}`, which has {count} (from 0)"
                ));
            };
            let texts = value.texts.len();
            (texts != axis.keys.len()).then(|| format!("{texts} texts for `{title}`"))
        })
    }

    /// Its value of an axis, for people.
    pub fn shown(&self, axes: &[Axis], axis: usize) -> String {
        match self.choice[axis] {
            Some(index) => axes[axis].values[index].shown(),
            None => "perfect".to_owned(),
        }
    }

    /// All its values, for people.
    pub fn describe(&self, axes: &[Axis]) -> String {
        let values = (0..axes.len()).filter(|&a| self.choice[a].is_some());
        let values = values.map(|a| format!("{}={}", axes[a].title(), self.shown(axes, a)));
        let values = values.collect::<Vec<_>>().join(", ");
        match (self.is_baseline, values.is_empty()) {
            (true, true) => "perfect links".to_owned(),
            (true, false) => format!("perfect links, {values}"),
            (false, true) => "the scenario as it is".to_owned(),
            (false, false) => values,
        }
    }
}

/// One mission of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Run {
    /// Its seed.
    pub seed: u64,
    /// Index of its point.
    pub point: usize,
}

/// Refuses keys that several arguments claim.
pub fn clashes(axes: &[Axis], sets: &[String]) -> Vec<Mistake> {
    let mut mistakes = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    let within = |inner: &str, outer: &str| {
        inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    for key in axes.iter().flat_map(|axis| &axis.keys) {
        if let Some(other) = seen.iter().find(|other| within(key, other) || within(other, key)) {
            let message = if other == key {
                format!("`{key}` varies twice")
            } else {
                format!("`{key}` and `{other}` vary each other")
            };
            let expected = "every key in one --vary only";
            mistakes.push(Mistake::new(message).expected(expected));
        }
        seen.push(key);
    }
    for set in sets {
        let Some(key) = set.split_once('=').and_then(|(key, _)| super::vary::dotted(key)) else {
            continue;
        };
        if key == "seed" {
            let mistake = Mistake::new(format!("`--set {set}`: the seeds are those of --seeds"));
            mistakes.push(mistake.expected("`--seeds 1..5`"));
        }
        if let Some(varied) = seen.iter().find(|varied| within(&key, varied)) {
            let message = format!("`--set {set}` does nothing: `{varied}` varies");
            mistakes.push(Mistake::new(message).expected("a key in --set or in --vary, not both"));
        }
    }
    mistakes
}

/// Every combination, the last axis fastest. What [`Point::identify`] and loading them tell is not known
/// yet.
pub fn points(axes: &[Axis]) -> Vec<Point> {
    let mut choices: Vec<Vec<Option<usize>>> = vec![Vec::new()];
    for axis in axes {
        let longer = |choice: &Vec<Option<usize>>| {
            let base = choice.clone();
            (0..axis.values.len()).map(move |v| [&base[..], &[Some(v)]].concat())
        };
        choices = choices.iter().flat_map(longer).collect();
    }
    choices.into_iter().map(|choice| point(axes, choice, String::new())).collect()
}

/// The points with perfect links that `points` lacks: one for each combination of what is not about
/// the links.
pub fn baselines(axes: &[Axis], points: &[Point]) -> Vec<Point> {
    let rest = |choice: &[Option<usize>]| -> Vec<Option<usize>> {
        choice.iter().zip(axes).map(|(c, axis)| c.filter(|_| !axis.is_netem())).collect()
    };
    let there: BTreeSet<_> = points.iter().filter(|p| p.perfect).map(|p| rest(&p.choice)).collect();
    let mut missing: Vec<Vec<Option<usize>>> = Vec::new();
    for choice in points.iter().map(|p| rest(&p.choice)) {
        if !there.contains(&choice) && !missing.contains(&choice) {
            missing.push(choice);
        }
    }
    let baseline = |choice| {
        let mut point = point(axes, choice, BASELINE.to_owned());
        point.sets.extend(perfect_links());
        (point.perfect, point.is_baseline) = (true, true);
        point
    };
    missing.into_iter().map(baseline).collect()
}

/// The sets that make all links perfect.
fn perfect_links() -> Vec<String> {
    let value = toml::Value::try_from(NetemConfig::default()).ok();
    let table = value.as_ref().and_then(toml::Value::as_table);
    table.into_iter().flatten().map(|(key, value)| format!("netem.{key}={value}")).collect()
}

fn point(axes: &[Axis], choice: Vec<Option<usize>>, mut name: String) -> Point {
    let mut sets = Vec::new();
    for (axis, index) in axes.iter().zip(&choice) {
        let Some(index) = index else { continue };
        let value = &axis.values[*index];
        let last = axis.keys.iter().map(|k| k.rsplit('.').next().unwrap_or(k));
        name += &format!("-{}-{}", last.collect::<Vec<_>>().join("-"), value.shown());
        sets.extend(axis.keys.iter().zip(&value.texts).map(|(k, t)| format!("{k}={t}")));
    }
    let name = slug(name.trim_start_matches('-'));
    let scenario_hash = String::new();
    Point { name, is_baseline: false, choice, sets, perfect: false, scenario_hash }
}

/// What can be part of a file's name on any system.
pub fn slug(text: &str) -> String {
    let mut slug = String::new();
    for c in text.chars().take(4 * SLUG) {
        let c = if c.is_ascii_alphanumeric() || "._+".contains(c) { c } else { '-' };
        if c != '-' || !slug.ends_with('-') {
            slug.push(c);
        }
    }
    slug.truncate(SLUG);
    slug.trim_end_matches(['-', '.']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(arguments: &[&str]) -> Vec<Axis> {
        arguments.iter().map(|a| Axis::parse(a).unwrap()).collect()
    }

    #[test]
    fn every_combination_has_its_name_and_sets() {
        let axes = axes(&["netem.radio.range_m=25,inf", "agents.count,targets.count=(2,4),(4,8)"]);
        let points = points(&axes);
        let names: Vec<_> = points.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "range_m-25-count-count-2-4",
                "range_m-25-count-count-4-8",
                "range_m-inf-count-count-2-4",
                "range_m-inf-count-count-4-8",
            ]
        );
        assert_eq!(points[1].sets, ["netem.radio.range_m=25", "agents.count=4", "targets.count=8"]);
        assert_eq!(
            points[1].describe(&axes),
            "netem.radio.range_m=25, agents.count, targets.count=4, 8"
        );
        let [mut bare] = <[Point; 1]>::try_from(super::points(&[])).unwrap();
        bare.identify("0123");
        assert_eq!(bare.run_name(7), "0123-seed7");
        let mut first = points[0].clone();
        first.identify("0123");
        first.identify("4567");
        assert_eq!(first.name, "range_m-25-count-count-2-4-4567");
    }

    #[test]
    fn perfect_links_are_flown_once_for_what_is_not_about_links() {
        let axes = axes(&["netem.radio.range_m=25,inf", "agents.count=2,4"]);
        let mut points = points(&axes);
        // As if range inf were perfect for two agents only.
        points[2].perfect = true;
        let missing = baselines(&axes, &points);
        assert_eq!(missing.len(), 1);
        assert_eq!(missing[0].choice, [None, Some(1)]);
        assert!(missing[0].is_baseline && missing[0].perfect);
        assert_eq!(missing[0].sets[0], "agents.count=4");
        assert!(missing[0].sets.iter().any(|s| s.starts_with("netem.radio={")), "{missing:?}");
        assert_eq!(missing[0].describe(&axes), "perfect links, agents.count=4");
    }

    /// `3` and `-3` look the same in a file's name, and so do long values.
    #[test]
    fn no_two_points_share_a_file() {
        let long = ["a", "b"].map(|end| format!("'{}{end}'", "x".repeat(2 * SLUG))).join(",");
        for values in ["3,-3", "'ä','ö'", &long] {
            let axes = axes(&["netem.radio.range_m=25,50", &format!("a.b={values}")]);
            let mut points = points(&axes);
            points.extend(baselines(&axes, &points));
            crate::sweep::manifest::tests::identify(&mut points);
            let names: BTreeSet<&str> = points.iter().map(|p| p.name.as_str()).collect();
            assert_eq!(names.len(), 6, "{names:?}");
            assert!(points[4].name.starts_with("baseline-b-"), "{names:?}");
        }
    }

    #[test]
    fn keys_that_are_claimed_twice_are_refused() {
        let say = |vary: &[&str], set: &str| {
            let mistakes = clashes(&axes(vary), &[set.to_owned()]);
            mistakes.iter().map(|m| m.message.clone()).collect::<Vec<_>>()
        };
        assert_eq!(say(&["a.b=1", "a.b=2"], "c=1"), ["`a.b` varies twice"]);
        assert_eq!(say(&["a,a=(1,2)"], "c=1"), ["`a` varies twice"]);
        assert_eq!(say(&["a.b=1", "a={b=2}"], "c=1"), ["`a` and `a.b` vary each other"]);
        assert_eq!(say(&["a.b=1"], "a . 'b'=4"), ["`--set a . 'b'=4` does nothing: `a.b` varies"]);
        assert_eq!(say(&["a.b=1"], "a.b.c=4"), ["`--set a.b.c=4` does nothing: `a.b` varies"]);
        assert!(say(&["a.b=1"], "a={c=1}").is_empty());
        assert!(say(&["a.b=1"], "a.bc=1").is_empty());
        assert_eq!(say(&["a.b=1"], "seed=3").len(), 1);
    }

    #[test]
    fn file_names_are_tame() {
        assert_eq!(slug("-map.file-../a b/ü.geojson"), "-map.file-..-a-b-.geojson");
        assert!(slug(&"x".repeat(1000)).len() <= SLUG);
    }
}
