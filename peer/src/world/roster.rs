//! The processes that have joined, and which of them take part.
//!
//! A process joins by a query, then declares its liveliness token and says which others it hears. It
//! takes part once it and all that take part already hear each other: a publisher that does not know of
//! a subscription yet loses its first messages without a trace.

use std::collections::BTreeMap;
use std::time::Duration;

use csat_proto::control::{Join, PROTOCOL, Ready, Welcome};
use csat_proto::ids::AgentId;

use super::error::Awaited;
use super::port::JoinRequest;
use csat_mission::timing::Stopwatch;

/// How long a process that was welcomed may take to hold its token. Without the limit a process that died
/// meanwhile would keep its agent from others for good.
const TOKEN_LIMIT: Duration = Duration::from_secs(10);

/// The processes that have joined.
#[derive(Debug)]
pub struct Roster {
    welcome: Welcome,
    /// By agent.
    entries: Vec<Entry>,
    token_limit: Duration,
    /// Whether all agents' processes have taken part at once, as they do at the start.
    is_complete: bool,
}

/// The process of an agent.
#[derive(Debug, Clone, Default)]
struct Entry {
    /// The process that was welcomed last, until it is gone.
    process: Option<u64>,
    /// Since when it has been welcome without a token; `None` once it holds one. Zenoh reports the end
    /// only of a process that held one.
    tokenless: Option<Stopwatch>,
    /// Whether it takes part.
    is_admitted: bool,
    /// The agents that it hears, with their processes; `None` until it says so: it may not subscribe yet.
    heard: Option<BTreeMap<AgentId, u64>>,
}

/// Why the world refuses a process.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
enum JoinError {
    /// It has another version of the protocol.
    #[error(
        "{program} speaks version {protocol} of the protocol, this world version {PROTOCOL}: use the \
         same csat everywhere"
    )]
    Protocol { program: String, protocol: u32 },
    /// The mission has no such agent.
    #[error("there is no agent {agent} among {count}")]
    Unknown { agent: AgentId, count: usize },
    /// The agent has a process.
    #[error("agent {0} is flown by another process; expected another --id, or that one to end")]
    Taken(AgentId),
}

impl Roster {
    /// A roster of `count` agents without processes; a process that joins is told `welcome`.
    pub fn new(welcome: Welcome, count: usize) -> Self {
        let entries = vec![Entry::default(); count];
        Self { welcome, entries, token_limit: TOKEN_LIMIT, is_complete: false }
    }

    fn entry(&self, agent: AgentId) -> &Entry {
        &self.entries[usize::from(agent.0)]
    }

    fn agents(&self) -> impl Iterator<Item = AgentId> + use<> {
        (0..self.entries.len() as u16).map(AgentId)
    }

    /// The process that takes part as an agent.
    pub fn process(&self, agent: AgentId) -> Option<u64> {
        let entry = self.entries.get(usize::from(agent.0))?;
        entry.process.filter(|_| entry.is_admitted)
    }

    /// The process of each agent that takes part, by index.
    pub fn attendance(&self) -> Vec<Option<u64>> {
        self.agents().map(|agent| self.process(agent)).collect()
    }

    /// The agents whose processes take part.
    pub fn present(&self) -> impl Iterator<Item = AgentId> {
        self.agents().filter(|agent| self.process(*agent).is_some())
    }

    /// The agents without a process that takes part.
    fn missing(&self) -> Vec<AgentId> {
        self.agents().filter(|agent| self.process(*agent).is_none()).collect()
    }

    /// Whether any process has joined that is not gone, whether or not it takes part.
    pub fn has_processes(&self) -> bool {
        self.entries.iter().any(|entry| entry.process.is_some())
    }

    /// The agents that the world waits for before the mission, and for what: those without a process or,
    /// once all have one, those that do not take part. `None` when all take part.
    pub fn awaited(&self) -> Option<(Vec<AgentId>, Awaited)> {
        let missing = self.missing();
        let has_joined = |agent: &&AgentId| self.entry(**agent).process.is_some();
        if missing.is_empty() {
            None
        } else if missing.iter().all(|agent| has_joined(&agent)) {
            Some((missing, Awaited::Hearing))
        } else {
            let without = missing.iter().filter(|agent| !has_joined(agent)).copied();
            Some((without.collect(), Awaited::Join))
        }
    }

    /// Answers a process that asks to take part.
    pub fn join(&mut self, request: JoinRequest) {
        tracing::debug!(join = ?request.join, "asks to take part");
        match self.check(&request.join) {
            Ok(()) => {
                self.enter(&request.join);
                request.welcome(&self.welcome);
            }
            Err(error) => request.refuse(&error.to_string()),
        }
    }

    /// A process that asks twice keeps its entry.
    fn enter(&mut self, join: &Join) {
        let entry = &mut self.entries[usize::from(join.agent.0)];
        if entry.process != Some(join.process) {
            let (process, tokenless) = (Some(join.process), Some(Stopwatch::start()));
            *entry = Entry { process, tokenless, ..Entry::default() };
        }
    }

    fn check(&self, join: &Join) -> Result<(), JoinError> {
        let &Join { protocol, ref program, agent, process } = join;
        if protocol != PROTOCOL {
            return Err(JoinError::Protocol { program: program.clone(), protocol });
        }
        let count = self.entries.len();
        let entry = self.entries.get(usize::from(agent.0));
        let entry = entry.ok_or(JoinError::Unknown { agent, count })?;
        let is_abandoned =
            entry.tokenless.is_some_and(|since| since.left(self.token_limit).is_zero());
        match entry.process {
            Some(other) if other != process && !is_abandoned => Err(JoinError::Taken(agent)),
            _ => Ok(()),
        }
    }

