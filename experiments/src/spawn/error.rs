//! Why the processes of a fleet do not start or cannot be watched.

use std::io;

use csat_peer::wire::session::WireError;

/// Why the processes could not be started or watched.
#[derive(Debug, thiserror::Error)]
pub enum SpawnError {
    /// The Zenoh configuration is not valid.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// The world has no port to listen on.
    #[error("there is no free port on 127.0.0.1")]
    Port(#[source] io::Error),
    /// The agents have no folder for their logs.
    #[error("there is no temporary folder for logs")]
    Logs(#[source] io::Error),
    /// A process does not start.
    #[error("cannot start `{what}`")]
    Start {
        /// The command.
        what: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// There is no runtime, or no signals.
    #[error("cannot watch processes")]
    Watch(#[source] io::Error),
}
