//! The configuration of a Zenoh session: csat's defaults, then a file, then the user's endpoints; each
//! replaces what it names.

use std::path::Path;

use serde_json::{Map, Value, json};
use zenoh::Config;
use zenoh::config::EndPoint;

use super::error::{FileError, WireError};
use super::session::{Role, WireArguments};

/// Where a world listens and where others connect by default: Zenoh's own port.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:7447";

/// The protocols of endpoints that this build supports.
const BUILT_FOR: &[&str] = if cfg!(feature = "tls") { &["tcp", "tls"] } else { &["tcp"] };

/// The differences to Zenoh's defaults, measured on loopback with up to 64 processes: discovery by
/// gossip, immediate reconnection, and queues that hold a burst of a whole fleet.
fn defaults() -> Value {
    let retry = json!({
        "period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 1.5,
    });
    let queue = json!({
        "size": {"data": 16},
        "congestion_control": {"drop": {"wait_before_drop": 20000}},
    });
    json!({
        "mode": "peer",
        "scouting": {"multicast": {"enabled": false}, "gossip": {"enabled": true}},
        "open": {"return_conditions": {"connect_scouted": false}},
        "connect": {"timeout_ms": -1, "exit_on_failure": false, "retry": retry},
        "transport": {"link": {"tx": {"queue": queue}}},
    })
}

/// The configuration of a session.
///
/// # Errors
/// When the file or an endpoint is not valid.
pub fn config(arguments: &WireArguments, role: Role) -> Result<Config, WireError> {
    let WireArguments { connect, listen, zenoh_config } = arguments;
    let file = zenoh_config.as_deref().map(|path| read(path, role)).transpose()?;
    let mut all = defaults();
    merge(&mut all, endpoints(arguments, role, scheme_of(file.as_ref())));
    if let Some(file) = file {
        merge(&mut all, file);
    }
    // Without the user's endpoints, which would hide a mistake in those of the file.
    let mut config = Config::from_json5(&all.to_string()).map_err(|error| WireError::File {
        path: zenoh_config.clone().unwrap_or_default(),
        cause: FileError::Config(error),
    })?;
    insert(&mut config, "connect/endpoints", connect)?;
    insert(&mut config, "listen/endpoints", listen)?;
    if role != Role::Spectator && all["mode"] == "client" {
        return Err(WireError::Mode);
    }
    Ok(config)
}

/// Replaces a list of endpoints by the user's, if there are any.
fn insert(config: &mut Config, key: &str, given: &[String]) -> Result<(), WireError> {
    for endpoint in given {
        endpoint
            .parse::<EndPoint>()
            .map_err(|error| WireError::Endpoint { endpoint: endpoint.clone(), cause: error })?;
    }
    if given.is_empty() {
        return Ok(());
    }
    config
        .insert_json5(key, &json!(given).to_string())
        .map_err(|cause| WireError::Endpoint { endpoint: given.join(", "), cause })
}

/// Where a process of this role listens and connects by default.
fn endpoints(arguments: &WireArguments, role: Role, scheme: String) -> Value {
    let default = json!([format!("{scheme}/{DEFAULT_ADDRESS}")]);
    let any_port = json!([format!("{scheme}/127.0.0.1:0")]);
    let WireArguments { connect, listen, .. } = arguments;
    let is_reached_otherwise = role != Role::World && !listen.is_empty() && connect.is_empty();
    let (connect, listen) = match role {
        Role::World => (json!([]), default),
        _ if is_reached_otherwise => (json!([]), json!([])),
        Role::Agent(_) => (default, any_port),
        Role::Spectator => (default, json!([])),
    };
    json!({"connect": {"endpoints": connect}, "listen": {"endpoints": listen}})
}

/// The protocol of default endpoints: TCP, unless the file allows only others.
fn scheme_of(file: Option<&Value>) -> String {
    let allowed = file.map(|file| &file["transport"]["link"]["protocols"]);
    let allowed = allowed.and_then(Value::as_array).cloned().unwrap_or_default();
    let mut allowed = allowed.iter().filter_map(Value::as_str);
    match allowed.clone().any(|protocol| protocol == "tcp") {
        true => "tcp".to_owned(),
        false => allowed.next().unwrap_or("tcp").to_owned(),
    }
}

