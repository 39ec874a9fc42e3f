//! The Bayesian search mission (Tisdale et al. 2008): beliefs from shared likelihoods.

mod columns;
pub mod judge;
pub mod layers;
pub mod measures;
pub mod report;

use csat_bayes::agent::{BayesAgent, Event};
use csat_bayes::config::AgentConfig;
use csat_bayes::likelihood::Sensor;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation};
use csat_world::sensor::SensorModel;
use csat_world::world::World;

use csat_mission::mission::{Detail, Kind, Mission};
use csat_mission::picture::Layer;
use csat_mission::style::Style;
use judge::Posterior;
use measures::BayesMeasures;
use report::Report;

/// The Bayesian search of a scenario.
#[derive(Debug, Clone)]
pub struct Bayes {
    config: AgentConfig,
}

impl Bayes {
    /// The mission whose first agent is told `config`.
    pub fn with_config(config: AgentConfig) -> Self {
        Self { config }
    }

    /// What the first agent is told.
    pub fn config(&self) -> &AgentConfig {
        &self.config
    }
}

impl Mission for Bayes {
    type Agent = BayesAgent;
    type Report = Report;
    type Judge = Posterior;
    type Measures = BayesMeasures;

    const KIND: Kind = Kind {
        name: "bayes",
        columns: columns::COLUMNS,
        headline: &["detections"],
        milestones: columns::MILESTONES,
        panels: columns::PANELS,
        promises: judge::PROMISES,
    };

    const LAYERS: &'static [Style] = layers::LAYERS;

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> BayesAgent {
        BayesAgent::new(&AgentConfig { id, incarnation, ..self.config.clone() })
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        (id.0 < self.config.fleet.count).then_some(self.config.camera)
    }

    fn sensor(&self, id: AgentId) -> Option<SensorModel> {
        let detector = self.config.detector;
        self.camera(id).map(|camera| SensorModel::Detector(camera, detector))
    }

    fn report(&self, agent: &mut BayesAgent, _: &Pose, detail: Detail) -> Report {
        Report::of(agent, detail)
    }

    fn judge(&self, _: &World) -> Posterior {
        Posterior::new(Sensor::new(&self.config))
    }

    fn measures(&self) -> BayesMeasures {
        BayesMeasures::new(self.config.camera)
    }

    fn footprint(&self, report: &Report) -> Vec<[f64; 2]> {
        match report.own {
            Some(_) => self.config.camera.at(&report.pose).footprint(),
            None => Vec::new(),
        }
    }

    fn picture(&self, report: &Report) -> Vec<Layer> {
        layers::picture(&self.config.ground, report)
    }

    fn stats(&self, report: &Report) -> Vec<(&'static str, Option<f64>)> {
        measures::stats(report)
    }

    /// Two factors of one identity: an agent is wrong.
    fn is_inconsistency(&self, event: &Event) -> bool {
        matches!(event, Event::Conflict { .. })
    }
}
