//! What an agent reports to its observers.

use std::borrow::Cow;

use csat_proto::ids::{AgentId, TargetId};
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

/// What an agent reports to its observers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// A target was identified for the first time.
    Identified {
        /// The agent's step.
        step: Step,
        /// j.
        target: TargetId,
        /// Whether another agent saw it.
        by_others: bool,
    },
    /// A target's set became empty and was restarted: an assumption failed or a message was false.
    Inconsistent {
        /// The agent's step.
        step: Step,
        /// j.
        target: TargetId,
    },
    /// Another agent was proven to have said something false, or this one to have: from now on its
    /// messages, or the own frames, are ignored.
    Liar {
        /// The agent's step.
        step: Step,
        /// Who said it.
        liar: AgentId,
    },
    /// No increment is known to keep clear of buildings, and no way out is left of the decision
    /// before. The UAV flies the increment that keeps clear longest of places where a building may
    /// stand. Reported when this begins.
    NoWayOut {
        /// The step of the decision.
        step: Step,
    },
    /// A message or an own frame was dropped, for a reason that was not reported of its sender before.
    Rejected {
        /// The agent's step.
        step: Step,
        /// The sender; `None` for a frame, and for a message without a valid sender.
        from: Option<AgentId>,
        /// Short name of the reason.
        reason: Cow<'static, str>,
        /// What was wrong, with values.
        detail: String,
    },
}
