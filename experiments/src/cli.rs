//! The command line of `csat`.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Cooperative search and tracking: a fleet of UAVs finds and follows the cars of an unknown town
/// with guaranteed sets.
#[derive(Debug, Clone, Parser)]
#[command(name = "csat", version, propagate_version = true, after_help = AFTER_HELP)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  csat run                                  fly the paper's city with seed 1
  csat run helsinki-05 --seed 7 --set agents.count=6 --set netem.radio.range_m=150
  csat check my.toml                        every mistake at once, with its line
  csat plot runs/city-seed1                 draw the pictures of a run again

Exit codes:
  0    done
  1    something failed, such as a full disk
  2    bad input: nothing was run
  3    the mission flew, and the guarantee or a separation was violated
  130  ended early by Ctrl-C: the run folder is whole up to there";

/// What to do.
#[derive(Debug, Clone, Subcommand)]
pub enum Command {
    /// Fly one mission in this process, in virtual time, as fast as it goes
    Run(RunArguments),
    /// Report every mistake of a scenario at once; flies nothing
    Check(ScenarioArguments),
    /// Draw the pictures of a run folder again, from its view.json, summary.json and metrics.csv
    Plot {
        /// The run folder
        dir: PathBuf,
    },
}

/// Which scenario.
#[derive(Debug, Clone, Args)]
pub struct ScenarioArguments {
    /// A shipped scenario (city, helsinki-05, helsinki-17) or a TOML file [default: city]
    pub scenario: Option<String>,
    /// Change one value, such as agents.count=6; may be repeated, later ones win
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// What every random stream of the mission is derived from
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,
}

/// How to run.
#[derive(Debug, Clone, Args)]
pub struct RunArguments {
    /// Which scenario.
    #[command(flatten)]
    pub scenario: ScenarioArguments,
    /// The run folder, which must be new or empty [default: runs/SCENARIO-seedN, numbered]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the summary as JSON on stdout, and nothing else there
    #[arg(long)]
    pub json: bool,
    /// Threads to use; the result is the same for any number [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}
