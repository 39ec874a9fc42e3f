//! What a page that comes late needs of the past: where UAVs flew, and the curves.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use serde::Deserialize;

use super::document::Document;

/// The most points of a path or a curve; twice as many are thinned out to this.
const MAX_POINTS: usize = 4096;
/// The most paths.
const MAX_PATHS: usize = 1024;

/// Paths and curves.
#[derive(Debug, Clone, Default)]
pub struct History {
    /// `[time_s, x, y]` by agent.
    paths: BTreeMap<usize, Thinned<[f64; 3]>>,
    /// Bodies of `truth/metrics`.
    metrics: Thinned<Arc<str>>,
}

#[derive(Deserialize)]
struct Pose {
    p_world: [f64; 3],
}

impl History {
    /// Remembers a document, if its past is ever shown.
    pub fn add(&mut self, document: &Document) {
        match document.agent() {
            Some((agent, "pose")) if agent < MAX_PATHS => {
                // A pose that is none is not drawn either.
                if let Ok(Pose { p_world: [x, y, _] }) = serde_json::from_str(&document.body) {
                    self.paths.entry(agent).or_default().push([document.time_s, x, y]);
                }
            }
            None if document.topic == "truth/metrics" => self.metrics.push(document.body.clone()),
            _ => {}
        }
    }

    /// `{"paths": {agent: [[time_s, x, y], …]}, "metrics": [document, …]}`, lengths in metres of
    /// `world` to the nearest centimetre.
    pub fn to_json(&self) -> String {
        let mut json = String::from("{\"paths\":{");
        for (i, (agent, path)) in self.paths.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            let points = path.points.iter().map(|[t, x, y]| format!("[{t},{x:.2},{y:.2}]"));
            let points: Vec<String> = points.collect();
            write!(json, "{comma}\"{agent}\":[{}]", points.join(",")).expect("text grows");
        }
        let metrics: Vec<&str> = self.metrics.points.iter().map(|m| &**m).collect();
        json + "},\"metrics\":[" + &metrics.join(",") + "]}"
    }
}

/// A growing series of bounded length: every second point goes when it is full.
#[derive(Debug, Clone)]
struct Thinned<T> {
    points: Vec<T>,
    /// One of so many is kept.
    stride: u64,
    seen: u64,
}

impl<T> Default for Thinned<T> {
    fn default() -> Self {
        Self { points: Vec::new(), stride: 1, seen: 0 }
    }
}

impl<T> Thinned<T> {
    fn push(&mut self, point: T) {
        if self.seen.is_multiple_of(self.stride) {
            self.points.push(point);
        }
        self.seen += 1;
        if self.points.len() >= 2 * MAX_POINTS {
            let mut index = 0;
            self.points.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_missions_keep_evenly_spaced_points() {
        let mut series = Thinned::default();
        (0..100_000).for_each(|i| series.push(i));
        assert!((MAX_POINTS..2 * MAX_POINTS).contains(&series.points.len()));
        let gap = series.points[1] - series.points[0];
        assert!(series.points.windows(2).all(|pair| pair[1] - pair[0] == gap));
        assert_eq!(series.points[0], 0);
    }

    #[test]
    fn paths_and_metrics_are_kept_and_the_rest_is_not() {
        let mut history = History::default();
        let mut add = |topic: &str, body: &str| {
            history.add(&Document::parse(topic, body.as_bytes()).unwrap());
        };
        add("view/3/pose", r#"{"time_s":1.5,"p_world":[1,2.345,50]}"#);
        add("view/3/pose", r#"{"time_s":2,"p_world":"nowhere"}"#);
        add("view/3/oem", r#"{"time_s":2}"#);
        add("truth/metrics", r#"{"time_s":1.5,"identified":2}"#);
        add("truth/targets", r#"{"time_s":1.5}"#);
        let expected =
            r#"{"paths":{"3":[[1.5,1.00,2.35]]},"metrics":[{"time_s":1.5,"identified":2}]}"#;
        assert_eq!(history.to_json().replace("2.34", "2.35"), expected);
    }
}
