//! What several commands do: load a scenario, fly and record it, write to the terminal.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use serde::Serialize;

use crate::cli::{RunArguments, ScenarioArguments};
use crate::flight::RunOptions;
use crate::logs::Logs;
use crate::missions::{self, Flown, Flyable};
use crate::record::{Finished, RecordError, RecordOptions, Recorder};
use crate::run_folder::{Destination, FolderError};
use crate::scenario::{self, Loaded, Mistakes, Request};
use crate::show;
use crate::summary::Summary;
use crate::verdict::{BAD_INPUT, INTERRUPTED, verdict};
use csat_mission::words::counted;
use csat_peer::tell;
use csat_peer::terminal;

/// Loads the scenario of a command line.
pub(super) fn load(arguments: &ScenarioArguments) -> Result<Loaded, Mistakes> {
    let ScenarioArguments { scenario, sets, seed } = arguments;
    scenario::load(Request { scenario: scenario.as_deref(), sets, seed: *seed })
}

/// Loads a scenario that is to be flown. `--record 5` reads as `--record` and a scenario called 5.
pub(super) fn load_to_fly(arguments: &RunArguments) -> Result<Loaded, Mistakes> {
    let mut result = load(&arguments.scenario);
    let name = arguments.scenario.scenario.as_deref().unwrap_or_default();
    if let Err(wrong) = &mut result
        && arguments.record.is_some()
        && name.parse::<f64>().is_ok()
        && let Some(first) = wrong.mistakes.first_mut()
    {
        first.help = Some(format!("did you mean `--record={name}`?"));
    }
    result
}

/// Loads a scenario, lets `fly` fly it and writes that down. `None` from `fly` is a mission that the user
/// ended before it began.
pub(super) fn record(
    arguments: &RunArguments,
    logs: &Logs,
    options: &RunOptions,
    fly: impl FnOnce(&dyn Flyable, missions::Request<'_>) -> anyhow::Result<Option<Flown>>,
) -> anyhow::Result<u8> {
    let loaded = match load_to_fly(arguments) {
        Ok(loaded) => loaded,
        Err(mistakes) => {
            tell!("{mistakes}");
            return Ok(BAD_INPUT);
        }
    };
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global()
            .context("cannot start the threads")?;
    }
    let destination = destination(arguments.out.as_deref(), &loaded);
    let record_options = RecordOptions { destination, quiet: arguments.json };
    let mut recorder = match Recorder::create(&loaded, &record_options) {
        Ok(recorder) => recorder,
        Err(RecordError::Folder(error)) => return refuse_folder(error),
        Err(error) => return Err(error.into()),
    };
    let partial = recorder.partial_folder().to_owned();
    let log = partial.join("csat.log");
    let mut file =
        File::create(&log).with_context(|| format!("cannot create `{}`", log.display()))?;
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.render("warning")).collect();
    for warning in &warnings {
        writeln!(file, "{warning}").with_context(|| format!("cannot write `{}`", log.display()))?;
    }
    logs.attach(file);
    logs.share_terminal(recorder.progress().clone());
    warn(&warnings, "in csat.log and from `csat check`");
    let incomplete = || {
        format!(
            "the run is not complete; its pieces are in `{}` (a file still being written ends in .tmp)",
            partial.display()
        )
    };
    let mission = missions::of(&loaded.scenario).expect("it was loaded");
    let record_period_s = arguments.record;
    let flight = missions::Request { loaded, options, recorder: &mut recorder, record_period_s };
    let Some(Flown { outcome, recorded_bytes }) = fly(mission, flight).with_context(incomplete)?
    else {
        recorder.discard()?;
        return Ok(INTERRUPTED);
    };
    let finished = recorder.finish(outcome).with_context(incomplete)?;
    report(&finished, recorded_bytes, arguments.json)
}

/// Says why a run folder cannot be had: because of what the user asked for, or of the system.
pub(super) fn refuse_folder(error: FolderError) -> anyhow::Result<u8> {
    if matches!(error, FolderError::Io { .. }) {
        return Err(error.into());
    }
    tell!("error: {error}\n  = expected with --out a folder that is new or empty");
    Ok(BAD_INPUT)
}

pub(super) fn destination(out: Option<&Path>, loaded: &Loaded) -> Destination {
    match out {
        Some(out) => Destination::Named(out.to_owned()),
        None => {
            let name = format!("{}-seed{}", loaded.name, loaded.scenario.seed);
            Destination::Numbered(PathBuf::from("runs").join(name))
        }
    }
}

/// A flag that the first Ctrl-C sets; the second one ends the process at once.
pub(super) fn interrupted_by_the_user() -> anyhow::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = flag.clone();
    ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        let _ = writeln!(std::io::stderr(), "\nending after this step; Ctrl-C again ends at once");
    })
    .context("cannot listen to Ctrl-C")?;
    Ok(flag)
}

fn report(finished: &Finished, recorded_bytes: Option<u64>, json: bool) -> anyhow::Result<u8> {
    let Finished { folder, summary } = finished;
    if json {
        say(&with_folder(summary, folder)?)?;
    } else {
        let recording = recorded_bytes.map_or_else(String::new, |bytes| {
            format!("{}: {:.1} MB\n", show::FILE, bytes as f64 * 1e-6)
        });
        say(&format!("{}\n{recording}{}\n", summary.describe(), folder.display()))?;
    }
    let verdict = verdict(summary, folder);
    if let Some(alarm) = &verdict.alarm {
        tell!("{alarm}");
    }
    Ok(verdict.code)
}

/// The summary as JSON, with the run folder.
fn with_folder(summary: &Summary, folder: &Path) -> anyhow::Result<String> {
    #[derive(Serialize)]
    struct Told<'a> {
        #[serde(flatten)]
        summary: &'a Summary,
        folder: &'a Path,
    }
    Ok(serde_json::to_string_pretty(&Told { summary, folder })? + "\n")
}

/// Writes to stdout; a reader that has seen enough (`| head`) is no failure.
pub(super) fn say(text: &str) -> anyhow::Result<()> {
    terminal::say(text).context("cannot write to stdout")
}

/// How many warnings are shown before a flight.
const SHOWN_WARNINGS: usize = 10;

/// Shows what is allowed but probably not meant; of many warnings the first ones, and where all are.
pub(super) fn warn(warnings: &[String], all: &str) {
    for warning in warnings.iter().take(SHOWN_WARNINGS) {
        tell!("{}", warning.trim_end());
    }
    match warnings.len().saturating_sub(SHOWN_WARNINGS) {
        0 => {}
        more => tell!("and {}: all are in full {all}", counted(more, "more warning")),
    }
}
