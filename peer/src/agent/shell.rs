//! What both pacings share: the shell around the node. It passes inputs to the node, and sends what the
//! node returns.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::time::Duration;

use csat_mission::mission::Mission;
use csat_mission::node::Node;
use csat_proto::camera::Pose;
use csat_proto::control::{FrameHeader, Order};
use csat_proto::frame::Frame;
use csat_proto::frame_wire;
use csat_proto::ids::AgentId;
use csat_proto::keys::Keys;
use csat_proto::time::{SimTime, Step};
use csat_world::sensor::SensorModel;
use zenoh::query::Query;

use super::input::{AgentInput, RawFrame, RawMessage};
use super::port::AgentPort;
use super::queue::MessageQueue;
use super::views::AgentViews;
use super::{AgentError, Setup, Welcomed};
use crate::world::report::StepLog;

/// The node of an agent and all that its process needs in either pacing.
pub(super) struct Shell<M: Mission> {
    pub id: AgentId,
    pub keys: Keys,
    pub process: u64,
    /// How long the process waits for others.
    pub patience: Duration,
    pub mission: M,
    /// `None` for a ground station.
    pub sensor: Option<SensorModel>,
    pub period_s: f64,
    pub node: Node<M>,
    pub port: AgentPort,
    pub views: AgentViews<M::Report>,
    pub queue: MessageQueue,
    /// The agents that this process hears, with their processes.
    pub heard: BTreeMap<AgentId, u64>,
    /// The agents whose processes are gone.
    pub gone: BTreeSet<AgentId>,
    /// By radio, the number of the agent's next message.
    pub next_number: Vec<u64>,
    /// What the process has reported of this step.
    pub log: StepLog,
    /// Snapshot queries that wait for their answer.
    pub queries: Vec<Query>,
    /// How many frames the process handed to its agent, or steps to one without camera.
    pub frames: u64,
}

/// The step that an agent is in.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurrentStep {
    pub step: Step,
    /// The instant of its frame.
    pub time: SimTime,
    /// The instant of the next frame.
    pub next: SimTime,
}

impl CurrentStep {
    pub fn of(header: &FrameHeader) -> Self {
        Self { step: header.step, time: header.time, next: header.next }
    }
}

impl<M: Mission> Shell<M> {
    pub fn new(welcomed: Welcomed<'_>, setup: Setup<M>) -> Result<Self, AgentError> {
        let Welcomed { welcome, session, arguments, process, inlet } = welcomed;
        let Setup { mission, period_s, channels, links, .. } = setup;
        let (id, keys) = (AgentId(arguments.id), Keys(welcome.run));
        let port = AgentPort::declare(session, &welcome, period_s, id, channels, inlet)
            .map_err(AgentError::zenoh("declare the agent's keys"))?;
        // After the port, because this may take long: the world gives the agent to another process if it
        // does not see the token that the port holds.
        let links = links()?;
        let views = AgentViews::declare(session, keys, id, mission.clone())
            .map_err(AgentError::zenoh("declare the agent's views"))?;
        Ok(Self {
            id,
            keys,
            process,
            patience: arguments.patience,
            sensor: mission.sensor(id),
            period_s,
            node: Node::new(&mission, id, links),
            mission,
            port,
            views,
            queue: MessageQueue::default(),
            heard: BTreeMap::new(),
            gone: BTreeSet::new(),
            next_number: vec![0; channels],
            log: StepLog::default(),
            queries: Vec::new(),
            frames: 0,
        })
    }