    /// A process says which others it hears.
    pub fn ready(&mut self, agent: AgentId, ready: &Ready) {
        tracing::debug!(%agent, ?ready, "hears");
        let entry = self.entries.get_mut(usize::from(agent.0));
        if let Some(entry) = entry.filter(|entry| entry.process == Some(ready.process)) {
            entry.heard = Some(ready.heard.iter().copied().collect());
        }
    }

    /// The process of an agent holds its token.
    pub fn alive(&mut self, agent: AgentId) {
        if let Some(entry) = self.entries.get_mut(usize::from(agent.0)) {
            entry.tokenless = None;
        }
    }

    /// The process of an agent is gone. Returns whether it took part.
    pub fn gone(&mut self, agent: AgentId) -> bool {
        tracing::debug!(%agent, "is gone");
        let Some(entry) = self.entries.get_mut(usize::from(agent.0)) else { return false };
        std::mem::take(entry).is_admitted
    }

    /// Admits the processes that hear and are heard by all that take part: at the start all at once or
    /// none, then each.
    pub fn admit(&mut self) {
        if !self.is_complete {
            let all: Vec<AgentId> = self.agents().collect();
            self.is_complete = all.iter().all(|agent| self.may_take_part(*agent, &all));
            if self.is_complete {
                self.entries.iter_mut().for_each(|entry| entry.is_admitted = true);
            }
            return;
        }
        for agent in self.missing() {
            let others: Vec<AgentId> = self.present().collect();
            self.entries[usize::from(agent.0)].is_admitted = self.may_take_part(agent, &others);
        }
    }

    /// Whether an agent's process subscribes, and hears and is heard by these others.
    fn may_take_part(&self, agent: AgentId, others: &[AgentId]) -> bool {
        let entry = self.entry(agent);
        let mut others = others.iter().filter(|other| **other != agent);
        entry.process.is_some()
            && entry.heard.is_some()
            && others.all(|other| self.hears(agent, *other) && self.hears(*other, agent))
    }

    /// Whether the process of `a` hears the present process of `b`.
    fn hears(&self, a: AgentId, b: AgentId) -> bool {
        let process = self.entry(b).process;
        let heard = self.entry(a).heard.as_ref();
        process.is_some() && heard.and_then(|heard| heard.get(&b)).copied() == process
    }
}

#[cfg(test)]
mod tests {
    use csat_proto::control::Pace;
    use csat_proto::ids::RunId;

    use super::*;

    fn join_as(agent: u16, process: u64) -> Join {
        let program = "test".to_owned();
        Join { protocol: PROTOCOL, program, agent: AgentId(agent), process }
    }

    fn join(process: u64) -> Join {
        join_as(0, process)
    }

    fn roster(count: usize) -> Roster {
        let welcome = Welcome {
            protocol: PROTOCOL,
            run: RunId(1),
            world: 9,
            name: "test".to_owned(),
            scenario: String::new(),
            map: None,
            pace: Pace::Lockstep,
        };
        Roster::new(welcome, count)
    }

    #[test]
    fn a_process_without_a_token_loses_its_entry() {
        let mut roster = roster(1);
        roster.enter(&join(1));
        assert!(roster.check(&join(2)).is_err(), "it may be about to declare its token");
        assert_eq!(roster.check(&join(1)), Ok(()));
        roster.token_limit = Duration::ZERO;
        assert_eq!(roster.check(&join(2)), Ok(()));
        roster.enter(&join(2));
        roster.alive(AgentId(0));
        assert!(roster.check(&join(3)).is_err());
        roster.gone(AgentId(0));
        assert_eq!(roster.check(&join(3)), Ok(()));
    }

    /// The process of UAV `agent` says that it hears these.
    fn ready(roster: &mut Roster, agent: u16, process: u64, heard: &[(u16, u64)]) {
        let heard = heard.iter().map(|(agent, process)| (AgentId(*agent), *process)).collect();
        roster.ready(AgentId(agent), &Ready { process, heard });
        roster.admit();
    }

    #[test]
    fn a_process_that_does_not_subscribe_yet_takes_no_part() {
        let mut alone = roster(1);
        alone.enter(&join(7));
        alone.admit();
        assert_eq!(alone.attendance(), [None], "its first frame would be lost");
        ready(&mut alone, 0, 7, &[]);
        assert_eq!(alone.attendance(), [Some(7)]);
    }

    #[test]
    fn all_take_part_at_once_and_then_each_that_comes_back() {
        let mut roster = roster(2);
        for agent in [0, 1] {
            roster.enter(&join_as(agent, 10 + u64::from(agent)));
        }
        ready(&mut roster, 0, 10, &[(1, 11)]);
        assert_eq!(roster.attendance(), [None, None]);
        ready(&mut roster, 1, 11, &[(0, 10)]);
        assert_eq!(roster.attendance(), [Some(10), Some(11)]);
        // Both die: each takes part again as soon as it can.
        roster.gone(AgentId(0));
        roster.gone(AgentId(1));
        roster.enter(&join_as(1, 21));
        ready(&mut roster, 1, 21, &[]);
        assert_eq!(roster.attendance(), [None, Some(21)]);
        roster.enter(&join_as(0, 20));
        ready(&mut roster, 0, 20, &[]);
        assert_eq!(roster.attendance(), [None, Some(21)], "it does not hear UAV 1 yet");
        ready(&mut roster, 0, 20, &[(1, 21)]);
        assert_eq!(roster.attendance(), [None, Some(21)], "UAV 1 does not hear it yet");
        ready(&mut roster, 1, 21, &[(0, 20)]);
        assert_eq!(roster.attendance(), [Some(20), Some(21)]);
    }
}
