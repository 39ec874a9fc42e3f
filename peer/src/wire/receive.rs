//! Receiving: from Zenoh's callbacks to the queue that a process reads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};

use csat_proto::keys;
use serde::de::DeserializeOwned;
use zenoh::sample::Sample;

use super::refusals::{Refusals, is_logged};

/// How many inputs of a process may wait: some steps of a fleet of hundreds.
pub const QUEUE: usize = 16_384;

/// A callback that reads a sample and queues the result. It never blocks: it drops what the queue has
/// no room for, and logs that. `read` counts what it refuses in `refusals`.
pub fn enqueue<T: Send + 'static>(
    queue: &SyncSender<T>,
    refusals: &Refusals,
    read: impl Fn(&Sample, &Refusals) -> Option<T> + Send + Sync + 'static,
) -> impl Fn(Sample) + Send + Sync + 'static {
    let (queue, refusals, dropped) = (queue.clone(), refusals.clone(), AtomicU64::new(0));
    move |sample: Sample| {
        let Some(input) = read(&sample, &refusals) else { return };
        if let Err(TrySendError::Full(_)) = queue.try_send(input) {
            let times = dropped.fetch_add(1, Ordering::Relaxed) + 1;
            if is_logged(times) {
                tracing::error!(key = %sample.key_expr(), times, "the input queue is full: dropped");
            }
        }
    }
}

/// The name of a sample's key below its run.
pub fn name(sample: &Sample) -> Option<&str> {
    keys::split(sample.key_expr().as_str()).map(|(_, name)| name)
}

/// The payload of a sample.
pub fn bytes(sample: &Sample) -> Vec<u8> {
    sample.payload().to_bytes().into_owned()
}

/// The payload of a sample as JSON; a payload of another form is refused.
pub fn json<T: DeserializeOwned>(sample: &Sample, refusals: &Refusals) -> Option<T> {
    parse(sample, &sample.payload().to_bytes(), refusals)
}

/// JSON that came with a sample; bytes of another form are refused.
pub fn parse<T: DeserializeOwned>(sample: &Sample, bytes: &[u8], refusals: &Refusals) -> Option<T> {
    let refuse = |error: &serde_json::Error| {
        refusals.count("not-understood", &format!("{}: {error}", sample.key_expr()));
    };
    serde_json::from_slice(bytes).inspect_err(refuse).ok()
}