    /// Handles an input that both pacings treat alike; `now` is `None` before the first frame. Breaks with
    /// the reason when the mission is over.
    pub fn handle(
        &mut self,
        input: AgentInput,
        now: Option<&CurrentStep>,
    ) -> Result<ControlFlow<String>, AgentError> {
        match input {
            AgentInput::Order(Order::End { reason }) => {
                tracing::info!(agent = %self.id, reason, "ends");
                return Ok(ControlFlow::Break(reason));
            }
            AgentInput::Message(message) => drop(self.push(message)),
            AgentInput::Probe(agent, probe) => self.take_probe(agent, probe, now.is_some()),
            AgentInput::Gone(agent) => self.lose(agent),
            AgentInput::SnapshotQuery(query) => self.take_query(query, now),
            AgentInput::ViewQuery(query) => {
                let step = self.shown_step(now, Vec::new(), 0);
                self.views.answer(step, query);
            }
            AgentInput::Snapshot(message) => self.take_snapshot(message),
            AgentInput::WorldGone => return Err(AgentError::WorldGone(self.id)),
            AgentInput::End(by) => return Err(AgentError::Ended(by)),
            // These mean something to one of the loops only, which handles them itself.
            AgentInput::Frame(_)
            | AgentInput::Order(_)
            | AgentInput::WorldAlive
            | AgentInput::Timeout(_) => {}
        }
        Ok(ControlFlow::Continue(()))
    }

    /// A step begins: hands the agent its frame, sends what it has to say, and answers the world.
    pub fn begin_step(&mut self, frame: &RawFrame) -> Result<(), AgentError> {
        let &FrameHeader { step, time, pose, p_world, yaw_rad, incarnation, .. } = &frame.header;
        self.log.clear();
        if incarnation.is_some_and(|life| life != self.node.incarnation()) {
            self.next_number.fill(0);
        }
        let place = Pose {
            p_world: p_world.unwrap_or(pose.p_world),
            yaw_rad: yaw_rad.unwrap_or(pose.yaw_rad),
            ..pose
        };
        // A crash of the scenario ends the life of the agent, not its process.
        self.node.begin(&self.mission, incarnation, &place);
        if incarnation.is_some() {
            self.look(frame)?;
            self.frames += 1;
        }
        self.talk(time);
        self.done(step, 0);
        Ok(())
    }

    /// Hands the agent its frame or, without sensor, the step.
    fn look(&mut self, frame: &RawFrame) -> Result<(), AgentError> {
        let RawFrame { header, pixels } = frame;
        let &FrameHeader { step, time, pose, pose_error, .. } = header;
        match &self.sensor {
            None => {
                header.check_blind(self.period_s, pixels.len())?;
                self.node.step(time, step);
            }
            Some(SensorModel::Labels(camera) | SensorModel::Roads(camera, _)) => {
                let (labels, depth) = frame_wire::decode(pixels, camera.pixels())
                    .map_err(|source| AgentError::Frame { step, source })?;
                header.check(camera, self.period_s, &labels)?;
                let (detections, sighting) = (header.detections.clone(), None);
                let frame = Frame { step, pose, pose_error, labels, depth, detections, sighting };
                self.node.look(time, || frame);
            }
            Some(SensorModel::Detector(camera, _)) => {
                header.check_detector(camera, self.period_s, pixels.len())?;
                let frame = Frame::of_detector(step, pose, header.sighting);
                self.node.look(time, || Frame { pose_error, ..frame });
            }
        }
        Ok(())
    }

    /// Queues a message of another agent. Returns whether it was accepted.
    pub fn push(&mut self, message: RawMessage) -> bool {
        let newest = self.port.newest_in_lockstep();
        let pushed = self.queue.push(message, newest);
        pushed.inspect_err(|error| self.port.refusals().count("message", error)).is_ok()
    }

    /// Runs the agent at an instant, and answers the queries that waited for that.
    pub fn run(&mut self, at: SimTime, now: &CurrentStep) {
        self.node.run(at);
        self.answer_queries(now);
    }

    /// Sends what the agent has to say.
    pub fn talk(&mut self, at: SimTime) {
        for said in self.node.say(at) {
            if let Some(next) = self.next_number.get_mut(usize::from(said.channel.0)) {
                *next = said.sequence + 1;
            }
            self.port.send(&said, &self.node.physical());
        }
    }
}
