//! A mission is a plug: the engine, the monitor, the metrics and the pictures know it by this trait,
//! not by name.

use std::collections::BTreeMap;

use csat_proto::agent::Agent;
use csat_proto::camera::CameraModel;
use csat_proto::command::YawCommand;
use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::region::Region;
use serde::Serialize;

use crate::metrics::StepRecord;
use crate::view;

/// What distinguishes one kind of mission from another: the agent's mind, what it reports, what the
/// monitor holds against the truth, and what is measured and drawn.
pub trait Mission: Sync {
    /// The agent.
    type Agent: Agent<Command = YawCommand, Event: Serialize> + Sync;

    /// The agent of a UAV at the start of one of its lives.
    fn agent(&self, id: AgentId, incarnation: Incarnation) -> Self::Agent;

    /// The camera of every UAV.
    fn camera(&self) -> CameraModel;

    /// The monitor's question: does what `agent` knows admit that `target` is at `location` (`world`,
    /// metres) or within `tolerance_m` of it?
    fn admits(
        &self,
        agent: &Self::Agent,
        target: TargetId,
        location: [f64; 2],
        tolerance_m: f64,
    ) -> bool;

    /// Fills in an agent's own part of a row of metrics; `truth` holds the targets' locations.
    fn measure(&self, agent: &mut Self::Agent, truth: &[[f64; 2]], row: &mut StepRecord);

    /// What the agent watches at this step, for (5.40)-(5.42) and figure 5.9.
    fn watched<'a>(&self, agent: &'a Self::Agent) -> Watched<'a>;

    /// What the agent knows, to be drawn.
    fn view(&self, agent: &Self::Agent) -> view::Knowledge;

    /// What an agent did not believe and did not say in its life so far.
    fn tally(&self, agent: &Self::Agent) -> Tally;

    /// Whether an event says that an assumption failed.
    fn is_inconsistency(&self, event: &<Self::Agent as Agent>::Event) -> bool;
}

/// What an agent did not believe and did not say.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
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
    /// F ∩ {z = 0}, `world`, metres.
    pub footprint: Vec<[f64; 2]>,
    /// C, the ground it sees.
    pub clear_ground: Option<&'a Region>,
    /// L_i.
    pub identified: Vec<TargetId>,
    /// D_i.
    pub detected: Vec<TargetId>,
}
