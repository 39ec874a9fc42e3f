//! What a user runs and what they get: the `csat` command around a mission.
//!
//! | module | what it does |
//! |---|---|
//! | [`scenario`] | reads scenarios and reports every mistake at once |
//! | [`cli`] | the command line |
//! | [`set_membership`] | the set-membership mission |
//! | [`node`] | one agent and what surrounds it |
//! | [`flight`] | flies, measures and records a mission |
//! | [`passages`] | what the links did, written down |
//! | [`missions`] | the kinds of missions that it flies |
//! | [`metrics_file`] | `metrics.csv` |
//! | [`values`] | numbers by key |
//! | [`series`] | those over time, averaged over agents and over the second half |
//! | [`summary`] | a mission in numbers |
//! | [`station`] | what a ground station knew, in numbers |
//! | [`sweep`] | every combination with every seed, and the report |
//! | [`compare`] | two runs, sweeps or reproductions side by side |
//! | [`reproduce`] | the published tables and figures, ours beside theirs |
//! | [`published`] | the published numbers |
//! | [`report`] | pages with plots that need nothing but themselves |
//! | [`record`] | writes a run down while it flies |
//! | [`show`] | what people get to see: documents, recordings, replays |
//! | [`run_folder`] | a folder that is whole or not there |
//! | [`outputs`] | what the columns and fields of its files mean |
//! | [`provenance`] | where a run comes from |
//! | [`view`] | the end of a mission, to be drawn |
//! | [`rounding`] | sets and outlines to the millimetre, and valid polygons still |
//! | [`plot`] | `map.svg` and `metrics.svg` |
//! | [`progress`], [`logs`] | what shows while it flies |
//! | [`watch`] | a live map in the browser |
//! | [`process`] | a fleet of processes: world, agents, and what spawns them |
//! | [`tools`] | looking at a fleet from a terminal: `csat echo`, `csat doctor` |
//! | [`verdict`] | exit codes |
//! | [`timing`] | what stages took |

#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic: see `terminal`.

use std::process::ExitCode;

use clap::Parser;
use csat_peer::tell;

use crate::cli::{Cli, Command, advice};
use crate::logs::Logs;
use crate::missions::Missions;
use crate::verdict::FAILED;

pub mod cli;
mod commands;
pub mod compare;
pub mod flight;
pub mod logs;
pub mod metrics_file;
pub mod missions;
pub mod outputs;
pub mod passages;
pub mod plot;
pub mod process;
pub mod progress;
pub mod provenance;
pub mod published;
pub mod record;
pub mod report;
pub mod reproduce;
pub mod rounding;
pub mod run_folder;
pub mod scenario;
pub mod series;
pub mod set_membership;
pub mod show;
pub mod station;
pub mod summary;
pub mod sweep;
#[cfg(test)]
mod testing;
pub mod timing;
pub mod tools;
pub mod values;
pub mod verdict;
pub mod view;
pub mod watch;

#[cfg(test)]
mod documents_tests;
#[cfg(test)]
mod engine_tests;

/// The command line of a program that flies `missions`, with its exit code: `csat` itself, and programs with
/// missions of their own. The first call of a process counts.
pub fn main(missions: Missions) -> ExitCode {
    missions::install(missions);
    let cli = Cli::try_parse().unwrap_or_else(|error| {
        let arguments: Vec<String> =
            std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
        advice::advise(error, &arguments).exit()
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
