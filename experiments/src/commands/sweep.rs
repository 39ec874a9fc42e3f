//! `csat sweep`.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use csat_experiments::cli::SweepArguments;
use csat_experiments::scenario::{Mistake, Mistakes};
use csat_experiments::sweep::SweepError;
use csat_experiments::sweep::bar::Bar;
use csat_experiments::sweep::check;
use csat_experiments::sweep::fly::Hangar;
use csat_experiments::sweep::folder::{SweepFolder, Taking, default_root};
use csat_experiments::sweep::manifest::{Manifest, Request};
use csat_experiments::sweep::merge;
use csat_experiments::sweep::plan::{self, MAX_RUNS, Run};
use csat_experiments::sweep::record::RunRecord;
use csat_experiments::sweep::results::{Counts, Results};
use csat_experiments::sweep::seeds::{Shard, parse_seeds};
use csat_experiments::sweep::vary::Axis;
use csat_experiments::sweep::work::work;
use csat_experiments::verdict::{BAD_INPUT, DONE, FAILED, INTERRUPTED, VIOLATED};

use super::{interrupted_by_the_user, say};

/// `csat sweep`.
pub fn sweep(arguments: &SweepArguments) -> anyhow::Result<u8> {
    let result = if arguments.merge.is_empty() { fly(arguments) } else { merge_folders(arguments) };
    match result.map_err(|error| error.downcast::<SweepError>()) {
        Ok(code) => Ok(code),
        Err(Ok(error @ (SweepError::Mistakes(_) | SweepError::Refused(_)))) => {
            eprintln!("{error}");
            Ok(BAD_INPUT)
        }
        Err(Ok(error)) => Err(error.into()),
        Err(Err(error)) => Err(error),
    }
}

fn merge_folders(arguments: &SweepArguments) -> anyhow::Result<u8> {
    let (folder, results) = merge::merge(&arguments.merge)?;
    tell(arguments, &folder, &results)?;
    Ok(code(&results.counts()))
}

fn fly(arguments: &SweepArguments) -> anyhow::Result<u8> {
    let (manifest, shard) = plan_sweep(arguments)?;
    let keys = manifest.vary.iter().flat_map(|axis| &axis.keys);
    let keys: Vec<&str> = keys.map(|k| k.rsplit('.').next().unwrap_or(k)).collect();
    let root = match &arguments.out {
        Some(out) => out.clone(),
        None => {
            let name = [&[manifest.scenario.as_str()], &keys[..]].concat().join("-");
            default_root(&plan::slug(&name), arguments.resume)?
        }
    };
    let taking = Taking { shard, resume: arguments.resume };
    let folder = SweepFolder::take(&root, &manifest, taking)?;
    let stop = interrupted_by_the_user()?;
    let part = Part { arguments, manifest: &manifest, folder: &folder, shard };
    let failed_fast = part.fly(stop.clone())?;
    let results = Results::read(&folder, manifest.clone())?;
    let counts = results.counts();
    // A Ctrl-C that came after the last step changes nothing.
    if stop.load(Ordering::SeqCst) && !failed_fast && part.lacks_runs(&results) {
        return Ok(part.interrupted());
    }
    if shard != Shard::WHOLE && counts.missing > 0 && !failed_fast {
        part.tell_shard(&counts)?;
        return Ok(code(&counts));
    }
    let results = merge::conclude(&folder, &manifest)?;
    tell(arguments, &folder, &results)?;
    Ok(code(&results.counts()))
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
        return Err(SweepError::Mistakes(Mistakes(mistakes)).into());
    }
    let source = arguments.scenario.clone().unwrap_or_else(|| "city".to_owned());
    let baseline =
        (arguments.baseline || axes.iter().any(Axis::is_netem)) && !arguments.no_baseline;
    let mut points = plan::points(&axes);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs(arguments)).build();
    let checked = pool
        .context("cannot start the threads")?
        .install(|| check::check(&source, &arguments.sets, &axes, &mut points, &seeds))?;
    if baseline {
        let mut perfect = plan::baselines(&axes, &points);
        if !perfect.is_empty() {
            check::check(&source, &arguments.sets, &axes, &mut perfect, &seeds[..1])?;
        }
        points.extend(perfect);
    }
    if !checked.warnings.is_empty() && !arguments.json {
        eprintln!("{}, in full from `csat check`", super::warnings(checked.warnings.len()));
    }
    let sets = arguments.sets.clone();
    let request = Request { source, sets, axes, seeds, baseline };
    Ok((Manifest::new(request, points, checked), shard))
}

