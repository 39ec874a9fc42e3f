//! What the mission promises: a car that is counted was in view.

use csat_mission::judge::{Broken, Judge, Judged, Promise, Truth};
use csat_proto::camera::CameraModel;
use csat_proto::ids::AgentId;
use csat_proto::region::{Region, grid_point};
use serde_json::{Map, json};

use crate::agent::Count;

/// How far outside of the footprint the middle of a car may be of which the camera sees a part, metres.
const REACH_M: f64 = 5.0;

/// The key of the promise.
const IN_VIEW: &str = "in_view";

/// All that the mission promises.
pub const PROMISES: &[Promise] =
    &[Promise { key: IN_VIEW, broken: "a car counted that was not in view" }];

/// Checks every car that an agent counts in a frame.
pub struct InView {
    camera: CameraModel,
}

impl InView {
    /// A judge of agents with this camera.
    pub fn new(camera: CameraModel) -> Self {
        Self { camera }
    }
}

impl Judge<Count> for InView {
    fn judge(&mut self, agent: AgentId, report: &Count, truth: &Truth<'_>) -> Judged {
        let ring = self.camera.at(&report.pose).footprint();
        let footprint =
            Region::from_shapes(vec![vec![ring.iter().map(|&p| grid_point(p)).collect()]]);
        let new = report.sightings.iter();
        let new = new.filter(|(_, sighting)| sighting.by == agent && sighting.step == report.step);
        let mut judged = Judged::default();
        for (target, sighting) in new {
            judged.checks.push((IN_VIEW, 1));
            let car = truth.targets.iter().find(|car| car.id == *target);
            if car.is_some_and(|car| footprint.distance_m(car.location) <= REACH_M) {
                continue;
            }
            judged.faults.push(Broken {
                promise: IN_VIEW,
                agent,
                detail: Map::from_iter([
                    ("target".to_owned(), json!(target)),
                    ("location".to_owned(), json!(sighting.location)),
                ]),
            });
        }
        judged
    }
}
