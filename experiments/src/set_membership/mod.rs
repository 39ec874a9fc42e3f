//! The set-membership mission: search and track with guaranteed sets.

mod documents;
pub mod report;

use std::sync::Arc;

use csat_agent::agent::{Event, SetMembershipAgent};
use csat_agent::config::AgentConfig;
use csat_agent::mutant::{Mutant, is_on};
use csat_agent::shared_cache::SharedCache;
use csat_proto::camera::CameraModel;
use csat_proto::ids::{AgentId, Incarnation, RunId, TargetId};
use csat_proto::time::Step;

use crate::metrics::{StepRecord, localization, percent_of};
use crate::plug::{Detail, Mission, Tally, Watched};
use crate::rounding;
use crate::scenario::Scenario;
use crate::show::documents::{AgentStep, Document};
use crate::view;
use report::Report;

/// The set-membership mission of a scenario.
#[derive(Debug, Clone)]
pub struct SetMembership {
    config: AgentConfig,
    /// What the agents share; `None` if every agent computes everything itself.
    cache: Option<Arc<SharedCache>>,
}

impl SetMembership {
    /// The mission that `scenario` describes.
    pub fn new(scenario: &Scenario) -> Self {
        Self { config: agent_config(scenario), cache: Some(Arc::default()) }
    }

    /// The same with agents that share no work: the results are the same, too.
    pub fn each_by_itself(self) -> Self {
        Self { cache: None, ..self }
    }
}

/// What the first agent of a scenario is told.
pub fn agent_config(scenario: &Scenario) -> AgentConfig {
    AgentConfig {
        run: RunId(scenario.seed),
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: scenario.run.period_s,
        ground: scenario.ground(),
        targets: scenario.targets.clone(),
        fleet: scenario.agents.clone(),
        stations: scenario.agent_count() - scenario.agents.count,
        camera: scenario.camera,
        estimator: scenario.estimator,
        guidance: scenario.guidance.clone(),
        exchange: scenario.exchange.clone(),
        channels: scenario.channels(),
    }
}

impl Mission for SetMembership {
    type Agent = SetMembershipAgent;
    type Report = Report;

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> SetMembershipAgent {
        let config = AgentConfig { id, incarnation, ..self.config.clone() };
        SetMembershipAgent::with_cache(&config, self.cache.clone().unwrap_or_default())
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        (id.0 < self.config.fleet.count).then_some(self.config.camera)
    }

    fn report(&self, agent: &mut SetMembershipAgent, detail: Detail) -> Report {
        Report::of(agent, detail)
    }

    fn step(&self, report: &Report) -> Step {
        report.step
    }

    fn admits(
        &self,
        report: &Report,
        target: TargetId,
        location: [f64; 2],
        tolerance_m: f64,
    ) -> bool {
        let lenient_m = if is_on(Mutant::MonitorLenient) { 1.0 } else { 0.0 };
        report.set_of(target).distance_m(location) <= tolerance_m + lenient_m
    }

    fn measure(&self, report: &Report, truth: &[[f64; 2]], row: &mut StepRecord) {
        let sets = report.targets.iter().map(|(j, set)| (*j, set));
        row.identified = report.targets.len() as u16;
        row.set_localization(localization(sets, truth));
        row.unexplored_pct = percent_of(&self.config.ground, report.unexplored.area_m2());
        row.hidden_pct = report.hidden_pct;
        row.oem_iou_pct = report.oem_iou_pct;
        row.news_age_s = report.news_age_s;
        row.vertices = report.vertices();
    }

    fn watched<'a>(&self, report: &'a Report) -> Watched<'a> {
        let (view, clear_ground) =
            (self.config.camera.at(&report.pose), report.clear_ground.as_ref());
        Watched {
            footprint: clear_ground.map_or_else(Vec::new, |_| view.footprint()),
            clear_ground,
            identified: report.targets.iter().map(|(j, _)| *j).collect(),
            detected: report.detected.clone(),
        }
    }

    fn view(&self, report: &Report) -> view::Knowledge {
        let maps = report.maps.as_ref();
        let ground = &self.config.ground;
        let targets = report.targets.iter();
        view::Knowledge {
            unexplored: rounding::outer(&report.unexplored, ground),
            targets: targets.map(|(j, set)| (j.0, rounding::outer(set, ground))).collect(),
            obstacle_margin: rounding::inner(&report.obstacle_margin),
            hidden: maps.map(|maps| view::cells(&maps.hidden)).unwrap_or_default(),
            oem: maps.map(|maps| view::oem(&maps.oem_grid, &maps.oem_cells())).unwrap_or_default(),
        }
    }

    fn documents(&self, step: &AgentStep<'_, Report>, known: &view::Knowledge) -> Vec<Document> {
        let camera = self.camera(step.agent);
        documents::documents(camera.as_ref(), &self.config.ground, step, known)
    }

    fn tally<'a>(&self, report: &'a Report) -> &'a Tally {
        &report.tally
    }

    fn is_inconsistency(&self, event: &Event) -> bool {
        matches!(event, Event::Inconsistent { .. })
    }
}
