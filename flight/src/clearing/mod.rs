//! The road clearing mission (Gagliardi et al. 2014): guaranteed, without map and localisation.

mod claims;
mod columns;
pub mod judge;
pub mod layers;
pub mod measures;
pub mod report;
mod trail;

use std::sync::Arc;

use csat_clearing::agent::{ClearingAgent, Event};
use csat_clearing::config::AgentConfig;
use csat_mission::mission::{Detail, Kind, Mission};
use csat_mission::picture::Layer;
use csat_mission::style::Style;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation};
use csat_world::contamination::Square;
use csat_world::road::RoadGraph;
use csat_world::search_number::Network;
use csat_world::sensor::{RoadSensor, SensorModel};
use csat_world::world::World;

use judge::Safety;
use measures::ClearingMeasures;
use report::{Maps, Report};
use trail::Trails;

/// The road clearing of a scenario.
#[derive(Debug, Clone)]
pub struct Clearing {
    config: AgentConfig,
    segmentation: RoadSensor,
    trails: Arc<Trails>,
}

/// A trail grows once in so many steps: images of one second overlap by 99 %.
const TRAIL_STEPS: u32 = 8;

impl Clearing {
    /// The mission whose first agent is told `config`, and whose cameras see roads so.
    pub fn new(config: AgentConfig, segmentation: RoadSensor) -> Self {
        Self { config, segmentation, trails: Arc::default() }
    }

    /// What the first agent is told.
    pub fn config(&self) -> &AgentConfig {
        &self.config
    }
}

impl Mission for Clearing {
    type Agent = ClearingAgent;
    type Report = Report;
    type Judge = Safety;
    type Measures = ClearingMeasures;

    const KIND: Kind = Kind {
        name: "clearing",
        columns: columns::COLUMNS,
        headline: &["cleared_pct"],
        milestones: columns::MILESTONES,
        panels: columns::PANELS,
        promises: judge::PROMISES,
    };

    const LAYERS: &'static [Style] = layers::LAYERS;

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> ClearingAgent {
        ClearingAgent::new(&AgentConfig { id, incarnation, ..self.config.clone() })
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        (id.0 < self.config.fleet.count).then_some(self.config.camera)
    }

    fn sensor(&self, id: AgentId) -> Option<SensorModel> {
        self.camera(id).map(|camera| SensorModel::Roads(camera, self.segmentation))
    }

    fn report(&self, agent: &mut ClearingAgent, pose: &Pose, detail: Detail) -> Report {
        let mut report = Report::of(agent, pose);
        let is_due = detail == Detail::Full || report.step.0.is_multiple_of(TRAIL_STEPS);
        if let Some(claims) = report.claims.as_ref().filter(|_| is_due) {
            let square = Square::of_image(&self.config.camera, pose);
            self.trails.add(report.agent, &square, claims);
        }
        report.maps =
            (detail == Detail::Full).then(|| Maps::of(agent, self.trails.of(report.agent)));
        report
    }

    fn judge(&self, world: &World) -> Safety {
        let roads = world.road_area().expect("`equip` tells the world of the segmentation");
        let start_line = world.start_line().expect("a world with roads has a start line");
        let connected = roads.component(start_line);
        let network = Network::of_roads(&RoadGraph::within(world.map(), &connected));
        Safety::new(&self.config, roads, connected, network.as_ref())
    }

    fn measures(&self) -> ClearingMeasures {
        ClearingMeasures::new(self.config.pixel_m())
    }

    fn footprint(&self, report: &Report) -> Vec<[f64; 2]> {
        let Square { middle: [x, y], side_m } = Square::of_image(&self.config.camera, &report.pose);
        let half_m = side_m / 2.0;
        vec![
            [x - half_m, y - half_m],
            [x + half_m, y - half_m],
            [x + half_m, y + half_m],
            [x - half_m, y + half_m],
        ]
    }

    fn picture(&self, report: &Report) -> Vec<Layer> {
        layers::picture(&self.config.camera, report)
    }

    fn stats(&self, report: &Report) -> Vec<(&'static str, Option<f64>)> {
        vec![("frontier_m", Some(self.config.pixel_m() * f64::from(report.frontier_px)))]
    }

    /// Nothing that an honest fleet says contradicts itself.
    fn is_inconsistency(&self, _: &Event) -> bool {
        false
    }
}
