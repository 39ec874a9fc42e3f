//! A mission is a plug: the engine, the links and the monitor know it by this trait, not by name.

use csat_proto::agent::Agent;
use csat_proto::camera::CameraModel;
use csat_proto::command::YawCommand;
use csat_proto::ids::{AgentId, TargetId};
use serde::Serialize;

/// What distinguishes one kind of mission from another: the agent's mind, what it reports, and what
/// the monitor holds against the truth.
pub trait Mission: Sync {
    /// The agent.
    type Agent: Agent<Command = YawCommand, Event: Serialize> + Sync;

    /// The agent of a UAV at the start of its first life.
    fn agent(&self, id: AgentId) -> Self::Agent;

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
}
