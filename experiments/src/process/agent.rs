//! The process of one agent: the mission that it flies, from the scenario of the world's welcome.

use csat_peer::agent::{self, AgentError, Welcomed};
use csat_peer::arguments::AgentArguments;
use csat_peer::wire::session::Role;

use crate::missions;
use crate::scenario::Scenario;
use crate::tools::doctor;

/// Drives agent `arguments.id` of the world that answers, until the mission is over. Gives the reason why
/// it is.
///
/// # Errors
/// When the process cannot take part, or not go on.
pub fn fly(arguments: &AgentArguments) -> Result<String, AgentError> {
    let role = Role::Agent(arguments.id);
    agent::join(arguments, |session| doctor::why_nobody(session, &arguments.wire, role), take_part)
}

fn take_part(welcomed: Welcomed<'_>) -> Result<String, AgentError> {
    let scenario = Scenario::from_toml(&welcomed.welcome.scenario)
        .map_err(|error| AgentError::Scenario(error.message().to_owned()))?;
    let mission = missions::find(&scenario.mission).ok_or_else(|| {
        AgentError::Scenario(format!("this program flies no mission `{}`", scenario.mission))
    })?;
    mission.take_part(welcomed, scenario)
}
