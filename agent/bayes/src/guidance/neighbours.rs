//! Where other aircraft are going to be.

use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use csat_proto::time::Step;

use super::NeighbourPlan;
use super::navigation::Airframe;
use crate::config::AgentConfig;

/// This long after the end of its plan nothing is known of a silent aircraft any more, seconds.
const SILENT_S: f64 = 20.0;

/// The other aircraft.
#[derive(Debug, Clone)]
pub struct Neighbours {
    airframe: Airframe,
    /// Where they started: all that is known before the first plan.
    starts: Vec<NeighbourPlan>,
}

impl Neighbours {
    /// All aircraft but the agent's own.
    pub fn new(config: &AgentConfig, airframe: Airframe) -> Self {
        let fleet = &config.fleet;
        let start = |index: u16| {
            let start = fleet.start_of(index, &config.ground);
            let p_world = [start.x_m, start.y_m, fleet.altitude_of(index)];
            let mut pose = Pose::level(p_world, start.yaw_deg.to_radians());
            pose.pitch_rad = -airframe.model.pitch_trim_deg.to_radians();
            let poses = vec![airframe.straight_on(&pose, 1.0)];
            NeighbourPlan { id: AgentId(index), step: Step(0), poses }
        };
        let others = (0..fleet.count).filter(|index| *index != config.id.0);
        Self { airframe, starts: others.map(start).collect() }
    }

    /// Their poses 1, 2, … `seconds` after `now`, for each of which something is known. A plan that has ended is
    /// continued straight on.
    pub fn predicted(&self, now: Step, plans: &[NeighbourPlan], seconds: usize) -> Vec<Vec<Pose>> {
        let newest = |start: &NeighbourPlan| {
            let own = plans.iter().filter(|plan| plan.id == start.id && !plan.poses.is_empty());
            self.continued(own.max_by_key(|plan| plan.step).unwrap_or(start), now, seconds)
        };
        self.starts.iter().filter_map(newest).collect()
    }

    fn continued(&self, plan: &NeighbourPlan, now: Step, seconds: usize) -> Option<Vec<Pose>> {
        let age = (f64::from(now.0) - f64::from(plan.step.0)) * self.airframe.period_s;
        let last = plan.poses.last()?;
        let end = plan.poses.len() as f64;
        let at = |second: usize| {
            let t = age + second as f64;
            if t > end {
                return self.airframe.straight_on(last, t - end);
            }
            plan.poses[(t.round() as usize).clamp(1, plan.poses.len()) - 1]
        };
        (age < end + SILENT_S).then(|| (1..=seconds).map(at).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::config;
    use super::*;
    use crate::config::Criterion;

    #[test]
    fn a_silent_neighbour_flies_on_for_a_while() {
        let config = config(Criterion::Information);
        let neighbours = Neighbours::new(&config, Airframe::new(&config));
        let at = |x: f64| Pose::level([x, 0.0, 90.0], 0.0);
        let plan = |step: u32| NeighbourPlan {
            id: AgentId(1),
            step: Step(step),
            poses: vec![at(20.0), at(40.0), at(60.0)],
        };
        let x = |now: u32, plans: &[NeighbourPlan]| -> Vec<f64> {
            let predicted = neighbours.predicted(Step(now), plans, 3);
            predicted.iter().flatten().map(|pose| pose.p_world[0]).collect()
        };
        assert_eq!(x(0, &[plan(0)]), [20.0, 40.0, 60.0]);
        assert_eq!(x(4, &[plan(0)]), [40.0, 60.0, 80.0], "one second old");
        assert_eq!(x(40, &[plan(0)]), [220.0, 240.0, 260.0], "old");
        assert_eq!(x(40, &[plan(0), plan(36)]), [40.0, 60.0, 80.0], "the newest counts");
        assert!(x(400, &[plan(0)]).is_empty(), "nobody knows where it is");
        assert_eq!(x(4, &[]), [-4960.0, -4940.0, -4920.0], "from its start");
    }
}
