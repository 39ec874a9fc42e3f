//! The life of an own frame: awaited, measured, said, applied.

use csat_proto::time::Step;

use crate::exchange::transmitter::SentFact;
use crate::sense::Measured;

/// The newest frame of the agent. A ground station has a step in its place, which proves nothing.
#[derive(Debug, Clone, Default)]
pub(super) enum OwnFrame {
    /// No frame arrived yet.
    #[default]
    Awaited,
    /// Measured, and not told to the other agents: the mode forbids it, no fact fitted the
    /// budget, or none was worth its bytes.
    Measured { step: Step, measured: Measured },
    /// Measured and told to the other agents.
    Said { step: Step, measured: Measured, said: SentFact },
    /// Part of the agent's knowledge.
    Applied { measured: Measured },
}

impl OwnFrame {
    /// A frame of `step` that was measured, and told to the other agents by the fact `said`, if any.
    pub(super) fn new(step: Step, measured: Measured, said: Option<SentFact>) -> Self {
        match said {
            Some(said) => Self::Said { step, measured, said },
            None => Self::Measured { step, measured },
        }
    }

    /// What the frame proved.
    pub(super) fn measured(&self) -> Option<&Measured> {
        match self {
            Self::Awaited => None,
            Self::Measured { measured, .. }
            | Self::Said { measured, .. }
            | Self::Applied { measured } => Some(measured),
        }
    }

    /// The step of a frame that is not applied yet, and what the frame proved.
    pub(super) fn pending(&self) -> Option<(Step, &Measured)> {
        match self {
            Self::Awaited | Self::Applied { .. } => None,
            Self::Measured { step, measured } | Self::Said { step, measured, .. } => {
                Some((*step, measured))
            }
        }
    }

    /// The fact that told the other agents of a frame that is not applied yet.
    pub(super) fn pending_said(&self) -> Option<SentFact> {
        match self {
            Self::Said { said, .. } => Some(*said),
            Self::Awaited | Self::Measured { .. } | Self::Applied { .. } => None,
        }
    }

    /// Notes that the frame is part of the knowledge now.
    pub(super) fn set_applied(&mut self) {
        *self = match std::mem::take(self) {
            Self::Measured { measured, .. } | Self::Said { measured, .. } => {
                Self::Applied { measured }
            }
            other => other,
        };
    }
}
