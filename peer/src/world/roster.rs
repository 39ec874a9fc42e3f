//! Which processes there are, and whether all of them hear each other.
//!
//! A process joins by a query, then declares itself alive and says which others it hears. It takes
//! part once it and all that take part already hear each other: a subscription that the other side
//! does not know of yet would lose the first messages without a trace.

use std::collections::BTreeMap;
use std::time::Duration;

use csat_proto::control::{Join, PROTOCOL, Ready, Welcome};
use csat_proto::ids::AgentId;

use super::port::JoinQuery;
use csat_mission::timing::Stopwatch;

/// How long a process that was welcomed may take to hold its token. One that died meanwhile would
/// keep its place for good.
const TOKEN_LIMIT: Duration = Duration::from_secs(10);

/// Which processes there are.
#[derive(Debug)]
pub struct Roster {
    welcome: Welcome,
    nodes: Vec<Place>,
    token_limit: Duration,
    /// Whether all have taken part at once, as they do at the start.
    is_complete: bool,
}

/// An agent's place in the roster.
#[derive(Debug, Clone, Default)]
struct Place {
    /// The process that was welcomed last, until it is gone.
    process: Option<u64>,
    /// Until it holds its token: since when it has been welcome. Only who held one can be missed.
    tokenless: Option<Stopwatch>,
    /// Whether it takes part.
    is_admitted: bool,
    /// Whom it hears, with their processes; `None` until it says so: it may not listen yet.
    heard: Option<BTreeMap<AgentId, u64>>,
}

impl Roster {
    /// A roster of `count` empty places; whoever joins is told `welcome`.
    pub fn new(welcome: Welcome, count: usize) -> Self {
        let nodes = vec![Place::default(); count];
        Self { welcome, nodes, token_limit: TOKEN_LIMIT, is_complete: false }
    }

    /// How many agents there are to be.
    pub fn count(&self) -> usize {
        self.nodes.len()
    }

    /// The process that takes part as an agent.
    pub fn process(&self, agent: AgentId) -> Option<u64> {
        let node = self.nodes.get(usize::from(agent.0))?;
        node.process.filter(|_| node.is_admitted)
    }

    /// The agents whose processes take part.
    pub fn present(&self) -> impl Iterator<Item = AgentId> {
        let ids = (0..self.nodes.len()).map(|index| AgentId(index as u16));
        ids.filter(|agent| self.process(*agent).is_some())
    }

    /// Whether any process has joined that is not gone, whether or not it takes part.
    pub fn is_joined(&self) -> bool {
        self.nodes.iter().any(|node| node.process.is_some())
    }

    /// The process of each agent that takes part, by index.
    pub fn attendance(&self) -> Vec<Option<u64>> {
        self.nodes.iter().map(|node| node.process.filter(|_| node.is_admitted)).collect()
    }

    /// The agents without a process that takes part.
    pub fn missing(&self) -> Vec<AgentId> {
        let ids = (0..self.nodes.len()).map(|index| AgentId(index as u16));
        ids.filter(|agent| self.process(*agent).is_none()).collect()
    }

    /// The agents that are waited for before the mission: those without a process, or, once all have
    /// one, those that do not take part.
    pub fn awaited(&self) -> Vec<AgentId> {
        let mut missing = self.missing();
        let has_joined = |agent: &AgentId| self.nodes[usize::from(agent.0)].process.is_some();
        if !missing.iter().all(has_joined) {
            missing.retain(|agent| !has_joined(agent));
        }
        missing
    }

    /// What is still to happen, for people.
    pub fn what_is_missing(&self, missing: &[AgentId]) -> String {
        let has_joined = |agent: &AgentId| self.nodes[usize::from(agent.0)].process.is_some();
        if missing.iter().all(has_joined) {
            "hear all others: a process may be unable to connect to another".to_owned()
        } else {
            "join: `csat agent --id N --connect ENDPOINT` starts one".to_owned()
        }
    }

    /// Answers a process that wants to take part.
    pub fn join(&mut self, query: JoinQuery) {
        tracing::debug!(join = ?query.join, "wants to take part");
        match self.judge(&query.join) {
            Ok(()) => {
                self.node(&query.join);
                query.welcome(&self.welcome);
            }
            Err(reason) => query.refuse(&reason),
        }
    }

    /// The same process may ask twice: its token is its token.
    fn node(&mut self, join: &Join) {
        let place = &mut self.nodes[usize::from(join.agent.0)];
        if place.process != Some(join.process) {
            let (process, tokenless) = (Some(join.process), Some(Stopwatch::start()));
            *place = Place { process, tokenless, ..Place::default() };
        }
    }

    fn judge(&self, join: &Join) -> Result<(), String> {
        if join.protocol != PROTOCOL {
            return Err(format!(
                "{} speaks version {} of the protocol, this world version {PROTOCOL}: use the same \
                 csat everywhere",
                join.program, join.protocol
            ));
        }
        let place = self.nodes.get(usize::from(join.agent.0)).ok_or_else(|| {
            format!("there is no agent {} among {}", join.agent, self.nodes.len())
        })?;
        let is_abandoned =
            place.tokenless.is_some_and(|since| since.left(self.token_limit).is_zero());
        match place.process {
            Some(process) if process != join.process && !is_abandoned => Err(format!(
                "agent {} is flown by another process; expected another --id, or that one to end",
                join.agent
            )),
            _ => Ok(()),
        }
    }

