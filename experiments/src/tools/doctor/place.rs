//! Endpoints: what is configured, and whether a process takes connections there.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use serde_json::Value;
use zenoh::Config;
use zenoh::config::EndPoint;

use super::finding::{Finding, Level};
use csat_peer::wire::config::unsupported;

/// How long a connection may take.
const LIMIT: Duration = Duration::from_secs(1);

/// The endpoints of a configuration.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Places {
    /// Where it connects.
    pub connect: Vec<String>,
    /// Where it listens.
    pub listen: Vec<String>,
    /// What it is to Zenoh: peer, client or router.
    pub mode: String,
    /// Whether it looks for others by multicast.
    pub multicast: bool,
}

/// What came of trying.
#[derive(Debug, Default)]
pub struct Reached {
    /// One for each endpoint.
    pub findings: Vec<Finding>,
    /// There are endpoints to connect to, and no process takes connections at any of them.
    pub is_hopeless: bool,
}

impl Places {
    /// Those of a configuration.
    pub fn of(config: &Config) -> Self {
        let get = |key| config.get_json(key).ok().and_then(|text| serde_json::from_str(&text).ok());
        let mode = match get("mode") {
            Some(Value::String(mode)) => mode,
            _ => "peer".to_owned(),
        };
        let endpoints = |key| strings(&get(key).unwrap_or_default(), &mode);
        Self {
            connect: endpoints("connect/endpoints"),
            listen: endpoints("listen/endpoints"),
            // Zenoh's default is yes.
            multicast: get("scouting/multicast/enabled") != Some(Value::Bool(false)),
            mode,
        }
    }

    /// What is configured.
    pub fn configured(&self) -> Vec<Finding> {
        // What follows is for those who build Zenoh.
        let version = zenoh::GIT_VERSION.split('-').next().unwrap_or_default();
        let Self { connect, listen, mode, multicast } = self;
        let multicast = if *multicast { "on" } else { "off" };
        let text = format!(
            "Zenoh {version} as a {mode}: connects to {}, listens on {}, multicast {multicast}",
            shown(connect),
            shown(listen)
        );
        let finding = if connect.is_empty() && listen.is_empty() && !self.multicast {
            Finding::problem("config", text).advice(
                "nobody can be met that way: expected --connect or --listen, or `connect` in the \
                 Zenoh configuration",
            )
        } else if connect.is_empty() && !self.multicast {
            Finding::warning("config", text)
                .advice("this waits for others to connect: they need --connect to where it listens")
        } else {
            Finding::ok("config", text)
        };
        vec![finding]
    }

    /// Tries to connect to each endpoint.
    pub fn reach(&self) -> Reached {
        let findings: Vec<Finding> =
            self.connect.iter().map(|endpoint| try_one(endpoint)).collect();
        let is_bad = |finding: &Finding| finding.level == Level::Problem;
        Reached { is_hopeless: !findings.is_empty() && findings.iter().all(is_bad), findings }
    }
}

/// Endpoints for people.
pub fn shown(endpoints: &[String]) -> String {
    if endpoints.is_empty() { "nothing".to_owned() } else { endpoints.join(", ") }
}

/// The endpoints of a list; Zenoh also takes lists by mode, and several ways to one place.
fn strings(value: &Value, mode: &str) -> Vec<String> {
    match value {
        Value::String(text) => vec![text.clone()],
        Value::Array(all) => all.iter().flat_map(|one| strings(one, mode)).collect(),
        Value::Object(members) => {
            let inner = members.get("locators").or_else(|| members.get(mode));
            inner.map_or(Vec::new(), |inner| strings(inner, mode))
        }
        _ => Vec::new(),
    }
}

fn try_one(endpoint: &str) -> Finding {
    let parsed = match endpoint.parse::<EndPoint>() {
        Ok(parsed) => parsed,
        Err(error) => return Finding::problem("endpoint", format!("{endpoint}: {error}")),
    };
    if let Some(text) = unsupported(&parsed) {
        return Finding::problem("endpoint", text).advice("expected such as tcp/127.0.0.1:7447");
    }
    match connect(parsed.address().as_str()) {
        Ok(()) => Finding::ok("endpoint", format!("{endpoint} takes connections")),
        Err(error) => unreachable_place(endpoint, &error),
    }
}

