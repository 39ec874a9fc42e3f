//! One agent and what surrounds it.

use std::sync::Arc;

use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::CameraModel;
use csat_proto::frame::Frame;
use csat_proto::ids::Incarnation;
use csat_proto::time::SimTime;
use csat_world::camera::Renderer;
use tracing::info_span;

use crate::stages;
use crate::timing::StageTimes;

/// One agent and what surrounds it.
pub struct Seat<A: Agent> {
    /// The agent, or what is left of it after a crash.
    pub agent: A,
    /// What the stages took since the start of the step.
    pub times: StageTimes,
    /// Bytes the agent sent in this step.
    pub bytes_sent: u64,
    pub(crate) outbox: Vec<Transmit>,
    pub(crate) events: Vec<A::Event>,
    pub(crate) commands: Vec<A::Command>,
    incarnation: Incarnation,
    is_alive: bool,
    renderer: Renderer,
    inbox: Vec<Arc<[u8]>>,
}

impl<A: Agent> Seat<A> {
    /// A seat with an agent in its first life.
    pub(crate) fn new(agent: A, camera: CameraModel) -> Self {
        Self {
            agent,
            times: StageTimes::default(),
            bytes_sent: 0,
            outbox: Vec::new(),
            events: Vec::new(),
            commands: Vec::new(),
            incarnation: Incarnation(0),
            is_alive: true,
            renderer: Renderer::new(camera),
            inbox: Vec::new(),
        }
    }

    /// Whether the agent runs.
    pub fn is_alive(&self) -> bool {
        self.is_alive
    }

    /// The agent's life, or its last one.
    pub fn incarnation(&self) -> Incarnation {
        self.incarnation
    }

    /// The agent ends. Its vehicle flies on.
    pub(crate) fn crash(&mut self) {
        self.is_alive = false;
        (self.times, self.bytes_sent) = (StageTimes::default(), 0);
        self.inbox.clear();
    }

    /// Another agent takes over, knowing nothing.
    pub(crate) fn restart(&mut self, agent: impl FnOnce(Incarnation) -> A) {
        self.incarnation.0 += 1;
        self.agent = agent(self.incarnation);
        self.is_alive = true;
    }

    /// Renders a frame of the world and hands it to the agent.
    pub(crate) fn look(&mut self, now: SimTime, render: impl FnOnce(&mut Renderer) -> Frame) {
        let Self { renderer, agent, .. } = self;
        let ((), times) = stages::collect(|| {
            let frame = info_span!("render").in_scope(|| render(renderer));
            agent.handle_frame(now, &frame);
        });
        self.times = times;
        self.bytes_sent = 0;
    }

    /// A message arrived. Nobody is there to read it after a crash.
    pub(crate) fn receive(&mut self, bytes: Arc<[u8]>) {
        if self.is_alive {
            self.inbox.push(bytes);
        }
    }

    /// When the agent next wants to be called.
    pub(crate) fn poll_timeout(&self) -> Option<SimTime> {
        self.agent.poll_timeout().filter(|_| self.is_alive)
    }

    /// Handles what arrived and, if its time has come, the timeout.
    pub(crate) fn run(&mut self, now: SimTime) {
        if !self.is_alive {
            return;
        }
        let inbox = std::mem::take(&mut self.inbox);
        let agent = &mut self.agent;
        let ((), times) = stages::collect(|| {
            for bytes in inbox {
                agent.handle_message(now, &bytes);
            }
            if agent.poll_timeout().is_some_and(|due| due <= now) {
                agent.handle_timeout(now);
            }
        });
        self.times.add(&times);
    }

    /// Takes everything the agent has to say.
    pub(crate) fn poll(&mut self) {
        if !self.is_alive {
            return;
        }
        self.outbox.extend(std::iter::from_fn(|| self.agent.poll_transmit()));
        self.commands.extend(std::iter::from_fn(|| self.agent.poll_command()));
        self.events.extend(std::iter::from_fn(|| self.agent.poll_event()));
    }
}
