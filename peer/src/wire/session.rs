//! Opening and closing a Zenoh session: the endpoints that the user gives, and no multicast.

use std::net::{TcpListener, ToSocketAddrs};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use zenoh::config::EndPoint;
use zenoh::{Session, Wait};

use super::config::{config, unsupported};
pub use super::error::{FileError, WireError, first_line};

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
    /// It listens; others connect to it.
    World,
    /// It takes part in a run as this agent: it connects to the world and listens for other agents,
    /// which learn its endpoint by gossip.
    Agent(u16),
    /// It only subscribes and asks.
    Spectator,
}

impl Role {
    /// Its name in configuration files that all peers share, such as the name of its certificate.
    pub fn peer_name(self) -> String {
        match self {
            Self::World => "world".to_owned(),
            Self::Agent(id) => format!("uav-{id}"),
            Self::Spectator => "spectator".to_owned(),
        }
    }
}

/// Opens a session.
///
/// # Errors
/// When the arguments are not valid or the session cannot listen. An endpoint to connect to that does
/// not answer is no error: Zenoh goes on trying.
pub fn open(arguments: &WireArguments, role: Role) -> Result<Session, WireError> {
    let config = config(arguments, role)?;
    let shown = |key: &str| config.get_json(key).unwrap_or_default();
    let (listen, connect) = (shown("listen/endpoints"), shown("connect/endpoints"));
    let parsed = [&listen, &connect].map(|list| endpoints(list));
    if let Some(reason) = parsed.iter().flatten().find_map(unsupported) {
        return Err(WireError::Protocol(reason));
    }
    zenoh::open(config).wait().map_err(|cause| {
        let [listens, connects] = &parsed;
        let is_local = listens.iter().all(is_local) && connects.iter().all(is_known);
        WireError::Open { listen, connect, is_local, cause }
    })
}

/// The endpoints of a list in JSON.
fn endpoints(list: &str) -> Vec<EndPoint> {
    let endpoints: Vec<String> = serde_json::from_str(list).unwrap_or_default();
    endpoints.iter().filter_map(|text| text.parse().ok()).collect()
}

/// Whether an endpoint's address is one of this computer, be its port free or not.
fn is_local(endpoint: &EndPoint) -> bool {
    use std::io::ErrorKind::{AddrInUse, PermissionDenied};
    match TcpListener::bind(endpoint.address().as_str()) {
        Ok(_) => true,
        Err(error) => matches!(error.kind(), AddrInUse | PermissionDenied),
    }
}

/// Whether an endpoint's address, or its name, can be looked up.
fn is_known(endpoint: &EndPoint) -> bool {
    endpoint.address().as_str().to_socket_addrs().is_ok()
}

/// Whether this process has begun to close its session.
static CLOSING: AtomicBool = AtomicBool::new(false);

/// Whether this process has begun to close its session: it ignores samples that still arrive.
pub fn is_closing() -> bool {
    CLOSING.load(Ordering::Relaxed)
}

/// Notes that this process begins to close its session.
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

/// Where a session with these arguments connects, as text for people.
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
    /// The same arguments with ports that others can be told: see [`with_a_port`].
    pub fn with_ports(&self) -> Self {
        let listen = self.listen.iter().map(|endpoint| with_a_port(endpoint)).collect();
        Self { listen, ..self.clone() }
    }
}

/// Replaces port 0 of an endpoint, any free port, by a port that is free now, so that others can be told
/// the endpoint. Returns any other endpoint as it is.
pub fn with_a_port(endpoint: &str) -> String {
    let free = |address: &str| TcpListener::bind(address).ok()?.local_addr().ok();
    let Some((protocol, address)) = endpoint.split_once('/').filter(|(_, a)| a.ends_with(":0"))
    else {
        return endpoint.to_owned();
    };
    free(address).map_or_else(|| endpoint.to_owned(), |free| format!("{protocol}/{free}"))
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

    #[test]
    fn the_cause_of_a_refused_endpoint_is_known() {
        let taken = TcpListener::bind("127.0.0.1:0").unwrap();
        let taken = format!("tcp/{}", taken.local_addr().unwrap());
        for (endpoint, local, known) in [
            (taken.as_str(), true, true),
            ("tcp/192.0.2.1:7447", false, true),
            ("tcp/no.such.host.invalid:7447", false, false),
        ] {
            let endpoint: EndPoint = endpoint.parse().unwrap();
            assert_eq!((is_local(&endpoint), is_known(&endpoint)), (local, known), "{endpoint}");
        }
    }
}
