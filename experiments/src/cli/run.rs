//! Which scenario to fly, and how to write it down.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use csat_peer::arguments::speed;

use crate::scenario::shipped;

/// Which scenario.
#[derive(Debug, Clone, Args)]
pub struct ScenarioArguments {
    /// A shipped scenario or a TOML file.
    #[arg(help = shipped::scenario_help(), value_hint = ValueHint::FilePath)]
    pub scenario: Option<String>,
    /// Change one value, such as agents.count=6; may be repeated, later ones win
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// What every random stream of the mission is derived from
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
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
    /// Print the summary, with the run folder as `folder`, as JSON on stdout, and nothing else there
    #[arg(long)]
    pub json: bool,
    /// Threads to use; the result is the same for any number [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Write recording.mcap too, for Foxglove, Lichtblick and `csat replay`: what everybody knows
    /// every so many simulated seconds [default with --record alone: 1]
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "1", value_parser = speed)]
    pub record: Option<f64>,
}
