//! Beam search over sequences of turns.

use csat_proto::camera::Pose;
use csat_proto::fixed_wing::FixedWing;

use super::manoeuvre::{Flight, Leg, Steering, Turn};
use super::navigation::wrapped;

/// Lengths of the first parts of a plan, seconds; all others are as long as the last one.
const PARTS_S: [usize; 4] = [1, 2, 2, 3];
/// Plans that end nearer to each other than this, metres, with similar headings count as alike.
const ALIKE_M: f64 = 12.0;
/// Headings that differ by less than this are similar, radians.
const ALIKE_RAD: f64 = 0.25;
/// A new plan must be better than the rest of the former one by this share.
const RELUCTANCE: f64 = 0.003;

/// What plans are good for.
pub trait Objective {
    /// What a plan has achieved up to some second.
    type State;
    /// At the start.
    fn start(&self) -> Self::State;
    /// How good a plan is that continues a state with poses, one per second, from `second` seconds after now on.
    fn value(&mut self, state: &Self::State, second: usize, poses: &[Pose]) -> f64;
    /// The state after these poses.
    fn after(&mut self, state: &Self::State, second: usize, poses: &[Pose]) -> Self::State;
}

/// Turns and predicted poses, one per second, from the next second on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// What is flown in each second.
    pub turns: Vec<Turn>,
    /// The pose at the end of each second.
    pub poses: Vec<Pose>,
}

/// What is searched.
pub struct Search<'a> {
    /// How the aircraft flies.
    pub flight: &'a Flight,
    /// The aircraft now.
    pub vehicle: FixedWing,
    /// What it flies now.
    pub steering: Option<Steering>,
    /// Length of plans, seconds.
    pub horizon_s: usize,
    /// How many plans are kept at each stage.
    pub beam: usize,
}

struct Node<S> {
    plan: Plan,
    state: S,
}

struct Candidate {
    value: f64,
    parent: usize,
    turn: Turn,
    leg: Leg,
}

impl Search<'_> {
    /// The best plan found; `former` is the rest of the plan that is flown. Among equals it is the former one,
    /// then the one with the gentlest turns first.
    pub fn best<O: Objective>(&self, objective: &mut O, former: &[Turn]) -> Plan {
        let root = Node { plan: Plan::default(), state: objective.start() };
        let mut nodes = vec![root];
        let mut second = 0;
        let mut parts = PARTS_S.into_iter().chain(std::iter::repeat(PARTS_S[PARTS_S.len() - 1]));
        let mut value = f64::NEG_INFINITY;
        while second < self.horizon_s {
            let seconds = parts.next().unwrap_or(1).min(self.horizon_s - second);
            let is_last = second + seconds >= self.horizon_s;
            let kept = if is_last { 1 } else { self.beam.max(1) };
            let candidates = distinct(self.candidates(objective, &nodes, second, seconds), kept);
            value = candidates.first().map_or(value, |best| best.value);
            let grown = |candidate: Candidate| grown(objective, &nodes, second, candidate);
            nodes = candidates.into_iter().map(grown).collect();
            second += seconds;
        }
        let best = nodes.into_iter().next().map(|node| node.plan).unwrap_or_default();
        self.former(objective, former, value).unwrap_or(best)
    }

    fn candidates<O: Objective>(
        &self,
        objective: &mut O,
        nodes: &[Node<O::State>],
        second: usize,
        seconds: usize,
    ) -> Vec<Candidate> {
        let mut candidates = Vec::with_capacity(nodes.len() * super::manoeuvre::TURNS);
        for (parent, Node { plan, state }) in nodes.iter().enumerate() {
            for turn in Turn::all() {
                let leg = match (plan.poses.last(), plan.turns.last()) {
                    (Some(pose), Some(before)) => self.flight.predict(pose, *before, turn, seconds),
                    _ => self.first(turn, seconds),
                };
                let value = objective.value(state, second, leg.poses());
                candidates.push(Candidate { value, parent, turn, leg });
            }
        }
        candidates
    }

    /// The first part of a plan, from the aircraft as it is.
    fn first(&self, turn: Turn, seconds: usize) -> Leg {
        let mut vehicle = self.vehicle;
        let steering = Steering::go_on(self.steering, turn, &vehicle.pose(), self.flight);
        let mut poses = Vec::with_capacity(seconds);
        self.flight.fly(&mut vehicle, &steering, seconds, |pose| poses.push(pose));
        Leg::new(&poses)
    }

    /// The rest of the former plan, if it is as good as `value`.
    fn former<O: Objective>(&self, objective: &mut O, former: &[Turn], value: f64) -> Option<Plan> {
        if former.is_empty() {
            return None;
        }
        let plan = self.flown(former);
        let own = objective.value(&objective.start(), 0, &plan.poses);
        (own >= value - RELUCTANCE * value.abs()).then_some(plan)
    }

    /// A flight of some turns, the last of which goes on to the horizon.
    pub fn flown(&self, turns: &[Turn]) -> Plan {
        let last = turns.last().copied().unwrap_or(Turn::STRAIGHT);
        let turns = turns.iter().copied().chain(std::iter::repeat(last)).take(self.horizon_s);
        let turns: Vec<Turn> = turns.collect();
        let (mut vehicle, mut steering) = (self.vehicle, self.steering);
        let mut poses = Vec::with_capacity(turns.len());
        for &turn in &turns {
            let next = Steering::go_on(steering, turn, &vehicle.pose(), self.flight);
            steering = Some(next);
            self.flight.fly(&mut vehicle, &next, 1, |pose| poses.push(pose));
        }
        Plan { turns, poses }
    }
}

/// The `count` best candidates, the best first, none like a better one.
fn distinct(mut candidates: Vec<Candidate>, count: usize) -> Vec<Candidate> {
    // A stable sort: the first of equals is the one with the gentlest turn.
    candidates.sort_by(|a, b| b.value.total_cmp(&a.value));
    let mut kept: Vec<Candidate> = Vec::with_capacity(count);
    for candidate in candidates {
        if kept.len() == count {
            break;
        }
        if !kept.iter().any(|other| alike(&candidate.leg, &other.leg)) {
            kept.push(candidate);
        }
    }
    kept
}

fn alike(a: &Leg, b: &Leg) -> bool {
    let (Some(a), Some(b)) = (a.poses().last(), b.poses().last()) else { return true };
    let [dx, dy] = [0, 1].map(|axis| a.p_world[axis] - b.p_world[axis]);
    dx * dx + dy * dy < ALIKE_M * ALIKE_M && wrapped(a.yaw_rad - b.yaw_rad).abs() < ALIKE_RAD
}

fn grown<O: Objective>(
    objective: &mut O,
    nodes: &[Node<O::State>],
    second: usize,
    Candidate { parent, turn, leg, .. }: Candidate,
) -> Node<O::State> {
    let Node { plan, state } = &nodes[parent];
    let state = objective.after(state, second, leg.poses());
    let mut plan = plan.clone();
    plan.turns.extend(leg.poses().iter().map(|_| turn));
    plan.poses.extend_from_slice(leg.poses());
    Node { plan, state }
}
