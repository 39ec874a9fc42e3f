//! Prediction (4.24)-(4.27): sets contain all that a target can reach, and little more.

use csat_agent::agent::SetMembershipAgent;
use csat_proto::agent::Agent;
use csat_proto::frame::Frame;
use csat_proto::model::Ground;
use csat_proto::region::{Region, metres};
use csat_proto::time::{SimTime, Step};
use csat_tests::geometry::{Point, points_in};
use csat_tests::replay::{for_seeds, is_replay};
use csat_tests::scenes::{Case, blind};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STEPS: u32 = 30;

/// A possible path of a target.
struct Walker {
    /// The set that it must stay in: an index into the sets at the start.
    set: usize,
    at: Point,
    /// `Some`: straight on at full speed, which is hardest to contain.
    heading_rad: Option<f64>,
}

impl Walker {
    /// One step, but not out of the region nor into X°, where no target can go.
    fn walk(&mut self, reach_m: f64, ground: &Ground, margin: &Region, rng: &mut ChaCha8Rng) {
        let (heading, length_m) = match self.heading_rad {
            Some(heading) => (heading, reach_m),
            None => (rng.random_range(0.0..6.3), reach_m * rng.random_range(0.0..1.0)),
        };
        let next = [self.at[0] + length_m * heading.cos(), self.at[1] + length_m * heading.sin()];
        if ground.contains(next) && !margin.contains(next) {
            self.at = next;
        }
    }
}

/// X̄, then the target sets by index.
fn sets(agent: &SetMembershipAgent) -> Vec<Region> {
    let knowledge = agent.knowledge();
    let targets = knowledge.targets.values().map(|set| set.region().clone());
    std::iter::once(knowledge.unexplored.region().clone()).chain(targets).collect()
}

fn walkers(sets: &[Region], rng: &mut ChaCha8Rng) -> Vec<Walker> {
    let mut walkers = Vec::new();
    for (set, region) in sets.iter().enumerate() {
        // A wrong dilation fails at corners first.
        let corners = region.rings().flatten().map(|&p| metres(p)).step_by(3).take(20);
        for at in points_in(region, 15, rng).into_iter().chain(corners) {
            let heading_rad = rng.random_bool(0.7).then(|| rng.random_range(0.0..6.3));
            walkers.push(Walker { set, at, heading_rad });
        }
    }
    walkers
}

/// An agent after one real frame, and its knowledge.
struct Start {
    agent: SetMembershipAgent,
    sets: Vec<Region>,
}

impl Start {
    fn new(case: &Case) -> Self {
        let mut agent = SetMembershipAgent::new(&case.config);
        let time = SimTime::from_seconds(case.config.period_s);
        agent.handle_frame(time, &case.frame());
        agent.handle_timeout(time);
        Self { sets: sets(&agent), agent }
    }

    /// The sets after one more step without evidence.
    fn predict(&mut self, case: &Case, step: u32) -> Vec<Region> {
        let time = SimTime::from_seconds(f64::from(step) * case.config.period_s);
        self.agent.handle_frame(time, &blind(&case.config.camera, Step(step), case.pose));
        self.agent.handle_timeout(time);
        assert_eq!(self.agent.knowledge().step, Step(step));
        sets(&self.agent)
    }
}

fn case(seed: u64) -> Case {
    let mut case = Case::random(seed);
    case.config.targets.v_max_m_s = [0.0, 0.3, 1.0, 3.0][seed as usize % 4];
    case
}

fn reach_m(case: &Case) -> f64 {
    case.config.targets.v_max_m_s * case.config.period_s
}

