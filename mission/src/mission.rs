//! A mission is a plug: the engine, the monitor, the metrics and the pictures know it by this trait,
//! not by name.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::marker::PhantomData;

use csat_proto::agent::Agent;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::command::Command;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;
use csat_world::sensor::SensorModel;
use csat_world::world::World;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::contact;
use crate::judge::{Judge, Promise};
use crate::measures::{Column, Joined, Measures, Milestone, Panel};
use crate::picture::Layer;
use crate::style::Style;

/// What distinguishes one kind of mission from another: the agent, what it reports, what is promised and
/// judged, and what is measured and drawn.
///
/// Agents may live in other processes, so their observers know their [`Report`](Self::Report) and
/// nothing else.
pub trait Mission: Clone + Send + Sync + 'static {
    /// The agent.
    type Agent: Agent<Command = Command, Event: Serialize + DeserializeOwned + Sync> + Sync;

    /// What an agent's observers get to know of it at the end of a step.
    type Report: Report;

    /// How the layers of [`picture`](Self::picture) are drawn, from the bottom up.
    const LAYERS: &'static [Style] = &[];

    /// What holds its reports against the truth.
    type Judge: Judge<Self::Report>;

    /// What measures it.
    type Measures: Measures<Self::Report>;

    /// What tools know of the mission without flying it. [`Whole`] adds what every mission has.
    const KIND: Kind;

    /// The agent of a UAV or a ground station at the start of one of its lives.
    fn agent(&self, id: AgentId, incarnation: Incarnation) -> Self::Agent;

    /// The camera of an agent; `None` for a ground station.
    fn camera(&self, id: AgentId) -> Option<CameraModel>;

    /// What an agent carries; `None` for a ground station. By default its camera, with labels.
    fn sensor(&self, id: AgentId) -> Option<SensorModel> {
        self.camera(id).map(SensorModel::Labels)
    }

    /// What the agent's observers get to know. `pose` is where it is, in truth: for observers of an agent that
    /// does not know.
    fn report(&self, agent: &mut Self::Agent, pose: &Pose, detail: Detail) -> Self::Report;

    /// The judge of a run in this world, at its start.
    fn judge(&self, world: &World) -> Self::Judge;

    /// What measures a run.
    fn measures(&self) -> Self::Measures;

    /// F ∩ {z = 0} of the agent's last frame, `world`, metres; empty without one.
    fn footprint(&self, report: &Self::Report) -> Vec<[f64; 2]>;

    /// What there is to draw of a report: at most one layer for each of [`LAYERS`](Self::LAYERS), in any
    /// order. A layer that the report's [`Detail`] leaves out is absent.
    fn picture(&self, _: &Self::Report) -> Vec<Layer> {
        Vec::new()
    }

    /// The numbers that the agent knows of itself, by their names in `metrics.csv`; `None` where a number
    /// is not defined.
    fn stats(&self, _: &Self::Report) -> Vec<(&'static str, Option<f64>)> {
        Vec::new()
    }

    /// Whether an event says that an assumption failed.
    fn is_inconsistency(&self, event: &<Self::Agent as Agent>::Event) -> bool;

    /// The agent that an event says has lied.
    fn liar_in(&self, _: &<Self::Agent as Agent>::Event) -> Option<AgentId> {
        None
    }
}

/// What every agent tells its observers, whatever its mission.
pub trait Report: Debug + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// The step that its knowledge is of.
    fn step(&self) -> Step;

    /// The pose of its last frame, or where a ground station stands.
    fn pose(&self) -> &Pose;

    /// Where it intends to be, in the order of time.
    fn planned(&self) -> &[Pose];

    /// What it did not believe and did not say in its life so far.
    fn tally(&self) -> &Tally;
}

/// How much an agent tells its observers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Detail {
    /// What the monitor and the metrics need.
    #[default]
    Brief,
    /// Its maps, too: all that can be drawn.
    Full,
}

/// What an agent did not believe and did not say.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Tally {
    /// Messages it dropped as invalid, by reason.
    pub rejected: BTreeMap<String, u64>,
    /// Steps it did not tell of because nothing fitted its budget.
    pub withheld: u64,
}

impl Tally {
    /// Adds what another agent, or another life, did not believe and did not say.
    pub fn add(&mut self, other: &Tally) {
        for (reason, count) in &other.rejected {
            *self.rejected.entry(reason.clone()).or_default() += count;
        }
        self.withheld += other.withheld;
    }
}

/// What tools know of a kind of mission without flying one.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Its name, the `mission` of scenarios.
    pub name: &'static str,
    /// What is measured.
    pub columns: &'static [Column],
    /// The columns that a line for people begins with.
    pub headline: &'static [&'static str],
    /// Instants that the summary has.
    pub milestones: &'static [Milestone],
    /// What is drawn over time.
    pub panels: &'static [Panel],
    /// What is promised.
    pub promises: &'static [Promise],
}

/// The kind of a mission with what is measured of every mission ([`contact`]): what tools read.
pub struct Whole<M>(PhantomData<fn() -> M>);

impl<M: Mission> Whole<M> {
    const COLUMNS: &'static Joined<Column> = &Joined::new(M::KIND.columns, contact::COLUMNS);
    const PANELS: &'static Joined<Panel> = &Joined::new(M::KIND.panels, contact::PANELS);

    /// The mission's own columns and panels, then those of every mission.
    pub const KIND: Kind =
        Kind { columns: Self::COLUMNS.all(), panels: Self::PANELS.all(), ..M::KIND };
}

impl Kind {
    /// The columns that sweeps, reports and summaries for people show: first those of the headline.
    pub fn plotted(&self) -> impl Iterator<Item = &'static Column> {
        let is_plotted = |column: &&Column| {
            let is_in_summary = column.in_summary || column.last_as == Some(column.key);
            is_in_summary && column.plot.is_some()
        };
        let is_first = |column: &&Column| self.headline.contains(&column.key);
        let (first, others): (Vec<_>, Vec<_>) =
            self.columns.iter().filter(is_plotted).partition(is_first);
        first.into_iter().chain(others)
    }

    /// A column by its key.
    pub fn column(&self, key: &str) -> Option<&'static Column> {
        self.columns.iter().find(|column| column.key == key)
    }
}
