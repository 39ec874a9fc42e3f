//! The newest document of each topic.
//!
//! Pages are never told of every document: each keeps a [`Cursor`] and asks for what is newer, when
//! it is ready for it. So a slow page costs no memory and does not delay other pages.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

use super::document::{Document, by_topic};
use super::history::History;

/// The most topics of one mission; a fleet of 64 has under 600.
const MAX_TOPICS: usize = 16_384;

/// How much of a feed a page has seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cursor {
    generation: u64,
    revision: u64,
}

/// What is new.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Batch {
    /// Counts missions from 1: what a page knows of another one is over.
    pub generation: u64,
    /// Which mission.
    pub run: String,
    /// Documents that were heard too fast, or were no documents.
    pub lost: u64,
    /// Whether the mission is over.
    pub ended: bool,
    /// The newest of each topic.
    pub documents: Vec<Document>,
}

impl Batch {
    /// `{"generation", "run", "lost", "ended", "documents": {topic: body}}`
    pub fn to_json(&self) -> String {
        format!(
            "{{\"generation\":{},\"run\":{},\"lost\":{},\"ended\":{},\"documents\":{}}}",
            self.generation,
            serde_json::Value::from(self.run.as_str()),
            self.lost,
            self.ended,
            by_topic(&self.documents)
        )
    }
}

/// Where documents come together and pages get them.
#[derive(Debug, Default)]
pub struct Hub {
    state: Mutex<State>,
    changed: watch::Sender<()>,
}

#[derive(Debug, Default)]
struct State {
    generation: u64,
    revision: u64,
    run: String,
    lost: u64,
    ended: bool,
    /// By topic, with the revision that brought it.
    latest: BTreeMap<String, (u64, Document)>,
    history: History,
}

impl State {
    fn begin(&mut self, run: &str) {
        self.generation += 1;
        self.run = run.to_owned();
        self.ended = false;
        self.latest.clear();
        self.history = History::default();
    }
}

impl Hub {
    fn state(&self) -> MutexGuard<'_, State> {
        // Each change is complete before anything can panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets everything: another mission begins.
    pub fn begin(&self, run: &str) {
        self.state().begin(run);
        self.changed.send_replace(());
    }

    /// Adds documents; those of a topic in their order. A time before the last one of its topic
    /// means that the same mission flies again from its start.
    pub fn publish(&self, documents: impl IntoIterator<Item = Document>) {
        let mut state = self.state();
        for document in documents {
            let last = state.latest.get(&document.topic).map(|(_, last)| last.time_s);
            if last.is_some_and(|last| document.time_s < last) {
                let run = state.run.clone();
                state.begin(&run);
            } else if last.is_none() && state.latest.len() >= MAX_TOPICS {
                state.lost += 1;
                continue;
            }
            state.history.add(&document);
            state.revision += 1;
            let revision = state.revision;
            state.latest.insert(document.topic.clone(), (revision, document));
        }
        drop(state);
        self.changed.send_replace(());
    }

    /// Says whether the mission is over.
    pub fn end(&self, ended: bool) {
        self.state().ended = ended;
        self.changed.send_replace(());
    }

    /// Counts documents that could not be shown.
    pub fn lose(&self, count: u64) {
        self.state().lost += count;
    }

    /// Whether there is a document of a topic.
    pub fn has(&self, topic: &str) -> bool {
        self.state().latest.contains_key(topic)
    }

    /// The newest document of each topic that `wanted` wants and that is newer than `cursor`, which
    /// moves on.
    pub fn since(&self, cursor: &mut Cursor, wanted: impl Fn(&str) -> bool) -> Batch {
        let state = self.state();
        let seen = if cursor.generation == state.generation { cursor.revision } else { 0 };
        *cursor = Cursor { generation: state.generation, revision: state.revision };
        let new = state.latest.values().filter(|(revision, _)| *revision > seen);
        let documents = new.map(|(_, document)| document).filter(|d| wanted(&d.topic));
        Batch {
            generation: state.generation,
            run: state.run.clone(),
            lost: state.lost,
            ended: state.ended,
            documents: documents.cloned().collect(),
        }
    }

    /// Paths and curves so far.
    pub fn history_json(&self) -> String {
        self.state().history.to_json()
    }

    /// Wakes the tasks that wait for something new.
    pub fn changes(&self) -> watch::Receiver<()> {
        self.changed.subscribe()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(topic: &str, time_s: f64) -> Document {
        Document::parse(topic, format!("{{\"time_s\":{time_s}}}").as_bytes()).unwrap()
    }

    fn times(batch: &Batch) -> Vec<(&str, f64)> {
        batch.documents.iter().map(|d| (d.topic.as_str(), d.time_s)).collect()
    }

    #[test]
    fn a_slow_page_gets_the_newest_of_each_topic_once() {
        let hub = Hub::default();
        hub.begin("1");
        let (mut slow, mut fast) = (Cursor::default(), Cursor::default());
        for step in 0..1000 {
            hub.publish([document("view/0/pose", f64::from(step))]);
            let batch = hub.since(&mut fast, |_| true);
            assert_eq!(times(&batch), [("view/0/pose", f64::from(step))]);
        }
        hub.publish([document("truth/metrics", 1.0)]);
        let batch = hub.since(&mut slow, |_| true);
        assert_eq!(times(&batch), [("truth/metrics", 1.0), ("view/0/pose", 999.0)]);
        assert_eq!(times(&hub.since(&mut slow, |_| true)), []);
    }

    #[test]
    fn a_mission_that_begins_again_is_another_generation() {
        let hub = Hub::default();
        hub.begin("7");
        let mut cursor = Cursor::default();
        hub.publish([document("view/0/pose", 5.0), document("view/1/pose", 5.0)]);
        assert_eq!(hub.since(&mut cursor, |_| true).generation, 1);
        hub.publish([document("view/1/pose", 0.0)]);
        let batch = hub.since(&mut cursor, |_| true);
        assert_eq!((batch.generation, batch.run.as_str()), (2, "7"));
        assert_eq!(times(&batch), [("view/1/pose", 0.0)]);
    }

    #[test]
    fn there_is_an_end_to_the_topics() {
        let hub = Hub::default();
        hub.publish((0..MAX_TOPICS + 5).map(|i| document(&format!("view/{i}/pose"), 0.0)));
        let batch = hub.since(&mut Cursor::default(), |_| true);
        assert_eq!((batch.documents.len(), batch.lost), (MAX_TOPICS, 5));
    }

    #[test]
    fn batches_are_json() {
        let hub = Hub::default();
        hub.begin("a\"b");
        hub.publish([document("odd\"topic", 1.0), document("view/0/pose", 2.0)]);
        let json = hub.since(&mut Cursor::default(), |_| true).to_json();
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(value["run"], "a\"b");
        assert_eq!(value["documents"]["odd\"topic"]["time_s"], 1.0);
    }
}
