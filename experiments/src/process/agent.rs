//! The process of one agent, with the mission that the world's scenario describes.

use csat_peer::agent::{self, AgentError, Welcomed};
use csat_peer::arguments::AgentArguments;
use csat_peer::wire::session::Role;

use crate::missions;
use crate::scenario::Scenario;
use crate::tools::doctor;

/// Drives agent `arguments.id` of the world that answers, until the mission is over. Returns the reason
/// that the world gives.
///
/// # Errors
/// When the process cannot take part, or not go on.
pub fn fly(arguments: &AgentArguments) -> Result<String, AgentError> {
    let role = Role::Agent(arguments.id);
    agent::join(
        arguments,
        |session| doctor::why_no_world(session, &arguments.wire, role),
        take_part,
    )
}

/// Why the world's scenario is not understood: TOML's message, without its excerpt of the file.
#[derive(Debug, thiserror::Error)]
#[error("{}", .0.message())]
struct ScenarioError(toml::de::Error);

fn take_part(welcomed: Welcomed<'_>) -> Result<String, AgentError> {
    let scenario = Scenario::from_toml(&welcomed.welcome.scenario)
        .map_err(|error| AgentError::Scenario(ScenarioError(error).into()))?;
    let mission = missions::find(&scenario.mission)
        .ok_or_else(|| AgentError::Mission(scenario.mission.clone(), missions::names()))?;
    mission.take_part(welcomed, scenario)
}
