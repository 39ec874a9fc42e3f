//! What the UAVs together leave unexplored: the intersection of their X̄.

use csat_agent::region::Outer;
use csat_proto::region::Region;
use csat_proto::time::Step;

use super::report::Report;

/// How often sets that differ are intersected, seconds. Sets that are equal cost nothing.
const PERIOD_S: f64 = 1.0;

/// Follows the intersection of the UAVs' X̄ over a run.
#[derive(Debug, Clone)]
pub struct Merged {
    /// How many steps apart intersections are.
    every: u32,
    /// The newest one: its step and its area, m².
    newest: Option<(Step, f64)>,
}

impl Merged {
    /// Before the first step of a mission of steps of `period_s`, seconds.
    pub fn new(period_s: f64) -> Self {
        let every = (PERIOD_S / period_s).round().clamp(1.0, f64::from(u32::MAX));
        Self { every: every as u32, newest: None }
    }

    /// φ(∩ X̄_i) over the reports of the newest step, m²: no more than any X̄_i of these has, and as old as a second
    /// where they differ. `None` without reports.
    pub fn unexplored_m2(&mut self, uavs: &[&Report]) -> Option<f64> {
        // In real time a report may be late. Its set would have to grow first.
        let step = uavs.iter().map(|report| report.step).max()?;
        let of_step = uavs.iter().filter(|report| report.step == step);
        let sets = distinct(of_step.map(|report| &report.unexplored));
        let least_m2 = sets.iter().map(|set| set.area_m2()).fold(f64::INFINITY, f64::min);
        let common_m2 = match self.newest {
            _ if sets.len() == 1 => least_m2,
            Some((then, area_m2)) if step.0 < then.0.saturating_add(self.every) => {
                return Some(area_m2.min(least_m2));
            }
            _ => common(&sets).region().area_m2().min(least_m2),
        };
        self.newest = Some((step, common_m2));
        Some(common_m2)
    }
}

/// The regions without those that are equal to an earlier one.
fn distinct<'a>(regions: impl Iterator<Item = &'a Region>) -> Vec<&'a Region> {
    let mut distinct: Vec<&Region> = Vec::new();
    for region in regions {
        if !distinct.contains(&region) {
            distinct.push(region);
        }
    }
    distinct
}

/// The intersection, in the order of a tree: the same on any number of threads.
fn common(sets: &[&Region]) -> Outer {
    match sets {
        [] => Outer::default(),
        [set] => Outer::containing((*set).clone()),
        _ => {
            let (some, others) = sets.split_at(sets.len() / 2);
            let (some, others) = rayon::join(|| common(some), || common(others));
            some.intersection(&others)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{self, Request};
    use crate::set_membership::SetMembership;
    use csat_mission::mission::{Detail, Mission};
    use csat_proto::camera::Pose;
    use csat_proto::ids::{AgentId, Incarnation};
    use csat_proto::region::grid_point;

    /// Rectangles between these corners, disjoint.
    fn boxes(corners: &[[f64; 4]]) -> Region {
        let shape = |&[west, south, east, north]: &[f64; 4]| {
            let ring = [[west, south], [east, south], [east, north], [west, north]];
            vec![ring.iter().map(|&p| grid_point(p)).collect()]
        };
        Region::from_shapes(corners.iter().map(shape).collect())
    }

    /// Reports of a step with these X̄.
    fn reports(step: u32, sets: &[Region]) -> Vec<Report> {
        let loaded = scenario::load(Request::default()).unwrap();
        let mission = <SetMembership as crate::scenario::missions::Offered>::of(&loaded.scenario);
        let mut agent = mission.agent(AgentId(0), Incarnation(0));
        let blank = mission.report(&mut agent, &Pose::default(), Detail::Brief);
        let report = |unexplored: &Region| Report {
            step: Step(step),
            unexplored: unexplored.clone(),
            ..blank.clone()
        };
        sets.iter().map(report).collect()
    }

    /// The next step of a mission of steps of half a second.
    fn next(merged: &mut Merged, step: u32, sets: &[Region]) -> Option<f64> {
        let reports = reports(step, sets);
        merged.unexplored_m2(&reports.iter().collect::<Vec<_>>())
    }

    fn first(sets: &[Region]) -> Option<f64> {
        next(&mut Merged::new(0.5), 0, sets)
    }

    #[test]
    fn equal_sets_are_their_own_intersection_to_the_last_bit() {
        let set = boxes(&[[0.1, 0.2, 10.3, 20.7], [30.0, 0.0, 31.0, 1.0]]);
        let own = Some(set.area_m2());
        assert_eq!(first(&[set.clone(), set.clone(), set.clone()]), own);
        assert_eq!(first(&[set]), own, "one agent");
        assert_eq!(first(&[]), None);
        assert_eq!(first(&[Region::EMPTY, Region::EMPTY]), Some(0.0));
    }

    #[test]
    fn the_fleet_knows_what_each_of_its_uavs_knows() {
        let whole = boxes(&[[0.0, 0.0, 10.0, 10.0]]);
        let (west, east) = (boxes(&[[0.0, 0.0, 6.0, 10.0]]), boxes(&[[4.0, 0.0, 10.0, 10.0]]));
        assert_eq!(first(&[west.clone(), east.clone()]), Some(20.0));
        assert_eq!(first(&[whole.clone(), west.clone(), whole, east.clone()]), Some(20.0));
        let apart = boxes(&[[0.0, 0.0, 4.0, 10.0]]);
        assert_eq!(first(&[apart, east.clone()]), Some(0.0), "disjoint");
        let ring = boxes(&[[0.0, 0.0, 10.0, 2.0], [0.0, 8.0, 10.0, 10.0]]);
        assert_eq!(first(&[ring, west, east]), Some(8.0));
    }

    #[test]
    fn sets_that_differ_are_intersected_once_a_second() {
        let halves =
            |width_m: f64| [boxes(&[[0.0, 0.0, width_m, 1.0]]), boxes(&[[4.0, 0.0, 10.0, 1.0]])];
        let mut merged = Merged::new(0.5);
        assert_eq!(next(&mut merged, 0, &halves(9.0)), Some(5.0));
        assert_eq!(next(&mut merged, 1, &halves(8.0)), Some(5.0), "held");
        assert_eq!(next(&mut merged, 2, &halves(7.0)), Some(3.0));
        assert_eq!(next(&mut merged, 3, &halves(2.0)), Some(2.0), "no more than a UAV's own");
        let equal = [boxes(&[[0.0, 0.0, 9.0, 1.0]]), boxes(&[[0.0, 0.0, 9.0, 1.0]])];
        assert_eq!(next(&mut merged, 3, &equal), Some(9.0), "equal sets are not held");
        assert_eq!(next(&mut Merged::new(5.0), 1, &halves(8.0)), Some(4.0));
    }

    /// In real time: what a late report says is of another step.
    #[test]
    fn reports_of_earlier_steps_are_left_out() {
        let [west, east] = [[0.0, 0.0, 6.0, 10.0], [4.0, 0.0, 10.0, 10.0]].map(|b| boxes(&[b]));
        let late = reports(3, &[west]);
        let newest = reports(4, &[east]);
        let all: Vec<&Report> = late.iter().chain(&newest).collect();
        assert_eq!(Merged::new(0.5).unexplored_m2(&all), Some(60.0));
    }
}
