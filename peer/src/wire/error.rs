//! Why a process has no Zenoh session.

use std::fmt;
use std::io;
use std::path::PathBuf;

use serde_json::Value;

/// Why there is no session. Its text ends with a line of advice and contains that of its cause, which is
/// why it has no [`source`](std::error::Error::source).
#[derive(Debug)]
pub enum WireError {
    /// The file of `--zenoh-config` is not valid.
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: FileError,
    },
    /// An endpoint is not valid.
    Endpoint {
        /// As given.
        endpoint: String,
        /// What Zenoh answers.
        cause: zenoh::Error,
    },
    /// This build does not support the protocol of an endpoint.
    Protocol(String),
    /// The configuration makes the process a client; the world and its agents are peers.
    Mode,
    /// The session does not open.
    Open {
        /// Endpoints.
        listen: String,
        /// Endpoints.
        connect: String,
        /// Whether this computer has, or knows, the addresses of all endpoints.
        is_local: bool,
        /// What Zenoh answers.
        cause: zenoh::Error,
    },
}

/// What is wrong with a configuration file.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(io::Error),
    /// The file is not JSON5.
    #[error(transparent)]
    Syntax(json5::Error),
    /// The file is JSON5 of another form.
    #[error("`{0}` is no object")]
    NoObject(Value),
    /// Zenoh does not take the configuration.
    #[error("{}", first_line(&.0.to_string()))]
    Config(zenoh::Error),
}

impl WireError {
    /// What is wrong.
    pub fn problem(&self) -> String {
        match self {
            Self::File { path, cause } => {
                format!("cannot use the Zenoh configuration `{}`: {cause}", path.display())
            }
            Self::Endpoint { endpoint, cause } => {
                format!("`{endpoint}` is no Zenoh endpoint: {}", first_line(&cause.to_string()))
            }
            Self::Protocol(reason) => reason.clone(),
            Self::Mode => "the Zenoh configuration makes this process a client, and clients meet \
                           routers and peers only"
                .to_owned(),
            Self::Open { listen, connect, cause, .. } => format!(
                "cannot open a Zenoh session that listens on {listen} and connects to {connect}: {}",
                first_line(&cause.to_string())
            ),
        }
    }

    /// What to do.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::File { .. } => "expected JSON5 as in Zenoh's DEFAULT_CONFIG.json5",
            Self::Endpoint { .. } => "expected such as tcp/127.0.0.1:7447",
            Self::Protocol(_) => {
                "expected such as tcp/127.0.0.1:7447; tls/ needs a csat that is built with \
                 `--features tls`, see docs/processes.md"
            }
            Self::Mode => {
                "expected mode: \"peer\", for the world and its agents talk to each other directly"
            }
            Self::Open { is_local: false, .. } => {
                "expected addresses of this computer, or names that it can look up"
            }
            Self::Open { .. } => {
                "expected free ports; another program, or another fleet, may listen there"
            }
        }
    }
}

impl fmt::Display for WireError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\n  = {}", self.problem(), self.advice())
    }
}

impl std::error::Error for WireError {}

/// The first line of a Zenoh error without the place in Zenoh's source where it arose.
pub fn first_line(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    line.split(" at /").next().unwrap_or(line).trim_end_matches('.').to_owned()
}
