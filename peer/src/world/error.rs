//! Why a fleet of processes cannot go on.

use csat_proto::time::Step;

/// Why a fleet of processes cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// Somebody did not do something in time.
    #[error("waited {limit_s} s for {whom} to {what}")]
    Late {
        /// How long.
        limit_s: u64,
        /// Their names.
        whom: String,
        /// What was waited for.
        what: String,
    },
    /// The user wants the mission to end.
    #[error("ended by the user before all agents were there")]
    Interrupted,
    /// All agents' processes ended.
    #[error("no agent's process is left at step {step}; `csat spawn --restart` brings them back")]
    Deserted {
        /// k.
        step: Step,
    },
    /// All agents' processes ended, and those that were to be started again did not come.
    #[error("waited {limit_s} s at step {step} for an agent's process to come back")]
    Abandoned {
        /// How long.
        limit_s: u64,
        /// k.
        step: Step,
    },
}
