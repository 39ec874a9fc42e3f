//! `csat echo` and `csat doctor`.

use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use anyhow::Context;

use super::common;
use crate::tools::doctor::{self, DoctorArguments};
use crate::tools::echo::{self, EchoArguments};
use crate::verdict::{BAD_INPUT, DONE, FAILED, INTERRUPTED};
use csat_peer::tell;

/// `csat echo`.
pub fn echo(arguments: &EchoArguments) -> anyhow::Result<u8> {
    // Ctrl-C is how it ends, so it is no failure. Some programs, such as `timeout`, ask twice at once;
    // a user who asks once more does not want to wait, say for a reader of stdout that does not read.
    let interrupted = Arc::new(AtomicBool::new(false));
    let (seen, asked) = (interrupted.clone(), AtomicU32::new(0));
    ctrlc::set_handler(move || {
        seen.store(true, Ordering::SeqCst);
        if asked.fetch_add(1, Ordering::SeqCst) >= 2 {
            std::process::exit(INTERRUPTED.into());
        }
    })
    .context("cannot listen to Ctrl-C")?;
    let mut stdout = io::stdout();
    let redraw = stdout.is_terminal();
    match echo::echo(arguments, &interrupted, &mut stdout, redraw) {
        Ok(()) => Ok(DONE),
        Err(error) if error.is_mistake() => {
            tell!("error: {error}");
            Ok(BAD_INPUT)
        }
        Err(error) => Err(error.into()),
    }
}

/// `csat doctor`.
pub fn doctor(arguments: &DoctorArguments) -> anyhow::Result<u8> {
    let mut told = Ok(());
    // Told while it goes, so that a slow network shows where it is slow.
    let diagnosis = doctor::examine(arguments, &mut |finding| {
        if !arguments.json && told.is_ok() {
            told = common::say(&format!("{finding}\n"));
        }
    });
    let diagnosis = match diagnosis {
        Ok(diagnosis) => diagnosis,
        Err(error) if error.is_mistake() => {
            tell!("error: {error}");
            return Ok(BAD_INPUT);
        }
        Err(error) => return Err(error.into()),
    };
    told?;
    if arguments.json {
        common::say(&format!("{}\n", serde_json::to_string_pretty(&diagnosis)?))?;
    } else {
        common::say(&format!("{}\n", diagnosis.verdict()))?;
    }
    Ok(if diagnosis.problems == 0 { DONE } else { FAILED })
}
