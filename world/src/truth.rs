//! The monitor of the world: it checks at every step of every run that the assumptions of the theory about cars,
//! UAVs and messages hold (docs/concepts/guarantee.md). A mission's judge checks what the mission promises.

use std::collections::BTreeMap;

use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, TargetId};
use csat_proto::model::{FLIGHT_CLEARANCE_M, Ground, TargetsModel};
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

use crate::obstacle::{Obstacle, Walls};
use crate::plane::{between, distance_m};
use crate::target::TargetTruth;

/// Allowance for rounding in speeds, metres per check.
const SPEED_TOLERANCE_M: f64 = 1e-9;

/// Distance between the points at which the way of a UAV is checked, metres.
const WAY_STEP_M: f64 = 0.5;

/// Counts of messages so far, for the check of their conservation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct MessageCounts {
    /// Copies handed to the network, one per receiver.
    pub sent: u64,
    /// Further copies that the network made.
    pub duplicated: u64,
    /// Copies that arrived.
    pub delivered: u64,
    /// Copies dropped, for any reason.
    pub dropped: u64,
    /// Copies in flight.
    pub in_flight: u64,
}

impl MessageCounts {
    /// Whether no copy was lost or gained: sent + duplicated = delivered + dropped + in flight.
    pub fn conserved(&self) -> bool {
        let made = u128::from(self.sent) + u128::from(self.duplicated);
        let found = [self.delivered, self.dropped, self.in_flight];
        made == found.into_iter().map(u128::from).sum()
    }
}

/// What was violated; lengths in metres, `world`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Fault {
    /// A target is too near to an obstacle (3.8).
    ObstacleDistance {
        /// The target.
        target: TargetId,
        /// Index of the obstacle.
        obstacle: usize,
        /// The distance.
        distance_m: f64,
        /// The distance that it has to exceed.
        limit_m: f64,
    },
    /// Two targets are too near to each other (3.11).
    TargetDistance {
        /// One target.
        a: TargetId,
        /// The other target.
        b: TargetId,
        /// Their distance.
        distance_m: f64,
        /// The distance that it has to exceed.
        limit_m: f64,
    },
    /// A target left the region.
    OutsideRegion {
        /// The target.
        target: TargetId,
        /// Where it is.
        location: [f64; 2],
    },
    /// A target moved faster than v_max.
    Speed {
        /// The target.
        target: TargetId,
        /// How far it moved since the last check.
        moved_m: f64,
        /// How far it may have moved.
        limit_m: f64,
    },
    /// A UAV is in a building, or too near to one that reaches its altitude less the clearance.
    BuildingDistance {
        /// Its agent.
        agent: AgentId,
        /// Index of the obstacle.
        obstacle: usize,
        /// The distance over the ground; 0 inside.
        distance_m: f64,
        /// The least distance allowed.
        limit_m: f64,
    },
    /// Messages appeared or disappeared.
    MessageConservation {
        /// The counts that do not add up.
        counts: MessageCounts,
    },
}

/// A fault and when it was seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violation {
    /// k.
    pub step: Step,
    /// What was violated.
    pub fault: Fault,
}

/// A kind of promise that the monitor checks; each [`Fault`] breaks one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Promise {
    /// [`Fault::ObstacleDistance`]: checked for every target, against all obstacles at once.
    ObstacleDistance,
    /// [`Fault::TargetDistance`]: checked for every pair of targets.
    TargetDistance,
    /// [`Fault::OutsideRegion`]: checked for every target.
    OutsideRegion,
    /// [`Fault::Speed`]: checked for every target from its second step on, unless targets walk at random:
    /// then no bound of their speed exists.
    Speed,
    /// [`Fault::BuildingDistance`]: checked for every UAV, against all buildings at once.
    BuildingDistance,
    /// [`Fault::MessageConservation`]: checked once per step.
    MessageConservation,
}

impl Promise {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::ObstacleDistance,
        Self::TargetDistance,
        Self::OutsideRegion,
        Self::Speed,
        Self::BuildingDistance,
        Self::MessageConservation,
    ];
}

