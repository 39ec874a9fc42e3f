//! The set-membership mission: search and track with guaranteed sets.

pub mod layers;
pub mod report;

use csat_agent::agent::{Event, SetMembershipAgent};
use csat_agent::commons::Commons;
use csat_agent::config::AgentConfig;
use csat_agent::mutant::{Mutant, is_on};
use csat_proto::camera::CameraModel;
use csat_proto::ids::{AgentId, Incarnation, RunId, TargetId};

use crate::metrics::percent_of;
use crate::metrics::{localization, set_localization};
use crate::scenario::Scenario;
use csat_mission::mission::{Detail, Mission, Watched};
use csat_mission::picture::Layer;
use csat_mission::row::StepRecord;
use csat_mission::style::Style;
use report::Report;

/// The set-membership mission of a scenario.
#[derive(Debug, Clone)]
pub struct SetMembership {
    config: AgentConfig,
    /// `None` if every agent is to work everything out by itself.
    commons: Option<Commons>,
}

impl SetMembership {
    /// The mission that `scenario` describes.
    pub fn new(scenario: &Scenario) -> Self {
        Self { config: agent_config(scenario), commons: Some(Commons::default()) }
    }

    /// The same with agents that share no work: the results are the same, too.
    pub fn each_by_itself(self) -> Self {
        Self { commons: None, ..self }
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
    const LAYERS: &'static [Style] = layers::LAYERS;

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> SetMembershipAgent {
        let config = AgentConfig { id, incarnation, ..self.config.clone() };
        SetMembershipAgent::sharing(&config, self.commons.clone().unwrap_or_default())
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        (id.0 < self.config.fleet.count).then_some(self.config.camera)
    }

    fn report(&self, agent: &mut SetMembershipAgent, detail: Detail) -> Report {
        Report::of(agent, detail)
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
        set_localization(row, localization(sets, truth));
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

    fn picture(&self, report: &Report) -> Vec<Layer> {
        layers::picture(&self.config.ground, report)
    }

    fn stats(&self, report: &Report) -> Vec<(&'static str, Option<f64>)> {
        let unexplored_pct = percent_of(&self.config.ground, report.unexplored.area_m2());
        vec![
            ("identified", Some(report.targets.len() as f64)),
            ("unexplored_pct", Some(unexplored_pct)),
            ("hidden_pct", Some(report.hidden_pct)),
            ("oem_iou_pct", report.oem_iou_pct),
            ("news_age_s", report.news_age_s),
            ("vertices", Some(f64::from(report.vertices()))),
        ]
    }

    fn is_inconsistency(&self, event: &Event) -> bool {
        matches!(event, Event::Inconsistent { .. })
    }
}
