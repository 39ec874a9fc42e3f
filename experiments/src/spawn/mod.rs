//! `csat spawn`: a world and its agents as processes of this machine, all of which end with this one.
//!
//! Each child holds the reading end of a pipe as its standard input. When this process ends, however it
//! does, the pipe closes and the child ends itself. Each child is in a process group of its own, so that
//! Ctrl-C reaches this process only and the mission ends in order.

mod command;
mod error;
mod supervisor;

use std::io;
use std::net::TcpListener;

use crate::cli::fleet::SpawnArguments;
use crate::scenario::Loaded;
use command::Commands;
use csat_peer::wire::config::{DEFAULT_ADDRESS, scheme};
use csat_peer::wire::session;
pub use error::SpawnError;
use supervisor::{Signals, Supervisor};

/// Starts a world and all agents of a scenario and stays until all have ended. Returns the world's exit
/// code.
///
/// # Errors
/// When a process cannot be started or watched.
pub fn spawn(arguments: &SpawnArguments, loaded: &Loaded) -> Result<u8, SpawnError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.map_err(SpawnError::Watch)?.block_on(supervise(arguments, loaded))
}

async fn supervise(arguments: &SpawnArguments, loaded: &Loaded) -> Result<u8, SpawnError> {
    let endpoint = endpoint(arguments)?;
    let logs = tempfile::Builder::new().prefix("csat-logs-").tempdir().map_err(SpawnError::Logs)?;
    let seed = loaded.scenario.seed;
    let commands = Commands { arguments, endpoint, seed, logs: logs.path().to_owned() };
    // Before the children, so that none outlives a signal.
    let signals = Signals::install()?;
    let mut supervisor = Supervisor::start(commands, &loaded.scenario)?;
    let status = supervisor.run(signals).await?;
    let is_stopped = supervisor.end().await;
    Ok(supervisor::exit_code(status, is_stopped, logs))
}

/// Where the world listens: where the user says or else at Zenoh's own port, or at any other if that is
/// taken.
fn endpoint(arguments: &SpawnArguments) -> Result<String, SpawnError> {
    if let Some(endpoint) = &arguments.listen {
        return Ok(session::with_a_port(endpoint));
    }
    let scheme = scheme(arguments.zenoh_config.as_deref())?;
    Ok(format!("{scheme}/{}", free_address().map_err(SpawnError::Port)?))
}

fn free_address() -> io::Result<String> {
    if TcpListener::bind(DEFAULT_ADDRESS).is_ok() {
        return Ok(DEFAULT_ADDRESS.to_owned());
    }
    Ok(TcpListener::bind("127.0.0.1:0")?.local_addr()?.to_string())
}
