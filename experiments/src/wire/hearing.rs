//! From Zenoh's callbacks to a queue that somebody reads.

use std::sync::mpsc::{SyncSender, TrySendError};

use serde::de::DeserializeOwned;
use zenoh::sample::Sample;

use super::rarely::Rarely;

/// What was not understood so far.
static NOT_UNDERSTOOD: Rarely = Rarely::new();

/// A callback that reads a sample and queues what it says. It never blocks: what does not fit is lost,
/// and that is told.
pub fn queueing<T: Send + 'static>(
    sender: &SyncSender<T>,
    read: impl Fn(&Sample) -> Option<T> + Send + Sync + 'static,
) -> impl Fn(Sample) + Send + Sync + 'static {
    let (sender, missed) = (sender.clone(), Rarely::new());
    move |sample: Sample| {
        if let Some(news) = read(&sample)
            && let Err(TrySendError::Full(_)) = sender.try_send(news)
            && let Some(times) = missed.another()
        {
            tracing::error!(key = %sample.key_expr(), times, "too much to hear: dropped");
        }
    }
}

/// What the JSON of a sample says, if it is that.
pub fn json<T: DeserializeOwned>(sample: &Sample) -> Option<T> {
    parse(sample, &sample.payload().to_bytes())
}

/// What some JSON that came with a sample says, if it is that.
pub fn parse<T: DeserializeOwned>(sample: &Sample, bytes: &[u8]) -> Option<T> {
    let complain = |error: &serde_json::Error| {
        if let Some(times) = NOT_UNDERSTOOD.another() {
            tracing::warn!(key = %sample.key_expr(), %error, times, "not understood");
        }
    };
    serde_json::from_slice(bytes).inspect_err(complain).ok()
}
