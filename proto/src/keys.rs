//! The Zenoh key expressions of a run (docs/topics.md).
//!
//! All keys of a run are under `csat/{run}/`: the agents' messages under `link`, the protocol between
//! the world and the agents' processes under `uav`, `clock` and `join`, what users see under `view`
//! and `truth`, liveliness tokens under `alive`, and the answers to agents that join late under
//! `state`.

use crate::ids::{AgentId, ChannelId, RunId};

/// The keys of one run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keys(pub RunId);

impl Keys {
    /// A key below `csat/{run}/`.
    pub fn of(self, name: &str) -> String {
        format!("csat/{}/{name}", self.0)
    }

    /// Messages of `src` on a radio.
    pub fn link(self, src: AgentId, channel: ChannelId) -> String {
        self.of(&format!("link/{src}/{channel}"))
    }

    /// Probes of `src` on the path of its messages, before it flies.
    pub fn probe(self, src: AgentId) -> String {
        self.of(&format!("link/{src}/probe"))
    }

    /// All messages and probes of all agents.
    pub fn links(self) -> String {
        self.of("link/*/*")
    }

    /// Frames for an agent.
    pub fn frame(self, agent: AgentId) -> String {
        self.of(&format!("uav/{agent}/frame"))
    }

    /// When an agent is done with a turn, and its commands.
    pub fn command(self, agent: AgentId) -> String {
        self.of(&format!("uav/{agent}/command"))
    }

    /// Which processes an agent's process hears.
    pub fn ready(self, agent: AgentId) -> String {
        self.of(&format!("uav/{agent}/ready"))
    }

    /// The reports of an agent to the monitor and the recorder.
    pub fn report(self, agent: AgentId) -> String {
        self.of(&format!("uav/{agent}/report"))
    }

    /// The orders of the world to all processes.
    pub fn clock(self) -> String {
        self.of("clock")
    }

    /// Where an agent's process asks the world to take part.
    pub fn join(self, agent: AgentId) -> String {
        self.of(&format!("join/{agent}"))
    }

    /// The liveliness token of an agent's process.
    pub fn alive(self, agent: AgentId) -> String {
        self.of(&format!("alive/{agent}"))
    }

    /// The liveliness token of the world's process.
    pub fn alive_world(self) -> String {
        self.of("alive/world")
    }

    /// What users see of an agent.
    pub fn view(self, agent: AgentId, topic: &str) -> String {
        self.of(&format!("view/{agent}/{topic}"))
    }

    /// What users see of the world.
    pub fn truth(self, topic: &str) -> String {
        self.of(&format!("truth/{topic}"))
    }

    /// The answers of an agent to agents that join late.
    pub fn state(self, agent: AgentId, topic: &str) -> String {
        self.of(&format!("state/{agent}/{topic}"))
    }
}

/// The run and the rest of a key: `csat/7/view/0/pose` is `(7, "view/0/pose")`.
pub fn split(key: &str) -> Option<(RunId, &str)> {
    let (run, name) = key.strip_prefix("csat/")?.split_once('/')?;
    Some((RunId(run.parse().ok()?), name))
}

/// The agent and the rest of a key: `link/3/probe` below `link` is `(3, "probe")`.
pub fn split_agent<'a>(name: &'a str, below: &str) -> Option<(AgentId, &'a str)> {
    let rest = name.strip_prefix(below)?.strip_prefix('/')?;
    let (agent, rest) = rest.split_once('/').unwrap_or((rest, ""));
    Some((AgentId(agent.parse().ok()?), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_come_apart_as_they_were_made() {
        let key = Keys(RunId(7)).link(AgentId(3), ChannelId(1));
        assert_eq!(key, "csat/7/link/3/1");
        let (run, name) = split(&key).unwrap();
        assert_eq!((run, split_agent(name, "link")), (RunId(7), Some((AgentId(3), "1"))));
        assert_eq!(split_agent("alive/4", "alive"), Some((AgentId(4), "")));
    }

    #[test]
    fn other_keys_are_not_ours() {
        for key in ["", "csat", "csat/7", "csat/x/clock", "other/7/clock", "csat/-1/clock"] {
            assert_eq!(split(key), None, "{key}");
        }
        for name in ["link", "link/x/1", "alive/world", "view/1"] {
            assert_eq!(split_agent(name, "link").or(split_agent(name, "alive")), None, "{name}");
        }
    }
}
