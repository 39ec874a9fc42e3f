//! Two agents (or more) and their links, in the style of quinn-proto's `Pair`: no world, no threads,
//! a `time` that only the test advances, and a filter that decides the fate of each packet.

use crate::hears::Hears;
use csat_agent::agent::{Event, SetMembershipAgent};
use csat_agent::config::AgentConfig;
use csat_proto::agent::Agent;
use csat_proto::command::Command;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::{SimTime, Step};

/// A message for one receiver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
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

/// The fate of a packet: one copy arrives after each of these delays, seconds. Without a delay the
/// packet is lost, with two it is repeated, and with different delays packets are reordered.
pub type Filter = Box<dyn FnMut(&Packet) -> Vec<f64>>;

/// Agents that hear each other through a [`Filter`].
pub struct Pair {
    /// The current time.
    pub time: SimTime,
    /// k: the step of the last frames.
    pub step: Step,
    /// The agents, by index.
    pub agents: Vec<SetMembershipAgent>,
    /// Decides the fate of packets.
    pub filter: Filter,
    /// Every event so far.
    pub events: Vec<(AgentId, Event)>,
    /// Commands not yet taken.
    pub commands: Vec<(AgentId, Command)>,
    /// Every packet that was sent since [`Self::keep_packets`] was called.
    pub packets: Vec<Packet>,
    keeps_letters: bool,
    in_flight: Vec<(SimTime, Packet)>,
    period_s: f64,
}

/// Every packet arrives at once.
pub fn perfect() -> Filter {
    Box::new(|_| vec![0.0])
}

/// No packet arrives.
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
            packets: Vec::new(),
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

    /// Keeps a copy of every packet from now on.
    pub fn keep_packets(&mut self) {
        self.keeps_letters = true;
    }

    /// An agent by its index.
    pub fn agent(&self, index: usize) -> &SetMembershipAgent {
        &self.agents[index]
    }

    /// One step: the time is that of the frames, every agent gets its frame, and all packets and
    /// timeouts before the next step are handled.
    pub fn step(&mut self, frames: &[Frame]) {
        self.look(frames);
        self.drive();
    }

    /// Advances to the time of the frames and hands them to the agents. There may be fewer frames
    /// than agents; agents without a frame get none in this step.
    pub fn look(&mut self, frames: &[Frame]) {
        let Some(first) = frames.first() else { return };
        self.step = first.step;
        self.time = self.time_of(first.step);
        for (agent, frame) in self.agents.iter_mut().zip(frames) {
            agent.handle_frame(self.time, frame);
        }
    }

    /// Handles packets and timeouts until none is left before the next step.
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

    /// Restarts an agent with its next incarnation and without knowledge.
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

    /// Collects the messages of all agents and applies the filter to each packet.
    fn collect(&mut self) {
        let ids = 0..self.agents.len() as u16;
        for (src, agent) in ids.clone().map(AgentId).zip(&mut self.agents) {
            self.events.extend(std::iter::from_fn(|| agent.poll_event()).map(|e| (src, e)));
            self.commands.extend(std::iter::from_fn(|| agent.poll_command()).map(|c| (src, c)));
            while let Some(transmit) = agent.poll_transmit() {
                for dst in ids.clone().map(AgentId).filter(|&dst| dst != src) {
                    let (sequence, bytes) = (transmit.sequence, transmit.bytes.clone());
                    let packet = Packet { src, dst, sequence, sent: self.time, bytes };
                    for delay_s in (self.filter)(&packet) {
                        self.in_flight.push((self.time.after(delay_s), packet.clone()));
                    }
                    if self.keeps_letters {
                        self.packets.push(packet);
                    }
                }
            }
        }
    }

    /// Delivers the packets that are due, in the order of arrival.
    fn deliver(&mut self) {
        let now = self.time;
        let mut due: Vec<_> = self.in_flight.extract_if(.., |(at, _)| *at <= now).collect();
        due.sort_by_key(|(at, _)| *at);
        for (_, packet) in due {
            self.agents[usize::from(packet.dst.0)].hear(now, &packet.bytes);
        }
    }
}
