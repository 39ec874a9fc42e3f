//! From Zenoh's callbacks to a queue that somebody reads.

use std::sync::mpsc::{SyncSender, TrySendError};

use serde::de::DeserializeOwned;
use zenoh::sample::Sample;

use super::rarely::Rarely;
use super::refusals::Refusals;

/// A callback that reads a sample and queues what it says. It never blocks: what does not fit is lost,
/// and that is told. What `read` does not believe goes to `refusals`.
pub fn queueing<T: Send + 'static>(
    sender: &SyncSender<T>,
    refusals: &Refusals,
    read: impl Fn(&Sample, &Refusals) -> Option<T> + Send + Sync + 'static,
) -> impl Fn(Sample) + Send + Sync + 'static {
    let (sender, refusals, missed) = (sender.clone(), refusals.clone(), Rarely::new());
    move |sample: Sample| {
        if let Some(news) = read(&sample, &refusals)
            && let Err(TrySendError::Full(_)) = sender.try_send(news)
            && let Some(times) = missed.another()
        {
            tracing::error!(key = %sample.key_expr(), times, "too much to hear: dropped");
        }
    }
}

/// What the JSON of a sample says, if it is that.
pub fn json<T: DeserializeOwned>(sample: &Sample, refusals: &Refusals) -> Option<T> {
    parse(sample, &sample.payload().to_bytes(), refusals)
}

/// What some JSON that came with a sample says, if it is that.
pub fn parse<T: DeserializeOwned>(sample: &Sample, bytes: &[u8], refusals: &Refusals) -> Option<T> {
    let complain = |error: &serde_json::Error| {
        refusals.count("not-understood", &format!("{}: {error}", sample.key_expr()));
    };
    serde_json::from_slice(bytes).inspect_err(complain).ok()
}
