//! Where an aircraft flies (Tisdale et al. 2008, section IV).
//!
//! [`Guide`] gives headings. `lawnmower` and `waypoints` follow given routes. `information` plans turns over a
//! receding horizon by beam search (`beam`): for the probability of detection (`coverage`) as long as there is no
//! target, then for the expected covariance of the target (`localisation`). Turns are predicted by the vehicle's
//! model (`manoeuvre`), with banks and their footprints (`footprint`): while an aircraft banks, its camera looks
//! outward, and planned turns to one side and the other sweep twice the width that level flight does.

mod beam;
mod coverage;
mod dubins;
mod footprint;
mod information;
mod lanes;
mod localisation;
mod manoeuvre;
mod navigation;
mod neighbours;
mod route;
#[cfg(test)]
mod tests;

use csat_proto::camera::Pose;
use csat_proto::command::Command;
use csat_proto::fixed_wing::FixedWing;
use csat_proto::ids::AgentId;
use csat_proto::time::Step;

use crate::config::{AgentConfig, Criterion};
use crate::search_map::{Gaussian, SearchMap};

use information::Information;
use lanes::Lanes;
use navigation::{Airframe, Navigation};
use route::{Route, Waypoints};

/// What guidance is told in a step.
pub struct GuidanceInput<'a> {
    /// The step.
    pub step: Step,
    /// The reported pose.
    pub pose: &'a Pose,
    /// The belief, when it is asked for.
    pub map: &'a dyn Fn() -> SearchMap,
    /// The target, once there is one to localise.
    pub target: Option<Gaussian>,
    /// The newest known plans of other aircraft.
    pub neighbours: &'a [NeighbourPlan],
}

/// What another aircraft intends.
#[derive(Debug, Clone, PartialEq)]
pub struct NeighbourPlan {
    /// Which one.
    pub id: AgentId,
    /// When it decided.
    pub step: Step,
    /// Its poses 1, 2, … seconds after `step`.
    pub poses: Vec<Pose>,
}

/// Decides where an aircraft flies.
#[derive(Debug, Clone)]
pub struct Guide {
    airframe: Airframe,
    navigation: Navigation,
    pilot: Pilot,
    /// When the plan was made, and the plan.
    planned: (Step, Vec<Pose>),
}

#[derive(Debug, Clone)]
enum Pilot {
    Lawnmower(Lanes, Option<Route>),
    Waypoints(Waypoints),
    Information(Box<Information>),
}

/// How far `lawnmower` and `waypoints` announce their way, seconds.
const ANNOUNCED_S: u32 = 20;

impl Guide {
    /// The guide of an aircraft.
    pub fn new(config: &AgentConfig) -> Self {
        let airframe = Airframe::new(config);
        let pilot = match config.guidance.criterion {
            Criterion::Lawnmower => Pilot::Lawnmower(Lanes::new(config, &airframe), None),
            Criterion::Waypoints => Pilot::Waypoints(Waypoints::new(config)),
            Criterion::Information => {
                Pilot::Information(Box::new(Information::new(config, airframe)))
            }
        };
        let navigation = Navigation::new(airframe);
        Self { airframe, navigation, pilot, planned: (Step(0), Vec::new()) }
    }

    /// What to fly from this step on; `None`: as before. To be called once per step, after the belief was
    /// updated.
    pub fn step(&mut self, input: &GuidanceInput<'_>) -> Option<Command> {
        let pose = self.navigation.update(input.step, input.pose);
        let vehicle = self.navigation.vehicle();
        let decided = match &mut self.pilot {
            Pilot::Information(information) => information.decide(vehicle, input),
            _ => input
                .step
                .0
                .is_multiple_of(self.airframe.per_second())
                .then(|| self.announced(vehicle)),
        };
        if let Some(poses) = decided {
            self.planned = (input.step, poses);
        }
        let yaw_rad = self.pilot.yaw(&pose, &self.airframe)?;
        self.navigation.command(yaw_rad);
        Some(Command::Yaw { yaw_rad })
    }

    /// Where the aircraft intends to be 1, 2, … seconds after [`Self::planned_at`].
    pub fn planned(&self) -> &[Pose] {
        &self.planned.1
    }

    /// When it decided so.
    pub fn planned_at(&self) -> Step {
        self.planned.0
    }

    /// The way of a pilot without plans.
    fn announced(&self, mut vehicle: FixedWing) -> Vec<Pose> {
        let mut pilot = self.pilot.clone();
        let commands = self.airframe.per_second();
        let mut second = |_| {
            for _ in 0..commands {
                if let Some(yaw) = pilot.yaw(&vehicle.pose(), &self.airframe) {
                    vehicle.command(yaw);
                }
                vehicle.advance(1.0 / f64::from(commands));
            }
            vehicle.pose()
        };
        (0..ANNOUNCED_S).map(&mut second).collect()
    }
}

impl Pilot {
    /// The heading to command, radians.
    fn yaw(&mut self, pose: &Pose, airframe: &Airframe) -> Option<f64> {
        match self {
            Self::Lawnmower(lanes, route) => {
                let route = route.get_or_insert_with(|| lanes.route(pose));
                Some(route.yaw(pose, airframe))
            }
            Self::Waypoints(waypoints) => waypoints.yaw(pose, airframe),
            Self::Information(information) => information.yaw(pose),
        }
    }
}
