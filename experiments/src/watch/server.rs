//! What a browser may ask for. Nothing leaves the computer: the server is on 127.0.0.1.

use std::convert::Infallible;
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{Query, State};
use axum::http::{HeaderName, StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use futures_util::stream::{self, Stream};
use serde::Deserialize;
use tokio::net::TcpListener;
use tokio::time::MissedTickBehavior;

use super::document::is_drawn;
use super::error::WatchError;
use super::feed::{Cursor, Hub};
use super::page;
use super::recording::Recording;

/// The least time between two batches to one page.
const BATCH_EVERY: Duration = Duration::from_millis(100);
/// A quiet connection says so often that it lives.
const KEEP_ALIVE: Duration = Duration::from_secs(5);
/// A page tries so soon to come back.
const RETRY: Duration = Duration::from_secs(1);

/// Where documents come from.
#[derive(Debug, Clone)]
pub enum Source {
    /// A fleet that flies.
    Live(Arc<Hub>),
    /// A run that flew.
    Recorded(Arc<Recording>),
}

/// Listens on a port of this computer; 0 is any free one.
///
/// # Errors
/// When the port is taken or the system refuses.
pub async fn listen(port: u16) -> Result<TcpListener, WatchError> {
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    TcpListener::bind(address).await.map_err(|error| match error.kind() {
        ErrorKind::AddrInUse => WatchError::PortTaken(address),
        _ => WatchError::Listen { address, error },
    })
}

/// Serves pages until it is dropped.
///
/// # Errors
/// When the system refuses.
pub async fn serve(listener: TcpListener, source: Source) -> Result<(), WatchError> {
    let pages = Router::new()
        .route("/", get(page))
        .route("/events", get(events))
        .route("/recording", get(recording))
        .route("/at", get(at))
        .route("/series", get(series))
        .with_state(source);
    axum::serve(listener, pages).await.map_err(WatchError::Serve)
}

async fn page(State(source): State<Source>) -> Response {
    let mode = match source {
        Source::Live(_) => page::Mode::Live,
        Source::Recorded(_) => page::Mode::Recorded,
    };
    let page = page::html(mode);
    let headers = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8"),
        (header::CACHE_CONTROL, "no-store"),
        (header::CONTENT_SECURITY_POLICY, page.policy.as_str()),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
    ];
    (headers, page.html).into_response()
}

fn json(body: String) -> Response {
    let headers: [(HeaderName, &str); 2] =
        [(header::CONTENT_TYPE, "application/json"), (header::CACHE_CONTROL, "no-store")];
    (headers, body).into_response()
}

fn not_here(expected: &str) -> Response {
    (StatusCode::NOT_FOUND, format!("{expected}\n")).into_response()
}

/// Whose knowledge a page draws.
#[derive(Debug, Deserialize)]
struct Drawn {
    #[serde(default)]
    agent: usize,
}

async fn events(State(source): State<Source>, Query(Drawn { agent }): Query<Drawn>) -> Response {
    let Source::Live(hub) = source else {
        return not_here("a recording has no events: expected /at?time_s=SECONDS");
    };
    let keep_alive = KeepAlive::new().interval(KEEP_ALIVE);
    Sse::new(batches(hub, agent)).keep_alive(keep_alive).into_response()
}

/// Batches for one page; it is asked for the next one when the last one is on its way.
fn batches(hub: Arc<Hub>, agent: usize) -> impl Stream<Item = Result<Event, Infallible>> {
    let mut changes = hub.changes();
    changes.mark_changed();
    let mut pace = tokio::time::interval(BATCH_EVERY);
    pace.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let start = (hub, changes, pace, Cursor::default(), None);
    stream::unfold(start, move |(hub, mut changes, mut pace, mut cursor, told)| async move {
        loop {
            changes.changed().await.ok()?;
            pace.tick().await;
            changes.mark_unchanged();
            let batch = hub.since(&mut cursor, |topic| is_drawn(topic, agent));
            let now = Some((batch.generation, batch.ended));
            // A page is greeted at once, so that it knows that it is connected.
            if now != told || !batch.documents.is_empty() {
                let event = Event::default().event("batch").retry(RETRY).data(batch.to_json());
                return Some((Ok(event), (hub, changes, pace, cursor, now)));
            }
        }
    })
}

async fn recording(State(source): State<Source>) -> Response {
    match source {
        Source::Recorded(recording) => json(recording.to_json()),
        Source::Live(_) => not_here("a fleet that flies has no recording: expected /events"),
    }
}

/// Which moment of a recording.
#[derive(Debug, Deserialize)]
struct Moment {
    time_s: f64,
    #[serde(default)]
    agent: usize,
    /// Leaves the town out when it is `false`.
    #[serde(default = "yes")]
    town: bool,
}

fn yes() -> bool {
    true
}

async fn at(State(source): State<Source>, Query(moment): Query<Moment>) -> Response {
    let Moment { time_s, agent, town } = moment;
    match source {
        Source::Recorded(recording) => json(recording.at_json(time_s, agent, town)),
        Source::Live(_) => not_here("a fleet that flies has no recording: expected /events"),
    }
}

async fn series(State(source): State<Source>) -> Response {
    json(match source {
        Source::Live(hub) => hub.history_json(),
        Source::Recorded(recording) => recording.history_json(),
    })
}

#[cfg(test)]
#[path = "server_tests.rs"]
mod tests;
