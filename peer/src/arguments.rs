//! Command-line arguments of the processes of a fleet.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::wire::session::WireArguments;

/// `csat agent`.
#[derive(Debug, Clone, Args)]
pub struct AgentArguments {
    /// Which agent: the UAVs from 0, then the stations
    #[arg(long, value_name = "N")]
    pub id: u16,
    /// The run to take part in, a mission's seed [default: the one that answers]
    #[arg(long, value_name = "N")]
    pub run: Option<u64>,
    /// How long to wait for the world and for others before giving up, seconds
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = patience)]
    pub patience: Duration,
    /// Append the log to a file, too
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Where to listen and connect.
    #[command(flatten)]
    pub wire: WireArguments,
    /// End when standard input ends, as it does when the parent process ends
    #[arg(long, hide = true)]
    pub end_with_parent: bool,
}

/// How time passes.
#[derive(Debug, Clone, Copy, Args)]
pub struct PaceArguments {
    /// Pass X simulated seconds in a second, and wait for no process [default: all processes wait for each
    /// other]
    #[arg(long, value_name = "X", value_parser = speed)]
    pub realtime: Option<f64>,
    /// How long to wait for processes before giving up, seconds
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = patience)]
    pub patience: Duration,
}

/// Parses a speed of time: finite and positive.
///
/// # Errors
/// When it is not.
pub fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if speed > 0.0 && speed.is_finite() => Ok(speed),
        _ => Err("expected a positive number, such as 1".to_owned()),
    }
}

fn patience(text: &str) -> Result<Duration, String> {
    match text.parse::<u64>() {
        Ok(seconds @ 1..=86_400) => Ok(Duration::from_secs(seconds)),
        _ => Err("expected whole seconds from 1 to 86400".to_owned()),
    }
}
