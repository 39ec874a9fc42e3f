//! Documents for people: published while a subscriber matches, and on request.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use csat_mission::documents::Document;
use csat_proto::keys::Keys;
use zenoh::bytes::Encoding;
use zenoh::key_expr::KeyExpr;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Query;
use zenoh::{Session, Wait};

/// The least time between two steps that are published, however fast a fleet flies.
pub const MIN_PERIOD: Duration = Duration::from_millis(80);

/// A publisher of documents that knows whether any subscriber matches its key.
pub struct DocumentPublisher {
    publisher: Publisher<'static>,
    is_matched: Arc<AtomicBool>,
}

impl DocumentPublisher {
    /// Declares a publisher of low priority that never waits: its documents may be lost.
    ///
    /// # Errors
    /// When Zenoh does not declare it.
    pub fn declare(session: &Session, key: String) -> zenoh::Result<Self> {
        let publisher = session
            .declare_publisher(key)
            .congestion_control(CongestionControl::Drop)
            .priority(Priority::DataLow)
            .wait()?;
        let is_matched = Arc::new(AtomicBool::new(publisher.matching_status().wait()?.matching()));
        let flag = is_matched.clone();
        publisher
            .matching_listener()
            .callback(move |status| flag.store(status.matching(), Ordering::Relaxed))
            .background()
            .wait()?;
        Ok(Self { publisher, is_matched })
    }

    /// Whether any subscriber matches the key.
    pub fn is_matched(&self) -> bool {
        self.is_matched.load(Ordering::Relaxed)
    }

    /// The same, to be read by another thread.
    pub(crate) fn matched(&self) -> Arc<AtomicBool> {
        self.is_matched.clone()
    }

    /// Publishes a document.
    pub fn put(&self, document: &Document) {
        let encoding = Encoding::from(document.encoding.media_type());
        if let Err(error) = self.publisher.put(&document.body).encoding(encoding).wait() {
            tracing::warn!(%error, "cannot show");
        }
    }
}

/// Replies to a query with a document, if the query's key covers that of the document.
pub fn reply(query: &Query, keys: Keys, document: &Document) {
    let name = keys.of(&document.topic);
    // A process that joins late asks for the map under this name.
    let state = document.topic.replacen("view/", "state/", 1);
    for key in [name, keys.of(&state)] {
        let is_asked =
            KeyExpr::try_from(key.as_str()).is_ok_and(|key| query.key_expr().intersects(&key));
        if is_asked {
            let encoding = Encoding::from(document.encoding.media_type());
            let replied = query.reply(key, &document.body).encoding(encoding).wait();
            if let Err(error) = replied {
                tracing::debug!(%error, "cannot answer a query");
            }
        }
    }
}
