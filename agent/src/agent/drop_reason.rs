//! Why an agent dropped a message or an own frame.

use crate::exchange::validate::Rejection;
use crate::guidance::PlanError;

/// Why an agent dropped a message or an own frame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DropReason {
    /// A message that is not valid.
    #[error(transparent)]
    Message(#[from] Rejection),
    /// A flight plan that does not fit the schedule.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// An own frame that is not of a later step than the one before.
    #[error("frame of step {got} after that of step {last}")]
    OldFrame {
        /// Its step.
        got: u32,
        /// The step of the frame before.
        last: u32,
    },
}

impl DropReason {
    /// A short name, by which dropped messages are counted.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Message(rejection) => rejection.name(),
            Self::Plan(_) => "plan",
            Self::OldFrame { .. } => "old-frame",
        }
    }
}
