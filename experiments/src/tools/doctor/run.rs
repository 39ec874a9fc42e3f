//! What was heard of each run.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::control::Order;
use csat_proto::keys::{split, split_agent};
use serde::Serialize;

use crate::tools::ear;
use crate::tools::rates::Traffic;

/// How many keys are remembered by themselves.
const MAX_KEYS: usize = 100_000;

/// Everything that was heard.
#[derive(Debug, Default)]
pub struct Heard {
    /// How many others there are.
    pub peers: usize,
    /// How long was listened, seconds.
    pub seconds: f64,
    /// What came too fast.
    pub missed: u64,
    /// By number.
    pub runs: BTreeMap<u64, Run>,
    /// Every key that something came on.
    pub keys: BTreeSet<String>,
}

/// A run, as far as it was heard.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Run {
    /// Its number, the mission's seed.
    pub run: u64,
    /// Whether its world is alive.
    pub world: bool,
    /// The agents whose processes are alive.
    pub agents: BTreeSet<u16>,
    /// How many of its agents are UAVs, if that is known; the others are stations.
    pub uavs: Option<u16>,
    /// How many agents it has, if that is known.
    pub expected: Option<u16>,
    /// How many orders its world gave.
    pub orders: u64,
    /// The step of the last one.
    pub step: Option<u32>,
    /// Why it ended, if it did.
    pub ended: Option<String>,
    /// What came, by the first part of the key's name.
    pub topics: BTreeMap<String, Traffic>,
    /// Agents that frames were sent to.
    #[serde(skip)]
    pub frames: BTreeSet<u16>,
    /// Agents that showed something.
    pub viewed: BTreeSet<u16>,
}

impl Heard {
    /// Takes down a sample.
    pub fn add(&mut self, sample: &ear::Heard) {
        if self.keys.len() < MAX_KEYS && !self.keys.contains(&sample.key) {
            self.keys.insert(sample.key.clone());
        }
        let Some((run, name)) = split(&sample.key) else { return };
        let run = self.run(run.0);
        let topic = name.split('/').next().unwrap_or_default();
        run.topics.entry(topic.to_owned()).or_default().add(sample.bytes);
        if name == "clock" {
            run.obey(&sample.body);
        }
        if let Some((agent, "frame")) = split_agent(name, "uav") {
            run.frames.insert(agent.0);
        }
        if let Some((agent, _)) = split_agent(name, "view") {
            run.viewed.insert(agent.0);
        }
    }

    /// Takes down a token.
    pub fn add_token(&mut self, key: &str) {
        let Some((run, name)) = split(key) else { return };
        match (name, split_agent(name, "alive")) {
            ("alive/world", _) => self.run(run.0).world = true,
            (_, Some((agent, ""))) => {
                self.run(run.0).agents.insert(agent.0);
            }
            _ => {}
        }
    }

    fn run(&mut self, run: u64) -> &mut Run {
        self.runs.entry(run).or_insert_with(|| Run { run, ..Run::default() })
    }
}

impl Run {
    fn obey(&mut self, order: &[u8]) {
        self.orders += 1;
        match serde_json::from_slice(order) {
            Ok(Order::Turn { step, .. } | Order::Close { step, .. } | Order::Show { step }) => {
                self.step = Some(step.0);
            }
            Ok(Order::End { reason }) => self.ended = Some(reason),
            Err(_) => {}
        }
    }

    /// How many agents it has, by the frames that its world sends: to all, even those that are gone.
    pub fn flown(&self) -> Option<u16> {
        self.frames.last().map(|last| last.saturating_add(1))
    }

    /// Agents whose processes should be alive; as far as is known, those below one that is.
    pub fn missing(&self) -> Vec<u16> {
        let known = self.agents.last().map_or(0, |last| last.saturating_add(1));
        (0..self.expected.unwrap_or(known)).filter(|agent| !self.agents.contains(agent)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(samples: &[(&str, &str)], tokens: &[&str]) -> Heard {
        let mut heard = Heard::default();
        for (key, body) in samples {
            heard.add(&ear::Heard {
                key: (*key).to_owned(),
                bytes: body.len(),
                body: body.as_bytes().to_vec(),
                ..ear::Heard::default()
            });
        }
        tokens.iter().for_each(|key| heard.add_token(key));
        heard
    }

    #[test]
    fn samples_and_tokens_are_sorted_by_run() {
        let heard = heard(
            &[
                ("csat/1/clock", r#"{"order":"close","step":7,"full":false}"#),
                ("csat/1/clock", r#"{"order":"show","step":7}"#),
                ("csat/1/clock", "?"),
                ("csat/1/uav/3/frame", ""),
                ("csat/1/view/0/pose", "{}"),
                ("csat/2/clock", r#"{"order":"end","reason":"enough"}"#),
                ("csat/x/clock", ""),
            ],
            &["csat/1/alive/world", "csat/1/alive/0", "csat/1/alive/2", "csat/3/alive/x", "x/1/y"],
        );
        assert_eq!(heard.runs.keys().copied().collect::<Vec<_>>(), [1, 2]);
        let run = &heard.runs[&1];
        assert_eq!((run.world, run.orders, run.step), (true, 3, Some(7)));
        assert_eq!(run.topics["view"], Traffic { messages: 1, bytes: 2 });
        assert_eq!((run.flown(), run.missing()), (Some(4), vec![1]));
        let told = Run { expected: run.flown(), ..run.clone() };
        assert_eq!(told.missing(), [1, 3]);
        assert_eq!(heard.runs[&2].ended.as_deref(), Some("enough"));
        assert_eq!(heard.keys.len(), 5);
        assert_eq!(Run::default().missing(), [0; 0]);
    }
}
