//! How far the agent's newest frame has come.

use csat_proto::time::Step;

use crate::exchange::transmitter::SentFact;
use crate::sense::Measured;

/// The newest frame of the agent, from its arrival on. A ground station has a step instead, which
/// proves nothing.
#[derive(Debug, Clone, Default)]
pub(super) enum OwnFrame {
    /// No frame arrived yet.
    #[default]
    Awaited,
    /// Measured. The agent did not tell the others: it says nothing, or nothing fitted its budget.
    Measured { step: Step, measured: Measured },
    /// Measured and told to the others.
    SentFact { step: Step, measured: Measured, said: SentFact },
    /// Part of the agent's knowledge.
    Applied { measured: Measured },
}

impl OwnFrame {
    /// A frame of `step` that was measured, and told to the others if something was `said`.
    pub(super) fn new(step: Step, measured: Measured, said: Option<SentFact>) -> Self {
        match said {
            Some(said) => Self::SentFact { step, measured, said },
            None => Self::Measured { step, measured },
        }
    }

    /// What the frame proved.
    pub(super) fn measured(&self) -> Option<&Measured> {
        match self {
            Self::Awaited => None,
            Self::Measured { measured, .. }
            | Self::SentFact { measured, .. }
            | Self::Applied { measured } => Some(measured),
        }
    }

    /// The step of a frame that is not applied yet, and what the frame proved.
    pub(super) fn pending(&self) -> Option<(Step, &Measured)> {
        match self {
            Self::Awaited | Self::Applied { .. } => None,
            Self::Measured { step, measured } | Self::SentFact { step, measured, .. } => {
                Some((*step, measured))
            }
        }
    }

    /// What was told to the others of a frame that is not applied yet.
    pub(super) fn pending_said(&self) -> Option<SentFact> {
        match self {
            Self::SentFact { said, .. } => Some(*said),
            Self::Awaited | Self::Measured { .. } | Self::Applied { .. } => None,
        }
    }

    /// The frame is part of the knowledge now.
    pub(super) fn set_applied(&mut self) {
        *self = match std::mem::take(self) {
            Self::Measured { measured, .. } | Self::SentFact { measured, .. } => {
                Self::Applied { measured }
            }
            other => other,
        };
    }
}
