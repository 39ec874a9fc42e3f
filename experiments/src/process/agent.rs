//! The process of one agent, with the mission that the world's scenario describes.

use csat_mission::engine;
use csat_netem::link::Links;
use csat_peer::agent::{self, AgentError, Setup, Welcomed};
use csat_peer::arguments::AgentArguments;
use csat_peer::wire::session::Role;
use csat_world::world::{World, WorldErrors};

use crate::scenario::Scenario;
use crate::set_membership::SetMembership;
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
    let scenario: Scenario = toml::from_str(&welcomed.welcome.scenario)
        .map_err(|error| AgentError::Scenario(ScenarioError(error).into()))?;
    let map = welcomed.welcome.map.clone();
    welcomed.fly(Setup {
        mission: SetMembership::new(&scenario),
        period_s: scenario.run.period_s,
        channels: scenario.netem.all_channels().count(),
        uavs: scenario.agents.count,
        agents: scenario.agent_count(),
        links: Box::new(move || links(&scenario, map.as_deref())),
    })
}

/// The links to an agent, with the buildings that stand in their way.
fn links(scenario: &Scenario, map: Option<&str>) -> Result<Links, WorldErrors> {
    let obstruction = if scenario.netem.has_propagation() {
        let mut config = scenario.world_config();
        // The links need only the buildings: an agent knows neither the cars nor their tracks.
        config.targets.count = 0;
        let world = match map {
            Some(text) => World::from_geojson(&config, text, scenario.seed),
            None => World::new(&config, scenario.seed),
        };
        engine::obstruction(&scenario.netem, &world?)
    } else {
        None
    };
    Ok(Links::new(&scenario.netem, scenario.seed, obstruction))
}
