//! A node: one agent, and the links to it.
//!
//! A node does no I/O. In a mission of one process, [`crate::local`] drives all nodes; in a fleet of processes,
//! each process drives its own. The same calls in the same simulated order give the same results, in one
//! process or in many.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use csat_netem::fate::Sent;
use csat_netem::link::{Arrival, Links};
use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::Pose;
use csat_proto::command::Command;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::radio::{self, PhysicalHeader, Reception};
use csat_proto::time::{SimTime, Step};

use crate::fleet::{Flown, Passage};
use crate::mission::{Detail, Mission};
use crate::stages;
use crate::timing::StageTimes;

/// One agent, and the links to it.
pub struct Node<M: Mission> {
    /// The agent, or what is left of it after a crash.
    pub agent: M::Agent,
    id: AgentId,
    incarnation: Incarnation,
    is_alive: bool,
    pose: Pose,
    /// The links from all other agents to this one.
    links: Links,
    received: Vec<Reception>,
    outbox: VecDeque<Transmit>,
    events: Vec<<M::Agent as Agent>::Event>,
    commands: Vec<<M::Agent as Agent>::Command>,
    times: StageTimes,
    bytes_sent: u64,
    passages: Vec<Passage>,
    arrivals: Vec<Arrival>,
}

/// A message as it leaves its sender, before the links decide about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// The sender.
    pub src: AgentId,
    /// The sender's incarnation.
    pub incarnation: Incarnation,
    /// The radio.
    pub channel: ChannelId,
    /// Its number among the sender's messages on that channel.
    pub sequence: u64,
    /// When it was sent.
    pub time: SimTime,
    /// Where the sender truly is, `world`, metres.
    pub p_world: [f64; 3],
    /// The encoded envelope.
    pub bytes: Arc<[u8]>,
}

impl<M: Mission> Node<M> {
    /// The node of an agent in its first incarnation; `links` decide which messages it receives.
    pub fn new(mission: &M, id: AgentId, links: Links) -> Self {
        Self {
            agent: mission.agent(id, Incarnation(0)),
            id,
            incarnation: Incarnation(0),
            is_alive: true,
            pose: Pose::default(),
            links,
            received: Vec::new(),
            outbox: VecDeque::new(),
            events: Vec::new(),
            commands: Vec::new(),
            times: StageTimes::default(),
            bytes_sent: 0,
            passages: Vec::new(),
            arrivals: Vec::new(),
        }
    }

    /// Whether the agent runs.
    pub fn is_alive(&self) -> bool {
        self.is_alive
    }

    /// The agent's incarnation, or the last one while it is down.
    pub fn incarnation(&self) -> Incarnation {
        self.incarnation
    }

    /// The links to this agent.
    pub fn links(&self) -> &Links {
        &self.links
    }

    /// The same, to change it.
    pub fn links_mut(&mut self) -> &mut Links {
        &mut self.links
    }

    /// A step begins with the agent at `pose`, in truth. `life` is the agent's, `None` while it is down; another
    /// life than before begins with an agent that knows nothing.
    pub fn begin(&mut self, mission: &M, life: Option<Incarnation>, pose: &Pose) {
        self.pose = *pose;
        self.times = StageTimes::default();
        self.bytes_sent = 0;
        match life {
            None => {
                self.is_alive = false;
                self.received.clear();
            }
            Some(incarnation) if !self.is_alive || incarnation != self.incarnation => {
                self.received.clear();
                self.incarnation = incarnation;
                self.agent = mission.agent(self.id, incarnation);
                self.is_alive = true;
            }
            Some(_) => {}
        }
    }

    /// Hands the agent its frame, if it runs; `frame` makes or unpacks it.
    pub fn look(&mut self, now: SimTime, frame: impl FnOnce() -> Frame) {
        if !self.is_alive {
            return;
        }
        let ((), times) = stages::collect(|| self.agent.handle_frame(now, &frame()));
        self.times.add(&times);
    }

    /// Tells an agent without camera that a step begins, if it runs.
    pub fn step(&mut self, now: SimTime, step: Step) {
        if self.is_alive {
            let pose = self.pose;
            let ((), times) = stages::collect(|| self.agent.handle_step(now, step, pose));
            self.times.add(&times);
        }
    }

    /// Another agent said something: the links decide when it arrives here, if at all.
    pub fn hear(&mut self, said: &Said) {
        let &Said { src, incarnation, channel, sequence, time, p_world, ref bytes } = said;
        let sent = Sent {
            src,
            dst: self.id,
            incarnation,
            channel,
            sequence,
            time,
            bytes: bytes.len(),
            src_p_world: p_world,
            dst_p_world: self.pose.p_world,
        };
        let fate = self.links.send(&sent, bytes.clone());
        self.passages.push(Passage { sent, bytes: bytes.clone(), fate });
    }