fn jobs(arguments: &SweepArguments) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    arguments.jobs.map_or_else(cores, usize::from)
}

/// What this process flies.
struct Part<'a> {
    arguments: &'a SweepArguments,
    manifest: &'a Manifest,
    folder: &'a SweepFolder,
    shard: Shard,
}

impl Part<'_> {
    /// Flies what has not been flown; gives whether it stopped at a run that failed.
    fn fly(&self, stop: Arc<AtomicBool>) -> Result<bool, SweepError> {
        let Part { arguments, manifest, folder, shard } = *self;
        let mine = manifest.runs(shard);
        let mut runs = Vec::new();
        for run in &mine {
            // A run that failed is no result: it may have been a full disk.
            if folder.run(manifest, run)?.is_none_or(|record| record.failed.is_some()) {
                runs.push(*run);
            }
        }
        let hangar = Hangar { manifest, folder, shard, keep_folders: arguments.keep_runs, stop };
        let mut bar = Bar::new(mine.len(), mine.len() - runs.len(), arguments.json);
        let mut failed_fast = false;
        let done = |run: &Run, record: &RunRecord| {
            bar.run(&manifest.run_name(run), record);
            let is_bad = record.failed.is_some() || record.violations() > 0;
            failed_fast |= is_bad && arguments.fail_fast;
            !(is_bad && arguments.fail_fast)
        };
        let result = work(&hangar, &runs, jobs(arguments), done);
        bar.clear();
        folder.clear_partial(shard)?;
        result.map(|()| failed_fast)
    }

    fn lacks_runs(&self, results: &Results) -> bool {
        let mine = self.manifest.runs(self.shard);
        results.runs.iter().any(|(run, record)| record.is_none() && mine.contains(run))
    }

    /// Says how to go on after Ctrl-C.
    fn interrupted(&self) -> u8 {
        let root = self.folder.root().display().to_string();
        let root = csat_experiments::sweep::manifest::quoted(&root);
        let shard = match self.shard {
            Shard::WHOLE => String::new(),
            Shard { index, count } => format!(" --shard {index}/{count}"),
        };
        eprintln!(
            "ended early; go on with\n  {}{shard} --resume --out {root}\nor see what is there \
             with\n  csat sweep --merge {root}",
            self.manifest.command()
        );
        INTERRUPTED
    }

    fn tell_shard(&self, counts: &Counts) -> anyhow::Result<()> {
        if self.arguments.json {
            return say(&(serde_json::to_string_pretty(counts)? + "\n"));
        }
        let Shard { index, count } = self.shard;
        let root = self.folder.root().display();
        say(&format!(
            "shard {index}/{count} is done; {} of {} runs are in {root}\nthe last shard in this \
             folder makes the report, or `csat sweep --merge DIR...`\n",
            counts.runs - counts.missing,
            counts.runs
        ))
    }
}

fn tell(arguments: &SweepArguments, folder: &SweepFolder, results: &Results) -> anyhow::Result<()> {
    let counts = results.counts();
    if arguments.json {
        return say(&(serde_json::to_string_pretty(&counts)? + "\n"));
    }
    let manifest = &results.manifest;
    let bad = |record: &RunRecord| record.failed.is_some() || record.violations() > 0;
    for (run, record) in &results.runs {
        let name = manifest.run_name(run);
        match record {
            None => eprintln!("missing: {name}\n  = fly it with --resume"),
            Some(record) if bad(record) => {
                eprintln!(
                    "{name}: {}\n  = fly it again with `{}`",
                    record.describe(),
                    record.replay
                );
            }
            Some(_) => {}
        }
    }
    let Counts { runs, flown, violated, failed, missing } = counts;
    let report: PathBuf = folder.root().join("report.html");
    say(&format!(
        "{}: {runs} runs: {flown} flown, {violated} with violations, {failed} failed, {missing} \
         missing\n{}\n",
        manifest.scenario,
        report.display()
    ))
}

/// Violations count most.
fn code(counts: &Counts) -> u8 {
    match counts {
        Counts { violated: 1.., .. } => VIOLATED,
        Counts { failed: 1.., .. } => FAILED,
        _ => DONE,
    }
}
