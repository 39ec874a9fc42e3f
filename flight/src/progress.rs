//! The bar that shows a mission's progress on a terminal.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use csat_mission::measures::Column;
use csat_mission::mission::Kind;

use crate::series::Point;
use csat_mission::timing::Stopwatch;

/// A bar on stderr; invisible when stderr is no terminal.
#[derive(Debug, Clone)]
pub struct Progress {
    bar: ProgressBar,
    watch: Stopwatch,
    kind: &'static Kind,
    targets: u16,
}

impl Progress {
    /// For a mission of `steps` steps; `hidden` for output that programs read.
    pub fn new(kind: &'static Kind, steps: u32, targets: u16, hidden: bool) -> Self {
        let bar = bar(u64::from(steps), style("{wide_bar} {msg}  eta {eta}"), hidden);
        Self { bar, watch: Stopwatch::start(), kind, targets }
    }

    /// Shows a step.
    pub fn step(&self, point: &Point, violations: u64) {
        if self.bar.is_hidden() {
            return;
        }
        let factor = point.time_s / self.watch.elapsed_s().max(1e-3);
        self.bar.set_message(describe(self.kind, point, factor, self.targets, violations));
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

/// The style of a constant template.
pub fn style(template: &'static str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is a constant")
}

/// A bar of `length` on stderr; invisible when it is `hidden` or stderr is no terminal.
pub fn bar(length: u64, style: ProgressStyle, hidden: bool) -> ProgressBar {
    let visible = !hidden && std::io::stderr().is_terminal();
    let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    ProgressBar::with_draw_target(Some(length), target).with_style(style)
}

fn describe(kind: &Kind, point: &Point, factor: f64, targets: u16, violations: u64) -> String {
    let word = if violations > 0 { "VIOLATIONS" } else { "violations" };
    let value = |column: &'static Column| {
        let value = point.get(kind.columns, column.key);
        let value = match (value, column.unit) {
            (None, _) => "-".to_owned(),
            (Some(value), "targets") => format!("{value}/{targets}"),
            (Some(value), unit) => format!("{value:.1} {unit}"),
        };
        format!("{} {value}  ", column.name)
    };
    let columns = kind.headline.iter().filter_map(|key| kind.column(key));
    let values: String = columns.map(value).collect();
    format!("{:.0} s ({factor:.1}x)  {values}{word} {violations}", point.time_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::missions::kind;
    use csat_mission::measures::in_order;

    #[test]
    fn violations_become_loud() {
        let kind = kind("set-membership").unwrap();
        let values = [("identified_union", Some(7.0)), ("unexplored_pct", Some(21.34))];
        let point = Point { time_s: 150.0, values: in_order(kind.columns, values) };
        let calm = "150 s (15.2x)  identified 7/8  unexplored 21.3 %  violations 0";
        assert_eq!(describe(kind, &point, 15.21, 8, 0), calm);
        assert!(describe(kind, &point, 15.21, 8, 2).ends_with(" %  VIOLATIONS 2"));
    }
}