    /// When something is to be done next: a message arrives, or the agent wants to be called.
    pub fn next_due(&self) -> Option<SimTime> {
        let timeout = self.agent.poll_timeout().filter(|_| self.is_alive);
        timeout.into_iter().chain(self.links.next_arrival()).min()
    }

    /// Lets arrive what is due at `now`, and the agent handle it and its timeout.
    pub fn run(&mut self, now: SimTime) {
        while let Some(arrival) = self.links.receive(now) {
            // A crashed agent reads nothing.
            if self.is_alive {
                self.received.push(reception(&self.pose, &arrival));
            }
            self.arrivals.push(arrival);
        }
        if !self.is_alive {
            return;
        }
        let received = std::mem::take(&mut self.received);
        let agent = &mut self.agent;
        let ((), times) = stages::collect(|| {
            for message in received {
                agent.handle_message(now, &message);
            }
            if agent.poll_timeout().is_some_and(|due| due <= now) {
                agent.handle_timeout(now);
            }
        });
        self.times.add(&times);
    }

    /// Takes everything the agent has to say at `now`.
    pub fn say(&mut self, now: SimTime) -> Vec<Said> {
        if !self.is_alive {
            return Vec::new();
        }
        self.outbox.extend(std::iter::from_fn(|| self.agent.poll_transmit()));
        let commands = std::iter::from_fn(|| self.agent.poll_command());
        self.commands.extend(commands.filter(|command: &Command| {
            // In one process as in many: such a number would not survive the way to the world.
            if !command.is_finite() {
                tracing::error!(agent = %self.id, ?command, "a command that is no number is dropped");
            }
            command.is_finite()
        }));
        self.events.extend(std::iter::from_fn(|| self.agent.poll_event()));
        let said = |Transmit { channel, sequence, bytes }| Said {
            src: self.id,
            incarnation: self.incarnation,
            channel,
            sequence,
            time: now,
            p_world: self.pose.p_world,
            bytes: bytes.into(),
        };
        let said: Vec<Said> = self.outbox.drain(..).map(said).collect();
        self.bytes_sent += said.iter().map(|s| s.bytes.len() as u64).sum::<u64>();
        said
    }

    /// What is physical about whatever the agent says now.
    pub fn physical(&self) -> PhysicalHeader {
        PhysicalHeader { p_world: self.pose.p_world }
    }

    /// What the agent answers to one that joins late.
    pub fn answer(&mut self, now: SimTime) -> Option<Transmit> {
        if self.is_alive { self.agent.answer(now) } else { None }
    }

    /// What the agent told its vehicle since this was asked last.
    pub fn take_commands(&mut self) -> Vec<<M::Agent as Agent>::Command> {
        std::mem::take(&mut self.commands)
    }

    /// What is left of the step for observers.
    pub fn finish(&mut self, mission: &M, detail: Detail) -> Flown<M> {
        Flown {
            agent: self.id,
            digest: if self.is_alive { self.agent.digest() } else { 0 },
            report: self.is_alive.then(|| mission.report(&mut self.agent, &self.pose, detail)),
            commands: self.take_commands(),
            events: std::mem::take(&mut self.events),
            passages: std::mem::take(&mut self.passages),
            arrivals: std::mem::take(&mut self.arrivals),
            times: self.times,
            bytes_sent: self.bytes_sent,
        }
    }

    /// Everything the agent knows, or knew when it crashed.
    pub fn show(&mut self, mission: &M) -> M::Report {
        mission.report(&mut self.agent, &self.pose, Detail::Full)
    }
}

/// A message as an agent at `pose`, in truth, receives it: with what it measures of the sender.
fn reception(pose: &Pose, arrival: &Arrival) -> Reception {
    let &Arrival { at, channel, src_p_world, measured, ref bytes, .. } = arrival;
    let bearing_rad = radio::bearing_rad(pose, src_p_world) + measured.bearing_error_rad;
    let offset = |axis: usize, error_m: f64| src_p_world[axis] - pose.p_world[axis] + error_m;
    let offset_m = measured.offset_error_m.map(|[east, north]| [offset(0, east), offset(1, north)]);
    Reception { channel, at, bearing_rad: wrapped(bearing_rad), offset_m, bytes: bytes.clone() }
}

/// An angle in [-2π, 2π] in (-π, π].
fn wrapped(angle_rad: f64) -> f64 {
    if angle_rad > PI {
        angle_rad - TAU
    } else if angle_rad <= -PI {
        angle_rad + TAU
    } else {
        angle_rad
    }
}
