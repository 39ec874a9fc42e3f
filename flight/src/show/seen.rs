//! What people see of an agent.

use csat_mission::picture::Ring;
use csat_proto::ids::AgentId;

use super::drawn::Drawn;

/// What people see of an agent at one step.
#[derive(Debug)]
pub struct Seen {
    /// Whose.
    pub agent: AgentId,
    /// F ∩ {z = 0}, `world`, metres.
    pub footprint: Ring,
    /// What it knows, as far as viewers draw it.
    pub layers: Vec<Drawn>,
    /// Whether an agent before it knows the very same, as with perfect links.
    pub is_repeated: bool,
}
