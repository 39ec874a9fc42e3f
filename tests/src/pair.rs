//! Two agents (or more) and a post office, in the style of quinn-proto's `Pair`: no world, no
//! threads, a `time` that only the test moves, and a filter that decides what becomes of each letter.

use crate::hears::Hears;
use csat_agent::agent::{Event, SetMembershipAgent};
use csat_agent::config::AgentConfig;
use csat_proto::agent::Agent;
use csat_proto::command::YawCommand;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::{SimTime, Step};

/// A message for one receiver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Letter {
    /// The sender.
    pub src: AgentId,
    /// The receiver.
    pub dst: AgentId,
    /// Its number among the sender's messages.
    pub sequence: u64,
    /// When it was sent.
    pub sent: SimTime,
    /// The encoded envelope.
    pub bytes: Vec<u8>,
}

/// What becomes of a letter: one copy arrives after each of these delays, in seconds. None: lost.
/// Two: repeated. Different ones for different letters: reordered.
pub type Filter = Box<dyn FnMut(&Letter) -> Vec<f64>>;

/// Agents that hear each other through a [`Filter`].
pub struct Pair {
    /// Now.
    pub time: SimTime,
    /// k: the step of the last frames.
    pub step: Step,
    /// The agents, by index.
    pub agents: Vec<SetMembershipAgent>,
    /// Decides what becomes of letters.
    pub filter: Filter,
    /// Every event so far.
    pub events: Vec<(AgentId, Event)>,
    /// Commands not yet taken.
    pub commands: Vec<(AgentId, YawCommand)>,
    /// Every letter handed over, if [`Self::keep_letters`] was called.
    pub letters: Vec<Letter>,
    keeps_letters: bool,
    in_flight: Vec<(SimTime, Letter)>,
    period_s: f64,
}

/// Everything arrives at once.
pub fn perfect() -> Filter {
    Box::new(|_| vec![0.0])
}

/// Nothing arrives.
pub fn silence() -> Filter {
    Box::new(|_| Vec::new())
}

impl Pair {
    /// Agents 0, 1, … with perfect links.
    pub fn new(agents: Vec<SetMembershipAgent>) -> Self {
        let period_s = agents.first().map_or(0.5, |agent| agent.config().period_s);
        Self {
            time: SimTime(0),
            step: Step(0),
            agents,
            filter: perfect(),
            events: Vec::new(),
            commands: Vec::new(),
            letters: Vec::new(),
            keeps_letters: false,
            in_flight: Vec::new(),
            period_s,
        }
    }

    /// `count` agents of one configuration.
    pub fn of(config: &AgentConfig, count: u16) -> Self {
        let agent = |i| SetMembershipAgent::new(&AgentConfig { id: AgentId(i), ..config.clone() });
        Self::new((0..count).map(agent).collect())
    }

    /// Keeps a copy of every letter from now on.
    pub fn keep_letters(&mut self) {
        self.keeps_letters = true;
    }

    /// An agent by its index.
    pub fn agent(&self, index: usize) -> &SetMembershipAgent {
        &self.agents[index]
    }

    /// One step: time goes to the frames' step, every agent gets its frame, and all is settled
    /// before the next step begins.
    pub fn step(&mut self, frames: &[Frame]) {
        self.look(frames);
        self.drive();
    }

    /// Goes to the time of the frames and hands them out. `frames` may be fewer than agents: the
    /// others see nothing in this step.
    pub fn look(&mut self, frames: &[Frame]) {
        let Some(first) = frames.first() else { return };
        self.step = first.step;
        self.time = self.time_of(first.step);
        for (agent, frame) in self.agents.iter_mut().zip(frames) {
            agent.handle_frame(self.time, frame);
        }
    }

    /// Letters and timeouts, until nothing is left before the next step.
    pub fn drive(&mut self) {
        let end = self.time_of(Step(self.step.0 + 1));
        loop {
            self.collect();
            let arrivals = self.in_flight.iter().map(|(at, _)| *at);
            let timeouts = self.agents.iter().filter_map(|agent| agent.poll_timeout());
            let Some(due) = arrivals.chain(timeouts).min().filter(|&due| due < end) else { break };
            self.time = self.time.max(due);
            self.deliver();
            for agent in &mut self.agents {
                if agent.poll_timeout().is_some_and(|due| due <= self.time) {
                    agent.handle_timeout(self.time);
                }
            }
        }
    }

    /// An agent dies and comes back with its next incarnation and empty knowledge.
    pub fn restart(&mut self, index: usize) {
        let config = self.agents[index].config().clone();
        let incarnation = Incarnation(config.incarnation.0 + 1);
        self.agents[index] = SetMembershipAgent::new(&AgentConfig { incarnation, ..config });
    }

    /// The digests of all agents.
    pub fn digests(&self) -> Vec<u64> {
        self.agents.iter().map(Agent::digest).collect()
    }

    fn time_of(&self, step: Step) -> SimTime {
        SimTime::from_seconds(f64::from(step.0) * self.period_s)
    }

    /// Takes everything the agents have to say and asks the filter about each letter.
    fn collect(&mut self) {
        let ids = 0..self.agents.len() as u16;
        for (src, agent) in ids.clone().map(AgentId).zip(&mut self.agents) {
            self.events.extend(std::iter::from_fn(|| agent.poll_event()).map(|e| (src, e)));
            self.commands.extend(std::iter::from_fn(|| agent.poll_command()).map(|c| (src, c)));
            while let Some(transmit) = agent.poll_transmit() {
                for dst in ids.clone().map(AgentId).filter(|&dst| dst != src) {
                    let (sequence, bytes) = (transmit.sequence, transmit.bytes.clone());
                    let letter = Letter { src, dst, sequence, sent: self.time, bytes };
                    for delay_s in (self.filter)(&letter) {
                        self.in_flight.push((self.time.after(delay_s), letter.clone()));
                    }
                    if self.keeps_letters {
                        self.letters.push(letter);
                    }
                }
            }
        }
    }

    /// Delivers what is due, in the order of arrival.
    fn deliver(&mut self) {
        let now = self.time;
        let mut due: Vec<_> = self.in_flight.extract_if(.., |(at, _)| *at <= now).collect();
        due.sort_by_key(|(at, _)| *at);
        for (_, letter) in due {
            self.agents[usize::from(letter.dst.0)].hear(now, &letter.bytes);
        }
    }
}
