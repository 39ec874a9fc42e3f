//! The commands of a fleet of processes.

use std::fs::File;
use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::Context;

use super::common;
use crate::cli::fleet::{SpawnArguments, WorldArguments};
use crate::flight::RunOptions;
use crate::logs::Logs;
use crate::missions;
use crate::run_folder::RunFolder;
use crate::spawn::{self, SpawnError};
use crate::tools::doctor;
use crate::verdict::{BAD_INPUT, DONE, INTERRUPTED};
use crate::world::{WorldError, WorldOptions};
use csat_peer::agent::{self, AgentError, EndedBy};
use csat_peer::arguments::AgentArguments;
use csat_peer::parent_death;
use csat_peer::tell;
use csat_peer::wire::session::{self, Role};
use csat_peer::world::FleetError;

/// `csat spawn`.
pub fn spawn(arguments: &SpawnArguments) -> anyhow::Result<u8> {
    let loaded = match common::load_to_fly(&arguments.run) {
        Ok(loaded) => loaded,
        Err(mistakes) => {
            tell!("{mistakes}");
            return Ok(BAD_INPUT);
        }
    };
    // The world makes the folder. Should it be refused, no process need be started to find out.
    if let Err(error) =
        RunFolder::try_out(common::destination(arguments.run.out.as_deref(), &loaded))
    {
        return common::refuse_folder(error);
    }
    match spawn::spawn(arguments, &loaded) {
        Err(SpawnError::Wire(error)) => {
            tell!("error: {error}");
            Ok(BAD_INPUT)
        }
        spawned => Ok(spawned?),
    }
}

/// `csat world`.
pub fn world(arguments: &WorldArguments, logs: &Logs) -> anyhow::Result<u8> {
    let WorldArguments { run, wire, end_with_parent, logs: agents_logs, .. } = arguments;
    let interrupted = common::interrupted_by_the_user()?;
    if *end_with_parent {
        let interrupted = interrupted.clone();
        parent_death::on_parent_death(move || interrupted.store(true, Ordering::SeqCst));
    }
    let options = RunOptions { interrupted };
    let asked = wire;
    let wire = asked.with_ports();
    if wire.listen != asked.listen {
        tell!("listens on {}", wire.listen.join(", "));
    }
    let session = match session::open(&wire, Role::World) {
        Ok(session) => session,
        Err(error) => {
            tell!("error: {error}");
            return Ok(BAD_INPUT);
        }
    };
    let world = WorldOptions { pace: &arguments.pace, wire: &wire, restarts: arguments.restarts };
    let code = common::record(run, logs, &options, |mission, flight| {
        let folder = flight.recorder.partial_folder().to_owned();
        let flown = mission.fly_fleet(&session, world, flight);
        // Above all when the fleet failed: they tell why.
        let logs = agents_logs.as_ref().map_or(Ok(()), |from| adopt(from, &folder));
        let flown = match flown {
            Err(WorldError::Fleet(FleetError::Interrupted)) => return Ok(None),
            flown => flown?,
        };
        logs.context("cannot keep the agents' logs")?;
        Ok(Some(flown))
    });
    session::close(session);
    code
}

/// Moves the files of a folder into another one, which may be on another disk.
fn adopt(from: &Path, to: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        std::fs::copy(entry.path(), to.join(entry.file_name()))?;
    }
    std::fs::remove_dir_all(from)
}

/// `csat agent`.
pub fn agent(arguments: &AgentArguments, logs: &Logs) -> anyhow::Result<u8> {
    if let Some(path) = &arguments.log {
        let file = File::options().create(true).append(true).open(path);
        logs.attach(file.with_context(|| format!("cannot write to `{}`", path.display()))?);
    }
    let role = Role::Agent(arguments.id);
    let why = |session: &_| doctor::why_no_world(session, &arguments.wire, role);
    match agent::join(arguments, why, missions::take_part) {
        Ok(_) => Ok(DONE),
        Err(AgentError::Ended(EndedBy::Signal)) => Ok(INTERRUPTED),
        Err(error @ (AgentError::Wire(_) | AgentError::Refused { .. })) => {
            tell!("error: {error}");
            Ok(BAD_INPUT)
        }
        Err(error) => Err(error.into()),
    }
}
