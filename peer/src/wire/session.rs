//! Opening a Zenoh session: endpoints given by the user, no multicast, no surprises.

use std::net::TcpListener;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use zenoh::config::EndPoint;
use zenoh::{Session, Wait};

use super::config::{config, unspoken};

/// How long closing a session may take.
const CLOSE_LIMIT: Duration = Duration::from_secs(2);

/// How to reach the others.
#[derive(Debug, Clone, Default, Args)]
pub struct WireArguments {
    /// A Zenoh endpoint to connect to, such as tcp/10.0.0.7:7447; may be repeated
    #[arg(long, value_name = "ENDPOINT")]
    pub connect: Vec<String>,
    /// A Zenoh endpoint to listen on, such as tcp/0.0.0.0:7447; may be repeated
    #[arg(long, value_name = "ENDPOINT")]
    pub listen: Vec<String>,
    /// A Zenoh configuration (JSON5) for all the rest, such as TLS and access control: what it does not
    /// say stays as it is
    #[arg(long, value_name = "FILE")]
    pub zenoh_config: Option<PathBuf>,
}

/// What a process is to the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Others connect to it: it listens.
    World,
    /// It takes part in a run as this UAV: it connects to the world and listens where others find it by
    /// gossip.
    Agent(u16),
    /// It looks on.
    Spectator,
}

impl Role {
    /// Its name in configurations that are for every peer, such as the names of certificates.
    pub fn peer_name(self) -> String {
        match self {
            Self::World => "world".to_owned(),
            Self::Agent(id) => format!("uav-{id}"),
            Self::Spectator => "spectator".to_owned(),
        }
    }
}

/// Why there is no session.
#[derive(Debug, thiserror::Error)]
pub enum WireError {
    /// The file of `--zenoh-config`.
    #[error("cannot use the Zenoh configuration `{}`: {reason}\n  = expected JSON5 as in Zenoh's DEFAULT_CONFIG.json5", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What Zenoh says.
        reason: String,
    },
    /// An endpoint.
    #[error("`{endpoint}` is no Zenoh endpoint: {reason}\n  = expected such as tcp/127.0.0.1:7447")]
    Endpoint {
        /// As given.
        endpoint: String,
        /// What Zenoh says.
        reason: String,
    },
    /// An endpoint of a protocol that is not built in.
    #[error(
        "{0}\n  = expected such as tcp/127.0.0.1:7447; tls/ needs a csat that is built with `--features \
         tls`, see docs/processes.md"
    )]
    Protocol(String),
    /// The world and its agents are peers.
    #[error(
        "the Zenoh configuration makes this process a client, and clients meet routers and peers only\n  \
         = expected mode: \"peer\", for the world and its agents talk to each other directly"
    )]
    Mode,
    /// The session does not open.
    #[error(
        "cannot open a Zenoh session that listens on {listen} and connects to {connect}: {reason}\n  = expected {}",
        expected(.reason)
    )]
    Open {
        /// Endpoints.
        listen: String,
        /// Endpoints.
        connect: String,
        /// What Zenoh says.
        reason: String,
    },
}

/// What would do instead of endpoints that cannot be had.
fn expected(reason: &str) -> &'static str {
    if ["lookup", "resol", "assign"].iter().any(|word| reason.contains(word)) {
        "addresses of this computer, or names that it can look up"
    } else {
        "free ports; another program, or another fleet, may listen there"
    }
}

/// Opens a session.
///
/// # Errors
/// When the arguments are no configuration or the endpoints cannot be had. That nobody answers at an
/// endpoint to connect to is no error: Zenoh goes on trying.
pub fn open(arguments: &WireArguments, role: Role) -> Result<Session, WireError> {
    let config = config(arguments, role)?;
    let shown = |key: &str| config.get_json(key).unwrap_or_default();
    let (listen, connect) = (shown("listen/endpoints"), shown("connect/endpoints"));
    for list in [&listen, &connect] {
        let endpoints: Vec<String> = serde_json::from_str(list).unwrap_or_default();
        let mut parsed = endpoints.iter().filter_map(|text| text.parse::<EndPoint>().ok());
        if let Some(reason) = parsed.find_map(|endpoint| unspoken(&endpoint)) {
            return Err(WireError::Protocol(reason));
        }
    }
    zenoh::open(config).wait().map_err(|error| WireError::Open {
        listen,
        connect,
        reason: first_line(&error.to_string()),
    })
}

/// Whether this process has stopped listening.
static CLOSING: AtomicBool = AtomicBool::new(false);

/// Whether this process has stopped listening: what still comes then is nothing to it.
pub fn is_closing() -> bool {
    CLOSING.load(Ordering::Relaxed)
}

/// This process is about to stop listening.
pub fn stop_listening() {
    CLOSING.store(true, Ordering::Relaxed);
}

/// Closes a session, or leaves it to the end of the process when that takes too long.
pub fn close(session: Session) {
    stop_listening();
    let (done, closed) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let _ = session.close().wait();
        let _ = done.send(());
    });
    let _ = closed.recv_timeout(CLOSE_LIMIT);
}

/// Where a session with these arguments connects, for people.
pub fn shown_endpoints(arguments: &WireArguments, role: Role) -> String {
    let config = config(arguments, role).ok();
    config.and_then(|config| config.get_json("connect/endpoints").ok()).unwrap_or_default()
}

/// Where a session with these arguments listens.
pub fn listened(arguments: &WireArguments, role: Role) -> Vec<String> {
    let config = config(arguments, role).ok();
    let list = config.and_then(|config| config.get_json("listen/endpoints").ok());
    list.and_then(|list| serde_json::from_str(&list).ok()).unwrap_or_default()
}

impl WireArguments {
    /// The same, with ports that can be told to others: see [`with_a_port`].
    pub fn with_ports(&self) -> Self {
        let listen = self.listen.iter().map(|endpoint| with_a_port(endpoint)).collect();
        Self { listen, ..self.clone() }
    }
}

/// An endpoint on any free port with a port that is free now, so that it can be told to others; any
/// other endpoint as it is.
pub fn with_a_port(endpoint: &str) -> String {
    let free = |address: &str| TcpListener::bind(address).ok()?.local_addr().ok();
    let Some((protocol, address)) = endpoint.split_once('/').filter(|(_, a)| a.ends_with(":0"))
    else {
        return endpoint.to_owned();
    };
    free(address).map_or_else(|| endpoint.to_owned(), |free| format!("{protocol}/{free}"))
}

/// Zenoh's errors go on with where in its source they arose.
pub fn first_line(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    line.split(" at /").next().unwrap_or(line).trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_port_can_be_told() {
        let endpoint = with_a_port("tcp/127.0.0.1:0");
        assert!(endpoint.starts_with("tcp/127.0.0.1:") && !endpoint.ends_with(":0"), "{endpoint}");
        assert_eq!(with_a_port("tcp/127.0.0.1:7447"), "tcp/127.0.0.1:7447");
        assert_eq!(listened(&WireArguments::default(), Role::World), ["tcp/127.0.0.1:7447"]);
    }
}
