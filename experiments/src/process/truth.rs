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
use csat_peer::agent::mirror::{LEAST_PERIOD, Watched, reply};

/// The newest document of each name.
type Newest = Arc<Mutex<BTreeMap<String, Document>>>;

/// Shows what is true, and what the fleet is worth, while a mission is flown.
pub struct Showcase {
    newest: Newest,
    targets: Watched,
    metrics: Watched,
    lives: Watched,
    shown: Option<Stopwatch>,
    _queryable: Queryable<()>,
}

impl Showcase {
    /// Shows the town and the layers of a mission, and answers queries for documents.
    ///
    /// # Errors
    /// What Zenoh says.
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
        // What does not change is said once; a listener that comes later asks for it.
        let columns = truth::columns(loaded.kind());
        keep(&newest, &columns);
        for document in [&town, &layers, &columns] {
            Watched::declare(session, keys.of(&document.topic))?.put(document);
        }
        let watched = |name| Watched::declare(session, keys.truth(name));
        Ok(Self {
            targets: watched("targets")?,
            metrics: watched("metrics")?,
            lives: watched("lives")?,
            newest,
            shown: None,
            _queryable: queryable,
        })
    }
}

fn keep(newest: &Newest, document: &Document) {
    let mut newest = newest.lock().unwrap_or_else(PoisonError::into_inner);
    newest.insert(document.topic.clone(), document.clone());
}

impl<M: Mission> Audience<M> for Showcase {
    fn wants(&mut self, _: Step) -> Detail {
        Detail::Brief
    }

    fn see(&mut self, moment: &Moment<'_, M>) -> Result<(), RecordError> {
        for document in truth::lives(moment.trace, moment.time_s) {
            self.lives.put(&document);
        }
        if self.shown.is_some_and(|shown| !shown.left(LEAST_PERIOD).is_zero()) {
            return Ok(());
        }
        self.shown = Some(Stopwatch::start());
        let documents = [truth::targets(moment), truth::metrics(moment)];
        for (document, watched) in documents.iter().zip([&self.targets, &self.metrics]) {
            keep(&self.newest, document);
            if watched.is_wanted() {
                watched.put(document);
            }
        }
        Ok(())
    }
}
