//! Why there is nothing to watch.

use std::net::SocketAddr;
use std::path::PathBuf;

use csat_peer::wire::session::WireError;

use crate::show::read::ReadError;

/// Why there is nothing to watch.
#[derive(Debug, thiserror::Error)]
pub enum WatchError {
    /// There is no recording that can be read.
    #[error(transparent)]
    Recording(#[from] ReadError),
    /// A document is not what it should be.
    #[error("`{topic}` at {time_s} s of the recording: {reason}; expected JSON")]
    Document {
        /// Topic of the document.
        topic: String,
        /// Its simulated time, seconds.
        time_s: f64,
        /// What is wrong.
        reason: String,
    },
    /// There is no document in the recording.
    #[error("`{}`: got no document in JSON, expected those of a fleet", .0.display())]
    Empty(PathBuf),
    /// Another process has the port.
    #[error("port {} of {} is taken: expected a free one with --port", .0.port(), .0.ip())]
    PortTaken(SocketAddr),
    /// The system refuses the port.
    #[error("cannot listen on {address}: {error}; expected a free one with --port")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// Why.
        error: std::io::Error,
    },
    /// No session of Zenoh.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// Zenoh refuses.
    #[error("cannot listen to the fleet: {0}")]
    Zenoh(String),
    /// The server ended.
    #[error("the server ended: {0}")]
    Serve(std::io::Error),
}

impl WatchError {
    /// Whether the user asked for something that is not there: nothing was run.
    pub fn is_mistake(&self) -> bool {
        !matches!(self, Self::Serve(_) | Self::Zenoh(_) | Self::Recording(ReadError::Io { .. }))
    }
}
