//! One run of a sweep: a mission whose folder is taken away when its numbers are known.

use std::any::Any;
use std::cell::RefCell;
use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde_json::Value;

use super::folder::SweepFolder;
use super::manifest::Manifest;
use super::plan::Run;
use super::record::RunRecord;
use super::seeds::Shard;
use super::{SweepError, check};
use crate::flight::RunOptions;
use crate::missions;
use crate::record::{RecordOptions, Recorder};
use crate::run_folder::Destination;

/// What the runs of one process have in common.
#[derive(Debug)]
pub struct Hangar<'a> {
    /// The sweep.
    pub manifest: &'a Manifest,
    /// Its folder.
    pub folder: &'a SweepFolder,
    /// This process's part.
    pub shard: Shard,
    /// Whether run folders stay.
    pub keep_folders: bool,
    /// Set when all missions are to end after their current step.
    pub stop: Arc<AtomicBool>,
}

thread_local! {
    /// On a thread that flies: where it panicked.
    static PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
}

impl Hangar<'_> {
    /// Flies a run and writes its file; `None` when it was ended early and leaves nothing.
    ///
    /// # Errors
    /// When the file cannot be written. A mission that fails is a result.
    pub fn fly(&self, run: &Run) -> Result<Option<RunRecord>, SweepError> {
        let name = self.manifest.run_name(run);
        let partial = self.folder.partial(self.shard, &name);
        let flown = panic::catch_unwind(AssertUnwindSafe(|| self.mission(run, &partial)));
        let outcome = match flown {
            Ok(Ok(None)) => {
                remove(&partial);
                return Ok(None);
            }
            Ok(Ok(Some(summary))) => self.keep(&partial, &name).map(|()| summary),
            Ok(Err(why)) => Err(why),
            Err(payload) => Err(panic_text(payload.as_ref())),
        };
        remove(&partial);
        let record = RunRecord::new(self.manifest, run, outcome);
        self.folder.put_run(self.manifest, run, &record.to_json())?;
        Ok(Some(record))
    }

    fn mission(&self, run: &Run, partial: &Path) -> Result<Option<Value>, String> {
        let Manifest { source, sets, points, .. } = self.manifest;
        let loaded = check::load(source, sets, &points[run.point], run.seed)
            .map_err(|mistakes| mistakes.to_string())?;
        if check::hash(&loaded) != points[run.point].scenario_hash {
            return Err("the scenario or its map changed since the sweep began".to_owned());
        }
        let destination = Destination::Named(partial.join("run"));
        let mut recorder = Recorder::create(&loaded, &RecordOptions { destination, quiet: true })
            .map_err(|e| e.to_string())?;
        let options = RunOptions { interrupted: self.stop.clone() };
        let mission = missions::of(&loaded.scenario).expect("it was loaded");
        let (options, record_period_s) = (&options, None);
        let flight =
            missions::Request { loaded, options, recorder: &mut recorder, record_period_s };
        let outcome = mission.fly(flight).map_err(|e| e.to_string())?.outcome;
        if outcome.interrupted {
            return Ok(None);
        }
        let finished = recorder.finish(outcome).map_err(|e| e.to_string())?;
        serde_json::to_value(&finished.summary).map(Some).map_err(|e| e.to_string())
    }

    /// The folder comes before the run's file, which says that all is done.
    fn keep(&self, partial: &Path, name: &str) -> Result<(), String> {
        if !self.keep_folders {
            return Ok(());
        }
        let kept = self.folder.kept(name);
        let say =
            |what: &str, e: std::io::Error| format!("cannot {what} `{}`: {e}", kept.display());
        // Left by a process that died between this line and the run's file.
        if kept.exists() {
            fs::remove_dir_all(&kept).map_err(|e| say("remove", e))?;
        }
        fs::create_dir_all(self.folder.root().join("folders")).map_err(|e| say("create", e))?;
        fs::rename(partial.join("run"), &kept).map_err(|e| say("rename to", e))
    }
}

/// What cannot be removed now is removed when the sweep ends.
fn remove(partial: &Path) {
    let _ = fs::remove_dir_all(partial);
}

/// From now on a panic on a thread that flies is told by the run's file, not on the terminal.
pub fn catch_panics() {
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let flies = std::thread::current().name().is_some_and(|name| name.starts_with(THREAD));
        if flies {
            let place = info.location().map(|l| format!("{}:{}", l.file(), l.line()));
            PANIC.set(place);
        } else {
            usual(info);
        }
    }));
}

/// What the names of threads that fly begin with.
pub const THREAD: &str = "csat-sweep";

fn panic_text(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<String>()
        .cloned()
        .or_else(|| payload.downcast_ref::<&str>().map(|s| (*s).to_owned()))
        .unwrap_or_else(|| "something without words".to_owned());
    match PANIC.take() {
        Some(place) => format!("panicked at {place}: {text}"),
        None => format!("panicked: {text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_on_a_flying_thread_is_caught_with_its_place() {
        catch_panics();
        let thread = std::thread::Builder::new().name(format!("{THREAD}-0")).spawn(|| {
            let caught = panic::catch_unwind(|| panic!("wing {} fell off", 2)).unwrap_err();
            panic_text(caught.as_ref())
        });
        let text = thread.unwrap().join().unwrap();
        assert!(text.starts_with("panicked at ") && text.contains("fly.rs:"), "{text}");
        assert!(text.ends_with(": wing 2 fell off"), "{text}");
    }
}