#[test]
fn a_prediction_contains_whatever_can_be_reached() {
    let (mut walked, mut escapees) = (0, 0);
    let name = ["estimator", "a_prediction_contains_whatever_can_be_reached"];
    for_seeds(name, 0..100, |seed| {
        let case = case(seed);
        let mut start = Start::new(&case);
        let margin = start.agent.knowledge().margin.region().clone();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut walkers = walkers(&start.sets, &mut rng);
        for step in 2..STEPS + 2 {
            let now = start.predict(&case, step);
            for walker in &mut walkers {
                walker.walk(reach_m(&case), &case.config.ground, &margin, &mut rng);
                let error_m = now[walker.set].distance_m(walker.at);
                assert!(error_m < 1e-5, "step {step}: {:?} is {error_m} m out", walker.at);
                walked += 1;
            }
        }
        // Walkers that left the sets of the start are contained only because of the prediction.
        escapees += walkers.iter().filter(|w| !start.sets[w.set].contains(w.at)).count();
    });
    println!("{walked} steps walked, {escapees} escapees");
    assert!(is_replay() || (walked > 50_000 && escapees > 300));
}

/// How far a set reaches beyond another, metres.
fn reach_beyond_m(before: &Region, after: &Region) -> f64 {
    let corners = after.rings().flatten().map(|&p| before.distance_m(metres(p)));
    corners.fold(0.0, f64::max)
}

#[test]
fn a_prediction_hardly_reaches_farther_than_a_target() {
    let [mut exact_m2, mut simple_m2] = [0.0; 2];
    let (mut worst_m, mut corners) = (0.0f64, [0, 0]);
    let name = ["estimator", "a_prediction_hardly_reaches_farther_than_a_target"];
    for_seeds(name, 0..60, |seed| {
        let mut case = case(seed);
        case.config.estimator.simplify_m = 0.0;
        let mut exact = Start::new(&case);
        case.config.estimator.simplify_m = 0.15;
        let mut simple = Start::new(&case);
        for step in 2..STEPS + 2 {
            exact.predict(&case, step);
            simple.predict(&case, step);
        }
        let n = f64::from(case.config.estimator.disc_vertices);
        let step_m = reach_m(&case) / (std::f64::consts::PI / n).cos() + 1.2e-4;
        // Details of up to a millimetre are always simplified.
        let limit_m = f64::from(STEPS) * (step_m + 1e-3);
        for (before, after) in exact.sets.iter().zip(&sets(&exact.agent)) {
            let beyond_m = reach_beyond_m(before, after);
            assert!(beyond_m <= limit_m, "{beyond_m} m, a target can do {limit_m} m");
            exact_m2 += after.area_m2();
            corners[0] += after.vertex_count();
        }
        for (before, after) in simple.sets.iter().zip(&sets(&simple.agent)) {
            // Each simplification may shift a corner.
            let excess_m = reach_beyond_m(before, after) - limit_m;
            assert!(excess_m <= f64::from(STEPS) * 0.15, "{excess_m} m");
            worst_m = worst_m.max(excess_m);
            simple_m2 += after.area_m2();
            corners[1] += after.vertex_count();
        }
    });
    let more_pct = 100.0 * (simple_m2 / exact_m2 - 1.0);
    println!(
        "simplified by 0.15 m in each of {STEPS} steps: {more_pct:.2} % more area, corners at most \
         {worst_m:.2} m too far, {corners:?} corners"
    );
    assert!(is_replay() || more_pct < 3.0, "{more_pct} %");
}

/// A frame proves something about its own step; an old frame taken for a current one would exclude
/// too much.
#[test]
fn a_frame_of_no_later_step_is_refused() {
    let case = case(2);
    let mut start = Start::new(&case);
    start.predict(&case, 9);
    let before = start.agent.digest();
    for step in [1, 8, 9] {
        let old = Frame { step: Step(step), ..case.frame() };
        let now = SimTime::from_seconds(9.2 * case.config.period_s);
        start.agent.handle_frame(now, &old);
        start.agent.handle_timeout(now);
        assert_eq!(start.agent.digest(), before, "step {step}");
    }
    assert_eq!(start.agent.rejected().get("old-frame"), Some(&3));
    start.predict(&case, 10);
    assert_ne!(start.agent.digest(), before);
}
