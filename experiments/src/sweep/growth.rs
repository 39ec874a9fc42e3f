//! One sweep out of two: more seeds, more values, or further keys, if the rest of their scenarios is
//! equal.
//!
//! A mission is known by the hash of its scenario in full and its seed, never by its place among others:
//! a run that one of the two sweeps has flown is a run of the sweep that covers both.

use std::collections::BTreeSet;

use super::manifest::Manifest;
use super::plan::Point;
use super::seeds::seeds_text;
use super::vary::{Axis, Choice};
use crate::scenario::differences::{Difference, differences, is_within};

/// The sweep that covers `there`, which is in a folder, and `here`, which is asked for. Where one of them
/// has all values (or seeds) of the other, its order counts; else values of `here` come after those that
/// are there, and seeds are in ascending order.
///
/// `mix_versions` lets runs of another version of the program count.
///
/// # Errors
/// What stands against it, one line each.
pub fn union(
    there: &Manifest,
    here: &Manifest,
    mix_versions: bool,
) -> Result<Manifest, Vec<String>> {
    let mut lines = Vec::new();
    if !mix_versions && !there.build.is_same_source(&here.build) {
        lines.push(format!(
            "csat: `{}` there, `{}` here; --mix-versions takes both and names them in the report",
            there.build, here.build
        ));
    }
    // A mission that both have is the same in every key.
    if hashes(there).is_disjoint(&hashes(here)) {
        lines.extend(scenarios(there, here).into_iter().map(line));
    }
    if !lines.is_empty() {
        return Err(lines);
    }
    let mut whole = if keys(there) == keys(here) {
        on_the_same_keys(there, here)?
    } else if keys(here).is_superset(&keys(there)) {
        covering(here, "here", there)?
    } else {
        covering(there, "there", here)?
    };
    whole.seeds = seeds(there, here);
    whole.baseline = there.baseline || here.baseline;
    whole.against = here.against.clone().or_else(|| there.against.clone());
    if there.build.is_same_source(&here.build) {
        whole.build = there.build.clone();
    }
    let first = whole.points.first().map(|point| &point.scenario_hash);
    let owner = if there.points.first().map(|p| &p.scenario_hash) == first { there } else { here };
    whole.scenario_toml.clone_from(&owner.scenario_toml);
    whole.map_hash.clone_from(&owner.map_hash);
    Ok(whole)
}

/// The refusal of two sweeps that do not go together.
pub fn refusal(what: &str, lines: &[String]) -> String {
    lines.iter().fold(format!("error: {what}"), |text, line| format!("{text}\n  = {line}"))
}

/// The keys that vary.
pub(crate) fn keys(manifest: &Manifest) -> BTreeSet<&str> {
    manifest.vary.iter().flat_map(|axis| &axis.keys).map(String::as_str).collect()
}

fn hashes(manifest: &Manifest) -> BTreeSet<&str> {
    manifest.points.iter().map(|point| point.scenario_hash.as_str()).collect()
}

/// The keys of two sweeps' scenarios that differ, but for those that vary.
pub(crate) fn scenarios(there: &Manifest, here: &Manifest) -> Vec<Difference> {
    let varied: BTreeSet<&str> = keys(there).union(&keys(here)).copied().collect();
    let varies = |key: &str| varied.iter().any(|outer| is_within(key, outer));
    // Where a map's file is does not count, but what is in it.
    let own_maps = there.map_hash.is_some() && here.map_hash.is_some();
    let mut all = differences(&there.scenario_toml, &here.scenario_toml);
    all.retain(|d| !varies(&d.key) && d.key != "name" && !(own_maps && d.key == "map.file"));
    if own_maps && there.map_hash != here.map_hash && !varies("map.file") {
        let contents = |hash: &Option<String>| hash.as_ref().map(|h| format!("contents {h}"));
        let (a, b) = (contents(&there.map_hash), contents(&here.map_hash));
        all.push(Difference { key: "map.file".to_owned(), a, b });
    }
    all
}

fn line(Difference { key, a, b }: Difference) -> String {
    let value = |value: Option<String>| value.map_or("nothing".to_owned(), |v| format!("`{v}`"));
    format!("{key}: {} there, {} here", value(a), value(b))
}

