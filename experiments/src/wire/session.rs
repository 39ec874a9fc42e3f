//! Opening a Zenoh session: endpoints given by the user, no multicast, no surprises.

use std::net::TcpListener;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use zenoh::{Config, Session, Wait};

/// Where a world listens and everybody else connects unless told otherwise: Zenoh's own port.
pub const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

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
    /// A Zenoh configuration (JSON5) for all the rest, such as TLS and access control
    #[arg(long, value_name = "FILE")]
    pub zenoh_config: Option<PathBuf>,
}

/// What a process is to the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Others connect to it: it listens.
    World,
    /// It takes part in a run: it connects to the world and listens where others find it by gossip.
    Agent,
    /// It looks on.
    Spectator,
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
    #[error("`{endpoint}` is no Zenoh endpoint: {reason}\n  = expected such as {DEFAULT_ENDPOINT}")]
    Endpoint {
        /// As given.
        endpoint: String,
        /// What Zenoh says.
        reason: String,
    },
    /// A setting of ours.
    #[error("Zenoh refuses `{key}`: {reason}")]
    Setting {
        /// The key.
        key: &'static str,
        /// What Zenoh says.
        reason: String,
    },
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
    zenoh::open(config).wait().map_err(|error| WireError::Open {
        listen,
        connect,
        reason: first_line(&error.to_string()),
    })
}

/// Closes a session, or leaves it to the end of the process when that takes too long.
pub fn close(session: Session) {
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

/// An endpoint on any free port with a port that is free now, so that it can be told to others; any
/// other endpoint as it is.
pub fn with_a_port(endpoint: &str) -> String {
    let free = |address: &str| TcpListener::bind(address).ok()?.local_addr().ok();
    let Some(address) = endpoint.strip_prefix("tcp/").filter(|a| a.ends_with(":0")) else {
        return endpoint.to_owned();
    };
    free(address).map_or_else(|| endpoint.to_owned(), |free| format!("tcp/{free}"))
}

/// The configuration of a session.
///
/// # Errors
/// When the arguments are none.
pub fn config(arguments: &WireArguments, role: Role) -> Result<Config, WireError> {
    let WireArguments { connect, listen, zenoh_config } = arguments;
    if let Some(path) = zenoh_config {
        let mut config = Config::from_file(path).map_err(|error| WireError::File {
            path: path.clone(),
            reason: first_line(&error.to_string()),
        })?;
        endpoints(&mut config, "connect/endpoints", connect)?;
        endpoints(&mut config, "listen/endpoints", listen)?;
        return Ok(config);
    }
    let mut config = Config::default();
    for (key, value) in SETTINGS {
        config
            .insert_json5(key, value)
            .map_err(|error| WireError::Setting { key, reason: first_line(&error.to_string()) })?;
    }
    let default = || vec![DEFAULT_ENDPOINT.to_owned()];
    let any_port = || vec!["tcp/127.0.0.1:0".to_owned()];
    let (default_connect, default_listen) = match role {
        Role::World => (Vec::new(), default()),
        Role::Agent => (default(), any_port()),
        Role::Spectator => (default(), Vec::new()),
    };
    let or = |given: &Vec<String>, default| if given.is_empty() { default } else { given.clone() };
    let is_reached_otherwise = role != Role::World && !listen.is_empty() && connect.is_empty();
    let connect = if is_reached_otherwise { Vec::new() } else { or(connect, default_connect) };
    set_endpoints(&mut config, "connect/endpoints", &connect)?;
    set_endpoints(&mut config, "listen/endpoints", &or(listen, default_listen))?;
    Ok(config)
}

/// What differs from Zenoh's defaults, measured on loopback with up to 64 processes: found by
/// gossip, connected again at once, and queues that hold a burst of a whole fleet.
const SETTINGS: [(&str, &str); 8] = [
    ("mode", "'peer'"),
    ("scouting/multicast/enabled", "false"),
    ("scouting/gossip/enabled", "true"),
    ("open/return_conditions/connect_scouted", "false"),
    ("connect/timeout_ms", "-1"),
    ("connect/exit_on_failure", "false"),
    ("connect/retry", "{period_init_ms: 50, period_max_ms: 200, period_increase_factor: 1.5}"),
    (
        "transport/link/tx/queue",
        "{size: {data: 16}, congestion_control: {drop: {wait_before_drop: 20000}}}",
    ),
];

fn endpoints(config: &mut Config, key: &'static str, given: &[String]) -> Result<(), WireError> {
    if given.is_empty() { Ok(()) } else { set_endpoints(config, key, given) }
}

fn set_endpoints(
    config: &mut Config,
    key: &'static str,
    endpoints: &[String],
) -> Result<(), WireError> {
    for endpoint in endpoints {
        endpoint.parse::<zenoh::config::EndPoint>().map_err(|error| WireError::Endpoint {
            endpoint: endpoint.clone(),
            reason: first_line(&error.to_string()),
        })?;
    }
    let list = serde_json::to_string(endpoints).expect("strings are JSON");
    config
        .insert_json5(key, &list)
        .map_err(|error| WireError::Setting { key, reason: first_line(&error.to_string()) })
}

/// Zenoh's errors go on with where in its source they arose.
pub(crate) fn first_line(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    line.split(" at /").next().unwrap_or(line).trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scratch;

    fn endpoints_of(config: &Config, key: &str) -> Vec<String> {
        serde_json::from_str(&config.get_json(key).unwrap()).unwrap()
    }

    #[test]
    fn roles_have_their_endpoints() {
        for (role, connect, listen) in [
            (Role::World, vec![], vec![DEFAULT_ENDPOINT]),
            (Role::Agent, vec![DEFAULT_ENDPOINT], vec!["tcp/127.0.0.1:0"]),
            (Role::Spectator, vec![DEFAULT_ENDPOINT], vec![]),
        ] {
            let config = config(&WireArguments::default(), role).unwrap();
            assert_eq!(endpoints_of(&config, "connect/endpoints"), connect, "{role:?}");
            assert_eq!(endpoints_of(&config, "listen/endpoints"), listen, "{role:?}");
            assert_eq!(config.get_json("scouting/multicast/enabled").unwrap(), "false");
        }
    }

    #[test]
    fn a_free_port_can_be_told() {
        let endpoint = with_a_port("tcp/127.0.0.1:0");
        assert!(endpoint.starts_with("tcp/127.0.0.1:") && !endpoint.ends_with(":0"), "{endpoint}");
        assert_eq!(with_a_port("tcp/127.0.0.1:7447"), "tcp/127.0.0.1:7447");
        assert_eq!(listened(&WireArguments::default(), Role::World), [DEFAULT_ENDPOINT]);
    }

    #[test]
    fn mistakes_name_what_was_expected() {
        let arguments = |connect: &str| WireArguments {
            connect: vec![connect.to_owned()],
            ..WireArguments::default()
        };
        let error = config(&arguments("here"), Role::Agent).unwrap_err().to_string();
        assert!(error.contains("`here` is no Zenoh endpoint") && error.contains("tcp/"), "{error}");
        let folder = scratch("wire");
        let path = folder.join("zenoh.json5");
        for text in ["{", "{no_such_key: 1}"] {
            std::fs::write(&path, text).unwrap();
            let arguments =
                WireArguments { zenoh_config: Some(path.clone()), ..WireArguments::default() };
            let error = config(&arguments, Role::Agent).unwrap_err().to_string();
            assert!(error.contains("zenoh.json5"), "{error}");
        }
    }
}
