//! The set-membership mission: search and track with guaranteed sets.

use csat_agent::agent::{Event, SetMembershipAgent};
use csat_agent::config::AgentConfig;
use csat_proto::camera::CameraModel;
use csat_proto::ids::{AgentId, Incarnation, RunId, TargetId};

use crate::metrics::{StepRecord, hidden_unexplored_pct, localization, oem_iou_pct, percent_of};
use crate::plug::{Mission, Tally, Watched};
use crate::scenario::Scenario;
use crate::view;

/// The set-membership mission of a scenario.
#[derive(Debug, Clone)]
pub struct SetMembership {
    config: AgentConfig,
}

impl SetMembership {
    /// The mission that `scenario` describes.
    pub fn new(scenario: &Scenario) -> Self {
        let config = AgentConfig {
            run: RunId(scenario.seed),
            id: AgentId(0),
            incarnation: Incarnation(0),
            period_s: scenario.run.period_s,
            ground: scenario.ground(),
            targets: scenario.targets,
            fleet: scenario.agents,
            camera: scenario.camera,
            estimator: scenario.estimator,
            guidance: scenario.guidance.clone(),
            exchange: scenario.exchange.clone(),
            channels: scenario.channels(),
        };
        Self { config }
    }
}

impl Mission for SetMembership {
    type Agent = SetMembershipAgent;

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> SetMembershipAgent {
        SetMembershipAgent::new(&AgentConfig { id, incarnation, ..self.config.clone() })
    }

    fn camera(&self) -> CameraModel {
        self.config.camera
    }

    fn admits(
        &self,
        agent: &SetMembershipAgent,
        target: TargetId,
        location: [f64; 2],
        tolerance_m: f64,
    ) -> bool {
        agent.knowledge().set_of(target).region().distance_m(location) <= tolerance_m
    }

    fn measure(&self, agent: &mut SetMembershipAgent, truth: &[[f64; 2]], row: &mut StepRecord) {
        let expected = agent.predicted_hidden();
        let knowledge = agent.knowledge();
        let ground = &self.config.ground;
        let sets = knowledge.targets.iter().map(|(&j, set)| (j, set.region()));
        row.identified = knowledge.targets.len() as u16;
        row.set_localization(localization(sets, truth));
        let unexplored = knowledge.unexplored.region();
        row.unexplored_pct = percent_of(ground, unexplored.area_m2());
        row.hidden_pct = hidden_unexplored_pct(unexplored, &knowledge.hidden, ground);
        row.oem_iou_pct = agent.measured().and_then(|m| oem_iou_pct(&m.hidden, &expected));
        let sets = knowledge.targets.values().map(|set| set.region());
        let regions = sets.chain([unexplored, knowledge.margin.region()]);
        row.vertices = regions.map(|region| region.vertex_count() as u32).sum();
    }

    fn watched<'a>(&self, agent: &'a SetMembershipAgent) -> Watched<'a> {
        let measured = agent.measured();
        Watched {
            footprint: self.config.camera.at(agent.pose()).footprint(),
            clear_ground: measured.map(|m| m.clear_ground.region()),
            identified: agent.knowledge().targets.keys().copied().collect(),
            detected: measured.into_iter().flat_map(|m| &m.targets).map(|t| t.target).collect(),
        }
    }

    fn view(&self, agent: &SetMembershipAgent) -> view::Knowledge {
        let knowledge = agent.knowledge();
        let targets = knowledge.targets.iter();
        view::Knowledge {
            unexplored: view::shapes(knowledge.unexplored.region()),
            targets: targets.map(|(j, set)| (j.0, view::shapes(set.region()))).collect(),
            obstacle_margin: view::shapes(knowledge.margin.region()),
            hidden: view::cells(&knowledge.hidden),
            oem: view::oem(knowledge.oem.grid(), knowledge.oem.cells()),
        }
    }

    fn tally(&self, agent: &SetMembershipAgent) -> Tally {
        let rejected = agent.rejected().iter().map(|(reason, n)| ((*reason).to_owned(), *n));
        Tally { rejected: rejected.collect(), withheld: agent.withheld() }
    }

    fn is_inconsistency(&self, event: &Event) -> bool {
        matches!(event, Event::Inconsistent { .. })
    }
}