/// The protocol of default endpoints.
///
/// # Errors
/// When the file is not valid.
pub fn scheme(zenoh_config: Option<&Path>) -> Result<String, WireError> {
    let file = zenoh_config.map(|path| read(path, Role::World)).transpose()?;
    Ok(scheme_of(file.as_ref()))
}

/// Reads a configuration file for a process of this role. In its strings `{peer}` stands for the name of
/// the process and `{folder}` for the folder of the file.
fn read(path: &Path, role: Role) -> Result<Value, WireError> {
    let wrong = |cause| WireError::File { path: path.to_owned(), cause };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(FileError::Read(error)))?;
    let mut file: Value =
        json5::from_str(&text).map_err(|error| wrong(FileError::Syntax(error)))?;
    if !file.is_object() {
        return Err(wrong(FileError::NoObject(file)));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new(".")).display().to_string();
    fill_in(&mut file, &role.peer_name(), &folder);
    Ok(file)
}

fn fill_in(value: &mut Value, peer: &str, folder: &str) {
    match value {
        Value::String(text) => *text = text.replace("{peer}", peer).replace("{folder}", folder),
        Value::Array(all) => all.iter_mut().for_each(|one| fill_in(one, peer, folder)),
        Value::Object(all) => all.values_mut().for_each(|one| fill_in(one, peer, folder)),
        _ => {}
    }
}

/// Replaces what `over` names; the rest of the value stays.
fn merge(value: &mut Value, over: Value) {
    match (value, over) {
        (Value::Object(under), Value::Object(over)) => merge_members(under, over),
        (value, over) => *value = over,
    }
}

fn merge_members(under: &mut Map<String, Value>, over: Map<String, Value>) {
    for (key, over) in over {
        match under.get_mut(&key) {
            Some(value) => merge(value, over),
            None => drop(under.insert(key, over)),
        }
    }
}

