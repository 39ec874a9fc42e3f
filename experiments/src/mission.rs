//! One mission in one process, in virtual time.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::record::{Outcome, RecordError, Recorder};
use crate::scenario::Loaded;

/// What the mission loop needs to know besides the scenario.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// Set when the user wants the mission to end after the current step.
    pub interrupted: Arc<AtomicBool>,
}

/// Why a mission could not be flown to its end.
#[derive(Debug, thiserror::Error)]
pub enum MissionError {
    /// It could not be written down.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// There is no mission loop yet.
    #[error("this build has no mission loop yet")]
    NotBuilt,
}

/// Flies a mission and records its steps and events.
///
/// # Errors
/// When a step or an event cannot be written down.
pub fn run(
    _loaded: Loaded,
    _options: &RunOptions,
    _recorder: &mut Recorder,
) -> Result<Outcome, MissionError> {
    Err(MissionError::NotBuilt)
}
