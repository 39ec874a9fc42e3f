//! The command line of `csat watch`.

use std::path::PathBuf;

use clap::Args;

use csat_peer::wire::session::WireArguments;

/// What to watch and where to show it.
#[derive(Debug, Clone, Default, Args)]
#[command(after_help = HELP)]
pub struct WatchArguments {
    /// A run folder recorded with --record [default: the fleet that flies now]
    #[arg(conflicts_with_all = ["run", "connect", "listen", "zenoh_config"])]
    pub dir: Option<PathBuf>,
    /// The port of the page on this computer (127.0.0.1); 0 is any free one
    #[arg(long, value_name = "N", default_value_t = 8080)]
    pub port: u16,
    /// Which mission, by its seed, when several fly [default: the first one heard]
    #[arg(long, value_name = "N")]
    pub run: Option<u64>,
    /// How to reach the fleet.
    #[command(flatten)]
    pub wire: WireArguments,
}

const HELP: &str = "\
Open the address that is printed in a browser. Ctrl-C ends.

Examples:
  csat watch                                the fleet that flies on this computer
  csat watch --connect tcp/10.0.0.7:7447    one that flies elsewhere
  csat watch runs/city-seed1                a recorded run, with a time line
  csat watch runs/city-seed1 --port 0       on any free port

The keys of the page: space pauses and plays, the arrows step through a recording, digits choose the
UAV whose knowledge shows, F fits the map, + and - zoom.";
