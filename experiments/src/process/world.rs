//! The command line of the world's process.

use std::path::PathBuf;

use clap::Args;
use csat_peer::arguments::PaceArguments;
use csat_peer::wire::session::WireArguments;

use crate::cli::RunArguments;

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
