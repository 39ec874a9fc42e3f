//! The set-membership mission: search and track with guaranteed sets.

mod columns;
pub mod judge;
pub mod layers;
pub mod measures;
mod merged;
pub mod report;

use std::sync::Arc;

use csat_agent::agent::{Event, SetMembershipAgent};
use csat_agent::config::AgentConfig;
use csat_agent::shared_cache::SharedCache;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation};
use csat_world::world::World;

use csat_mission::mission::{Detail, Kind, Mission};
use csat_mission::picture::Layer;
use csat_mission::style::Style;
use judge::Containment;
use measures::SetMeasures;
use report::Report;

/// The set-membership mission of a scenario.
#[derive(Debug, Clone)]
pub struct SetMembership {
    config: AgentConfig,
    /// What the agents share; `None` if every agent computes everything itself.
    cache: Option<Arc<SharedCache>>,
}

impl SetMembership {
    /// The mission whose first agent is told `config`.
    pub fn with_config(config: AgentConfig) -> Self {
        Self { config, cache: Some(Arc::default()) }
    }

    /// The same with agents that share no work: the results are the same, too.
    pub fn each_by_itself(self) -> Self {
        Self { cache: None, ..self }
    }
}

impl Mission for SetMembership {
    type Agent = SetMembershipAgent;
    type Report = Report;
    type Judge = Containment;
    type Measures = SetMeasures;

    const KIND: Kind = Kind {
        name: "set-membership",
        columns: columns::COLUMNS,
        headline: &["identified_union", "unexplored_pct"],
        milestones: columns::MILESTONES,
        panels: columns::PANELS,
        promises: judge::PROMISES,
    };

    const LAYERS: &'static [Style] = layers::LAYERS;

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> SetMembershipAgent {
        let config = AgentConfig { id, incarnation, ..self.config.clone() };
        SetMembershipAgent::with_cache(&config, self.cache.clone().unwrap_or_default())
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        (id.0 < self.config.fleet.count).then_some(self.config.camera)
    }

    fn report(&self, agent: &mut SetMembershipAgent, _: &Pose, detail: Detail) -> Report {
        Report::of(agent, detail)
    }

    fn judge(&self, _: &World) -> Containment {
        Containment::default()
    }

    fn measures(&self) -> SetMeasures {
        SetMeasures::new(self.config.ground, self.config.camera, self.config.period_s)
    }

    fn footprint(&self, report: &Report) -> Vec<[f64; 2]> {
        measures::footprint(&self.config.camera, report)
    }

    fn picture(&self, report: &Report) -> Vec<Layer> {
        layers::picture(&self.config.ground, report)
    }

    fn stats(&self, report: &Report) -> Vec<(&'static str, Option<f64>)> {
        measures::stats(&self.config.ground, report)
    }

    fn is_inconsistency(&self, event: &Event) -> bool {
        matches!(event, Event::Inconsistent { .. })
    }

    fn liar_in(&self, event: &Event) -> Option<AgentId> {
        match event {
            Event::Liar { liar, .. } => Some(*liar),
            _ => None,
        }
    }
}
