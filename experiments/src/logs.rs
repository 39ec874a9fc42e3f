//! Logs: warnings on stderr, more in the run folder.

use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::sync::{Arc, Mutex, PoisonError};

use tracing::field::{Field, Visit};
use tracing::{Event, Metadata};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::{FilterExt, LevelFilter, Targets};
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::{Context, Filter, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

use crate::progress::Progress;
use csat_mission::stages::StageLayer;
use csat_peer::wire::session::is_closing;

/// What stderr gets by default. Zenoh's orchestrator warns of endpoints that cannot be had, with places in
/// its source; the code that opens a session says the same in csat's words.
const DEFAULT: &str = "warn,zenoh::net::runtime::orchestrator=error";

/// Where logs go. Clones share their targets.
#[derive(Debug, Clone, Default)]
pub struct Logs {
    file: Arc<Mutex<Option<File>>>,
    progress: Arc<Mutex<Option<Progress>>>,
}

impl Logs {
    /// Makes this the process's log; `RUST_LOG` chooses what stderr gets (default: warnings).
    pub fn install() -> Self {
        let logs = Self::default();
        let filter = match std::env::var("RUST_LOG") {
            Ok(chosen) => EnvFilter::builder()
                .with_default_directive(LevelFilter::WARN.into())
                .parse_lossy(chosen),
            Err(_) => EnvFilter::new(DEFAULT),
        };
        let terminal = tracing_subscriber::fmt::layer()
            .without_time()
            .with_target(false)
            .with_ansi(io::stderr().is_terminal())
            .with_writer(Terminal(logs.progress.clone()))
            .with_filter(filter.and(NotOfTheEnd));
        let file = tracing_subscriber::fmt::layer()
            .without_time()
            .with_ansi(false)
            .with_writer(InFile(logs.file.clone()))
            .with_filter(
                Targets::new()
                    .with_default(LevelFilter::INFO)
                    .with_target("zenoh", LevelFilter::WARN),
            );
        // A second subscriber in one process (tests) is refused; then the first one stays.
        let _ =
            tracing_subscriber::registry().with(terminal).with(file).with(StageLayer).try_init();
        logs
    }

    /// From now on also into this file.
    pub fn attach(&self, file: File) {
        *lock(&self.file) = Some(file);
    }

    /// From now on without tearing this bar.
    pub fn share_terminal(&self, progress: Progress) {
        *lock(&self.progress) = Some(progress);
    }
}

/// Leaves out what Zenoh calls an error and is none: samples that come while a session is being closed.
struct NotOfTheEnd;

impl<S> Filter<S> for NotOfTheEnd {
    fn enabled(&self, _: &Metadata<'_>, _: &Context<'_, S>) -> bool {
        true
    }

    fn event_enabled(&self, event: &Event<'_>, _: &Context<'_, S>) -> bool {
        !(is_closing() && is_late_sample(event))
    }
}

fn is_late_sample(event: &Event<'_>) -> bool {
    struct IsLate(bool);
    impl Visit for IsLate {
        fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
            self.0 |= field.name() == "message"
                && format!("{value:?}").starts_with("Received Data for unknown key_expr");
        }
    }
    let mut late = IsLate(false);
    if event.metadata().target().starts_with("zenoh::api::session") {
        event.record(&mut late);
    }
    late.0
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Terminal(Arc<Mutex<Option<Progress>>>);

impl Write for Terminal {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let written = match &*lock(&self.0) {
            Some(progress) => progress.suspend(|| io::stderr().write(buffer)),
            None => io::stderr().write(buffer),
        };
        // The subscriber tells of errors with `eprintln!`, which panics where this one failed.
        Ok(written.unwrap_or(buffer.len()))
    }
    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

impl<'a> MakeWriter<'a> for Terminal {
    type Writer = Terminal;
    fn make_writer(&'a self) -> Terminal {
        Terminal(self.0.clone())
    }
}

struct InFile(Arc<Mutex<Option<File>>>);

impl Write for InFile {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        match &mut *lock(&self.0) {
            Some(file) => file.write(buffer),
            None => Ok(buffer.len()),
        }
    }
    fn flush(&mut self) -> io::Result<()> {
        lock(&self.0).as_mut().map_or(Ok(()), Write::flush)
    }
}

impl<'a> MakeWriter<'a> for InFile {
    type Writer = InFile;
    fn make_writer(&'a self) -> InFile {
        InFile(self.0.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_samples_are_known_by_what_zenoh_says_of_them() {
        #[derive(Clone, Default)]
        struct Seen(Arc<Mutex<Vec<bool>>>);
        impl<S: tracing::Subscriber> Layer<S> for Seen {
            fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
                lock(&self.0).push(is_late_sample(event));
            }
        }
        let seen = Seen::default();
        tracing::subscriber::with_default(
            tracing_subscriber::registry().with(seen.clone()),
            || {
                let error = "3 is unknown";
                tracing::error!(target: "zenoh::api::session", "Received Data for unknown key_expr: {error}");
                tracing::error!(target: "zenoh::api::session", "Received Query for unknown key_expr");
                tracing::error!(target: "csat", "Received Data for unknown key_expr: {error}");
            },
        );
        assert_eq!(*lock(&seen.0), [true, false, false]);
    }
}
