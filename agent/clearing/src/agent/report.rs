//! What an agent reports.

use csat_proto::ids::AgentId;
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

/// What an agent does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// It clears.
    Cleaner,
    /// It follows a cleaner, at its left.
    LeftWing,
    /// It follows a cleaner, at its right.
    RightWing,
    /// It follows a cleaner, behind it.
    Tail,
    /// It looks for a cleaner to follow.
    Helper,
    /// A ground station: it listens.
    Station,
}

impl Role {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cleaner => "cleaner",
            Self::LeftWing => "left-wing",
            Self::RightWing => "right-wing",
            Self::Tail => "tail",
            Self::Helper => "helper",
            Self::Station => "station",
        }
    }
}

/// What happened to an agent so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// How often it took a frontier over.
    pub splits: u32,
    /// How often another cleaner, which was not out of reach before, spared it a part of its frontier.
    pub encounters: u32,
    /// How often it joined a formation as a helper.
    pub merges: u32,
    /// How often it became a helper.
    pub calls: u32,
    /// What it said on the channel of short range, bytes.
    pub hbsr_bytes: u64,
    /// What it said on the channel of long range, bytes.
    pub lblr_bytes: u64,
}

/// What an agent reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// It has another role than before.
    Role {
        /// The step.
        step: Step,
        /// The new one.
        role: Role,
        /// Whom it follows, or from whom it took a frontier over.
        #[serde(skip_serializing_if = "Option::is_none")]
        leader: Option<AgentId>,
    },
    /// Another cleaner spared it a part of its frontier.
    Encounter {
        /// The step.
        step: Step,
        /// The other one.
        with: AgentId,
    },
    /// It cannot move on, and nobody comes; or it can again.
    Stalled {
        /// The step.
        step: Step,
        /// Whether it cannot.
        is_stalled: bool,
        /// The number of sub-frontiers that it would have to give away.
        runs: u32,
    },
    /// A cleaner is silent, or its frontier has left its image: what it guarded is lost.
    Lost {
        /// The step.
        step: Step,
        /// Which one: this one, if its own frontier has left its image.
        cleaner: AgentId,
    },
    /// It dropped a message; reported once per reason and sender.
    Rejected {
        /// The step of its last frame.
        step: Step,
        /// The sender, if it is an agent of the mission.
        from: Option<AgentId>,
        /// Why, in a word.
        reason: String,
        /// Why, with values.
        detail: String,
    },
}