impl Promise {
    /// Its key below `checked` of the summary.
    pub fn key(self) -> &'static str {
        match self {
            Self::ObstacleDistance => "obstacle_distance",
            Self::TargetDistance => "target_distance",
            Self::OutsideRegion => "outside_region",
            Self::Speed => "speed",
            Self::BuildingDistance => "building_distance",
            Self::MessageConservation => "message_conservation",
        }
    }

    /// What happens when it is broken, in words.
    pub fn broken(self) -> &'static str {
        match self {
            Self::ObstacleDistance => "a car too close to a wall",
            Self::TargetDistance => "cars too close to each other",
            Self::OutsideRegion => "a car outside the region",
            Self::Speed => "a car too fast",
            Self::BuildingDistance => "a UAV too close to a building",
            Self::MessageConservation => "a message unaccounted for",
        }
    }
}

impl Fault {
    /// The promise that it breaks.
    pub fn promise(&self) -> Promise {
        match self {
            Self::ObstacleDistance { .. } => Promise::ObstacleDistance,
            Self::TargetDistance { .. } => Promise::TargetDistance,
            Self::OutsideRegion { .. } => Promise::OutsideRegion,
            Self::Speed { .. } => Promise::Speed,
            Self::BuildingDistance { .. } => Promise::BuildingDistance,
            Self::MessageConservation { .. } => Promise::MessageConservation,
        }
    }
}

/// How often a promise was checked, and how often it was broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Checked {
    /// Checks made.
    pub checks: u64,
    /// Checks that found it broken.
    pub violations: u64,
}

/// What was checked so far, by the key of the promise; a promise that was never checked is not there.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CheckCounts(BTreeMap<String, Checked>);

impl CheckCounts {
    /// Takes note of checks.
    pub fn add(&mut self, promise: &str, more: Checked) {
        if !self.0.contains_key(promise) {
            self.0.insert(promise.to_owned(), Checked::default());
        }
        if let Some(sum) = self.0.get_mut(promise) {
            sum.checks += more.checks;
            sum.violations += more.violations;
        }
    }

    /// Takes note of all checks of another account.
    pub fn add_all(&mut self, more: &Self) {
        more.iter().for_each(|(promise, checked)| self.add(promise, checked));
    }

    /// How often a promise was checked and broken.
    pub fn of(&self, promise: &str) -> Checked {
        self.0.get(promise).copied().unwrap_or_default()
    }

    /// Over all promises.
    pub fn total(&self) -> Checked {
        self.0.values().fold(Checked::default(), |sum, one| Checked {
            checks: sum.checks + one.checks,
            violations: sum.violations + one.violations,
        })
    }

    /// Each promise that was checked, with its counts.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Checked)> {
        self.0.iter().map(|(promise, checked)| (promise.as_str(), *checked))
    }
}

/// Checks one run.
#[derive(Debug, Clone)]
pub struct Monitor {
    ground: Ground,
    model: TargetsModel,
    period_s: f64,
    walls: Walls,
    /// The last step checked, and all targets at that step.
    previous: Option<(Step, Vec<TargetTruth>)>,
    /// The pose of every UAV at the last check of the flights.
    flown_from: Vec<Pose>,
    counts: CheckCounts,
}

impl Monitor {
    /// A monitor of a run in that region, with those targets, that period and those obstacles.
    pub fn new(ground: Ground, model: TargetsModel, period_s: f64, obstacles: &[Obstacle]) -> Self {
        let walls = Walls::new(obstacles);
        let counts = CheckCounts::default();
        let flown_from = Vec::new();
        Self { ground, model, period_s, walls, previous: None, flown_from, counts }
    }

    /// Checks step k: the separations, the region and the speeds of all targets.
    ///
    /// A value that is not a number violates every check that uses it.
    pub fn check(&mut self, step: Step, targets: &[TargetTruth]) -> Vec<Violation> {
        let mut faults = Vec::new();
        for (index, target) in targets.iter().enumerate() {
            self.check_place(target, &mut faults);
            for other in &targets[..index] {
                self.check_pair(other, target, &mut faults);
            }
        }
        self.check_speeds(step, targets, &mut faults);
        self.previous = Some((step, targets.to_vec()));
        self.record(step, faults)
    }

