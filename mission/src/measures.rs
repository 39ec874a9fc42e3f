//! What is measured of a mission: columns, known in one list.
//!
//! `metrics.csv`, the summary, schemas, live curves, plots, sweeps and reports read the list of a mission's
//! [`Column`]s. A value that is not defined is absent, never 0.

use csat_proto::camera::Pose;

/// What a value is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// One agent.
    Agent,
    /// All UAVs together: the same in all rows of a step.
    Fleet,
}

/// A number that a mission measures at each step.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Its key in files, with the unit at its end.
    pub key: &'static str,
    /// What people call it, in a word or two.
    pub name: &'static str,
    /// Its unit. `%` is a share of the ground's area where nothing else is said.
    pub unit: &'static str,
    /// What it is of.
    pub of: Of,
    /// What it is a mean over, in words; empty if it is none.
    pub over: &'static str,
    /// What it is, for the documentation.
    pub meaning: &'static str,
    /// Equation, table or figure that defines it; empty for what is csat's own.
    pub source: &'static str,
    /// Whether it counts something: files give it without decimals.
    pub is_count: bool,
    /// Whether it says yes (1) or no (0). Of the UAVs together it is what the first one says, and the summary has
    /// `true` or `false`.
    pub is_flag: bool,
    /// Whether the summary has its mean over the second half and over the UAVs, and the same at the end.
    pub in_summary: bool,
    /// Whether the summary has these of each ground station.
    pub of_stations: bool,
    /// The key of its value at the end, if the summary has that at the top.
    pub last_as: Option<&'static str>,
    /// How sweeps, reports and comparisons show it; `None` if they only list it.
    pub plot: Option<Plot>,
}

/// How sweeps, reports and comparisons show a number of a run.
#[derive(Debug, Clone, Copy)]
pub struct Plot {
    /// What people call it.
    pub title: &'static str,
    /// How it is called in a table, unit included.
    pub short: &'static str,
    /// Unit of its axis.
    pub unit: &'static str,
    /// The most it can be.
    pub top: f64,
    /// Whether less of it is better; else more is.
    pub less_is_better: bool,
    /// What there is to say under its plot.
    pub note: &'static str,
}

/// What there is to say under the plot of a mean.
pub const SECOND_HALF: &str = "Mean over the second half of the mission and over the agents.";

impl Column {
    /// A column of each agent.
    pub const fn of_agent(key: &'static str, name: &'static str, unit: &'static str) -> Self {
        Self {
            key,
            name,
            unit,
            of: Of::Agent,
            over: "",
            meaning: "",
            source: "",
            is_count: false,
            is_flag: false,
            in_summary: false,
            of_stations: false,
            last_as: None,
            plot: None,
        }
    }

    /// A column of the fleet.
    pub const fn of_fleet(key: &'static str, name: &'static str, unit: &'static str) -> Self {
        Self { of: Of::Fleet, ..Self::of_agent(key, name, unit) }
    }

    /// The same, with what it is and which equation, table or figure defines it.
    pub const fn defined(self, meaning: &'static str, source: &'static str) -> Self {
        Self { meaning, source, ..self }
    }

    /// The same, as a mean over something.
    pub const fn over(self, over: &'static str) -> Self {
        Self { over, ..self }
    }

    /// The same, as a count.
    pub const fn count(self) -> Self {
        Self { is_count: true, ..self }
    }

    /// The same, as yes or no.
    pub const fn flag(self) -> Self {
        Self { is_count: true, is_flag: true, ..self }
    }

    /// The same, with means in the summary.
    pub const fn in_summary(self) -> Self {
        Self { in_summary: true, ..self }
    }

    /// The same, with means of each ground station in the summary.
    pub const fn of_stations(self) -> Self {
        Self { of_stations: true, ..self }
    }

    /// The same, with its value at the end in the summary under this key.
    pub const fn last_as(self, key: &'static str) -> Self {
        Self { last_as: Some(key), ..self }
    }

    /// The same, shown in sweeps.
    pub const fn plotted(self, plot: Plot) -> Self {
        Self { plot: Some(plot), ..self }
    }
}

impl Plot {
    /// A mean over the second half that is better when it is smaller.
    pub const fn less(title: &'static str, short: &'static str, unit: &'static str) -> Self {
        let (top, note) = (f64::INFINITY, SECOND_HALF);
        Self { title, short, unit, top, less_is_better: true, note }
    }

    /// A mean over the second half that is better when it is greater.
    pub const fn more(title: &'static str, short: &'static str, unit: &'static str) -> Self {
        Self { less_is_better: false, ..Self::less(title, short, unit) }
    }

    /// The same, of something that cannot exceed `top`.
    pub const fn up_to(self, top: f64) -> Self {
        Self { top, ..self }
    }

    /// The same, with another note.
    pub const fn note(self, note: &'static str) -> Self {
        Self { note, ..self }
    }
}

