//! A mission of its own on csat, as docs/extending.md explains it: a census. Each UAV flies straight ahead,
//! turns back at the border of the region, and counts the cars that its camera identifies. The UAVs tell each
//! other what they counted.
//!
//! | module | what it holds |
//! |---|---|
//! | [`agent`] | the agent: a state machine without clock, socket or file |
//! | [`judge`] | what the mission promises |
//! | [`measures`] | what is measured |
//! | [`picture`] | what is drawn |
//!
//! This file ties them together.

pub mod agent;
pub mod judge;
pub mod measures;
pub mod picture;

use csat_experiments::missions::Offered;
use csat_experiments::scenario::Scenario;
use csat_experiments::scenario::validate::Issue;
use csat_mission::mission::{Detail, Kind, Mission};
use csat_mission::picture::Layer;
use csat_mission::style::Style;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation, RunId};
use csat_proto::model::Ground;
use csat_world::world::World;
use serde::{Deserialize, Serialize};

use crate::agent::{Counter, Identity};
use crate::judge::InView;
use crate::measures::Tallies;
use agent::Count;

/// The mission's own table of a scenario, `[census]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// How near to the border a UAV turns back, metres.
    pub margin_m: f64,
    /// The angle between the courses of one UAV and the next, degrees.
    pub spread_deg: f64,
    /// Whether the UAVs tell each other what they counted.
    pub share: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { margin_m: 50.0, spread_deg: 25.0, share: true }
    }
}

/// The tables that only this mission knows.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tables {
    /// `[census]`.
    pub census: Settings,
}

/// The mission of a scenario.
#[derive(Debug, Clone)]
pub struct Census {
    run: RunId,
    uavs: u16,
    ground: Ground,
    camera: CameraModel,
    settings: Settings,
}

impl Offered for Census {
    type Tables = Tables;

    fn of(scenario: &Scenario) -> Self {
        Self {
            run: RunId(scenario.seed),
            uavs: scenario.agents.count,
            ground: scenario.ground(),
            camera: scenario.camera,
            settings: scenario.own::<Tables>().census,
        }
    }

    /// Types and names are judged already. What is left: a margin that leaves room to fly, and an angle.
    fn judge_scenario(scenario: &Scenario) -> Vec<Issue> {
        let Tables { census: Settings { margin_m, spread_deg, .. } } = scenario.own();
        let [width_m, depth_m] = scenario.map.size_m;
        let half_m = width_m.min(depth_m) / 2.0;
        let margin = (!(0.0..half_m).contains(&margin_m)).then(|| {
            let expected =
                format!("from 0 m to less than half of the region's shorter side, {half_m} m");
            Issue::refused(&["census.margin_m", "map.size_m"], &margin_m.to_string(), &expected)
        });
        let spread = (!(0.0..=180.0).contains(&spread_deg)).then(|| {
            Issue::refused(&["census.spread_deg"], &spread_deg.to_string(), "from 0 to 180 degrees")
        });
        margin.into_iter().chain(spread).collect()
    }
}

impl Mission for Census {
    type Agent = Counter;
    type Report = Count;
    type Judge = InView;
    type Measures = Tallies;

    const KIND: Kind = Kind {
        name: "census",
        columns: measures::COLUMNS,
        headline: &["counted_union", "looked_at_pct"],
        milestones: measures::MILESTONES,
        panels: measures::PANELS,
        promises: judge::PROMISES,
    };

    const LAYERS: &'static [Style] = picture::LAYERS;

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> Counter {
        let Self { run, uavs, ground, camera, settings } = *self;
        let camera = (id.0 < uavs).then_some(camera);
        let places = f64::from(id.0) - f64::from(uavs - 1) / 2.0;
        let offset_rad = (places * settings.spread_deg).to_radians();
        Counter::new(Identity { run, id, incarnation }, ground, camera, settings, offset_rad)
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        (id.0 < self.uavs).then_some(self.camera)
    }

    fn report(&self, agent: &mut Counter, _: &Pose, detail: Detail) -> Count {
        agent.report(detail)
    }

    fn footprint(&self, report: &Count) -> Vec<[f64; 2]> {
        if report.has_looked { self.camera.at(&report.pose).footprint() } else { Vec::new() }
    }

    fn judge(&self, _: &World) -> InView {
        InView::new(self.camera)
    }

    fn measures(&self) -> Tallies {
        Tallies::new(self.ground, self.camera)
    }

    fn picture(&self, report: &Count) -> Vec<Layer> {
        picture::layers(report)
    }

    fn stats(&self, report: &Count) -> Vec<(&'static str, Option<f64>)> {
        measures::stats(report)
    }

    /// The agents report no events.
    fn is_inconsistency(&self, (): &()) -> bool {
        false
    }
}