/// Both have the same keys: all values of both.
fn on_the_same_keys(there: &Manifest, here: &Manifest) -> Result<Manifest, Vec<String>> {
    let mut whole = here.clone();
    for axis in &mut whole.vary {
        let same = |other: &&Axis| other.keys == axis.keys;
        let Some(other) = there.vary.iter().find(same) else {
            let [there, here] = [there, here].map(titles);
            return Err(vec![format!("--vary: {there} there, {here} here")]);
        };
        *axis = all_values(other, axis).map_err(|line| vec![line])?;
    }
    // A combination counts before perfect links for comparison only.
    let mut all: Vec<(&Manifest, &Point)> = Vec::new();
    for manifest in [here, there] {
        all.extend(manifest.points.iter().map(|point| (manifest, point)));
    }
    all.sort_by_key(|(_, point)| point.is_baseline);
    let (mut points, mut hashes, mut choices) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
    for (manifest, point) in all {
        if !hashes.insert(&point.scenario_hash) {
            continue;
        }
        let choice = choice_of(&whole.vary, manifest, point);
        if !choices.insert((point.is_baseline, choice.clone())) && !point.is_baseline {
            let values = point.describe(&manifest.vary);
            return Err(vec![format!("{values}: another mission there than here")]);
        }
        points.push(Point { choice, ..point.clone() });
    }
    points.sort_by(|a, b| (a.is_baseline, &a.choice).cmp(&(b.is_baseline, &b.choice)));
    whole.points = points;
    Ok(whole)
}

/// The one with more keys, if it has all missions of the other one.
fn covering(large: &Manifest, name: &str, small: &Manifest) -> Result<Manifest, Vec<String>> {
    if !keys(large).is_superset(&keys(small)) {
        let (large, small) = (titles(large), titles(small));
        return Err(vec![format!(
            "--vary: {small} and {large}; one must vary all keys of the other"
        )]);
    }
    let there = hashes(large);
    let lacks = |point: &&Point| !there.contains(point.scenario_hash.as_str());
    let line = |point: &Point| {
        let values = point.describe(&small.vary);
        format!("{values}: not among the combinations of {} {name}", titles(large))
    };
    let mut lines: Vec<String> = small.points.iter().filter(lacks).map(line).collect();
    if lines.is_empty() {
        return Ok(large.clone());
    }
    // What those missions have instead.
    let is_new = |key: &str| {
        let varies = |manifest| keys(manifest).iter().any(|outer| is_within(key, outer));
        varies(large) && !varies(small)
    };
    let all = differences("", &small.scenario_toml).into_iter().filter(|d| is_new(&d.key));
    let value = |d: Difference| Some(format!("{}={}", d.key, d.b?));
    let values: Vec<String> = all.filter_map(value).collect();
    if !values.is_empty() {
        lines.push(format!("expected also the values that they have: {}", values.join(", ")));
    }
    Err(lines)
}

/// What varies, for people.
pub(crate) fn titles(manifest: &Manifest) -> String {
    let titles: Vec<String> =
        manifest.vary.iter().map(|axis| format!("`{}`", axis.title())).collect();
    if titles.is_empty() { "nothing".to_owned() } else { titles.join(" and ") }
}

fn all_values(there: &Axis, here: &Axis) -> Result<Axis, String> {
    let lacks = |axis: &Axis, value: &Choice| index_of(axis, value).is_none();
    let new: Vec<Choice> = here.values.iter().filter(|v| lacks(there, v)).cloned().collect();
    if there.values.iter().all(|value| !lacks(here, value)) {
        return Ok(here.clone());
    }
    let values = there.values.iter().cloned().chain(new).collect();
    let axis = Axis { keys: here.keys.clone(), values };
    // Two values may have got the same name.
    Axis::parse(&axis.argument())
        .map_err(|mistake| format!("{}: {}", axis.title(), mistake.message))
}

fn index_of(axis: &Axis, value: &Choice) -> Option<usize> {
    axis.values.iter().position(|other| other.is_same_value(value))
}

/// The choice of a point on other axes of the same keys; `None` for a value that they lack, and for perfect
/// links instead of one.
pub(crate) fn choice_of(axes: &[Axis], manifest: &Manifest, point: &Point) -> Vec<Option<usize>> {
    let on = |axis: &Axis| {
        let own = manifest.vary.iter().position(|other| other.keys == axis.keys)?;
        index_of(axis, &manifest.vary[own].values[point.choice[own]?])
    };
    axes.iter().map(on).collect()
}

