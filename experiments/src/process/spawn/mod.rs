//! `csat spawn`: a world and its agents as processes of this machine, all of which end with this one.
//!
//! Each child holds the reading end of a pipe as its standard input. When this process ends, however it
//! does, the pipe closes and the child ends itself. Each child is in a process group of its own, so that
//! Ctrl-C reaches this process only and the mission ends in order.

mod command;
mod supervisor;

use std::io;
use std::net::TcpListener;
use std::path::PathBuf;

use clap::Args;

use crate::cli::RunArguments;
use crate::scenario::Loaded;
use command::Commands;
use csat_peer::arguments::PaceArguments;
use csat_peer::wire::config::{DEFAULT_ADDRESS, scheme};
use csat_peer::wire::session::{self, WireError};
use supervisor::{Signals, Supervisor};

/// `csat spawn`.
#[derive(Debug, Clone, Args)]
pub struct SpawnArguments {
    /// What to fly and where to write it down.
    #[command(flatten)]
    pub run: RunArguments,
    /// How time passes and how long to wait.
    #[command(flatten)]
    pub pace: PaceArguments,
    /// Start an agent's process again when it ends before the mission
    #[arg(long)]
    pub restart: bool,
    /// Where the world listens [default: tcp/127.0.0.1:7447, or any free port if that is taken]
    #[arg(long, value_name = "ENDPOINT")]
    pub listen: Option<String>,
    /// A Zenoh configuration (JSON5) for all processes, such as TLS and access control
    #[arg(long, value_name = "FILE")]
    pub zenoh_config: Option<PathBuf>,
}

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
