//! Key expressions: where in Zenoh's space of names what is said (docs/topics.md).
//!
//! Everything of a run lies under `csat/{run}/`. Agents' messages are under `link`, what a world and
//! its agents' processes need to fly under `uav`, `clock` and `join`, mirrors for people under `view`
//! and `truth` (docs/topics.md), who is there under `alive`, and what late joiners ask for under
//! `state`.

use crate::ids::{AgentId, ChannelId, RunId};

/// The names of one run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keys(pub RunId);

impl Keys {
    /// A name below `csat/{run}/`.
    pub fn of(self, name: &str) -> String {
        format!("csat/{}/{name}", self.0)
    }

    /// Messages of `src` on a radio.
    pub fn link(self, src: AgentId, channel: ChannelId) -> String {
        self.of(&format!("link/{src}/{channel}"))
    }

    /// Signs of life of `src` on the way that its messages take, before it flies.
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

    /// An agent's answers: when it is done, and what it commands.
    pub fn command(self, agent: AgentId) -> String {
        self.of(&format!("uav/{agent}/command"))
    }

    /// Whom an agent's process hears.
    pub fn ready(self, agent: AgentId) -> String {
        self.of(&format!("uav/{agent}/ready"))
    }

    /// What an agent tells the monitor and the recorder.
    pub fn report(self, agent: AgentId) -> String {
        self.of(&format!("uav/{agent}/report"))
    }

    /// What the world says to all processes.
    pub fn clock(self) -> String {
        self.of("clock")
    }

    /// Where an agent's process asks the world to take part.
    pub fn join(self, agent: AgentId) -> String {
        self.of(&format!("join/{agent}"))
    }

    /// The token of an agent's process.
    pub fn alive(self, agent: AgentId) -> String {
        self.of(&format!("alive/{agent}"))
    }

    /// The token of the world's process.
    pub fn alive_world(self) -> String {
        self.of("alive/world")
    }

    /// What an agent shows people.
    pub fn view(self, agent: AgentId, topic: &str) -> String {
        self.of(&format!("view/{agent}/{topic}"))
    }

    /// What the world shows people.
    pub fn truth(self, topic: &str) -> String {
        self.of(&format!("truth/{topic}"))
    }

    /// What an agent answers to whoever joins late.
    pub fn state(self, agent: AgentId, topic: &str) -> String {
        self.of(&format!("state/{agent}/{topic}"))
    }
}

/// The run and the rest of a key: `csat/7/view/0/pose` is `(7, "view/0/pose")`.
pub fn split(key: &str) -> Option<(RunId, &str)> {
    let (run, name) = key.strip_prefix("csat/")?.split_once('/')?;
    Some((RunId(run.parse().ok()?), name))
}

/// The agent and the rest of a name: `link/3/probe` below `link` is `(3, "probe")`.
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
