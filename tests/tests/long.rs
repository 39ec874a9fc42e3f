//! Half an hour: sets stay small, and the guarantee holds.

use csat_agent::agent::SetMembershipAgent;
use csat_tests::flight::Flight;
use csat_tests::missions::small;

/// 30 minutes at 2 Hz.
const STEPS: usize = 3600;
/// Until most of the region was seen once, steps.
const WARM_UP: usize = 300;

/// Vertices of all sets of an agent.
fn vertices(agent: &SetMembershipAgent) -> usize {
    let knowledge = agent.knowledge();
    let targets = knowledge.targets.values().map(|set| set.region().vertex_count());
    targets.sum::<usize>()
        + knowledge.unexplored.region().vertex_count()
        + knowledge.margin.region().vertex_count()
}

#[test]
fn vertices_stay_bounded_for_half_an_hour() {
    let mut scenario = small(11, 200.0, 2);
    scenario.targets.count = 5;
    let mut flight = Flight::new(&scenario);
    let (mut counts, mut margins) = (Vec::new(), Vec::new());
    for _ in 0..=STEPS {
        flight.step();
        flight.check_guarantee();
        counts.push(flight.pair.agents.iter().map(vertices).max().unwrap());
        let margin = flight.pair.agent(0).knowledge().margin.region();
        margins.push(margin.vertex_count());
    }
    flight.check_consistency();
    let third = (STEPS - WARM_UP) / 3;
    let most = |counts: &[usize]| counts.iter().copied().max().unwrap();
    let mean = |counts: &[usize]| counts.iter().sum::<usize>() / counts.len();
    let (first, last) = (&counts[WARM_UP..WARM_UP + third], &counts[STEPS - third..]);
    println!(
        "vertices: first third at most {}, {} on average; last third at most {}, {} on average; \
         of the margin {} and {} at the end",
        most(first),
        mean(first),
        most(last),
        mean(last),
        margins[WARM_UP + third],
        margins[STEPS]
    );
    assert!(2 * most(last) <= 3 * most(first), "{} {}", most(last), most(first));
    assert!(2 * mean(last) <= 3 * mean(first), "{} {}", mean(last), mean(first));
    assert_eq!(flight.pair.agent(0).knowledge().targets.len(), 5, "all cars are found");
}
