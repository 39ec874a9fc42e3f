//! Agents whose clocks are ahead and which miss frames: any mission with both.
//!
//! In real time a process without enough processor time handles the newest frame only and misses
//! those before, and clocks differ by up to `exchange.clock_skew_s`. Neither occurs in virtual time,
//! so this module adds both between the node and its agent.

use std::ops::Range;

use csat_mission::judge::{Judge, Judged, Truth};
use csat_mission::measures::{Measures, Values};
use csat_mission::mission::{self, Detail, Kind, Mission, Tally};
use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::radio::Reception;
use csat_proto::time::{SimTime, Step};
use csat_world::sensor::SensorModel;
use csat_world::world::World;
use serde::{Deserialize, Serialize};

/// The handicap of one agent.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Handicap {
    /// By how many steps its clock is ahead of the world's.
    pub ahead: u32,
    /// The steps of the world whose frames it misses.
    pub missed: Vec<Range<u32>>,
}

impl Handicap {
    /// Whether it misses the frame of a step of the world.
    pub fn misses(&self, step: Step) -> bool {
        self.missed.iter().any(|steps| steps.contains(&step.0))
    }
}

/// A mission with a handicap for each agent, by index.
#[derive(Debug, Clone)]
pub struct Faulty<M> {
    mission: M,
    period_s: f64,
    handicaps: Vec<Handicap>,
}

impl<M: Mission> Faulty<M> {
    /// A mission whose steps take `period_s`, with these handicaps.
    pub fn new(mission: M, period_s: f64, handicaps: Vec<Handicap>) -> Self {
        Self { mission, period_s, handicaps }
    }
}

/// An agent with a handicap.
pub struct FaultyAgent<A> {
    /// The agent.
    pub inner: A,
    handicap: Handicap,
    ahead_s: f64,
}

impl<A> FaultyAgent<A> {
    /// The agent's clock when the world's shows `now`.
    fn own(&self, now: SimTime) -> SimTime {
        now.after(self.ahead_s)
    }

    /// The agent's step when the world's is `step`; `None` if it misses that frame.
    fn noticed(&self, step: Step) -> Option<Step> {
        (!self.handicap.misses(step)).then(|| step.after(self.handicap.ahead))
    }
}

impl<A: Agent> Agent for FaultyAgent<A> {
    type Command = A::Command;
    type Event = A::Event;

    fn handle_frame(&mut self, now: SimTime, frame: &Frame) {
        if let Some(step) = self.noticed(frame.step) {
            self.inner.handle_frame(self.own(now), &Frame { step, ..frame.clone() });
        }
    }

    fn handle_step(&mut self, now: SimTime, step: Step, pose: Pose) {
        if let Some(step) = self.noticed(step) {
            self.inner.handle_step(self.own(now), step, pose);
        }
    }

    fn handle_message(&mut self, now: SimTime, message: &Reception) {
        self.inner.handle_message(self.own(now), message);
    }

    fn handle_timeout(&mut self, now: SimTime) {
        self.inner.handle_timeout(self.own(now));
    }

    fn poll_transmit(&mut self) -> Option<Transmit> {
        self.inner.poll_transmit()
    }

    fn answer(&mut self, now: SimTime) -> Option<Transmit> {
        self.inner.answer(self.own(now))
    }

    fn poll_command(&mut self) -> Option<A::Command> {
        self.inner.poll_command()
    }

    fn poll_event(&mut self) -> Option<A::Event> {
        self.inner.poll_event()
    }

    fn poll_timeout(&self) -> Option<SimTime> {
        let due = self.inner.poll_timeout()?;
        Some(SimTime(due.0.saturating_sub(SimTime::from_seconds(self.ahead_s).0)))
    }

    fn digest(&self) -> u64 {
        self.inner.digest()
    }
}

/// A report, and by how many steps the clock of its agent is ahead.
#[derive(Debug, Serialize, Deserialize)]
pub struct FaultyReport<R> {
    /// The report of the agent.
    pub inner: R,
    ahead: u32,
}

impl<R: mission::Report> mission::Report for FaultyReport<R> {
    /// The world's step. An agent that has seen no frame knows what holds at the start.
    fn step(&self) -> Step {
        Step(self.inner.step().0.saturating_sub(self.ahead))
    }

    fn pose(&self) -> &Pose {
        self.inner.pose()
    }

    fn planned(&self) -> &[Pose] {
        self.inner.planned()
    }

    fn tally(&self) -> &Tally {
        self.inner.tally()
    }
}

impl<M: Mission> Mission for Faulty<M> {
    type Agent = FaultyAgent<M::Agent>;
    type Report = FaultyReport<M::Report>;
    type Judge = FaultyJudge<M::Judge>;
    type Measures = Unmeasured;

    const KIND: Kind = Kind { columns: &[], ..M::KIND };

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> FaultyAgent<M::Agent> {
        let handicap = self.handicaps.get(usize::from(id.0)).cloned().unwrap_or_default();
        let ahead_s = f64::from(handicap.ahead) * self.period_s;
        FaultyAgent { inner: self.mission.agent(id, incarnation), handicap, ahead_s }
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        self.mission.camera(id)
    }

    fn sensor(&self, id: AgentId) -> Option<SensorModel> {
        self.mission.sensor(id)
    }

    fn report(
        &self,
        agent: &mut FaultyAgent<M::Agent>,
        pose: &Pose,
        detail: Detail,
    ) -> FaultyReport<M::Report> {
        let inner = self.mission.report(&mut agent.inner, pose, detail);
        FaultyReport { inner, ahead: agent.handicap.ahead }
    }

    fn judge(&self, world: &World) -> FaultyJudge<M::Judge> {
        FaultyJudge(self.mission.judge(world))
    }

    fn measures(&self) -> Unmeasured {
        Unmeasured
    }

    fn footprint(&self, report: &FaultyReport<M::Report>) -> Vec<[f64; 2]> {
        self.mission.footprint(&report.inner)
    }

    fn is_inconsistency(&self, event: &<M::Agent as Agent>::Event) -> bool {
        self.mission.is_inconsistency(event)
    }
}

/// The judge of the mission.
pub struct FaultyJudge<J>(J);

impl<R, J: Judge<R>> Judge<FaultyReport<R>> for FaultyJudge<J> {
    fn judge(&mut self, agent: AgentId, report: &FaultyReport<R>, truth: &Truth<'_>) -> Judged {
        self.0.judge(agent, &report.inner, truth)
    }
}

/// The swarms measure nothing.
pub struct Unmeasured;

impl<R> Measures<R> for Unmeasured {
    fn fleet(&mut self, _: &[&R], _: &[[f64; 2]]) -> Values {
        Values::new()
    }

    fn agent(&self, _: &R, _: &[[f64; 2]]) -> Values {
        Values::new()
    }
}
