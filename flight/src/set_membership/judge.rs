//! What the mission promises: every target lies in the set of every agent, and no honest agent is named
//! as a liar. It is demanded of the agents whose own frames were true so far.

use csat_agent::mutant::{Mutant, is_on};
use csat_mission::judge::{Broken, Judge, Judged, Promise, Truth};
use csat_mission::measures::Values;
use csat_proto::ids::{AgentId, TargetId};
use csat_world::target::TargetTruth;
use serde_json::{Map, json};

use super::report::Report;

/// ε of the guarantee, metres.
pub const TOLERANCE_M: f64 = 1e-3;

/// The key of the guarantee.
pub const GUARANTEE: &str = "guarantee";

/// The key of the promise about liars.
pub const ACCUSATION: &str = "accusation";

/// All that the mission promises.
pub const PROMISES: &[Promise] = &[
    Promise { key: GUARANTEE, broken: "a target outside the set of an agent" },
    Promise { key: ACCUSATION, broken: "an honest agent named as a liar" },
];

/// Checks of every report that it admits every target where it is, and names liars only.
#[derive(Debug, Clone, Copy, Default)]
pub struct Containment {
    /// How many agents' frames were false so far.
    false_agents: usize,
}

impl Judge<Report> for Containment {
    fn judge(&mut self, agent: AgentId, report: &Report, truth: &Truth<'_>) -> Judged {
        if truth.is_false(agent) {
            return Judged::default();
        }
        let outside = truth.targets.iter().filter(|t| !admits(report, t.id, t.location));
        let faults = outside.map(|TargetTruth { id, location, .. }| Broken {
            promise: GUARANTEE,
            agent,
            detail: Map::from_iter([
                ("target".to_owned(), json!(id)),
                ("location".to_owned(), json!(location)),
            ]),
        });
        let wronged = report.liars.iter().filter(|named| !truth.is_false(**named));
        let accused =
            wronged.map(|named| Broken::new(ACCUSATION, agent, json!({ "named": named })));
        let mut checks = vec![(GUARANTEE, truth.targets.len() as u64)];
        if !report.liars.is_empty() {
            checks.push((ACCUSATION, report.liars.len() as u64));
        }
        Judged { faults: faults.chain(accused).collect(), checks }
    }

    fn close(&mut self, truth: &Truth<'_>, _: &[bool]) -> Judged {
        self.false_agents = truth.is_false.iter().filter(|is_false| **is_false).count();
        Judged::default()
    }

    fn fleet(&self) -> Values {
        vec![("false_agents", Some(self.false_agents as f64))]
    }
}

/// Whether what an agent knows admits that `target` is at `location` (`world`, metres) or within ε of it: in
/// X_ij if the agent has identified the target, else in X̄_i.
pub fn admits(report: &Report, target: TargetId, location: [f64; 2]) -> bool {
    let lenient_m = if is_on(Mutant::MonitorLenient) { 1.0 } else { 0.0 };
    // False for a location that is not a number.
    report.set_of(target).distance_m(location) <= TOLERANCE_M + lenient_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::camera::Pose;
    use csat_proto::region::{Region, grid_point};
    use csat_proto::time::Step;

    fn square(x: f64, y: f64, side: f64) -> Region {
        let ring = [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
        Region::from_shapes(vec![vec![ring.iter().map(|&p| grid_point(p)).collect()]])
    }

    fn at(id: u16, x: f64, y: f64) -> TargetTruth {
        TargetTruth { id: TargetId(id), location: [x, y], heading_rad: 0.0, speed_m_s: 0.5 }
    }

    #[test]
    fn the_guarantee_is_checked_for_every_target_to_a_millimetre() {
        let report = Report {
            step: Step(7),
            pose: Pose::default(),
            targets: vec![(TargetId(0), square(0.0, 0.0, 1.0))],
            unexplored: square(50.0, 50.0, 10.0),
            obstacle_margin: Region::EMPTY,
            clear_ground: None,
            detected: Vec::new(),
            planned: Vec::new(),
            hidden_pct: 0.0,
            oem_iou_pct: None,
            news_age_s: None,
            pose_error_m: None,
            liars: vec![AgentId(0)],
            tally: csat_mission::mission::Tally::default(),
            maps: None,
        };
        let judge_of = |agent, targets: &[TargetTruth]| {
            let truth =
                Truth { step: report.step, targets, poses: &[], is_false: &[true, false, false] };
            Containment::default().judge(AgentId(agent), &report, &truth)
        };
        let judge = |targets: &[TargetTruth]| judge_of(1, targets);
        let good = judge(&[at(0, 0.5, 1.000_9), at(1, 55.0, 55.0)]);
        let checks = vec![(GUARANTEE, 2), (ACCUSATION, 1)];
        assert_eq!((good.checks, good.faults), (checks, Vec::new()));
        assert_eq!(judge_of(0, &[at(0, 9.0, 9.0)]).checks, [], "nothing is demanded of a liar");
        let bad = judge(&[at(0, 0.5, 1.001_1), at(1, 0.5, 0.5), at(2, f64::NAN, 55.0)]);
        let blamed: Vec<&serde_json::Value> =
            bad.faults.iter().map(|fault| &fault.detail["target"]).collect();
        assert_eq!(blamed, [0, 1, 2], "beyond a millimetre, in the set of another, nowhere");
        let line = serde_json::to_value(&bad.faults[0]).unwrap();
        let expected =
            json!({"kind": "guarantee", "agent": 1, "target": 0, "location": [0.5, 1.001_1]});
        assert_eq!(line, expected);
    }

    #[test]
    fn who_names_an_honest_agent_breaks_a_promise() {
        let mut mission = crate::set_membership::SetMembership::new(&Default::default());
        let report = blank(&mut mission, vec![AgentId(0), AgentId(2)]);
        let truth =
            Truth { step: report.step, targets: &[], poses: &[], is_false: &[false, false, true] };
        let mut judge = Containment::default();
        let judged = judge.judge(AgentId(1), &report, &truth);
        let [fault] = &judged.faults[..] else { panic!("{:?}", judged.faults) };
        assert_eq!((fault.promise, fault.detail["named"].clone()), (ACCUSATION, json!(0)));
        assert_eq!(judged.checks, [(GUARANTEE, 0), (ACCUSATION, 2)]);
        judge.close(&truth, &[true; 3]);
        assert_eq!(judge.fleet(), [("false_agents", Some(1.0))]);
    }

    /// A report at the start, but for whom it names.
    fn blank(mission: &mut crate::set_membership::SetMembership, liars: Vec<AgentId>) -> Report {
        use csat_mission::mission::{Detail, Mission};
        let mut agent = mission.agent(AgentId(1), csat_proto::ids::Incarnation(0));
        Report { liars, ..mission.report(&mut agent, &Pose::default(), Detail::Brief) }
    }
}