fn connect(address: &str) -> io::Result<()> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, LIMIT) {
            Ok(_) => return Ok(()),
            Err(error) => last = error,
        }
    }
    Err(last)
}

fn unreachable_place(endpoint: &str, error: &io::Error) -> Finding {
    let (text, advice) = match error.kind() {
        io::ErrorKind::ConnectionRefused => (
            "connection refused, nobody listens there".to_owned(),
            "start `csat spawn` or `csat world` there, or name with --connect where one is: `csat \
             spawn` says it when it starts",
        ),
        io::ErrorKind::TimedOut => (
            format!("no answer within {} s", LIMIT.as_secs()),
            "check the address, and that no firewall is between; a world that listens on 127.0.0.1 \
             is not reached from other computers: expected `csat world --listen tcp/0.0.0.0:7447`",
        ),
        _ => (error.to_string(), "check the address: expected such as tcp/10.0.0.7:7447"),
    };
    Finding::problem("endpoint", format!("{endpoint}: {text}")).advice(advice)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::doctor::Level;
    use csat_peer::wire::config::config;
    use csat_peer::wire::session::{Role, WireArguments};
    use std::net::TcpListener;

    fn levels(places: &Places) -> (Level, Vec<Level>) {
        let reached = places.reach();
        (places.configured()[0].level, reached.findings.iter().map(|f| f.level).collect())
    }

    #[test]
    fn what_is_configured_is_told() {
        let places = Places::of(&config(&WireArguments::default(), Role::Spectator).unwrap());
        let finding = &places.configured()[0];
        let expected = "Zenoh v1.10.2 as a peer: connects to tcp/127.0.0.1:7447, listens on \
                        nothing, multicast off";
        assert_eq!((finding.level, finding.text.as_str()), (Level::Ok, expected));
        let listen = Places { listen: vec!["tcp/[::]:0".into()], ..Places::default() };
        assert_eq!(levels(&listen), (Level::Warning, vec![]));
        assert_eq!(levels(&Places::default()), (Level::Problem, vec![]));
        let multicast = Places { multicast: true, ..Places::default() };
        assert_eq!(levels(&multicast), (Level::Ok, vec![]));
        assert!(!multicast.reach().is_hopeless);
    }

    #[test]
    fn endpoints_may_depend_on_the_mode() {
        let mut config = Config::default();
        let endpoints = "{peer: ['tcp/a:1', {strategy: 'allOf', locators: ['tcp/b:2', 'tcp/c:3']}], router: ['tcp/d:4']}";
        config.insert_json5("connect/endpoints", endpoints).unwrap();
        let places = Places::of(&config);
        assert_eq!(places.connect, ["tcp/a:1", "tcp/b:2", "tcp/c:3"]);
        assert!(places.multicast);
    }

    #[test]
    fn endpoints_are_tried() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let there = format!("tcp/{}", listener.local_addr().unwrap());
        let gone = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let nowhere = format!("tcp/{gone}");
        for (endpoint, level, text) in [
            (there.as_str(), Level::Ok, "takes connections"),
            (&nowhere, Level::Problem, "connection refused, nobody listens there"),
            ("quic/127.0.0.1:1", Level::Problem, "only, not for quic"),
            ("tcp/no.such.host.invalid:1", Level::Problem, "no.such.host.invalid"),
            ("nonsense", Level::Problem, "nonsense: "),
        ] {
            let finding = try_one(endpoint);
            assert_eq!(finding.level, level, "{finding}");
            assert!(finding.text.contains(text), "{finding}");
        }
        let secret = try_one(&there.replace("tcp/", "tls/"));
        let expected = if cfg!(feature = "tls") { Level::Ok } else { Level::Problem };
        assert_eq!(secret.level, expected, "{secret}");
        let both = Places { connect: vec![nowhere.clone(), there], ..Places::default() };
        assert!(!both.reach().is_hopeless);
        let one = Places { connect: vec![nowhere], ..Places::default() };
        assert!(one.reach().is_hopeless);
        let late = io::Error::from(io::ErrorKind::TimedOut);
        let finding = unreachable_place("tcp/10.0.0.7:7447", &late);
        assert!(finding.to_string().contains("no answer within 1 s"), "{finding}");
    }
}
