//! Every combination with every seed is loaded before anything flies.

use std::collections::BTreeMap;

use csat_netem::config::NetemConfig;
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_64;

use super::SweepError;
use super::manifest::{self, Checked, Manifest};
use super::plan::{self, Point, Run};
use super::vary::Axis;
use crate::scenario::{self, Loaded, Mistake, Mistakes, Request};

/// What is kept of a loaded scenario.
struct Probe {
    name: String,
    perfect: bool,
    hash: String,
    scenario_toml: String,
    map_hash: Option<String>,
    warnings: Vec<String>,
}

/// Everything that `request` asks for, loaded once, and the distinct warnings.
///
/// # Errors
/// As [`check`].
pub fn manifest(request: manifest::Request) -> Result<(Manifest, Vec<String>), SweepError> {
    let manifest::Request { source, sets, axes, seeds, baseline, .. } = &request;
    let mut points = plan::points(axes);
    let checked = check(source, sets, axes, &mut points, seeds)?;
    if *baseline {
        let mut perfect = plan::baselines(axes, &points);
        if !perfect.is_empty() {
            check(source, sets, axes, &mut perfect, &seeds[..1])?;
        }
        points.extend(perfect);
    }
    let warnings = checked.warnings.clone();
    let manifest = Manifest::new(request, points, checked);
    match manifest.flaw() {
        None => Ok((manifest, warnings)),
        Some(flaw) => Err(SweepError::Refused(format!("error: {flaw}"))),
    }
}

/// Loads one run of a point. A baseline has perfect links whatever the sets left over.
///
/// # Errors
/// Everything that is wrong with it.
pub fn load(scenario: &str, sets: &[String], point: &Point, seed: u64) -> Result<Loaded, Mistakes> {
    let sets = [sets, &point.sets[..]].concat();
    let request = Request { scenario: Some(scenario), sets: &sets, seed: Some(seed) };
    let mut loaded = scenario::load(request)?;
    if point.is_baseline {
        loaded.scenario.netem = NetemConfig::default();
    }
    Ok(loaded)
}

fn probe(loaded: Loaded) -> Probe {
    let seed = format!("seed = {}\n", loaded.scenario.seed);
    Probe {
        perfect: loaded.scenario.netem == NetemConfig::default(),
        hash: hash(&loaded),
        scenario_toml: loaded.scenario.to_toml().replacen(&seed, "", 1),
        map_hash: loaded.own_map().map(|map| hexadecimal(&map.text)),
        warnings: loaded.warnings.iter().map(|w| w.render("warning")).collect(),
        name: loaded.name,
    }
}

/// Hash of a scenario in full, of its map and of its tracks, hexadecimal. Neither its seed, its name nor
/// the places of its files make it another one.
pub fn hash(loaded: &Loaded) -> String {
    let mut scenario = loaded.kept();
    scenario.seed = 0;
    scenario.name.clear();
    let map = loaded.map.as_ref().map_or("", |map| &map.text);
    let tracks = loaded.tracks.as_ref().map_or("", |tracks| &tracks.text);
    hexadecimal(&format!("{}\0{map}{tracks}", scenario.to_toml()))
}

fn hexadecimal(text: &str) -> String {
    format!("{:016x}", xxh3_64(text.as_bytes()))
}

/// Loads every point with every seed, fills in what that shows, and refuses what cannot fly.
///
/// # Errors
/// Every distinct mistake, with combinations that have it.
pub fn check(
    scenario: &str,
    sets: &[String],
    axes: &[Axis],
    points: &mut [Point],
    seeds: &[u64],
) -> Result<Checked, SweepError> {
    let runs: Vec<Run> = (0..points.len())
        .flat_map(|point| seeds.iter().map(move |&seed| Run { seed, point }))
        .collect();
    let probes: Vec<Result<Probe, Mistakes>> = runs
        .par_iter()
        .map(|run| load(scenario, sets, &points[run.point], run.seed).map(probe))
        .collect();
    let mut found = Found::default();
    let mut checked = Checked::default();
    for (run, result) in runs.iter().zip(probes) {
        match result {
            Err(found_mistakes) => found.add(found_mistakes.mistakes, run),
            Ok(probe) => {
                for warning in probe.warnings {
                    if !checked.warnings.contains(&warning) {
                        checked.warnings.push(warning);
                    }
                }
                if checked.name.is_empty() {
                    (checked.name, checked.scenario_toml) = (probe.name, probe.scenario_toml);
                    checked.map_hash = probe.map_hash;
                }
                let point = &mut points[run.point];
                point.perfect = probe.perfect;
                point.identify(&probe.hash);
            }
        }
    }
    found.add_twins(axes, points);
    found.finish(axes, points, seeds.len()).map(|()| checked)
}

