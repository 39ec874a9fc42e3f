//! Why an agent's process ends before its mission does.

use csat_proto::control::{HeaderError, PROTOCOL};
use csat_proto::frame_wire::PixelsError;
use csat_proto::ids::{AgentId, ChannelId, RunId};
use csat_proto::time::Step;
use csat_world::world::WorldErrors;

use crate::wire::session::WireError;

/// What ended a process from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum EndedBy {
    /// Ctrl-C or SIGTERM.
    #[error("a signal")]
    Signal,
    /// The end of its parent process.
    #[error("whoever spawned it")]
    Parent,
}

/// Why an agent's process ended before its mission.
#[derive(Debug, thiserror::Error)]
pub enum AgentError {
    /// It has no session.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// Zenoh did not do something else.
    #[error("Zenoh cannot {action}")]
    Zenoh {
        /// What it was to do.
        action: &'static str,
        /// Its answer.
        source: zenoh::Error,
    },
    /// No world answered.
    #[error(
        "waited {limit_s} s for a world to answer on `{key}`\n{cause}\n  = expected a `csat world` or \
         `csat spawn` there; `csat doctor` tells who is"
    )]
    NoWorld {
        /// The key of the query.
        key: String,
        /// What came of connecting, a line for each endpoint.
        cause: String,
        /// How long the process waited.
        limit_s: u64,
    },
    /// The world refuses the process.
    #[error("the world refuses agent {agent}: {reason}")]
    Refused {
        /// The agent.
        agent: AgentId,
        /// The world's words.
        reason: String,
    },
    /// The world is of another version.
    #[error("the world's welcome is not understood; use the same csat everywhere")]
    Welcome(#[from] WelcomeError),
    /// The town, which the links need, cannot be built.
    #[error("the world's town cannot be built")]
    Town(#[from] WorldErrors),
    /// The pixels of a frame are not valid.
    #[error("the world's frame of step {step} is not understood")]
    Frame {
        /// k.
        step: Step,
        /// What is wrong.
        source: PixelsError,
    },
    /// The header of a frame cannot be true.
    #[error("the world's frame cannot be believed")]
    Header(#[from] HeaderError),
    /// The world holds no liveliness token.
    #[error("waited {limit_s} s for the world's liveliness token `{key}`")]
    NoToken {
        /// The key of the token.
        key: String,
        /// How long the process waited.
        limit_s: u64,
    },
    /// The world's scenario is not valid.
    #[error("the world's scenario is not understood")]
    Scenario(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// This program does not know the world's mission: its name, and those that the program knows.
    #[error("the world's mission is `{0}`; this program flies {1}")]
    Mission(String, String),
    /// A message that the world announced did not come.
    #[error(
        "waited {limit_s} s at step {step} for message {number} of agent {from} on radio {radio}"
    )]
    MissingMessage {
        /// How long the process waited.
        limit_s: u64,
        /// k.
        step: Step,
        /// Its sender.
        from: AgentId,
        /// Its radio.
        radio: ChannelId,
        /// Its number.
        number: u64,
    },
    /// The world's process is gone.
    #[error("the world ended without a word; the mission is over for agent {0}")]
    WorldGone(AgentId),
    /// The user or the parent process ended this one.
    #[error("ended by {0}")]
    Ended(EndedBy),
}

/// What is wrong with a world's welcome.
#[derive(Debug, thiserror::Error)]
pub enum WelcomeError {
    /// It is of another form.
    #[error(transparent)]
    Form(#[from] serde_json::Error),
    /// It is of another version of the protocol.
    #[error("protocol {0}, expected {PROTOCOL}")]
    Protocol(u32),
    /// It is of another run than its key.
    #[error("of run {run} under `{key}`")]
    Run {
        /// The run that it names.
        run: RunId,
        /// The key of the reply.
        key: String,
    },
}

impl AgentError {
    /// Makes the error of what Zenoh was to do from its answer.
    pub(crate) fn zenoh(action: &'static str) -> impl Fn(zenoh::Error) -> Self {
        move |source| Self::Zenoh { action, source }
    }
}
