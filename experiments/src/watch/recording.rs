//! A recording, by time.

use std::collections::BTreeMap;

use serde_json::json;

use super::document::{Document, by_topic, is_drawn};
use super::history::History;

/// A run that flew.
#[derive(Debug)]
pub struct Recording {
    /// By topic, then time.
    topics: BTreeMap<String, Vec<Document>>,
    /// The times of the steps, ascending, seconds.
    times_s: Vec<f64>,
    history: History,
}

impl Recording {
    /// The recording of some documents, which may come in any order.
    pub fn new(mut documents: Vec<Document>) -> Self {
        documents.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let moving = |d: &&Document| d.topic.starts_with("view/") || d.topic == "truth/metrics";
        let mut times_s: Vec<f64> = documents.iter().filter(moving).map(|d| d.time_s).collect();
        times_s.dedup();
        let mut history = History::default();
        let mut topics: BTreeMap<String, Vec<Document>> = BTreeMap::new();
        for document in documents {
            history.add(&document);
            topics.entry(document.topic.clone()).or_default().push(document);
        }
        Self { topics, times_s, history }
    }

    /// Simulated time from the first step to the last, seconds.
    pub fn duration_s(&self) -> f64 {
        match (self.times_s.first(), self.times_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// The newest document of each topic at a time, seconds.
    pub fn at(&self, time_s: f64) -> impl Iterator<Item = &Document> {
        self.topics.values().filter_map(move |documents| {
            // A time that went through text and back is still that of its step.
            let until = documents.partition_point(|d| d.time_s <= time_s + 1e-6);
            documents[..until].last()
        })
    }

    /// What a page that draws what `agent` knows shows of [`Self::at`]: an object by topic. `false`
    /// in `with_town` leaves the town out, which a page has already.
    pub fn at_json(&self, time_s: f64, agent: usize, with_town: bool) -> String {
        let wanted =
            |d: &&Document| is_drawn(&d.topic, agent) && (with_town || d.topic != "truth/town");
        by_topic(self.at(time_s).filter(wanted))
    }

    /// `{"topics": [...], "start_s", "end_s", "times_s": [...]}`
    pub fn to_json(&self) -> String {
        json!({
            "topics": self.topics.keys().collect::<Vec<_>>(),
            "start_s": self.times_s.first(),
            "end_s": self.times_s.last(),
            "times_s": self.times_s,
        })
        .to_string()
    }

    /// Paths and curves.
    pub fn history_json(&self) -> String {
        self.history.to_json()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording() -> Recording {
        let document = |topic: &str, time_s: f64| Document {
            topic: topic.to_owned(),
            time_s,
            body: format!("{{\"time_s\":{time_s}}}").into(),
        };
        let mut documents = vec![document("truth/town", 0.0)];
        for step in (0..4).rev() {
            documents.push(document("view/0/pose", f64::from(step) * 0.1));
        }
        documents.push(document("view/1/oem", 0.2));
        Recording::new(documents)
    }

    fn topics(recording: &Recording, time_s: f64) -> Vec<(&str, f64)> {
        recording.at(time_s).map(|d| (d.topic.as_str(), d.time_s)).collect()
    }

    #[test]
    fn at_gives_the_newest_of_each_topic() {
        let recording = recording();
        assert_eq!(topics(&recording, -1.0), []);
        assert_eq!(topics(&recording, 0.15), [("truth/town", 0.0), ("view/0/pose", 0.1)]);
        assert_eq!(
            topics(&recording, 1e9),
            [("truth/town", 0.0), ("view/0/pose", 3.0 * 0.1), ("view/1/oem", 0.2)]
        );
        assert_eq!(topics(&recording, 0.3).len(), 3, "0.3 < 3 * 0.1 is the same step");
        assert_eq!(recording.duration_s(), 3.0 * 0.1);
    }

    #[test]
    fn a_page_gets_what_it_draws() {
        let recording = recording();
        let json = |agent, town| recording.at_json(0.2, agent, town);
        assert!(json(1, true).contains("view/1/oem") && json(1, true).contains("truth/town"));
        assert!(!json(0, true).contains("view/1/oem"));
        assert!(!json(0, false).contains("truth/town"));
        let meta: serde_json::Value = serde_json::from_str(&recording.to_json()).unwrap();
        assert_eq!(meta["times_s"].as_array().unwrap().len(), 4);
        assert_eq!(meta["topics"][2], "view/1/oem");
    }

    #[test]
    fn nothing_is_no_reason_to_panic() {
        let empty = Recording::new(Vec::new());
        assert_eq!((empty.duration_s(), empty.at(0.0).count()), (0.0, 0));
        assert!(empty.to_json().contains("null"));
    }
}
