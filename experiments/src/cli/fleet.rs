//! How to fly a fleet of processes.

use std::path::PathBuf;

use clap::Args;
use csat_peer::arguments::PaceArguments;
use csat_peer::wire::session::WireArguments;

use super::run::RunArguments;

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

/// `csat world`.
#[derive(Debug, Clone, Args)]
pub struct WorldArguments {
    /// What to fly and where to write it down.
    #[command(flatten)]
    pub run: RunArguments,
    /// How time passes and how long to wait.
    #[command(flatten)]
    pub pace: PaceArguments,
    /// Where to listen and connect.
    #[command(flatten)]
    pub wire: WireArguments,
    /// End when standard input ends, as it does when the parent process ends
    #[arg(long, hide = true)]
    pub end_with_parent: bool,
    /// Agents' processes that end are started again: wait for one when none is left
    #[arg(long, hide = true)]
    pub restarts: bool,
    /// A folder with the agents' logs, to be moved into the run folder at the end
    #[arg(long, hide = true, value_name = "DIR")]
    pub logs: Option<PathBuf>,
}