    /// Checks that no UAV is nearer to a building than [`FLIGHT_CLEARANCE_M`], over it or beside it,
    /// and that none was on the straight way from its pose at the last check. `poses` are by agent.
    pub fn check_flights(&mut self, step: Step, poses: &[Pose]) -> Vec<Violation> {
        let mut faults = Vec::new();
        for (index, pose) in poses.iter().enumerate() {
            self.count(Promise::BuildingDistance);
            let from = self.flown_from.get(index).unwrap_or(pose);
            let nearest = self.nearest_on_way(from, pose);
            faults.extend(nearest.map(|(obstacle, distance_m)| Fault::BuildingDistance {
                agent: AgentId(index as u16),
                obstacle,
                distance_m,
                limit_m: FLIGHT_CLEARANCE_M,
            }));
        }
        self.flown_from = poses.to_vec();
        self.record(step, faults)
    }

    /// Of the obstacles that a UAV comes too near to on its way between two poses, the nearest one
    /// and its distance.
    fn nearest_on_way(&self, from: &Pose, to: &Pose) -> Option<(usize, f64)> {
        let [a, b] = [from, to].map(|pose| [pose.p_world[0], pose.p_world[1]]);
        let floor_m = from.p_world[2].min(to.p_world[2]) - FLIGHT_CLEARANCE_M;
        // This bounds the work for a way of any length.
        let parts = (distance_m(a, b) / WAY_STEP_M).ceil().clamp(1.0, 100.0);
        (0..=parts as u32)
            .filter_map(|i| {
                let p = between(a, b, f64::from(i) / parts);
                self.walls.nearest_above(floor_m, p, FLIGHT_CLEARANCE_M)
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Checks that no message appeared or disappeared.
    pub fn check_messages(&mut self, step: Step, counts: MessageCounts) -> Option<Violation> {
        self.count(Promise::MessageConservation);
        let faults = if counts.conserved() {
            Vec::new()
        } else {
            vec![Fault::MessageConservation { counts }]
        };
        self.record(step, faults).pop()
    }

    /// All checks so far.
    pub fn counts(&self) -> &CheckCounts {
        &self.counts
    }

    /// Counts a check of a promise.
    fn count(&mut self, promise: Promise) {
        self.counts.add(promise.key(), Checked { checks: 1, violations: 0 });
    }

    fn record(&mut self, step: Step, faults: Vec<Fault>) -> Vec<Violation> {
        for fault in &faults {
            self.counts.add(fault.promise().key(), Checked { checks: 0, violations: 1 });
        }
        faults.into_iter().map(|fault| Violation { step, fault }).collect()
    }

    fn check_place(&mut self, target: &TargetTruth, faults: &mut Vec<Fault>) {
        let TargetTruth { id: target, location, .. } = *target;
        self.count(Promise::OutsideRegion);
        if !self.ground.contains(location) {
            faults.push(Fault::OutsideRegion { target, location });
        }
        self.count(Promise::ObstacleDistance);
        // The least number beyond the limit: a location at exactly the limit is a violation too.
        let limit_m = self.model.obstacle_distance_m;
        if let Some((obstacle, distance_m)) = self.walls.nearest_within(location, limit_m.next_up())
        {
            faults.push(Fault::ObstacleDistance { target, obstacle, distance_m, limit_m });
        }
    }

    fn check_pair(&mut self, a: &TargetTruth, b: &TargetTruth, faults: &mut Vec<Fault>) {
        self.count(Promise::TargetDistance);
        let (distance_m, limit_m) =
            (distance_m(a.location, b.location), self.model.target_distance_m);
        let apart = distance_m > limit_m; // false for NaN
        if !apart {
            faults.push(Fault::TargetDistance { a: a.id, b: b.id, distance_m, limit_m });
        }
    }

    fn check_speeds(&mut self, step: Step, targets: &[TargetTruth], faults: &mut Vec<Fault>) {
        let Some((before, previous)) = self.previous.take() else { return };
        if !self.model.driving.keeps_v_max() {
            return;
        }
        let periods = f64::from(step.0.saturating_sub(before.0));
        let limit_m = self.model.v_max_m_s * self.period_s * periods;
        for target in targets {
            let Some(old) = previous.iter().find(|old| old.id == target.id) else { continue };
            self.count(Promise::Speed);
            let moved_m = distance_m(old.location, target.location);
            let slow = moved_m <= limit_m + SPEED_TOLERANCE_M; // false for NaN
            if !slow {
                faults.push(Fault::Speed { target: target.id, moved_m, limit_m });
            }
        }
    }
}

#[cfg(test)]
mod tests;
