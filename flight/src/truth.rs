//! What the world's process shows to people (docs/topics.md, `truth/…`).

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use csat_proto::keys::Keys;
use csat_proto::time::Step;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use crate::flight::{Audience, Moment};
use crate::record::RecordError;
use crate::scenario::Loaded;
use crate::show::truth;
use csat_mission::documents::Document;
use csat_mission::mission::{Detail, Mission};
use csat_mission::style::Style;
use csat_mission::timing::Stopwatch;
use csat_peer::view::{DocumentPublisher, MIN_PERIOD, reply};

/// The newest document of each name.
type Newest = Arc<Mutex<BTreeMap<String, Document>>>;

/// Publishes the truth, and the metrics of the fleet, while a mission is flown.
pub struct TruthPublisher {
    newest: Newest,
    targets: DocumentPublisher,
    metrics: DocumentPublisher,
    lives: DocumentPublisher,
    /// Since targets and metrics were published.
    since: Option<Stopwatch>,
    _queryable: Queryable<()>,
}

impl TruthPublisher {
    /// Publishes the town, the layers and the columns, and answers queries for the newest documents.
    ///
    /// # Errors
    /// When Zenoh does not declare a key.
    pub fn declare(
        session: &Session,
        keys: Keys,
        loaded: &Loaded,
        layers: &[Style],
    ) -> zenoh::Result<Self> {
        let town = truth::town(&loaded.name, &loaded.scenario, &loaded.world);
        let layers = truth::layers(layers);
        let newest: Newest = Arc::default();
        keep(&newest, &town);
        keep(&newest, &layers);
        let known = newest.clone();
        let answer = move |query: Query| {
            let known = known.lock().unwrap_or_else(PoisonError::into_inner);
            known.values().for_each(|document| reply(&query, keys, document));
        };
        let queryable = session.declare_queryable(keys.of("truth/**")).callback(answer).wait()?;
        // What does not change is published once; a listener that comes later asks for it.
        let columns = truth::columns(loaded.kind());
        keep(&newest, &columns);
        for document in [&town, &layers, &columns] {
            DocumentPublisher::declare(session, keys.of(&document.topic))?.put(document);
        }
        let publisher = |name| DocumentPublisher::declare(session, keys.truth(name));
        Ok(Self {
            targets: publisher("targets")?,
            metrics: publisher("metrics")?,
            lives: publisher("lives")?,
            newest,
            since: None,
            _queryable: queryable,
        })
    }
}

fn keep(newest: &Newest, document: &Document) {
    let mut newest = newest.lock().unwrap_or_else(PoisonError::into_inner);
    newest.insert(document.topic.clone(), document.clone());
}

impl<M: Mission> Audience<M> for TruthPublisher {
    fn wants(&mut self, _: Step) -> Detail {
        Detail::Brief
    }

    fn see(&mut self, moment: &Moment<'_, M>) -> Result<(), RecordError> {
        for document in truth::lives(moment.trace, moment.time_s) {
            self.lives.put(&document);
        }
        if self.since.is_some_and(|since| !since.left(MIN_PERIOD).is_zero()) {
            return Ok(());
        }
        self.since = Some(Stopwatch::start());
        let documents = [truth::targets(moment), truth::metrics(moment)];
        for (document, publisher) in documents.iter().zip([&self.targets, &self.metrics]) {
            keep(&self.newest, document);
            if publisher.is_matched() {
                publisher.put(document);
            }
        }
        Ok(())
    }
}
