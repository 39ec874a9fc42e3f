//! `csat sweep`: every combination of values with every seed, and what comes of it.
//!
//! A sweep is a folder. `sweep.json`, the [`manifest`], says what belongs to it; `runs/` has one file
//! per finished mission and nothing of unfinished ones, so to resume is to fly what has no file, and
//! to merge is to read what has one. A mission is known by its scenario and seed, not by its place in a
//! sweep, so a sweep may grow. Everything drawn and tabled is a function of these files alone
//! and has no clock in it: one process or many, stopped or not, give the same bytes.
//!
//! | module | what it does |
//! |---|---|
//! | [`vary`], [`seeds`] | the command line's small languages |
//! | [`plan`] | points and runs |
//! | [`check`] | every mistake of every combination, before anything flies |
//! | [`manifest`] | `sweep.json` |
//! | [`folder`] | where the files are |
//! | [`take`], `lock` | which process flies what, so that no two fly the same |
//! | [`record`] | the file of one run |
//! | [`growth`] | more seeds, values and keys: one sweep out of two |
//! | [`fly`], [`work`] | one mission, many missions |
//! | [`bar`], [`pace`] | what shows meanwhile, and the time left |
//! | [`results`], [`metric`] | all runs, and which of their numbers count most |
//! | [`pairs`] | differences within a seed |
//! | [`table`] | `sweep.csv`, `sweep_means.csv` and `sweep_pairs.csv` |
//! | [`report`] | `report.html` |
//! | [`merge`] | from run files to those |

pub mod bar;
pub mod check;
pub mod fly;
pub mod folder;
pub mod growth;
mod lock;
pub mod manifest;
pub mod merge;
pub mod metric;
pub mod pace;
pub mod pairs;
pub mod plan;
pub mod record;
pub mod report;
pub mod results;
pub mod seeds;
pub mod table;
pub mod take;
pub mod vary;
pub mod work;

use crate::run_folder::FolderError;
use crate::scenario::Mistakes;

/// Why a sweep ended without its result.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Bad input: nothing was run.
    #[error(transparent)]
    Mistakes(#[from] Mistakes),
    /// Bad input of another kind: nothing was run.
    #[error("{0}")]
    Refused(String),
    /// A file or folder of the sweep.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A file of the sweep that is not what it should be.
    #[error("`{}` is not {expected}: {reason}", path.display())]
    Unreadable {
        /// Which file.
        path: std::path::PathBuf,
        /// What it should be.
        expected: &'static str,
        /// Why it is not.
        reason: String,
    },
    /// The threads did not start.
    #[error("cannot start {jobs} threads: {reason}")]
    Threads {
        /// How many.
        jobs: usize,
        /// What the system said.
        reason: String,
    },
}

/// A path of a file or folder with the system's refusal.
pub(crate) fn refused_by_system(
    what: &'static str,
    path: &std::path::Path,
    error: std::io::Error,
) -> SweepError {
    FolderError::Io { what, path: path.to_owned(), error }.into()
}