/// An instant that a mission may reach: when a column reaches a level. `null` in the summary if never.
#[derive(Debug, Clone, Copy)]
pub struct Milestone {
    /// Its key in the summary, seconds.
    pub key: &'static str,
    /// The key of the same with the length of the mission where it was never reached: its mean is the
    /// restricted mean time, which runs that never reached it do not bias.
    pub restricted: &'static str,
    /// Of the fleet: the column.
    pub fleet: &'static str,
    /// Of a ground station: the column; `None` if stations have no such instant.
    pub station: Option<&'static str>,
    /// What the column has to reach.
    pub level: Level,
    /// In words, as in `all after 93 s`.
    pub name: &'static str,
    /// What it is, for the documentation.
    pub meaning: &'static str,
    /// Equation, table or figure that defines it.
    pub source: &'static str,
    /// How sweeps show it.
    pub plot: Plot,
}

/// What a column has to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Level {
    /// The number of targets that there are; never where there are none.
    Targets,
    /// A value.
    Value(f64),
}

/// Curves that are drawn over time in one frame.
#[derive(Debug, Clone, Copy)]
pub struct Panel {
    /// Its title in `metrics.svg`.
    pub title: &'static str,
    /// Its title on the live page, a word; `None` if it is not shown there.
    pub live: Option<&'static str>,
    /// The unit of all its curves.
    pub unit: &'static str,
    /// The least and the greatest end of its axis.
    pub axis: [f64; 2],
    /// Its curves.
    pub curves: &'static [Curve],
    /// The column that is drawn of each ground station, too, if any.
    pub of_stations: Option<&'static str>,
}

/// A curve of the means over the UAVs.
#[derive(Debug, Clone, Copy)]
pub struct Curve {
    /// The key of its column.
    pub column: &'static str,
    /// What the legend calls it; empty for a panel's only one.
    pub name: &'static str,
    /// `#rrggbb`.
    pub colour: &'static str,
    /// Whether it is to be seen under another one.
    pub is_wide: bool,
    /// A published mean over the second half and its standard deviation, to be drawn beside it.
    pub published: Option<fn() -> [f64; 2]>,
}

impl Curve {
    /// A curve.
    pub const fn new(column: &'static str, name: &'static str, colour: &'static str) -> Self {
        Self { column, name, colour, is_wide: false, published: None }
    }

    /// To be seen under another one.
    pub const fn wide(self) -> Self {
        Self { is_wide: true, ..self }
    }

    /// Beside what was published.
    pub const fn beside(self, published: fn() -> [f64; 2]) -> Self {
        Self { published: Some(published), ..self }
    }
}

/// Two lists in one, made when the program is compiled.
#[derive(Debug)]
pub struct Joined<T> {
    /// The lists, and copies of what comes first in the second one.
    padded: [T; MOST_JOINED],
    len: usize,
}

/// How many elements two lists may have together.
const MOST_JOINED: usize = 64;

impl<T: Copy> Joined<T> {
    /// `first`, then `second`, which has one element at least. More than 64 elements do not compile.
    #[must_use]
    pub const fn new(first: &[T], second: &[T]) -> Self {
        let mut padded = [second[0]; MOST_JOINED];
        let len = first.len() + second.len();
        let mut index = 0;
        while index < len {
            let is_first = index < first.len();
            padded[index] = if is_first { first[index] } else { second[index - first.len()] };
            index += 1;
        }
        Self { padded, len }
    }

    /// All of both.
    pub const fn all(&self) -> &[T] {
        self.padded.split_at(self.len).0
    }
}

/// Values by the keys of columns; what is not defined is `None` or not there.
pub type Values = Vec<(&'static str, Option<f64>)>;

/// Measures a mission step by step, from what agents report and the truth.
pub trait Measures<R>: Send + Sync {
    /// Notes a UAV's report beside the truth at the step of the report: the UAV's pose and the locations of the
    /// targets by index, `world`, metres. It is called once per UAV and step, before [`Self::fleet`].
    fn observe(&mut self, _report: &R, _pose: &Pose, _targets: &[[f64; 2]]) {}

    /// Begins a step and gives its values of the fleet: `uavs` are the reports of its UAVs, `targets` the true
    /// locations by index, `world`, metres.
    fn fleet(&mut self, uavs: &[&R], targets: &[[f64; 2]]) -> Values;

    /// The values of one agent; `targets` are the true locations at the step of its report.
    fn agent(&self, report: &R, targets: &[[f64; 2]]) -> Values;
}

/// The place of a column in a list.
pub fn index_of(columns: &[Column], key: &str) -> Option<usize> {
    columns.iter().position(|column| column.key == key)
}

/// Values in the order of `columns`.
///
/// # Panics
/// In debug builds when a key is no column.
pub fn in_order(
    columns: &[Column],
    values: impl IntoIterator<Item = (&'static str, Option<f64>)>,
) -> Vec<Option<f64>> {
    let mut ordered = vec![None; columns.len()];
    for (key, value) in values {
        let index = index_of(columns, key);
        debug_assert!(index.is_some(), "`{key}` is no column of the mission");
        if let Some(index) = index {
            ordered[index] = value;
        }
    }
    ordered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_lists_are_one() {
        const BOTH: &Joined<u8> = &Joined::new(&[1, 2], &[3]);
        assert_eq!(BOTH.all(), [1, 2, 3]);
        assert_eq!(Joined::new(&[], &[3, 4]).all(), [3, 4]);
    }
}
