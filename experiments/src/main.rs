//! The `csat` command.

mod commands;

use std::process::ExitCode;

use clap::Parser;
use csat_experiments::cli::{Cli, Command};
use csat_experiments::logs::Logs;
use csat_experiments::verdict::FAILED;

fn main() -> ExitCode {
    let cli = Cli::parse();
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
    };
    match result {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(FAILED)
        }
    }
}
