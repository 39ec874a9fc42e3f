//! The `csat` command.

#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic: see `terminal`.

mod commands;

use std::process::ExitCode;

use clap::Parser;
use csat_experiments::cli::{Cli, Command, advice};
use csat_experiments::logs::Logs;
use csat_experiments::verdict::FAILED;
use csat_peer::tell;

fn main() -> ExitCode {
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
