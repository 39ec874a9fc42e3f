//! `csat compare A B`: two runs, two sweeps or two reproductions side by side.
//!
//! | module | what it does |
//! |---|---|
//! | `read` | what is in a folder |
//! | `sides` | two of a kind: their scenarios, programs, digests and numbers |
//! | `text` | for people |

mod read;
mod sides;
#[cfg(test)]
mod tests;
mod text;

use std::path::Path;

use serde::Serialize;

use crate::scenario::differences::Difference;
use crate::sweep::SweepError;

/// What two folders have in common and what not; `a` is the first one, and differences are b less a.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// What both are.
    pub kind: Kind,
    /// The first folder.
    pub a: String,
    /// The second folder.
    pub b: String,
    /// The programs that flew the first one.
    pub builds_a: Vec<String>,
    /// The programs that flew the second one.
    pub builds_b: Vec<String>,
    /// Keys of the scenarios that differ, but for those that vary in a sweep.
    pub scenario: Vec<Difference>,
    /// The runs that both have, by whether they are the same to the last bit; `None` where there are no
    /// missions.
    pub digests: Option<Digests>,
    /// What there is to say besides, such as runs that are missing.
    pub notes: Vec<String>,
    /// What is compared, point by point of a sweep, table by table of a reproduction without missions.
    pub parts: Vec<Part>,
}

/// Kinds of folders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One mission.
    Run,
    /// Many: of `csat sweep`, or of `csat reproduce`.
    Sweep,
    /// Tables of a reproduction without missions.
    Tables,
}

/// Runs by whether their digests are equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Digests {
    /// The same to the last bit.
    pub equal: usize,
    /// Not so.
    pub different: usize,
}

/// Numbers that belong together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// The values of a point or the title of a table; empty for a run.
    pub name: String,
    /// The numbers that both have or only one.
    pub numbers: Vec<Number>,
}

/// A number side by side.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// Its dotted name in the summary, or row and column of a table.
    pub key: String,
    /// The mean over the runs of the first folder that have it.
    pub a: Option<f64>,
    /// The same of the second one.
    pub b: Option<f64>,
    /// Runs with the same seed that both have (one for two runs, whatever their seeds).
    pub n: usize,
    /// The mean of their differences.
    pub difference: Option<f64>,
    /// Half the width of the 95 % confidence interval of that mean, by Student's t.
    pub ci95_half_width: Option<f64>,
    /// How many of the differences are negative.
    pub lower: usize,
    /// How many of them are positive.
    pub higher: usize,
}

/// Compares two folders.
///
/// # Errors
/// When one is no run, sweep or reproduction, they are of different kinds or have nothing in common.
pub fn compare(a: &Path, b: &Path) -> Result<Comparison, SweepError> {
    let [first, second] = [read::read(a)?, read::read(b)?];
    let names = [a, b].map(|path| path.display().to_string());
    sides::compare(names, &first, &second)
}
