//! What a user runs and what they get: the `csat` command around missions. One mission, from its scenario to its
//! run folder, is `csat-flight`; its modules are here under the same names.
//!
//! | module | what it does |
//! |---|---|
//! | [`cli`] | the command line |
//! | [`stats`] | means and their confidence |
//! | [`sweep`] | every combination with every seed, and the report |
//! | [`compare`] | two runs, sweeps or reproductions side by side |
//! | [`reproduce`] | the published tables and figures, ours beside theirs |
//! | [`report`] | pages with plots that need nothing but themselves |
//! | [`logs`] | what programs print while they fly |
//! | [`watch`] | a live map in the browser |
//! | [`spawn`] | starts the world and the agents as processes, and ends them all |
//! | [`tools`] | looking at a fleet from a terminal: `csat echo`, `csat doctor` |
//! | [`verdict`] | exit codes |

#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic: see `terminal`.

use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use csat_peer::tell;

use crate::cli::{Cli, Command, advice};
use crate::logs::Logs;
use crate::missions::Missions;
use crate::verdict::FAILED;

pub use csat_flight::{
    bayes, clearing, flight, metrics_file, missions, outputs, passages, plot, progress, provenance,
    published, record, rounding, run_folder, scenario, series, set_membership, show, station,
    summary, ticks, timing, truth, values, view, world,
};

pub mod cli;
mod commands;
pub mod compare;
pub mod logs;
pub mod report;
pub mod reproduce;
pub mod spawn;
pub mod stats;
pub mod sweep;
#[cfg(test)]
#[path = "../../flight/src/testing.rs"]
mod testing;
pub mod tools;
pub mod verdict;
pub mod watch;

/// The command line of a program that flies `missions`, with its exit code: `csat` itself, and programs with
/// missions of their own. The first call of a process counts.
pub fn main(missions: Missions) -> ExitCode {
    missions::install(missions);
    let cli = Cli::try_parse().unwrap_or_else(|error| {
        let arguments: Vec<String> =
            std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
        advice::advise(&Cli::command(), error, &arguments).exit()
    });
    let logs = Logs::install();
    let result = match &cli.command {
        Command::Run(arguments) => commands::run(arguments, &logs),
        Command::Spawn(arguments) => commands::spawn(arguments),
        Command::World(arguments) => commands::world(arguments, &logs),
        Command::Agent(arguments) => commands::agent(arguments, &logs),
        Command::Check(arguments) => commands::check(arguments),
        Command::Sweep(arguments) => commands::sweep(arguments),
        Command::Compare(arguments) => commands::compare(arguments),
        Command::Reproduce(arguments) => commands::reproduce(arguments),
        Command::Replay(arguments) => commands::replay(arguments),
        Command::Watch(arguments) => commands::watch(arguments),
        Command::Echo(arguments) => commands::echo(arguments),
        Command::Doctor(arguments) => commands::doctor(arguments),
        Command::Plot { dir, agent } => commands::plot(dir, *agent),
        Command::Scenarios { name } => commands::scenarios(name.as_deref()),
        Command::Keys { prefix, json } => commands::keys(prefix, *json),
        Command::Completions { shell } => commands::completions(*shell),
        Command::Man { out } => commands::man(out.as_deref()),
    };
    match result {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            tell!("error: {error:#}");
            ExitCode::from(FAILED)
        }
    }
}