fn seeds(there: &Manifest, here: &Manifest) -> String {
    let [there, here] = [there, here].map(Manifest::seed_list);
    let [old, new] = [&there, &here].map(|seeds| seeds.iter().copied().collect::<BTreeSet<u64>>());
    if new.is_superset(&old) {
        seeds_text(&here)
    } else if old.is_superset(&new) {
        seeds_text(&there)
    } else {
        seeds_text(&old.union(&new).copied().collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::manifest::tests::sample;

    fn grown(there: &[&str], here: &[&str], seeds: [&str; 2]) -> Result<Manifest, Vec<String>> {
        union(&sample(there, seeds[0]), &sample(here, seeds[1]), false)
    }

    /// A sweep that grew is the one that would have been asked for at once.
    #[test]
    fn what_covers_the_other_is_the_result() {
        let range = "netem.radio.range_m";
        let [few, more] = ["20,60", "20,40,60,inf"].map(|values| format!("{range}={values}"));
        let whole = sample(&[&more, "a=1,2"], "1..5");
        let seeds = ["1..2", "1..5"];
        assert_eq!(grown(&[&few, "a=1,2"], &[&more, "a=1,2"], seeds).unwrap(), whole);
        let [back, again] = [seeds[1], seeds[0]];
        assert_eq!(grown(&[&more, "a=1,2"], &[&few, "a=1,2"], [back, again]).unwrap(), whole);
        assert_eq!(union(&whole, &whole, false).unwrap(), whole);
    }

    #[test]
    fn values_and_seeds_of_both_are_taken() {
        let both = grown(&["a=1,2", "b=x"], &["b=x,y", "a=2,3.0"], ["3,4", "1,2"]).unwrap();
        assert_eq!(both.seeds, "1..4");
        let axes: Vec<String> = both.vary.iter().map(Axis::argument).collect();
        assert_eq!(axes, ["b=x,y", "a=1,2,3.0"]);
        // Neither of them asks for a=1 with b=y.
        let choices: Vec<_> = both.points.iter().map(|p| p.describe(&both.vary)).collect();
        assert_eq!(choices, ["b=x, a=1", "b=x, a=2", "b=x, a=3.0", "b=y, a=2", "b=y, a=3.0"]);
    }

    #[test]
    fn perfect_links_for_comparison_become_a_combination() {
        let range = |values: &str| format!("netem.radio.range_m={values}");
        let [there, here] = ["20,60", "20,inf"].map(|values| sample(&[&range(values)], "1"));
        assert!(there.points[2].is_baseline);
        for pair in [[&there, &here], [&here, &there]] {
            let whole = union(pair[0], pair[1], false).unwrap();
            assert_eq!(whole.points.len(), 3);
            assert!(whole.points.iter().all(|p| !p.is_baseline), "{:?}", whole.points);
        }
    }

    #[test]
    fn a_further_key_needs_the_missions_that_are_there() {
        let mut there = sample(&["a=1,2"], "1,2");
        let mut here = sample(&["a=1,2", "b=4,8"], "1..3");
        for (old, new) in [(0, 0), (1, 2)] {
            here.points[new].identify(&there.points[old].scenario_hash);
        }
        let whole = union(&there, &here, false).unwrap();
        assert_eq!((whole.points, whole.seeds.as_str()), (here.points.clone(), "1..3"));
        here.points[2].identify("other");
        there.scenario_toml = "a = 1\nb = 4\n".to_owned();
        assert_eq!(
            union(&there, &here, false).unwrap_err(),
            [
                "a=2: not among the combinations of `a` and `b` here",
                "expected also the values that they have: b=4"
            ]
        );
        assert_eq!(
            grown(&["a=1"], &["c=1"], ["1", "1"]).unwrap_err(),
            ["--vary: `c` and `a`; one must vary all keys of the other"]
        );
    }

    #[test]
    fn what_differs_is_named_key_by_key() {
        let mut there = sample(&["a=1,2"], "1");
        let mut here = sample(&["a=3"], "1");
        there.scenario_toml = "name = 'x'\na = 1\nb = 2\n[map]\nfile = '/one/town'\n".to_owned();
        here.scenario_toml =
            "name = 'y'\na = 3\nb = 4\nc = 1\n[map]\nfile = '/two/town'\n".to_owned();
        (there.map_hash, here.map_hash) = (Some("1".to_owned()), Some("2".to_owned()));
        there.build.git_revision = Some("abc".to_owned());
        let lines = union(&there, &here, false).unwrap_err();
        assert!(
            lines[0].contains("revision abc") && lines[0].contains("--mix-versions"),
            "{lines:?}"
        );
        assert_eq!(
            lines[1..],
            [
                "b: `2` there, `4` here",
                "c: nothing there, `1` here",
                "map.file: `contents 1` there, `contents 2` here"
            ]
        );
        here.scenario_toml.clone_from(&there.scenario_toml);
        here.map_hash.clone_from(&there.map_hash);
        assert_eq!(union(&there, &here, true).unwrap().points.len(), 3);
    }
}
