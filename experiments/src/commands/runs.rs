//! Flying the runs of a sweep that are not there yet, and saying what became of them.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::sweep::SweepError;
use crate::sweep::bar::Bar;
use crate::sweep::fly::Hangar;
use crate::sweep::folder::SweepFolder;
use crate::sweep::manifest::{Manifest, quoted};
use crate::sweep::pace::Pace;
use crate::sweep::plan::Run;
use crate::sweep::record::RunRecord;
use crate::sweep::results::{Counts, Results};
use crate::sweep::seeds::Shard;
use crate::sweep::work::{Event, work};
use crate::verdict::{BAD_INPUT, DONE, FAILED, INTERRUPTED, VIOLATED};
use csat_peer::tell;

/// What this process flies.
pub struct Flight<'a> {
    /// The sweep.
    pub manifest: &'a Manifest,
    /// Its folder.
    pub folder: &'a SweepFolder,
    /// Its part.
    pub shard: Shard,
    /// The runs of its part that the user asked for.
    pub runs: Vec<Run>,
    /// Missions at a time.
    pub jobs: usize,
    /// Nothing shows meanwhile.
    pub quiet: bool,
    /// Run folders stay.
    pub keep_folders: bool,
    /// Stops at the first run that fails or violates a guarantee.
    pub fail_fast: bool,
}

impl Flight<'_> {
    /// Flies what has not been flown; gives whether it stopped at a run that failed.
    pub fn fly(&self, stop: Arc<AtomicBool>) -> Result<bool, SweepError> {
        let Flight { manifest, folder, shard, keep_folders, .. } = *self;
        let (mut runs, mut took_s) = (Vec::new(), Vec::new());
        for run in &self.runs {
            match folder.run(manifest, run) {
                // A run that failed is no result: it may have been a full disk.
                Ok(record) if record.as_ref().is_none_or(|record| record.failed.is_some()) => {
                    runs.push(*run);
                }
                Ok(record) => took_s.extend(record.and_then(|record| record.number("wall_s"))),
                Err(bad) => {
                    if !self.quiet {
                        tell!("{bad}; it is flown again");
                    }
                    runs.push(*run);
                }
            }
        }
        let hangar = Hangar { manifest, folder, shard, keep_folders, stop };
        let pace = Pace::new(self.jobs, runs.len(), took_s);
        let mut bar = Bar::new(self.runs.len(), self.runs.len() - runs.len(), pace, self.quiet);
        let mut failed_fast = false;
        let watch = |event: Event<'_>| {
            match event {
                Event::Started(run) => bar.start(run),
                Event::Ended(run, record) => {
                    let values = manifest.points[run.point].describe(&manifest.vary);
                    bar.end(run, &format!("{values}, seed {}", run.seed), record);
                    failed_fast |= is_bad(record) && self.fail_fast;
                }
            }
            !failed_fast
        };
        let result = work(&hangar, &runs, self.jobs, watch);
        bar.clear();
        folder.clear_partial(shard)?;
        result.map(|()| failed_fast)
    }

    /// Whether some of its runs are not there.
    pub fn lacks_runs(&self, results: &Results) -> bool {
        let mine: BTreeSet<&Run> = self.runs.iter().collect();
        results.runs.iter().any(|(run, record)| record.is_none() && mine.contains(run))
    }

    /// Says how to go on after Ctrl-C: with `again`, and in which other ways.
    pub fn interrupted(&self, again: &str, or: &str) -> u8 {
        let root = quoted(&self.folder.root().display().to_string());
        tell!("ended early; go on with\n  {again} --resume --out {root}{or}");
        INTERRUPTED
    }
}

fn is_bad(record: &RunRecord) -> bool {
    record.failed.is_some() || record.violations() > 0
}

/// The most runs that are missing, or not what they should be, that are named one by one.
const MAX_NAMED: usize = 50;

/// Says on stderr which runs are missing or not what they should be.
pub fn complain(results: &Results) {
    let mut lines: Vec<String> = results.bad.iter().map(ToString::to_string).collect();
    for (run, record) in &results.runs {
        let name = results.manifest.run_name(run);
        match record {
            None => lines.push(format!("missing: {name}\n  = fly it with --resume")),
            Some(record) if is_bad(record) => {
                let (what, replay) = (record.describe(), &record.replay);
                lines.push(format!("{name}: {what}\n  = fly it again with `{replay}`"));
            }
            Some(_) => {}
        }
    }
    lines.iter().take(MAX_NAMED).for_each(|line| tell!("{line}"));
    if let Some(more @ 1..) = lines.len().checked_sub(MAX_NAMED) {
        tell!("and {more} more: see report.html and sweep.csv");
    }
}

/// The number of jobs asked for, or one per core.
pub fn jobs(asked: Option<u16>) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    asked.map_or_else(cores, usize::from)
}

/// The exit code: violations count most.
pub fn code(counts: &Counts) -> u8 {
    match counts {
        Counts { violated: 1.., .. } => VIOLATED,
        Counts { failed: 1.., .. } => FAILED,
        _ => DONE,
    }
}

/// Tells bad input apart from what failed.
pub fn judge(result: anyhow::Result<u8>) -> anyhow::Result<u8> {
    match result.map_err(|error| error.downcast::<SweepError>()) {
        Ok(code) => Ok(code),
        Err(Ok(error @ (SweepError::Mistakes(_) | SweepError::Refused(_)))) => {
            tell!("{error}");
            Ok(BAD_INPUT)
        }
        Err(Ok(error @ SweepError::Unreadable { .. })) => {
            tell!("error: {error}");
            Ok(BAD_INPUT)
        }
        Err(Ok(error)) => Err(error.into()),
        Err(Err(error)) => Err(error),
    }
}