    /// A process says whom it hears.
    pub fn ready(&mut self, agent: AgentId, ready: &Ready) {
        tracing::debug!(%agent, ?ready, "hears");
        let place = self.nodes.get_mut(usize::from(agent.0));
        if let Some(place) = place.filter(|place| place.process == Some(ready.process)) {
            place.heard = Some(ready.heard.iter().copied().collect());
        }
    }

    /// The process that flies an agent holds its token.
    pub fn here(&mut self, agent: AgentId) {
        if let Some(place) = self.nodes.get_mut(usize::from(agent.0)) {
            place.tokenless = None;
        }
    }

    /// A process is gone. Tells whether it took part.
    pub fn gone(&mut self, agent: AgentId) -> bool {
        tracing::debug!(%agent, "is gone");
        let Some(place) = self.nodes.get_mut(usize::from(agent.0)) else { return false };
        std::mem::take(place).is_admitted
    }

    /// Lets take part whoever listens, and hears and is heard by all that do.
    pub fn admit(&mut self) {
        if !self.is_complete {
            // At the start all take part at once, or none does.
            let all: Vec<AgentId> = (0..self.nodes.len() as u16).map(AgentId).collect();
            self.is_complete = all.iter().all(|agent| self.may_join(*agent, &all));
            if self.is_complete {
                self.nodes.iter_mut().for_each(|place| place.is_admitted = true);
            }
            return;
        }
        for agent in self.missing() {
            let others: Vec<AgentId> = self.present().collect();
            self.nodes[usize::from(agent.0)].is_admitted = self.may_join(agent, &others);
        }
    }

    /// Whether an agent's process listens, and hears and is heard by these others.
    fn may_join(&self, agent: AgentId, others: &[AgentId]) -> bool {
        let place = &self.nodes[usize::from(agent.0)];
        let mut others = others.iter().filter(|other| **other != agent);
        place.process.is_some()
            && place.heard.is_some()
            && others.all(|other| self.hear_each_other(agent, *other))
    }

    fn hear_each_other(&self, a: AgentId, b: AgentId) -> bool {
        let hears = |a: AgentId, b: AgentId| {
            let process = self.nodes[usize::from(b.0)].process;
            let heard = self.nodes[usize::from(a.0)].heard.as_ref();
            process.is_some() && heard.and_then(|heard| heard.get(&b)).copied() == process
        };
        hears(a, b) && hears(b, a)
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
    fn who_dies_before_it_holds_a_token_loses_its_place() {
        let mut roster = roster(1);
        roster.node(&join(1));
        assert!(roster.judge(&join(2)).is_err(), "it may be about to declare it");
        assert_eq!(roster.judge(&join(1)), Ok(()));
        roster.token_limit = Duration::ZERO;
        assert_eq!(roster.judge(&join(2)), Ok(()));
        roster.node(&join(2));
        roster.here(AgentId(0));
        assert!(roster.judge(&join(3)).is_err());
        roster.gone(AgentId(0));
        assert_eq!(roster.judge(&join(3)), Ok(()));
    }

    /// The process of UAV `agent` says that it listens and hears these.
    fn ready(roster: &mut Roster, agent: u16, process: u64, heard: &[(u16, u64)]) {
        let heard = heard.iter().map(|(agent, process)| (AgentId(*agent), *process)).collect();
        roster.ready(AgentId(agent), &Ready { process, heard });
        roster.admit();
    }

    #[test]
    fn who_does_not_listen_yet_takes_no_part() {
        let mut alone = roster(1);
        alone.node(&join(7));
        alone.admit();
        assert_eq!(alone.attendance(), [None], "its first frame would be lost");
        ready(&mut alone, 0, 7, &[]);
        assert_eq!(alone.attendance(), [Some(7)]);
    }

    #[test]
    fn all_take_part_at_once_and_then_each_that_comes_back() {
        let mut roster = roster(2);
        for agent in [0, 1] {
            roster.node(&join_as(agent, 10 + u64::from(agent)));
        }
        ready(&mut roster, 0, 10, &[(1, 11)]);
        assert_eq!(roster.attendance(), [None, None]);
        ready(&mut roster, 1, 11, &[(0, 10)]);
        assert_eq!(roster.attendance(), [Some(10), Some(11)]);
        // Both die: each is back as soon as it can be.
        roster.gone(AgentId(0));
        roster.gone(AgentId(1));
        roster.node(&join_as(1, 21));
        ready(&mut roster, 1, 21, &[]);
        assert_eq!(roster.attendance(), [None, Some(21)]);
        roster.node(&join_as(0, 20));
        ready(&mut roster, 0, 20, &[]);
        assert_eq!(roster.attendance(), [None, Some(21)], "it does not hear UAV 1 yet");
        ready(&mut roster, 0, 20, &[(1, 21)]);
        assert_eq!(roster.attendance(), [None, Some(21)], "UAV 1 does not hear it yet");
        ready(&mut roster, 1, 21, &[(0, 20)]);
        assert_eq!(roster.attendance(), [Some(20), Some(21)]);
    }
}
