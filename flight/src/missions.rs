//! The missions that this program flies: the list, and how each is flown.

use std::sync::OnceLock;

use csat_peer::agent::{AgentError, Setup, Welcomed};
use zenoh::Session;

use crate::bayes::Bayes;
use crate::clearing::Clearing;
use crate::flight::{self, RunOptions};
use crate::record::{Outcome, RecordError, Recorder};
pub use crate::scenario::missions::{Entry, Listed, Offered};
use crate::scenario::{self, Loaded, Scenario};
use crate::set_membership::SetMembership;
use crate::show::recording::Recording;
use crate::world::{self, WorldError, WorldOptions};

/// A mission that can be flown, for commands that do not know its types.
pub trait Flyable: Listed {
    /// Flies a mission in this process.
    ///
    /// # Errors
    /// When it cannot be written down.
    fn fly(&self, flight: Request<'_>) -> Result<Flown, RecordError>;

    /// Flies a mission whose agents are processes of their own.
    ///
    /// # Errors
    /// When processes are missing, or it cannot be flown or written down.
    fn fly_fleet(
        &self,
        session: &Session,
        world: WorldOptions<'_>,
        flight: Request<'_>,
    ) -> Result<Flown, WorldError>;

    /// Drives one agent, in a process of its own, until the mission is over. Gives the reason why it is.
    ///
    /// # Errors
    /// When the process cannot take part, or not go on.
    fn take_part(&self, welcomed: Welcomed<'_>, scenario: Scenario) -> Result<String, AgentError>;
}

/// A mission to be flown and written down.
pub struct Request<'a> {
    /// What to fly.
    pub loaded: Loaded,
    /// When to end.
    pub options: &'a RunOptions,
    /// Writes it down.
    pub recorder: &'a mut Recorder,
    /// The period of a recording, simulated seconds; `None` without one.
    pub record_period_s: Option<f64>,
}

/// What a mission came to.
pub struct Flown {
    /// What is left to write down.
    pub outcome: Outcome,
    /// The length of its recording, if there is one, bytes.
    pub recorded_bytes: Option<u64>,
}

impl<M: Offered> Flyable for Entry<M> {
    fn fly(&self, flight: Request<'_>) -> Result<Flown, RecordError> {
        let mut recording = recording::<M>(&flight)?;
        let Request { loaded, options, recorder, .. } = flight;
        let outcome = flight::run::<M>(loaded, options, recorder, &mut recording)?;
        let recorded_bytes = recording.map(Recording::finish).transpose()?;
        Ok(Flown { outcome, recorded_bytes })
    }

    fn fly_fleet(
        &self,
        session: &Session,
        world: WorldOptions<'_>,
        flight: Request<'_>,
    ) -> Result<Flown, WorldError> {
        let mut recording = recording::<M>(&flight)?;
        let Request { loaded, options, recorder, .. } = flight;
        let outcome = world::fly::<M>(session, world, loaded, options, recorder, &mut recording)?;
        let recorded_bytes = recording.map(Recording::finish).transpose()?;
        Ok(Flown { outcome, recorded_bytes })
    }

    fn take_part(&self, welcomed: Welcomed<'_>, scenario: Scenario) -> Result<String, AgentError> {
        let map = welcomed.welcome.map.clone();
        welcomed.fly(Setup {
            mission: M::of(&scenario),
            period_s: scenario.run.period_s,
            channels: scenario.netem.all_channels().count(),
            uavs: scenario.agents.count,
            agents: scenario.agent_count(),
            links: Box::new(move || scenario.links(map.as_deref())),
        })
    }
}

/// The recording that was asked for.
fn recording<M: Offered>(flight: &Request<'_>) -> Result<Option<Recording<M>>, RecordError> {
    let Request { loaded, recorder, record_period_s, .. } = flight;
    let folder = recorder.partial_folder();
    let create = |period_s| Recording::create(folder, M::of(&loaded.scenario), loaded, period_s);
    record_period_s.map(create).transpose()
}

/// The list of a program. A scenario that names no mission is one of `set-membership`, else of the first one.
pub type Missions = &'static [&'static dyn Flyable];

/// What `csat` flies.
pub const SHIPPED: Missions =
    &[&Entry::<SetMembership>::new(), &Entry::<Bayes>::new(), &Entry::<Clearing>::new()];

static INSTALLED: OnceLock<Missions> = OnceLock::new();

/// Makes `missions` the list of this program. The first call counts; without one it is [`SHIPPED`].
pub fn install(missions: Missions) {
    let _ = INSTALLED.set(missions);
    scenario::missions::install(missions.iter().map(|mission| *mission as &dyn Listed).collect());
}

/// The mission of a scenario, to fly it.
pub fn of(scenario: &Scenario) -> Option<&'static dyn Flyable> {
    let missions = INSTALLED.get_or_init(|| SHIPPED);
    missions.iter().copied().find(|mission| mission.kind().name == scenario.mission)
}

/// Drives one agent of the mission that the world's scenario describes, until the mission is over. Gives the
/// reason why it is.
///
/// # Errors
/// When the process cannot take part, or not go on.
pub fn take_part(welcomed: Welcomed<'_>) -> Result<String, AgentError> {
    let scenario = Scenario::from_toml(&welcomed.welcome.scenario)
        .map_err(|error| AgentError::Scenario(error.message().into()))?;
    let mission = of(&scenario).ok_or_else(|| {
        AgentError::Mission(scenario.mission.clone(), scenario::missions::names())
    })?;
    mission.take_part(welcomed, scenario)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reader of scenarios does not know how missions are flown, and has a list of its own.
    #[test]
    fn the_missions_that_are_read_are_those_that_are_flown() {
        let read: Vec<&str> = scenario::missions::all().iter().map(|m| m.kind().name).collect();
        let flown: Vec<&str> = SHIPPED.iter().map(|mission| mission.kind().name).collect();
        assert_eq!(read, flown);
    }
}