/// Distinct mistakes in the order in which they appear, each with the runs that have it.
#[derive(Default)]
struct Found {
    order: Vec<Mistake>,
    runs: BTreeMap<usize, Vec<Run>>,
    others: Vec<Mistake>,
}

impl Found {
    fn add(&mut self, mistakes: Vec<Mistake>, run: &Run) {
        for mistake in mistakes {
            let known = self.order.iter().position(|m| *m == mistake);
            let index = known.unwrap_or_else(|| {
                self.order.push(mistake);
                self.order.len() - 1
            });
            let runs = self.runs.entry(index).or_default();
            // A mistake may be there twice in one scenario.
            if runs.last() != Some(run) {
                runs.push(*run);
            }
        }
    }

    /// Two combinations that are the same mission would count its runs twice.
    fn add_twins(&mut self, axes: &[Axis], points: &[Point]) {
        let mut seen: BTreeMap<&str, &Point> = BTreeMap::new();
        for point in points.iter().filter(|p| !p.scenario_hash.is_empty()) {
            if let Some(first) = seen.get(point.scenario_hash.as_str()) {
                let message = format!(
                    "these are the same mission: {} and {}",
                    first.describe(axes),
                    point.describe(axes)
                );
                self.others.push(Mistake::new(message).expected("combinations that differ"));
            }
            seen.entry(&point.scenario_hash).or_insert(point);
        }
    }

    fn finish(self, axes: &[Axis], points: &[Point], seeds: usize) -> Result<(), SweepError> {
        let mut mistakes = Vec::new();
        for (index, mut mistake) in self.order.into_iter().enumerate() {
            let runs = &self.runs[&index];
            rename_place(&mut mistake, axes);
            let note = note(runs, axes, points, seeds);
            let gutter = match &mistake.place {
                Some(place) if place.is_file => " ".repeat(place.line.to_string().len()),
                Some(_) => String::new(),
                None => " ".to_owned(),
            };
            mistake.help = Some(match mistake.help {
                Some(help) => format!("{help}\n{gutter} = {note}"),
                None => note,
            });
            mistakes.push(mistake);
        }
        mistakes.extend(self.others);
        if mistakes.is_empty() { Ok(()) } else { Err(Mistakes::from(mistakes).into()) }
    }
}

/// A value of `--vary` reaches the loader as a `--set`.
fn rename_place(mistake: &mut Mistake, axes: &[Axis]) {
    let Some(place) = mistake.place.as_mut().filter(|place| place.source == "--set") else {
        return;
    };
    let pairs = axes
        .iter()
        .flat_map(|axis| axis.values.iter().flat_map(|v| axis.keys.iter().zip(&v.texts)));
    if pairs.into_iter().any(|(key, text)| place.excerpt == format!("{key}={text}")) {
        place.source = "--vary".to_owned();
    }
}

/// Which runs have a mistake.
fn note(runs: &[Run], axes: &[Axis], points: &[Point], seeds: usize) -> String {
    let first = runs[0];
    let mut which: Vec<usize> = runs.iter().map(|run| run.point).collect();
    which.dedup();
    let values = points[first.point].describe(axes);
    if runs.len() == points.len() * seeds {
        return if axes.is_empty() {
            "in every run".to_owned()
        } else {
            "in every combination".to_owned()
        };
    }
    let others = match which.len() - 1 {
        0 => String::new(),
        1 => " and 1 other combination".to_owned(),
        n => format!(" and {n} other combinations"),
    };
    let seed = if runs.len() == which.len() * seeds {
        String::new()
    } else {
        format!(", seed {}", first.seed)
    };
    format!("in the combination {values}{seed}{others}")
}