/// Why this build cannot use an endpoint: it does not support its protocol. `None` if it does.
pub fn unsupported(endpoint: &EndPoint) -> Option<String> {
    let protocol = endpoint.protocol();
    (!BUILT_FOR.contains(&protocol.as_str())).then(|| {
        let built_for = BUILT_FOR.join(" and ");
        format!("{endpoint}: this csat is built for {built_for} only, not for {protocol}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_file(text: &str, role: Role) -> Result<Config, WireError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("zenoh.json5");
        std::fs::write(&path, text).unwrap();
        config(&WireArguments { zenoh_config: Some(path), ..WireArguments::default() }, role)
    }

    fn get(config: &Config, key: &str) -> Value {
        let all: Value = serde_json::from_str(&config.to_string()).unwrap();
        all.pointer(&format!("/{key}")).cloned().unwrap_or_default()
    }

    #[test]
    fn roles_have_their_endpoints() {
        let default = json!([format!("tcp/{DEFAULT_ADDRESS}")]);
        for (role, connect, listen) in [
            (Role::World, json!([]), default.clone()),
            (Role::Agent(3), default.clone(), json!(["tcp/127.0.0.1:0"])),
            (Role::Spectator, default, json!([])),
        ] {
            let config = config(&WireArguments::default(), role).unwrap();
            assert_eq!(get(&config, "connect/endpoints"), connect, "{role:?}");
            assert_eq!(get(&config, "listen/endpoints"), listen, "{role:?}");
            assert_eq!(get(&config, "scouting/multicast/enabled"), json!(false));
        }
    }

    /// A file without endpoints leaves the default ones: no process listens on other interfaces.
    #[test]
    fn a_file_changes_what_it_names_and_nothing_else() {
        let plain = config(&WireArguments::default(), Role::Agent(1)).unwrap();
        let same = of_file("{}", Role::Agent(1)).unwrap();
        let queue = "{transport: {link: {tx: {queue: {size: {data: 4}}}}}}";
        let other = of_file(queue, Role::Agent(1)).unwrap();
        for key in [
            "mode",
            "connect",
            "listen",
            "scouting",
            "open",
            "transport/link/tx/queue/congestion_control",
        ] {
            assert_eq!(get(&same, key), get(&plain, key), "{key}");
            assert_eq!(get(&other, key), get(&plain, key), "{key}");
        }
        assert_eq!(get(&plain, "transport/link/tx/queue/size/data"), json!(16));
        assert_eq!(get(&other, "transport/link/tx/queue/size/data"), json!(4));
        assert_eq!(get(&plain, "connect/retry/period_max_ms"), json!(200));
        assert_eq!(get(&plain, "connect/timeout_ms"), json!(-1));
        let listens = of_file("{listen: {endpoints: ['tcp/10.0.0.7:1']}}", Role::World).unwrap();
        assert_eq!(get(&listens, "listen/endpoints"), json!(["tcp/10.0.0.7:1"]));
    }

    #[test]
    fn endpoints_of_the_user_replace_all_others() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("zenoh.json5");
        std::fs::write(&path, "{connect: {endpoints: {peer: ['tcp/10.0.0.7:1']}}}").unwrap();
        let arguments = WireArguments {
            connect: vec!["tcp/10.0.0.8:2".to_owned()],
            listen: vec!["tcp/10.0.0.9:3".to_owned()],
            zenoh_config: Some(path),
        };
        let config = config(&arguments, Role::Agent(1)).unwrap();
        assert_eq!(get(&config, "connect/endpoints"), json!(["tcp/10.0.0.8:2"]));
        assert_eq!(get(&config, "listen/endpoints"), json!(["tcp/10.0.0.9:3"]));
    }

    #[test]
    fn where_only_tls_is_allowed_all_endpoints_are_tls() {
        let text = "{transport: {link: {protocols: ['tls']}}}";
        let agent = of_file(text, Role::Agent(1)).unwrap();
        assert_eq!(get(&agent, "listen/endpoints"), json!(["tls/127.0.0.1:0"]));
        assert_eq!(get(&agent, "connect/endpoints"), json!(["tls/127.0.0.1:7447"]));
        let both = of_file("{transport: {link: {protocols: ['tls', 'tcp']}}}", Role::World);
        assert_eq!(get(&both.unwrap(), "listen/endpoints"), json!(["tcp/127.0.0.1:7447"]));
    }

    #[test]
    fn one_file_is_for_every_peer() {
        let text = "{transport: {link: {tls: {connect_certificate: '{folder}/{peer}.pem'}}}}";
        let of = |role| {
            let config = of_file(text, role).unwrap();
            let path = get(&config, "transport/link/tls/connect_certificate");
            path.as_str().unwrap().rsplit('/').next().unwrap().to_owned()
        };
        let names = [Role::World, Role::Agent(3), Role::Spectator].map(of);
        assert_eq!(names, ["world.pem", "uav-3.pem", "spectator.pem"]);
    }

    #[test]
    fn mistakes_name_what_was_expected() {
        let arguments = |connect: &str| WireArguments {
            connect: vec![connect.to_owned()],
            ..WireArguments::default()
        };
        let error = config(&arguments("here"), Role::Agent(0)).unwrap_err().to_string();
        assert!(error.contains("`here` is no Zenoh endpoint") && error.contains("tcp/"), "{error}");
        for text in ["{", "[]", "{no_such_key: 1}", "{mode: 'queen'}", ""] {
            let error = of_file(text, Role::Agent(0)).unwrap_err().to_string();
            assert!(error.contains("zenoh.json5"), "{text}: {error}");
        }
        let client = "{mode: 'client'}";
        for role in [Role::Agent(0), Role::World] {
            let error = of_file(client, role).unwrap_err().to_string();
            assert!(error.contains("expected mode: \"peer\""), "{error}");
        }
        assert!(of_file(client, Role::Spectator).is_ok());
    }
}
