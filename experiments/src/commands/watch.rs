//! `csat watch`.

use anyhow::Context;

use super::common;
use crate::verdict::{BAD_INPUT, DONE};
use crate::watch::{self, arguments::WatchArguments};
use csat_peer::tell;

/// `csat watch`.
pub fn watch(arguments: &WatchArguments) -> anyhow::Result<u8> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .context("cannot start the threads")?;
    let result = runtime.block_on(async {
        let ended = ended_by_the_user()?;
        let ready = |address| {
            if let Err(error) = common::say(&format!("http://{address}\n")) {
                tracing::warn!(%error, "cannot say where the page is");
            }
        };
        anyhow::Ok(watch::watch(arguments, ready, ended).await)
    })?;
    // What Zenoh still does in the background must not hold the user up.
    runtime.shutdown_background();
    match result {
        Ok(()) => Ok(DONE),
        Err(error) if error.is_mistake() => {
            tell!("error: {error}");
            Ok(BAD_INPUT)
        }
        Err(error) => Err(error.into()),
    }
}

/// Ends with Ctrl-C, or when the process is asked to end.
fn ended_by_the_user() -> anyhow::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let why = "cannot listen to Ctrl-C";
    let mut interrupted = signal(SignalKind::interrupt()).context(why)?;
    let mut terminated = signal(SignalKind::terminate()).context(why)?;
    Ok(async move {
        tokio::select! {
            _ = interrupted.recv() => {}
            _ = terminated.recv() => {}
        }
    })
}
