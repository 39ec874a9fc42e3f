//! The kinds of missions that this program flies: a list, and what the commands ask of each.

use std::marker::PhantomData;
use std::sync::OnceLock;

use csat_mission::mission::{Kind, Mission};
use csat_peer::agent::{AgentError, Setup, Welcomed};
use serde::Serialize;
use serde::de::DeserializeOwned;
use zenoh::Session;

use crate::flight::{self, RunOptions};
use crate::record::{Outcome, RecordError, Recorder};
use crate::scenario::validate::Issue;
use crate::scenario::{Loaded, Scenario};
use crate::set_membership::SetMembership;
use crate::show::recording::Recording;
use crate::world::{self, WorldError, WorldOptions};

/// A mission that scenarios can ask for.
pub trait Offered: Mission {
    /// Its own tables of a scenario: a struct with a field for each top-level table, and defaults.
    type Tables: Default + Serialize + DeserializeOwned;

    /// The mission of a scenario. The scenario has been judged.
    fn of(scenario: &Scenario) -> Self;

    /// What is wrong with a scenario of this mission: what no other judge of scenarios knows.
    fn judge_scenario(scenario: &Scenario) -> Vec<Issue>;
}

/// A kind of mission, for commands that do not know its types.
pub trait Flyable: Sync {
    /// What is known of it without flying it.
    fn kind(&self) -> &'static Kind;

    /// Its own tables of a scenario, with their defaults.
    fn tables(&self) -> toml::Table;

    /// Whether its own tables can be read.
    ///
    /// # Errors
    /// The first mistake of type or name.
    fn check_tables(&self, tables: toml::Table) -> Result<(), toml::de::Error>;

    /// What is wrong with a scenario of this mission.
    fn judge_scenario(&self, scenario: &Scenario) -> Vec<Issue>;

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

/// The entry of a mission in the list.
pub struct Entry<M>(PhantomData<fn() -> M>);

impl<M: Offered> Entry<M> {
    /// The entry of mission `M`.
    pub const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<M: Offered> Default for Entry<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: Offered> Flyable for Entry<M> {
    fn kind(&self) -> &'static Kind {
        &M::KIND
    }

    fn tables(&self) -> toml::Table {
        toml::Table::try_from(M::Tables::default()).expect("defaults are TOML")
    }

    fn check_tables(&self, tables: toml::Table) -> Result<(), toml::de::Error> {
        tables.try_into::<M::Tables>().map(drop)
    }

    fn judge_scenario(&self, scenario: &Scenario) -> Vec<Issue> {
        M::judge_scenario(scenario)
    }

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

/// The list of a program: the first is that of a scenario that names none.
pub type Missions = &'static [&'static dyn Flyable];

/// What `csat` flies.
pub const SHIPPED: Missions = &[&Entry::<SetMembership>::new()];

static INSTALLED: OnceLock<Missions> = OnceLock::new();

/// Makes `missions` the list of this program. The first call counts; without one it is [`SHIPPED`].
pub fn install(missions: Missions) {
    let _ = INSTALLED.set(missions);
}

/// The list of this program.
pub fn all() -> Missions {
    INSTALLED.get_or_init(|| SHIPPED)
}

/// A mission by its name.
pub fn find(name: &str) -> Option<&'static dyn Flyable> {
    all().iter().copied().find(|mission| mission.kind().name == name)
}

/// The names of all missions, for people.
pub fn names() -> String {
    let names = all().iter().map(|mission| format!("`{}`", mission.kind().name));
    names.collect::<Vec<_>>().join(", ")
}

/// The kind of a mission by its name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    find(name).map(Flyable::kind)
}

/// The name of the mission of a scenario that names none.
pub fn first() -> &'static str {
    all()[0].kind().name
}
