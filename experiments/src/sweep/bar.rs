//! What shows while a sweep flies: a bar on a terminal, a line per run elsewhere.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::record::RunRecord;

/// Progress on stderr.
#[derive(Debug)]
pub struct Bar {
    bar: ProgressBar,
    quiet: bool,
    done: usize,
    before: usize,
    total: usize,
    failed: usize,
    violated: usize,
}

impl Bar {
    /// Of `total` runs of which `before` were flown earlier; `quiet` shows nothing at all.
    pub fn new(total: usize, before: usize, quiet: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target =
            if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        // The time left is that of the runs not there yet.
        let bar = ProgressBar::with_draw_target(Some((total - before) as u64), target);
        let style = ProgressStyle::with_template("{wide_bar} {msg}  eta {eta}");
        bar.set_style(style.expect("the template is a constant"));
        let this = Self { bar, quiet, done: 0, before, total, failed: 0, violated: 0 };
        this.bar.set_message(this.describe());
        this.bar.enable_steady_tick(std::time::Duration::from_secs(1));
        this
    }

    /// Shows a run that has ended.
    pub fn run(&mut self, name: &str, record: &RunRecord) {
        self.done += 1;
        self.failed += usize::from(record.failed.is_some());
        self.violated += usize::from(record.violations() > 0);
        let is_loud = record.failed.is_some() || record.violations() > 0;
        let line = || format!("{}  {name}: {}", self.count(), record.describe());
        if self.bar.is_hidden() {
            if !self.quiet {
                eprintln!("{}", line());
            }
        } else if is_loud {
            self.bar.suspend(|| eprintln!("{}", line()));
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
