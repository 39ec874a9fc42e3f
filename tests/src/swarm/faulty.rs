//! Agents whose clocks are ahead and which miss frames: the set-membership mission with both.
//!
//! In real time a process without enough processor time handles the newest frame only and misses
//! those before, and clocks differ by up to `exchange.clock_skew_s`. Neither occurs in virtual time,
//! so this module adds both between the node and its agent.

use std::ops::Range;

use csat_agent::agent::{Event, SetMembershipAgent};
use csat_experiments::scenario::Scenario;
use csat_experiments::set_membership::SetMembership;
use csat_experiments::set_membership::judge::Containment;
use csat_experiments::set_membership::report::Report;
use csat_mission::judge::{Judge, Judged, Truth};
use csat_mission::measures::{Measures, Values};
use csat_mission::mission::{self, Detail, Kind, Mission, Tally};
use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::command::Command;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::radio::Reception;
use csat_proto::time::{SimTime, Step};
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

/// The mission with a handicap for each agent, by index.
#[derive(Debug, Clone)]
pub struct Faulty {
    mission: SetMembership,
    period_s: f64,
    handicaps: Vec<Handicap>,
}

impl Faulty {
    /// The mission of `scenario` with these handicaps.
    pub fn new(scenario: &Scenario, handicaps: Vec<Handicap>) -> Self {
        Self { mission: SetMembership::new(scenario), period_s: scenario.run.period_s, handicaps }
    }
}

/// An agent with a handicap.
pub struct FaultyAgent {
    /// The agent.
    pub inner: SetMembershipAgent,
    handicap: Handicap,
    ahead_s: f64,
}

impl FaultyAgent {
    /// The agent's clock when the world's shows `now`.
    fn own(&self, now: SimTime) -> SimTime {
        now.after(self.ahead_s)
    }

    /// The agent's step when the world's is `step`; `None` if it misses that frame.
    fn noticed(&self, step: Step) -> Option<Step> {
        let is_missed = self.handicap.missed.iter().any(|steps| steps.contains(&step.0));
        (!is_missed).then(|| step.after(self.handicap.ahead))
    }
}

impl Agent for FaultyAgent {
    type Command = Command;
    type Event = Event;

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

    fn poll_command(&mut self) -> Option<Command> {
        self.inner.poll_command()
    }

    fn poll_event(&mut self) -> Option<Event> {
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
pub struct FaultyReport {
    /// The report of the agent.
    pub inner: Report,
    ahead: u32,
}

impl mission::Report for FaultyReport {
    /// The world's step. An agent that has seen no frame knows what holds at the start.
    fn step(&self) -> Step {
        Step(self.inner.step.0.saturating_sub(self.ahead))
    }

    fn pose(&self) -> &Pose {
        &self.inner.pose
    }

    fn planned(&self) -> &[Pose] {
        &self.inner.planned
    }

    fn tally(&self) -> &Tally {
        &self.inner.tally
    }
}

impl Mission for Faulty {
    type Agent = FaultyAgent;
    type Report = FaultyReport;
    type Judge = Self;
    type Measures = Self;

    const KIND: Kind = Kind { columns: &[], ..SetMembership::KIND };

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> FaultyAgent {
        let handicap = self.handicaps.get(usize::from(id.0)).cloned().unwrap_or_default();
        let ahead_s = f64::from(handicap.ahead) * self.period_s;
        FaultyAgent { inner: self.mission.agent(id, incarnation), handicap, ahead_s }
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        self.mission.camera(id)
    }

    fn report(&self, agent: &mut FaultyAgent, pose: &Pose, detail: Detail) -> FaultyReport {
        let inner = self.mission.report(&mut agent.inner, pose, detail);
        FaultyReport { inner, ahead: agent.handicap.ahead }
    }

    fn judge(&self, _: &World) -> Faulty {
        self.clone()
    }

    fn measures(&self) -> Faulty {
        self.clone()
    }

    fn footprint(&self, report: &FaultyReport) -> Vec<[f64; 2]> {
        self.mission.footprint(&report.inner)
    }

    fn is_inconsistency(&self, event: &Event) -> bool {
        self.mission.is_inconsistency(event)
    }
}

impl Judge<FaultyReport> for Faulty {
    fn judge(&mut self, agent: AgentId, report: &FaultyReport, truth: &Truth<'_>) -> Judged {
        Containment.judge(agent, &report.inner, truth)
    }
}

/// The swarm measures nothing.
impl Measures<FaultyReport> for Faulty {
    fn fleet(&mut self, _: &[&FaultyReport], _: &[[f64; 2]]) -> Values {
        Values::new()
    }

    fn agent(&self, _: &FaultyReport, _: &[[f64; 2]]) -> Values {
        Values::new()
    }
}
