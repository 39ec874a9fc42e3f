//! What shows while a sweep flies: a line for each run that has ended, and on a terminal a bar below with
//! the time left.

use std::sync::{Arc, Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressState};

use super::pace::Pace;
use super::plan::Run;
use super::record::RunRecord;
use crate::progress;
use csat_peer::tell;

/// Progress on stderr.
#[derive(Debug)]
pub struct Bar {
    bar: ProgressBar,
    pace: Arc<Mutex<Pace>>,
    quiet: bool,
    done: usize,
    before: usize,
    total: usize,
    failed: usize,
    violated: usize,
}

impl Bar {
    /// Of `total` runs of which `before` were flown earlier; `quiet` shows nothing at all.
    pub fn new(total: usize, before: usize, pace: Pace, quiet: bool) -> Self {
        let pace = Arc::new(Mutex::new(pace));
        let shared = pace.clone();
        let left = move |_: &ProgressState, text: &mut dyn std::fmt::Write| {
            let pace = shared.lock().unwrap_or_else(PoisonError::into_inner);
            // A bar has no way to say that it could not be written.
            let _ = text.write_str(&pace.left());
        };
        let style = progress::style("{wide_bar} {msg}  left {left}").with_key("left", left);
        let bar = progress::bar((total - before) as u64, style, quiet);
        let this = Self { bar, pace, quiet, done: 0, before, total, failed: 0, violated: 0 };
        this.bar.set_message(this.describe());
        this.bar.enable_steady_tick(std::time::Duration::from_secs(1));
        this
    }

    fn pace(&self) -> std::sync::MutexGuard<'_, Pace> {
        self.pace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A run takes off.
    pub fn start(&self, run: &Run) {
        self.pace().start(run);
    }

    /// Shows a run that has ended.
    pub fn end(&mut self, run: &Run, name: &str, record: &RunRecord) {
        self.pace().end(run, record.failed.is_none());
        self.done += 1;
        self.failed += usize::from(record.failed.is_some());
        self.violated += usize::from(record.violations() > 0);
        if !self.quiet {
            let line = format!("{}  {name}: {}", self.count(), record.describe());
            self.bar.suspend(|| tell!("{line}"));
        }
        self.bar.set_message(self.describe());
        self.bar.inc(1);
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    fn count(&self) -> String {
        format!("{}/{}", self.before + self.done, self.total)
    }

    fn describe(&self) -> String {
        let count = self.count();
        let part =
            |n: usize, what: &str| if n == 0 { String::new() } else { format!("  {what} {n}") };
        format!(
            "{count} runs{}{}",
            part(self.failed, "FAILED"),
            part(self.violated, "WITH VIOLATIONS")
        )
    }
}
