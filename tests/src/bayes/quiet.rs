//! The Bayesian search without judge and measures: what agents know is looked at when a mission is over.

use csat_bayes::agent::{BayesAgent, Event};
use csat_flight::bayes::Bayes;
use csat_flight::scenario::Scenario;
use csat_flight::scenario::missions::Offered;
use csat_mission::judge::{Judge, Judged, Truth};
use csat_mission::measures::{Measures, Values};
use csat_mission::mission::{self, Detail, Kind, Mission, Tally};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;
use csat_world::sensor::SensorModel;
use csat_world::world::World;
use serde::{Deserialize, Serialize};

/// The mission.
#[derive(Debug, Clone)]
pub struct Quiet(Bayes);

impl Quiet {
    /// The mission of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        Self(Bayes::of(scenario))
    }
}

/// Next to nothing.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Nothing {
    step: Step,
    pose: Pose,
    tally: Tally,
}

impl mission::Report for Nothing {
    fn step(&self) -> Step {
        self.step
    }

    fn pose(&self) -> &Pose {
        &self.pose
    }

    fn planned(&self) -> &[Pose] {
        &[]
    }

    fn tally(&self) -> &Tally {
        &self.tally
    }
}

impl Mission for Quiet {
    type Agent = BayesAgent;
    type Report = Nothing;
    type Judge = Self;
    type Measures = Self;

    const KIND: Kind = Kind { columns: &[], ..Bayes::KIND };

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> BayesAgent {
        self.0.agent(id, incarnation)
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        self.0.camera(id)
    }

    fn sensor(&self, id: AgentId) -> Option<SensorModel> {
        self.0.sensor(id)
    }

    fn report(&self, agent: &mut BayesAgent, _: &Pose, _: Detail) -> Nothing {
        Nothing {
            step: agent.filter().step(),
            pose: *agent.pose(),
            tally: Tally { rejected: agent.rejected().clone(), withheld: agent.withheld() },
        }
    }

    fn judge(&self, _: &World) -> Self {
        self.clone()
    }

    fn measures(&self) -> Self {
        self.clone()
    }

    fn footprint(&self, _: &Nothing) -> Vec<[f64; 2]> {
        Vec::new()
    }

    fn is_inconsistency(&self, event: &Event) -> bool {
        self.0.is_inconsistency(event)
    }
}

impl Judge<Nothing> for Quiet {
    fn judge(&mut self, _: AgentId, _: &Nothing, _: &Truth<'_>) -> Judged {
        Judged::default()
    }
}

impl Measures<Nothing> for Quiet {
    fn fleet(&mut self, _: &[&Nothing], _: &[[f64; 2]]) -> Values {
        Values::new()
    }

    fn agent(&self, _: &Nothing, _: &[[f64; 2]]) -> Values {
        Values::new()
    }
}
