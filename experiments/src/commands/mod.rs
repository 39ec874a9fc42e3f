//! What the commands of `csat` do, with their exit codes.

mod common;
mod compare;
mod fleet;
mod reference;
mod replay;
mod reproduce;
mod runs;
mod sweep;
mod tools;
mod watch;

use std::path::Path;

use common::{interrupted_by_the_user, load, record, say};

use crate::cli::{RunArguments, ScenarioArguments};
use crate::flight::RunOptions;
use crate::logs::Logs;
use crate::plot::{self, PlotError, Whose};
use crate::verdict::{BAD_INPUT, DONE};
use csat_mission::words::counted;
use csat_peer::tell;

pub use compare::compare;
pub use fleet::{agent, spawn, world};
pub use reference::{completions, keys, man, scenarios};
pub use replay::replay;
pub use reproduce::reproduce;
pub use sweep::sweep;
pub use tools::{doctor, echo};
pub use watch::watch;

/// `csat check`.
pub fn check(arguments: &ScenarioArguments) -> anyhow::Result<u8> {
    let loaded = match load(arguments) {
        Ok(loaded) => loaded,
        Err(mistakes) => {
            tell!("{}", mistakes.describe());
            return Ok(BAD_INPUT);
        }
    };
    for warning in &loaded.warnings {
        tell!("{}", warning.render("warning"));
    }
    let scenario = &loaded.scenario;
    let warnings = match loaded.warnings.len() {
        0 => String::new(),
        count => format!(", {}", counted(count, "warning")),
    };
    let stations = match scenario.stations.len() {
        0 => String::new(),
        count => format!(", {}", counted(count, "station")),
    };
    say(&format!(
        "{}: no mistakes{warnings}: {}{}, {}, {}, {} s\n",
        loaded.name,
        counted(usize::from(scenario.agents.count), "UAV"),
        stations,
        counted(usize::from(scenario.targets.count), "target"),
        counted(loaded.world.obstacles().len(), "building"),
        scenario.run.duration_s
    ))?;
    if loaded.map.is_some() {
        say(&format!("{}\n", loaded.world.map().count))?;
    }
    Ok(DONE)
}

/// `csat run`.
pub fn run(arguments: &RunArguments, logs: &Logs) -> anyhow::Result<u8> {
    let options = RunOptions { interrupted: interrupted_by_the_user()? };
    record(arguments, logs, &options, |mission, flight| Ok(Some(mission.fly(flight)?)))
}

/// `csat plot`.
pub fn plot(dir: &Path, whose: Option<Whose>) -> anyhow::Result<u8> {
    let drawn = match whose {
        None => plot::redraw(dir).map(Vec::from),
        Some(whose) => plot::draw_knowledge(dir, whose).map(|path| vec![path]),
    };
    let pictures = match drawn {
        Ok(pictures) => pictures,
        Err(
            error
            @ (PlotError::Read { .. } | PlotError::Mission { .. } | PlotError::NoAgent { .. }),
        ) => {
            tell!("error: {error}");
            return Ok(BAD_INPUT);
        }
        Err(error) => return Err(error.into()),
    };
    say(&pictures.iter().map(|path| format!("{}\n", path.display())).collect::<String>())?;
    Ok(DONE)
}
