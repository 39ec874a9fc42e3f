//! The bar that shows a mission's progress on a terminal.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::series::Point;
use csat_mission::timing::Stopwatch;

/// A bar on stderr; invisible when stderr is no terminal.
#[derive(Debug, Clone)]
pub struct Progress {
    bar: ProgressBar,
    watch: Stopwatch,
    targets: u16,
}

impl Progress {
    /// For a mission of `steps` steps; `hidden` for output that programs read.
    pub fn new(steps: u32, targets: u16, hidden: bool) -> Self {
        let visible = !hidden && std::io::stderr().is_terminal();
        let target =
            if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(u64::from(steps)), target);
        let style = ProgressStyle::with_template("{wide_bar} {msg}  eta {eta}");
        bar.set_style(style.expect("the template is a constant"));
        Self { bar, watch: Stopwatch::start(), targets }
    }

    /// Shows a step.
    pub fn step(&self, point: &Point, violations: u64) {
        if self.bar.is_hidden() {
            return;
        }
        let factor = point.time_s / self.watch.elapsed_s().max(1e-3);
        self.bar.set_message(describe(point, factor, self.targets, violations));
        self.bar.inc(1);
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Lets `write` write to the terminal without tearing the bar.
    pub fn suspend<T>(&self, write: impl FnOnce() -> T) -> T {
        self.bar.suspend(write)
    }
}

fn describe(point: &Point, factor: f64, targets: u16, violations: u64) -> String {
    let word = if violations > 0 { "VIOLATIONS" } else { "violations" };
    format!(
        "{:.0} s ({factor:.1}x)  identified {}/{targets}  unexplored {:.1} %  {word} {violations}",
        point.time_s, point.identified_union, point.means.unexplored_pct
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::Means;

    #[test]
    fn violations_become_loud() {
        let point = Point {
            time_s: 150.0,
            identified_union: 7,
            means: Means { unexplored_pct: 21.34, ..Means::default() },
            ..Point::default()
        };
        let calm = "150 s (15.2x)  identified 7/8  unexplored 21.3 %  violations 0";
        assert_eq!(describe(&point, 15.21, 8, 0), calm);
        assert!(describe(&point, 15.21, 8, 2).ends_with(" %  VIOLATIONS 2"));
    }
}
