//! Why an agent's process ends before its mission does.

use csat_proto::control::HeaderError;
use csat_proto::frame_wire::PixelsError;
use csat_proto::ids::{AgentId, ChannelId};
use csat_proto::time::Step;
use csat_world::world::WorldErrors;

use crate::wire::session::WireError;

/// What ended a process from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum EndedBy {
    /// Ctrl-C or SIGTERM.
    #[error("a signal")]
    Signal,
    /// The process that spawned it is gone.
    #[error("whoever spawned it")]
    Spawner,
}

/// Why an agent's process ended before its mission.
#[derive(Debug, thiserror::Error)]
pub enum AgentError {
    /// Its session.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// Something else of Zenoh.
    #[error("Zenoh: {0}")]
    Zenoh(String),
    /// No world.
    #[error(
        "waited {limit_s} s for a world to answer on `{key}`\n{cause}\n  = expected a `csat world` or \
         `csat spawn` there; `csat doctor` tells who is"
    )]
    NoWorld {
        /// The key.
        key: String,
        /// What came of connecting, a line for each endpoint.
        cause: String,
        /// How long.
        limit_s: u64,
    },
    /// The world does not want it.
    #[error("the world refuses agent {agent}: {reason}")]
    Refused {
        /// Which agent.
        agent: AgentId,
        /// Its words.
        reason: String,
    },
    /// The world speaks another version.
    #[error("the world's welcome is not understood ({0}): use the same csat everywhere")]
    Version(String),
    /// The world's map, which the links need.
    #[error("the world's town cannot be built: {0}")]
    Town(#[from] WorldErrors),
    /// A frame.
    #[error("the world's frame of step {step} is not understood: {error}")]
    Frame {
        /// k.
        step: Step,
        /// What is wrong.
        error: PixelsError,
    },
    /// What comes with a frame.
    #[error("the world's frame cannot be believed: {0}")]
    Header(#[from] HeaderError),
    /// The world holds no token.
    #[error("waited {limit_s} s for the world's liveliness token `{key}`")]
    NoToken {
        /// The key.
        key: String,
        /// How long.
        limit_s: u64,
    },
    /// The world's scenario.
    #[error("the world's scenario is not understood: {0}")]
    Scenario(String),
    /// A message that was announced does not come.
    #[error(
        "waited {limit_s} s at step {step} for message {number} of agent {from} on radio {radio}"
    )]
    Silence {
        /// How long.
        limit_s: u64,
        /// k.
        step: Step,
        /// Whose.
        from: AgentId,
        /// Its radio.
        radio: ChannelId,
        /// Its number.
        number: u64,
    },
    /// The world's process ended.
    #[error("the world ended without a word; the mission is over for agent {0}")]
    WorldGone(AgentId),
    /// Something outside of the mission.
    #[error("ended by {0}")]
    Ended(EndedBy),
}

pub(crate) fn zenoh_error(error: zenoh::Error) -> AgentError {
    AgentError::Zenoh(error.to_string())
}
