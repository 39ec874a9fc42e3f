//! Why a fleet of processes cannot go on.

use std::fmt;

use csat_proto::time::Step;

/// Why a fleet of processes cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// Some agents' processes did not do something in time.
    #[error("waited {limit_s} s for {whom} to {what}")]
    Late {
        /// How long the world waited.
        limit_s: u64,
        /// The names of the agents.
        whom: String,
        /// What the world waited for.
        what: Awaited,
    },
    /// The user ended the mission before it began.
    #[error("ended by the user before all agents were there")]
    Interrupted,
    /// All agents' processes ended.
    #[error("no agent's process is left at step {step}; `csat spawn --restart` brings them back")]
    NoneLeft {
        /// k.
        step: Step,
    },
    /// All agents' processes ended, and none was started again in time.
    #[error("waited {limit_s} s at step {step} for an agent's process to come back")]
    NoneBack {
        /// How long the world waited.
        limit_s: u64,
        /// k.
        step: Step,
    },
}

/// What the world waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Awaited {
    /// A process for each agent.
    Join,
    /// Connections between all processes.
    Hearing,
    /// Answers to the frames of a step.
    Frames(Step),
    /// Answers to a turn of a step.
    Turn(Step, u32),
    /// Reports on a step.
    Report(Step),
    /// Reports at the end of the mission.
    FinalReport,
}

impl fmt::Display for Awaited {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Join => write!(f, "join: `csat agent --id N --connect ENDPOINT` starts one"),
            Self::Hearing => {
                write!(f, "hear all others: a process may be unable to connect to another")
            }
            Self::Frames(step) => write!(f, "look at their frames of step {step}"),
            Self::Turn(step, round) => write!(f, "finish turn {round} of step {step}"),
            Self::Report(step) => write!(f, "report on step {step}"),
            Self::FinalReport => write!(f, "show what they know"),
        }
    }
}
