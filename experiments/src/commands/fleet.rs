//! The commands of a fleet of processes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use csat_experiments::logs::Logs;
use csat_experiments::mission::RunOptions;
use csat_experiments::process::agent::{self, AgentError};
use csat_experiments::process::arguments::{AgentArguments, WorldArguments};
use csat_experiments::process::spawn::{self, SpawnArguments};
use csat_experiments::process::world;
use csat_experiments::verdict::{BAD_INPUT, DONE};
use csat_experiments::wire::session::{self, Role};

/// `csat spawn`.
pub fn spawn(arguments: &SpawnArguments) -> anyhow::Result<u8> {
    match super::load(&arguments.run.scenario) {
        Ok(loaded) => Ok(spawn::spawn(arguments, &loaded)?),
        Err(mistakes) => {
            eprintln!("{mistakes}");
            Ok(BAD_INPUT)
        }
    }
}

/// `csat world`.
pub fn world(arguments: &WorldArguments, logs: &Logs) -> anyhow::Result<u8> {
    let WorldArguments { run, pace, wire, leashed } = arguments;
    let interrupted = super::interrupted_by_the_user()?;
    if *leashed {
        end_with_stdin(interrupted.clone());
    }
    let options = RunOptions { interrupted };
    let session = match session::open(wire, Role::World) {
        Ok(session) => session,
        Err(error) => {
            eprintln!("error: {error}");
            return Ok(BAD_INPUT);
        }
    };
    let code = super::record(run, logs, |loaded, recorder, audience| {
        Ok(world::fly(&session, loaded, pace, &options, recorder, audience)?)
    });
    session::close(session);
    code
}

/// Whoever holds the other end of standard input is gone: the mission ends.
fn end_with_stdin(interrupted: Arc<AtomicBool>) {
    std::thread::spawn(move || {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        interrupted.store(true, Ordering::SeqCst);
    });
}

/// `csat agent`.
pub fn agent(arguments: &AgentArguments) -> anyhow::Result<u8> {
    match agent::fly(arguments) {
        Ok(reason) => {
            tracing::info!(agent = arguments.id, reason, "ended");
            Ok(DONE)
        }
        Err(error @ (AgentError::Wire(_) | AgentError::Refused { .. })) => {
            eprintln!("error: {error}");
            Ok(BAD_INPUT)
        }
        Err(error) => Err(error.into()),
    }
}
