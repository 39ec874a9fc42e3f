//! The recipe of docs/processes.md: mutual TLS and access control, one configuration for every peer.
//!
//! What it allows is tried with peers in Python, which are other programs than csat. A fleet flies with it
//! where csat has the feature `tls`. Both take `openssl` to make certificates.

#![cfg(unix)]

mod common;

use std::path::Path;
use std::process::{Command, Stdio};

use common::fleet::endpoint;
use common::{python, scratch, skipped, text};

/// Makes certificates and the configuration for two UAVs, in `secure`; not, said loudly, without openssl.
fn make(folder: &Path) -> bool {
    if Command::new("openssl").arg("version").stdout(Stdio::null()).status().is_err() {
        skipped("there is no openssl to make certificates with");
        return false;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/secure/secure.sh");
    let output = Command::new(script).args(["secure", "2"]).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    true
}

/// What peers with the recipe's certificates hear, a line for each try.
fn peers(python: &str, folder: &Path, more: &[&str]) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/secure/peers.py");
    let endpoint = endpoint();
    let port = endpoint.rsplit(':').next().unwrap();
    let mut command = Command::new(python);
    command.arg(script).args(["secure", port]).args(more).current_dir(folder);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

#[test]
fn each_peer_says_what_is_its_own_and_nothing_else() {
    let Some(python) = python(&["zenoh"], "eclipse-zenoh==1.10.2") else { return };
    let folder = scratch();
    if !make(folder.path()) {
        return;
    }
    let said = peers(&python, folder.path(), &[]);
    let (own, of_others): (Vec<&str>, Vec<&str>) =
        said.lines().partition(|line| !line.contains(" of another "));
    let expected = [
        "clock of the world: spectator uav-0 uav-1",
        "frame of the world: spectator uav-0 world",
        "command of uav-0: spectator world",
        "message of uav-1: spectator uav-0 uav-1",
        "token of uav-0: world",
        "welcome of uav-0: welcome",
        "without a certificate: 0 peers",
        "in the clear: 0 peers",
    ];
    assert_eq!(own, expected);
    assert_eq!(of_others.len(), 20, "{said}");
    assert!(of_others.iter().all(|line| line.ends_with(": nobody")), "{said}");
    // It is access control that keeps them out.
    let said = peers(&python, folder.path(), &["unguarded"]);
    let heard = said.lines().filter(|line| line.contains(" of another "));
    assert!(heard.filter(|line| !line.ends_with(": nobody")).count() > 15, "{said}");
}

#[cfg(feature = "tls")]
mod fleet {
    use std::collections::BTreeSet;
    use std::net::SocketAddr;

    use serde_json::json;
    use zenoh::handlers::RingChannel;
    use zenoh::{Config, Session, Wait};

    use super::common::fleet::{
        agent_process, end, expect_nobody, mission, processes, signal, spawn, wait_for_flight,
    };
    use super::common::{csat, json};
    use super::*;

    /// Where a process listens.
    fn listening(pid: u32) -> Vec<SocketAddr> {
        let mut own = BTreeSet::new();
        for entry in std::fs::read_dir(format!("/proc/{pid}/fd")).into_iter().flatten().flatten() {
            let link = std::fs::read_link(entry.path()).unwrap_or_default();
            let link = link.to_string_lossy().into_owned();
            own.extend(
                link.strip_prefix("socket:[").map(|rest| rest.trim_end_matches(']').to_owned()),
            );
        }
        let mut all = Vec::new();
        for (table, digits) in [("/proc/net/tcp", 8), ("/proc/net/tcp6", 32)] {
            for line in std::fs::read_to_string(table).unwrap_or_default().lines().skip(1) {
                let words: Vec<&str> = line.split_whitespace().collect();
                // 0A is the state of a socket that listens.
                if words[3] == "0A" && own.contains(words[9]) {
                    let (address, port) = words[1].split_once(':').unwrap();
                    assert_eq!((address.len(), digits), (8, 8), "IPv4 only, on loopback: {line}");
                    let address = u32::from_str_radix(address, 16).unwrap().to_le_bytes();
                    all.push(SocketAddr::from((address, u16::from_str_radix(port, 16).unwrap())));
                }
            }
        }
        all
    }

    /// A session that is to be there within two seconds, with the certificate of `name` if it has one and no
    /// access control of its own.
    fn stranger(folder: &Path, endpoint: &str, name: Option<&str>) -> zenoh::Result<Session> {
        let mut config = Config::default();
        let mut tls = json!({"root_ca_certificate": folder.join("secure/ca.pem")});
        if let Some(name) = name {
            for role in ["listen", "connect"] {
                tls[format!("{role}_certificate")] =
                    json!(folder.join(format!("secure/{name}.pem")));
                tls[format!("{role}_private_key")] =
                    json!(folder.join(format!("secure/{name}.key")));
            }
            tls["enable_mtls"] = json!(true);
        }
        let listen = if name.is_some() { "['tls/127.0.0.1:0']" } else { "[]" };
        for (key, value) in [
            ("scouting/multicast/enabled", "false"),
            ("listen/endpoints", listen),
            ("connect/endpoints", &json!([endpoint]).to_string()),
            ("connect/timeout_ms", "2000"),
            ("connect/exit_on_failure", "true"),
            ("transport/link/tls", &tls.to_string()),
        ] {
            config.insert_json5(key, value).unwrap();
        }
        zenoh::open(config).wait()
    }

    /// The fleet flies on only when all have answered: while an agent is stopped, `then` has as much time as the
    /// world has patience.
    fn while_stopped<T>(agent: u32, then: impl FnOnce() -> T) -> T {
        signal(agent, "-STOP");
        let got = then();
        signal(agent, "-CONT");
        got
    }

    fn met(session: &Session) -> usize {
        session.info().peers_zid().wait().count()
    }

    /// Who hears everything, says it at once and as the world itself would: without access control this ends a
    /// mission, with a digest of its own.
    fn forge(session: &Session, own: &str) {
        let orders =
            session.declare_subscriber("csat/5/clock").with(RingChannel::new(1)).wait().unwrap();
        let order = orders.recv().expect("who belongs to the fleet may look on");
        let order: serde_json::Value = serde_json::from_slice(&order.payload().to_bytes()).unwrap();
        let (world, step) = (&order["world"], order["step"].as_u64().unwrap());
        let put = |key: &str, what: serde_json::Value| {
            session.put(format!("csat/5/{key}"), what.to_string()).wait().unwrap();
        };
        for _ in 0..20 {
            put("clock", json!({"world": world, "order": "end", "reason": "forged"}));
            put("**", json!({"world": world, "order": "end", "reason": "forged"}));
            for step in step..step + 40 {
                put(
                    "clock",
                    json!({"world": world, "order": "turn", "step": step, "round": 1, "now": 0,
                "said": [{"agent": 0, "incarnation": 0, "next": [4000]}]}),
                );
                for uav in ["0", "1"].into_iter().filter(|uav| *uav != own) {
                    put(&format!("uav/{uav}/frame"), json!({}));
                    put(
                        &format!("uav/{uav}/command"),
                        json!({"process": 1, "step": step, "round": 0,
                    "said": null, "due": null, "commands": []}),
                    );
                    put(&format!("link/{uav}/0"), json!("no message"));
                }
            }
        }
    }

    #[test]
    fn a_fleet_with_the_recipe_flies_as_ever_and_lets_no_stranger_speak() {
        let (folder, endpoint) = (scratch(), endpoint().replace("tcp/", "tls/"));
        if !make(folder.path()) {
            return;
        }
        let mut alone = vec!["run", "--out", "alone", "--seed", "5"];
        let mission = mission("1500");
        alone.extend(mission.iter().map(String::as_str));
        assert_eq!(csat(folder.path(), &alone).status.code(), Some(0));

        let secure = ["--seed", "5", "--zenoh-config", "secure/zenoh.json5"];
        let fleet = spawn(folder.path(), &endpoint, "1500", &secure);
        wait_for_flight(folder.path());
        let [first, second] = [0, 1].map(|id| agent_process(&endpoint, id).expect("an agent"));
        // Nothing listens in the clear, nor on another interface.
        let pids: BTreeSet<u32> = processes(&endpoint).into_iter().map(|(pid, _)| pid).collect();
        let mut count = 0;
        for pid in pids {
            for address in listening(pid) {
                assert!(address.ip().is_loopback(), "{address}");
                // Not the one that is spoken to.
                let session = while_stopped(if pid == first { second } else { first }, || {
                    stranger(folder.path(), &format!("tcp/{address}"), None)
                });
                assert!(session.is_err(), "it takes what is not encrypted: {address}");
                count += 1;
            }
        }
        assert_eq!(count, 3, "the world and two agents listen");
        // Without a certificate nobody comes in.
        while_stopped(first, || {
            if let Ok(session) = stranger(folder.path(), &endpoint, None) {
                std::thread::sleep(std::time::Duration::from_secs(1));
                assert_eq!(met(&session), 0, "it lets in a peer without a certificate");
            }
        });
        // With one, a peer may say what is its own, and nothing else.
        for (name, own) in [("spectator", ""), ("uav-1", "1")] {
            let session = while_stopped(first, || {
                let session = stranger(folder.path(), &endpoint, Some(name)).expect("it is let in");
                assert!(met(&session) > 0, "{name}");
                session
            });
            forge(&session, own);
            csat_peer::wire::session::close(session);
        }
        // Who looks on with the same configuration sees what there is to see.
        let look = ["echo", "view/0/pose", "--once", "--patience", "30", "--connect", &endpoint];
        let output =
            csat(folder.path(), &[&look[..], &["--zenoh-config", "secure/zenoh.json5"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));

        let output = end(fleet);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        let summary = |name: &str| json(&folder.path().join(name).join("summary.json"));
        assert_eq!(summary("out")["digest"], summary("alone")["digest"], "{said}");
        assert_eq!(summary("out")["refused"], json!({}), "it came as far as csat");
        expect_nobody(&endpoint);
    }
}
