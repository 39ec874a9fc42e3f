//! What an agent reports to its observers.

use std::borrow::Cow;

use csat_proto::ids::{AgentId, TargetId};
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

/// What an agent reports to its observers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// A target is known of for the first time.
    Identified {
        /// The agent's step.
        step: Step,
        /// j.
        target: TargetId,
        /// Whether another agent saw it.
        by_others: bool,
    },
    /// A target's set became empty and was restarted: an assumption failed or a
    /// message lied.
    Inconsistent {
        /// The agent's step.
        step: Step,
        /// j.
        target: TargetId,
    },
    /// No increment is known to keep clear of buildings, nor was one before: the UAV flies what keeps
    /// clear longest of where one may stand. Said when it begins.
    NoWayOut {
        /// The step of the decision.
        step: Step,
    },
    /// A message or an own frame was dropped, for a reason not yet reported of its sender.
    Rejected {
        /// The agent's step.
        step: Step,
        /// The sender; `None` for a frame, and where a message is too damaged to tell.
        from: Option<AgentId>,
        /// Short name of the reason.
        reason: Cow<'static, str>,
        /// What was wrong, with values.
        detail: String,
    },
}
