//! `csat watch`: a live map in the browser of a fleet that flies, or of one that flew.
//!
//! | module | what it does |
//! |---|---|
//! | [`feed`] | the newest document of each topic, for pages that come when they like |
//! | [`history`] | what a page that comes late needs of the past: paths and curves |
//! | [`live`] | hears a fleet through Zenoh |
//! | [`recorded`] | reads a recording |
//! | [`recording`] | a recording, by time |
//! | [`server`] | what a browser may ask for |
//! | [`page`] | the page |
//! | [`arguments`] | the command line |
//!
//! Documents and topics are those of `docs/topics.md`; they pass through as they are. Watching
//! never slows a fleet: what is heard waits in a bounded queue, a slow page gets the newest state when it
//! is ready for it, and sets of agents that no page shows are not sent.

pub mod arguments;
pub mod document;
mod error;
pub mod feed;
pub mod history;
pub mod live;
pub mod page;
pub mod recorded;
pub mod recording;
pub mod server;

use std::net::SocketAddr;
use std::sync::Arc;

use arguments::WatchArguments;
use feed::Hub;
use recording::Recording;
use server::Source;

use csat_peer::wire::session::{self, Role};
pub use error::WatchError;

/// Serves the page until `ended`; `ready` hears its address once a browser may come.
///
/// # Errors
/// When there is nothing to show, or no way to show it.
pub async fn watch(
    arguments: &WatchArguments,
    ready: impl FnOnce(SocketAddr),
    ended: impl Future<Output = ()>,
) -> Result<(), WatchError> {
    let recording = match &arguments.dir {
        Some(dir) => Some(Recording::new(recorded::load(dir)?)),
        None => None,
    };
    let listener = server::listen(arguments.port).await?;
    let address = listener.local_addr().map_err(WatchError::Serve)?;
    if let Some(recording) = recording {
        ready(address);
        return tokio::select! {
            result = server::serve(listener, Source::Recorded(Arc::new(recording))) => result,
            () = ended => Ok(()),
        };
    }
    let wire = arguments.wire.clone();
    let session = blocking(move || session::open(&wire, Role::Spectator)).await??;
    let hub = Arc::new(Hub::default());
    ready(address);
    let result = tokio::select! {
        result = server::serve(listener, Source::Live(hub.clone())) => result,
        result = live::follow(&session, &hub, arguments.run) => result,
        () = ended => Ok(()),
    };
    blocking(move || session::close(session)).await?;
    result
}

/// Zenoh waits on the thread that calls it: one that nothing else needs.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, WatchError> {
    tokio::task::spawn_blocking(work).await.map_err(|error| WatchError::Zenoh(error.to_string()))
}
