//! A subscriber whose queue is bounded: it never makes a fleet wait, and counts what it missed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use zenoh::key_expr::KeyExpr;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use csat_peer::wire::session::stop_listening;

/// How many samples may wait.
const QUEUE: usize = 16_384;
/// How many bytes may wait: a frame has hundreds of thousands.
const QUEUE_BYTES: usize = 64 << 20;

/// What to listen to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Listen {
    /// What is published.
    Bodies,
    /// What is published, but for what it says.
    Sizes,
    /// Who comes and goes: liveliness tokens, first those that are there.
    Tokens,
}

/// A sample.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Heard {
    /// Its key.
    pub key: String,
    /// Whether the key, or the token, is gone.
    pub is_gone: bool,
    /// Zenoh's name of its encoding.
    pub encoding: String,
    /// How long its body is.
    pub bytes: usize,
    /// What it says; empty with [`Listen::Sizes`].
    pub body: Vec<u8>,
    /// What goes beside its body.
    pub attachment: Option<Vec<u8>>,
}

impl Heard {
    fn new(sample: &Sample, listen: Listen) -> Self {
        let is_wanted = listen != Listen::Sizes;
        let attachment = sample.attachment().filter(|_| is_wanted);
        Self {
            key: sample.key_expr().to_string(),
            is_gone: sample.kind() == SampleKind::Delete,
            encoding: sample.encoding().to_string(),
            bytes: sample.payload().len(),
            body: if is_wanted { sample.payload().to_bytes().into_owned() } else { Vec::new() },
            attachment: attachment.map(|bytes| bytes.to_bytes().into_owned()),
        }
    }

    /// The memory that it takes, roughly.
    fn weight(&self) -> usize {
        self.body.len() + self.attachment.as_ref().map_or(0, Vec::len)
    }
}

/// What the subscriber's thread and the reader share.
#[derive(Debug, Default)]
struct Queue {
    bytes: AtomicUsize,
    missed: AtomicU64,
}

/// Samples of some keys.
pub struct Ear {
    samples: Receiver<Heard>,
    queue: Arc<Queue>,
    _subscriber: Subscriber<()>,
}

impl Ear {
    /// Listens from now on.
    ///
    /// # Errors
    /// What Zenoh says.
    pub fn open(session: &Session, keys: &KeyExpr<'static>, listen: Listen) -> zenoh::Result<Self> {
        let (sender, samples) = sync_channel(QUEUE);
        let queue = Arc::new(Queue::default());
        let hear = hearing(sender, queue.clone(), listen);
        let subscriber = match listen {
            Listen::Tokens => {
                session.liveliness().declare_subscriber(keys).history(true).callback(hear).wait()
            }
            Listen::Bodies | Listen::Sizes => {
                session.declare_subscriber(keys).callback(hear).wait()
            }
        }?;
        Ok(Self { samples, queue, _subscriber: subscriber })
    }

    /// What comes next within `limit`.
    pub fn next(&self, limit: Duration) -> Option<Heard> {
        let heard = self.samples.recv_timeout(limit).ok()?;
        self.queue.bytes.fetch_sub(heard.weight(), Ordering::Relaxed);
        Some(heard)
    }

    /// How many came faster than they were taken.
    pub fn missed(&self) -> u64 {
        self.queue.missed.load(Ordering::Relaxed)
    }
}

impl Drop for Ear {
    fn drop(&mut self) {
        stop_listening();
    }
}

/// Zenoh's own thread never waits.
fn hearing(
    sender: SyncSender<Heard>,
    queue: Arc<Queue>,
    listen: Listen,
) -> impl Fn(Sample) + Send + Sync + 'static {
    move |sample: Sample| {
        let heard = Heard::new(&sample, listen);
        let weight = heard.weight();
        let waiting = queue.bytes.fetch_add(weight, Ordering::Relaxed);
        if waiting + weight > QUEUE_BYTES || sender.try_send(heard).is_err() {
            queue.bytes.fetch_sub(weight, Ordering::Relaxed);
            queue.missed.fetch_add(1, Ordering::Relaxed);
        }
    }
}
