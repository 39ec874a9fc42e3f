//! Whole missions through the engine, in worlds small enough for many of them.

use csat_agent::agent::Event;
use csat_agent::config::ExchangeMode;
use csat_experiments::scenario::{self, Request, Scenario, missions};
use csat_experiments::set_membership::SetMembership;
use csat_experiments::set_membership::report::percent_of;
use csat_mission::engine::Engine;
use csat_mission::mission::Mission;
use csat_proto::ids::AgentId;
use csat_world::world::{World, WorldErrors};
use serde::Serialize;

/// A generated town of `side_m`, a small coarse camera, low UAVs.
pub fn small(seed: u64, side_m: f64, uavs: u16) -> Scenario {
    let mut scenario = Scenario { seed, ..Scenario::default() };
    scenario.map.size_m = [side_m; 2];
    scenario.map.built_share = 0.08;
    scenario.map.max_height_m = 25.0;
    scenario.map.road_spacing_m = 45.0;
    scenario.targets.count = 4;
    scenario.agents.count = uavs;
    scenario.agents.altitude_m = 34.0;
    scenario.camera.columns = 96;
    scenario.camera.rows = 72;
    scenario.camera.tilt_deg = 40.0;
    scenario.camera.d_max_m = 150.0;
    scenario.camera.min_pixels = 2;
    scenario
}

/// A scenario that ships with csat.
///
/// # Panics
/// When it does not load.
pub fn shipped(name: &str) -> Scenario {
    let request = Request { scenario: Some(name), ..Request::default() };
    scenario::load(request).expect("it is shipped").scenario
}

/// The scenario with these tables of its mission's own.
///
/// # Panics
/// When something is wrong with it.
pub fn with_tables(mut scenario: Scenario, tables: &impl Serialize) -> Scenario {
    scenario.own = toml::Table::try_from(tables).expect("tables are TOML");
    let mission = missions::find(&scenario.mission).expect("it is shipped");
    let issues = scenario::validate::validate(&scenario, mission.judge_scenario(&scenario));
    let wrong: Vec<_> = issues.iter().filter(|issue| !issue.is_warning).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    scenario
}

/// The world of a scenario.
///
/// # Errors
/// When there is none.
pub fn world_of(scenario: &Scenario) -> Result<World, WorldErrors> {
    World::new(&scenario.world_config(), scenario.seed)
}

/// How a mission went.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The digest of the knowledge of every agent at every step.
    pub digest: u64,
    /// All violations that the monitor found, as text.
    pub violations: Vec<String>,
    /// Sets of honest agents that became empty.
    pub inconsistencies: u64,
    /// φ(X̄), mean over agents at the end, per cent.
    pub unexplored_pct: f64,
    /// φ(X̄), mean over agents and steps, per cent.
    pub mean_unexplored_pct: f64,
    /// Targets known to the first agent at the end.
    pub identified: usize,
    /// Lost messages.
    pub dropped: u64,
    /// How often a UAV began to fly without a way out.
    pub no_way_out: u64,
    /// Who was named as a liar, by whom, and when, seconds.
    pub named: Vec<Named>,
}

/// An honest agent named another one as a liar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Named {
    /// Whom.
    pub liar: AgentId,
    /// Who did.
    pub by: AgentId,
    /// When, seconds.
    pub time_s: f64,
}

impl Outcome {
    /// # Panics
    /// When a violation or an inconsistency occurred.
    pub fn check(&self, what: &str) {
        assert!(self.violations.is_empty(), "{what}: {:#?}", self.violations);
        assert_eq!(self.inconsistencies, 0, "{what}: sets became empty");
    }
}

/// Flies steps 0 to `steps`.
///
/// # Panics
/// When the scenario has no world.
pub fn fly(scenario: &Scenario, steps: u32) -> Outcome {
    fly_mission(SetMembership::new(scenario), scenario, steps)
}

/// Flies steps 0 to `steps` of a mission of `scenario`.
///
/// # Panics
/// When the scenario has no world.
pub fn fly_mission(mission: SetMembership, scenario: &Scenario, steps: u32) -> Outcome {
    let world = world_of(scenario).unwrap_or_else(|e| panic!("seed {}: {e}", scenario.seed));
    fly_in(mission, world, scenario, steps)
}

/// The same in a given world.
///
/// # Panics
/// When messages were not conserved.
pub fn fly_in(mission: SetMembership, world: World, scenario: &Scenario, steps: u32) -> Outcome {
    let mut engine = Engine::new(mission.clone(), world, &scenario.netem, scenario.seed);
    let (mut violations, mut inconsistencies, mut sum) = (Vec::new(), 0, 0.0);
    let (mut unexplored_pct, mut no_way_out, mut named) = (0.0, 0, Vec::new());
    for _ in 0..=steps {
        let trace = engine.step();
        violations.extend(trace.violations.iter().map(|v| format!("{v:?}")));
        let is_honest = |agent: &AgentId| !engine.is_false(*agent);
        let honest = || trace.events.iter().filter(|(agent, _)| is_honest(agent));
        inconsistencies +=
            honest().filter(|(_, event)| mission.is_inconsistency(event)).count() as u64;
        let is_lost = |event: &Event| matches!(event, Event::NoWayOut { .. });
        no_way_out += trace.events.iter().filter(|(_, event)| is_lost(event)).count() as u64;
        let time_s = f64::from(trace.step.0) * scenario.run.period_s;
        named.extend(honest().filter_map(|(by, event)| {
            Some(Named { liar: mission.liar_in(event)?, by: *by, time_s })
        }));
        let nodes = engine.nodes();
        let share = |region| percent_of(&scenario.ground(), region);
        let all = nodes.iter().map(|s| share(s.agent.knowledge().unexplored.region().area_m2()));
        unexplored_pct = all.sum::<f64>() / nodes.len() as f64;
        sum += unexplored_pct;
    }
    assert!(engine.counters().conserved(), "{:?}", engine.counters());
    Outcome {
        digest: engine.digest(),
        violations,
        inconsistencies,
        unexplored_pct,
        mean_unexplored_pct: sum / f64::from(steps + 1),
        identified: engine.nodes()[0].agent.knowledge().targets.len(),
        dropped: engine.counters().dropped.values().sum(),
        no_way_out,
        named,
    }
}

/// The scenario with another mode of exchange.
pub fn with_mode(mut scenario: Scenario, mode: ExchangeMode) -> Scenario {
    scenario.exchange.mode = mode;
    scenario
}
