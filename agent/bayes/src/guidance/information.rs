//! The criterion `information`: plans over a receding horizon.

use csat_proto::camera::Pose;
use csat_proto::fixed_wing::FixedWing;
use csat_proto::time::Step;

use super::GuidanceInput;
use super::beam::{Plan, Search};
use super::coverage::{Coverage, LEAD_S, Weights};
use super::footprint::Footprints;
use super::localisation::Localisation;
use super::manoeuvre::{Flight, Steering, Turn};
use super::navigation::Airframe;
use super::neighbours::Neighbours;
use crate::config::AgentConfig;
use crate::likelihood::Sensor;
use crate::search_map::Gaussian;

/// Plans, and flies them.
#[derive(Debug, Clone)]
pub struct Information {
    flight: Flight,
    footprints: Footprints,
    neighbours: Neighbours,
    weights: Weights,
    horizon_s: usize,
    beam: usize,
    /// Steps between decisions.
    period: u32,
    /// When it decided last, and what.
    decided: Option<(Step, Plan)>,
    steering: Option<Steering>,
}

impl Information {
    /// The planner of an aircraft.
    pub fn new(config: &AgentConfig, airframe: Airframe) -> Self {
        let guidance = &config.guidance;
        let height_m = config.fleet.altitude_of(config.id.0);
        Self {
            flight: Flight::new(airframe),
            footprints: Footprints::new(&Sensor::new(config), &airframe, height_m),
            neighbours: Neighbours::new(config, airframe),
            weights: Weights::from(guidance),
            horizon_s: guidance.horizon_s.round().max(1.0) as usize,
            beam: usize::from(guidance.beam),
            period: config.steps(guidance.period_s).max(1),
            decided: None,
            steering: None,
        }
    }

    /// A new plan, if it is time: poses after 1, 2, … seconds.
    pub fn decide(&mut self, vehicle: FixedWing, input: &GuidanceInput<'_>) -> Option<Vec<Pose>> {
        let mut former = Vec::new();
        if let Some((step, plan)) = &self.decided {
            let elapsed = input.step.0.saturating_sub(step.0);
            let seconds = f64::from(elapsed) * self.flight.airframe().period_s + 1e-9;
            let seconds = seconds as usize;
            former.extend(plan.turns.iter().skip(seconds).copied());
            if elapsed < self.period {
                self.turn(former.first(), &vehicle);
                return None;
            }
        }
        let others = self.neighbours.predicted(input.step, input.neighbours, self.horizon_s);
        let search = Search {
            flight: &self.flight,
            vehicle,
            steering: self.steering,
            horizon_s: self.horizon_s,
            beam: self.beam,
        };
        let plan = match &input.target {
            Some(target) => self.to_target(&search, target, &others, &former),
            None => self.to_probability(&search, input, &others, &former),
        };
        let poses = plan.poses.clone();
        self.turn(plan.turns.first(), &vehicle);
        self.decided = Some((input.step, plan));
        Some(poses)
    }

    fn turn(&mut self, turn: Option<&Turn>, vehicle: &FixedWing) {
        let turn = turn.copied().unwrap_or(Turn::STRAIGHT);
        let next = Steering::go_on(self.steering, turn, &vehicle.pose(), &self.flight);
        self.steering = Some(next);
    }

    fn to_target(
        &self,
        search: &Search<'_>,
        target: &Gaussian,
        others: &[Vec<Pose>],
        former: &[Turn],
    ) -> Plan {
        let lead_m = LEAD_S * self.flight.airframe().airspeed_m_s;
        let mut objective = Localisation::new(
            &self.footprints,
            target,
            others.iter().flatten(),
            lead_m,
            self.weights.attraction_m,
        );
        search.best(&mut objective, former)
    }

    fn to_probability(
        &self,
        search: &Search<'_>,
        input: &GuidanceInput<'_>,
        others: &[Vec<Pose>],
        former: &[Turn],
    ) -> Plan {
        let mut map = (input.map)();
        for pose in others.iter().flatten() {
            self.footprints.cells(&map.grid, pose, |cell, missed| {
                map.mass[cell] *= f64::from(missed);
            });
        }
        let lead_m = LEAD_S * self.flight.airframe().airspeed_m_s;
        // Shares are divided by where all of them are in the middle of the horizon.
        let middle = |poses: &[Pose]| {
            poses.get(poses.len() / 2).map(|pose| [pose.p_world[0], pose.p_world[1]])
        };
        let own = search.flown(former).poses;
        let own: Vec<_> = middle(&own).into_iter().collect();
        let others: Vec<_> = others.iter().filter_map(|poses| middle(poses)).collect();
        let mut objective =
            Coverage::new(&self.footprints, &map, &self.weights, [&own, &others], lead_m);
        search.best(&mut objective, former)
    }

    /// The heading to command at a pose, radians.
    pub fn yaw(&self, pose: &Pose) -> Option<f64> {
        self.steering.map(|steering| steering.yaw(pose, &self.flight))
    }
}
