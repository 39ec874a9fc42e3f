//! A fleet of the engine whose agents are in processes of their own.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use csat_mission::fleet::{Brief, Fleet, Flown, Frames, has_misidentified, sensors};
use csat_mission::mission::{Detail, Mission};
use csat_mission::timing::{StageTimes, Stopwatch};
use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::LinkId;
use csat_proto::control::{Order, Pace, Welcome};
use csat_proto::ids::AgentId;
use csat_world::sensor::Sensor;
use zenoh::Session;

use super::FleetError;
use super::error::Awaited;
use super::expected::Expected;
use super::member::Member;
use super::port::WorldPort;
use super::report::Scope;
use super::roster::Roster;

/// The agents of a mission in processes of their own.
pub struct RemoteFleet<M: Mission> {
    pub(super) port: WorldPort,
    pub(super) roster: Roster,
    /// How long the world waits for a process.
    pub(super) patience: Duration,
    /// By agent.
    pub(super) members: Vec<Member<M::Report>>,
    /// By agent; `None` for agents without one.
    pub(super) sensors: Vec<Option<Sensor>>,
    /// By agent, how long its last frame took.
    pub(super) render_times: Vec<StageTimes>,
    /// Real time: since the first frame.
    pub(super) since_start: Option<Stopwatch>,
    /// Set when the mission is to end early.
    pub(super) interrupted: Arc<AtomicBool>,
    /// Whether processes that end are started again.
    pub(super) restarts: bool,
    /// Since when no process takes part.
    pub(super) deserted: Option<Stopwatch>,
    pub(super) expected: Expected,
}

impl<M: Mission> RemoteFleet<M> {
    /// A fleet of `count` agents without processes; a process that joins is told `welcome`. The fleet
    /// waits for a process for `patience` at most. `interrupted` is set when the mission is to end early.
    ///
    /// # Errors
    /// When Zenoh does not declare the world's keys.
    pub fn declare(
        session: &Session,
        mission: &M,
        welcome: Welcome,
        count: usize,
        patience: Duration,
        interrupted: Arc<AtomicBool>,
    ) -> zenoh::Result<Self> {
        Ok(Self {
            port: WorldPort::declare(session, &welcome, count)?,
            members: (0..count).map(|_| Member::default()).collect(),
            sensors: sensors(mission, count),
            render_times: vec![StageTimes::default(); count],
            patience,
            since_start: None,
            interrupted,
            restarts: false,
            deserted: None,
            expected: Expected::new(welcome.pace),
            roster: Roster::new(welcome, count),
        })
    }

    /// The same fleet with processes that are started again when they end: when none is left it waits for
    /// one, unless the mission is to end early.
    pub fn with_restarts(self) -> Self {
        Self { restarts: true, ..self }
    }

    pub(super) fn member_mut(&mut self, agent: AgentId) -> &mut Member<M::Report> {
        &mut self.members[usize::from(agent.0)]
    }

    /// Asks all agents for their reports on the step.
    pub(super) fn request_reports(&mut self, detail: Detail) {
        let full = detail == Detail::Full;
        self.expected.scope = Some(Scope::of_step(full));
        self.port.publishers().order(Order::Close { step: self.expected.step, full });
    }

    /// What all agents said of the step.
    fn collect(&mut self) -> Vec<Flown<M>> {
        let members = self.members.iter_mut().zip(&self.render_times).enumerate();
        members
            .map(|(index, (member, times))| {
                let mut flown = member.flown(AgentId(index as u16));
                flown.times.render = times.render;
                flown
            })
            .collect()
    }
}

impl<M: Mission> Fleet<M> for RemoteFleet<M> {
    type Error = FleetError;

    fn attendance(&mut self) -> Vec<Option<u64>> {
        while let Some(input) = self.port.next(Duration::ZERO) {
            self.take(input);
        }
        self.roster.admit();
        if self.expected.pace == Pace::Lockstep {
            self.await_restart();
        }
        self.roster.attendance()
    }

    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<M>>, FleetError> {
        self.check_presence(brief.step)?;
        match self.expected.pace {
            Pace::Lockstep => self.fly_lockstep(brief)?,
            Pace::Realtime(speed) => self.fly_realtime(brief, speed),
        }
        Ok(self.collect())
    }

    fn show(&mut self) -> Vec<Option<M::Report>> {
        self.members.iter_mut().for_each(|member| member.has_reported = false);
        self.expected.scope = Some(Scope::Final);
        self.port.publishers().order(Order::Show { step: self.expected.step });
        if let Err(error) = self.wait(Awaited::FinalReport, |member| member.has_reported) {
            tracing::warn!(%error, "the picture of the end is not complete");
        }
        self.members.iter_mut().map(Member::mission_report).collect()
    }

    fn counters(&self) -> Counters {
        let mut all = Counters::default();
        self.members.iter().for_each(|member| all.add(&member.counters()));
        all
    }

    fn per_link(&self) -> Vec<(LinkId, LinkCounters)> {
        let mut links: Vec<_> = self.members.iter().flat_map(Member::per_link).collect();
        links.sort_by_key(|(id, _)| *id);
        links
    }

    fn frames(&self) -> Vec<Frames> {
        self.members.iter().map(Member::frames).collect()
    }

    fn has_misidentified(&self) -> Vec<bool> {
        has_misidentified(&self.sensors)
    }

    fn refused(&self) -> BTreeMap<String, u64> {
        let mut all = self.port.refusals().counts();
        self.members.iter().for_each(|member| member.add_refused(&mut all));
        all
    }
}
