//! Why there is no picture.

use std::path::PathBuf;

use crate::run_folder::FolderError;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The plotting library refused.
    #[error("metrics.svg: {0}")]
    Draw(String),
    /// A file of the run folder is missing or cannot be read.
    #[error("cannot read `{}`: {reason}; expected the folder of a finished run", path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The run is of a mission that this program does not know.
    #[error("`{}`: `mission` is `{got}`, expected one of {known}", path.display())]
    Mission {
        /// The summary.
        path: PathBuf,
        /// Its mission.
        got: String,
        /// Those that the program knows.
        known: String,
    },
    /// The mission has no such agent.
    #[error("--agent: got {got}, expected `all` or an agent from 0 to {last}")]
    NoAgent {
        /// What was asked for.
        got: usize,
        /// The last one.
        last: usize,
    },
    /// A picture could not be written.
    #[error(transparent)]
    Write(#[from] FolderError),
}
