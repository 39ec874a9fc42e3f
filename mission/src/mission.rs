//! A mission is a plug: the engine, the monitor, the metrics and the pictures know it by this trait,
//! not by name.

use std::collections::BTreeMap;
use std::fmt::Debug;

use csat_proto::agent::Agent;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::command::YawCommand;
use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::region::Region;
use csat_proto::time::Step;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::picture::Layer;
use crate::row::StepRecord;
use crate::style::Style;

/// What distinguishes one kind of mission from another: the agent's mind, what it reports, what the
/// monitor holds against the truth, and what is measured and drawn.
///
/// Agents may live in other processes, so their observers know their [`Report`](Self::Report) and
/// nothing else.
pub trait Mission: Clone + Send + Sync + 'static {
    /// The agent.
    type Agent: Agent<Command = YawCommand, Event: Serialize + DeserializeOwned + Sync> + Sync;

    /// What an agent's observers get to know of it at the end of a step.
    type Report: Report;

    /// How the layers of [`picture`](Self::picture) are drawn, from the bottom up.
    const LAYERS: &'static [Style] = &[];

    /// The agent of a UAV or a ground station at the start of one of its lives.
    fn agent(&self, id: AgentId, incarnation: Incarnation) -> Self::Agent;

    /// The camera of an agent; `None` for a ground station.
    fn camera(&self, id: AgentId) -> Option<CameraModel>;

    /// What the agent's observers get to know.
    fn report(&self, agent: &mut Self::Agent, detail: Detail) -> Self::Report;

    /// The monitor's question: does what the agent knows admit that `target` is at `location`
    /// (`world`, metres) or within `tolerance_m` of it?
    fn admits(
        &self,
        report: &Self::Report,
        target: TargetId,
        location: [f64; 2],
        tolerance_m: f64,
    ) -> bool;

    /// Fills in an agent's own part of a row of metrics; `truth` holds the targets' locations.
    fn measure(&self, report: &Self::Report, truth: &[[f64; 2]], row: &mut StepRecord);

    /// What the agent watches at this step, for (5.40)-(5.42) and figure 5.9.
    fn watched<'a>(&self, report: &'a Self::Report) -> Watched<'a>;

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

/// What an agent watches at one step.
#[derive(Debug, Clone, Default)]
pub struct Watched<'a> {
    /// F ∩ {z = 0}, `world`, metres; empty without a camera.
    pub footprint: Vec<[f64; 2]>,
    /// C, the ground it sees.
    pub clear_ground: Option<&'a Region>,
    /// L_i.
    pub identified: Vec<TargetId>,
    /// D_i.
    pub detected: Vec<TargetId>,
}
