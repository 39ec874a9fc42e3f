//! `csat sweep`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crate::cli::SweepArguments;
use crate::scenario::Mistake;
use crate::sweep::SweepError;
use crate::sweep::check;
use crate::sweep::folder::{SweepFolder, default_root};
use crate::sweep::manifest::{Manifest, Request, quoted};
use crate::sweep::merge;
use crate::sweep::plan::{self, MAX_RUNS};
use crate::sweep::results::{Counts, Results};
use crate::sweep::seeds::{Shard, parse_seeds};
use crate::sweep::take::Taking;
use crate::sweep::vary::Axis;
use anyhow::Context;

use super::common::{interrupted_by_the_user, say, warn};
use super::runs::{Flight, code, complain, jobs, judge};

/// `csat sweep`.
pub fn sweep(arguments: &SweepArguments) -> anyhow::Result<u8> {
    judge(if arguments.merge.is_empty() { fly(arguments) } else { merge_folders(arguments) })
}

fn merge_folders(arguments: &SweepArguments) -> anyhow::Result<u8> {
    let (folder, results) =
        merge::merge(&arguments.merge, arguments.mix_versions, arguments.against.as_deref())?;
    tell(arguments, &folder, &results)?;
    Ok(code(&results.counts()))
}

fn fly(arguments: &SweepArguments) -> anyhow::Result<u8> {
    let (asked, shard) = plan_sweep(arguments)?;
    let root = match &arguments.out {
        Some(out) => out.clone(),
        None => {
            let name = usual_name(&asked);
            let is_ours = |root: &Path| {
                SweepFolder::at(root).manifest().is_ok_and(|there| usual_name(&there) == name)
            };
            default_root(Path::new("sweeps"), &name, arguments.resume, is_ours)?
        }
    };
    let taking = Taking { shard, resume: arguments.resume, mix_versions: arguments.mix_versions };
    let (folder, manifest) = SweepFolder::take(&root, &asked, taking)?;
    let stop = interrupted_by_the_user()?;
    let flight = Flight {
        manifest: &manifest,
        folder: &folder,
        shard,
        runs: manifest.runs_of(&asked, shard),
        jobs: jobs(arguments.jobs),
        quiet: arguments.json,
        keep_folders: arguments.keep_runs,
        fail_fast: arguments.fail_fast,
    };
    let failed_fast = flight.fly(stop.clone())?;
    let results = Results::read(&folder, manifest.clone());
    let counts = results.counts();
    // A Ctrl-C that came after the last step changes nothing.
    if stop.load(Ordering::SeqCst) && !failed_fast && flight.lacks_runs(&results) {
        return Ok(interrupted(&flight, &asked));
    }
    let others = Flight { runs: manifest.runs_of(&asked, Shard::WHOLE), ..flight };
    if shard != Shard::WHOLE && others.lacks_runs(&results) && !failed_fast {
        tell_shard(arguments, &others, &counts)?;
        return Ok(code(&counts));
    }
    let results = merge::conclude(&folder, &manifest)?;
    tell(arguments, &folder, &results)?;
    Ok(code(&results.counts()))
}

/// What the folder of a sweep is called if the user does not say.
fn usual_name(manifest: &Manifest) -> String {
    let keys = manifest.vary.iter().flat_map(|axis| &axis.keys);
    let keys: Vec<&str> = keys.map(|k| k.rsplit('.').next().unwrap_or(k)).collect();
    plan::slug(&[&[manifest.scenario.as_str()], &keys[..]].concat().join("-"))
}

/// Reads the command line and loads every combination.
fn plan_sweep(arguments: &SweepArguments) -> anyhow::Result<(Manifest, Shard)> {
    let mut shard = Shard::WHOLE;
    let mut mistakes = Vec::new();
    let mut axes = Vec::new();
    for argument in &arguments.vary {
        match Axis::parse(argument) {
            Ok(axis) => axes.push(axis),
            Err(mistake) => mistakes.push(mistake),
        }
    }
    let seeds = parse_seeds(arguments.seeds.as_deref().unwrap_or_default());
    let seeds = seeds.unwrap_or_else(|error| {
        mistakes.push(Mistake::new(format!("--seeds: {error}")));
        Vec::new()
    });
    if let Some(text) = &arguments.shard {
        match Shard::parse(text) {
            Ok(parsed) => shard = parsed,
            Err(error) => mistakes.push(Mistake::new(format!("--shard: {error}"))),
        }
    }
    mistakes.extend(plan::clashes(&axes, &arguments.sets));
    let counts = axes.iter().map(|axis| axis.values.len()).chain([seeds.len()]);
    let runs = counts.fold(1usize, usize::saturating_mul);
    if runs > MAX_RUNS {
        let message = format!("these are {runs} runs");
        mistakes.push(Mistake::new(message).expected(format!("at most {MAX_RUNS}")));
    }
    if !mistakes.is_empty() {
        return Err(SweepError::Mistakes(mistakes.into()).into());
    }
    let source = arguments.scenario.clone().unwrap_or_else(|| "city".to_owned());
    let baseline =
        (arguments.baseline || axes.iter().any(Axis::is_netem)) && !arguments.no_baseline;
    let (sets, against) = (arguments.sets.clone(), arguments.against.clone());
    let request = Request { source, sets, axes, seeds, baseline, against };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs(arguments.jobs)).build();
    let pool = pool.context("cannot start the threads")?;
    let (manifest, warnings) = pool.install(|| check::manifest(request))?;
    warn(&warnings, "from `csat check` with the values of a run");
    Ok((manifest, shard))
}

/// Says how to go on after Ctrl-C.
fn interrupted(flight: &Flight<'_>, asked: &Manifest) -> u8 {
    let shard = match flight.shard {
        Shard::WHOLE => String::new(),
        Shard { index, count } => format!(" --shard {index}/{count}"),
    };
    let again = format!("{}{shard}", asked.command());
    let root = quoted(&flight.folder.root().display().to_string());
    flight.interrupted(&again, &format!("\nor see what is there with\n  csat sweep --merge {root}"))
}

fn tell_shard(
    arguments: &SweepArguments,
    flight: &Flight<'_>,
    counts: &Counts,
) -> anyhow::Result<()> {
    if arguments.json {
        return say(&(serde_json::to_string_pretty(counts)? + "\n"));
    }
    let Shard { index, count } = flight.shard;
    let root = flight.folder.root().display();
    say(&format!(
        "shard {index}/{count} is done; {} of {} runs are in {root}\nthe last shard in this folder \
         makes the report, or `csat sweep --merge DIR...`\n",
        counts.runs - counts.missing,
        counts.runs
    ))
}

fn tell(arguments: &SweepArguments, folder: &SweepFolder, results: &Results) -> anyhow::Result<()> {
    let counts = results.counts();
    if arguments.json {
        return say(&(serde_json::to_string_pretty(&counts)? + "\n"));
    }
    complain(results);
    let Counts { runs, flown, violated, failed, missing } = counts;
    let report: PathBuf = folder.root().join("report.html");
    say(&format!(
        "{}: {runs} runs: {flown} flown, {violated} with violations, {failed} failed, {missing} \
         missing\n{}\n",
        results.manifest.scenario,
        report.display()
    ))
}
