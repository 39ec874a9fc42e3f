//! Same scenario and seed: same digest, for any number of threads and any observers.

use csat_agent::config::ExchangeMode;
use csat_experiments::set_membership::SetMembership;
use csat_netem::config::{OutageConfig, OutageKind};
use csat_tests::missions::{Outcome, fly, fly_mission, small, with_mode};
use csat_tests::replay::for_seeds;
use csat_tests::swarm::draw::Draw;
use rayon::ThreadPoolBuilder;
use tracing_subscriber::layer::SubscriberExt;

const STEPS: u32 = 36;

fn flown(seed: u64, threads: usize) -> Outcome {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| fly(&small(seed, 120.0, 4), STEPS))
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let one = flown(1, 1);
    assert!(one.identified > 0 && one.unexplored_pct < 90.0, "something happens: {one:?}");
    assert_eq!(one, flown(1, 1), "twice in a row");
    assert_eq!(one, flown(1, 2));
    assert_eq!(one, flown(1, 8));
    one.check("seed 1");
}

#[test]
fn another_seed_is_another_mission() {
    let digests: Vec<u64> = (1..4).map(|seed| flown(seed, 2).digest).collect();
    assert_ne!(digests[0], digests[1]);
    assert_ne!(digests[1], digests[2]);
}

/// Agents have no clock: measuring them changes nothing.
#[test]
fn measuring_changes_nothing() {
    // One thread, so that the subscriber of this thread sees every span.
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let scenario = small(2, 120.0, 3);
    let measured = pool.install(|| {
        let layer = csat_mission::stages::StageLayer;
        let subscriber = tracing_subscriber::registry().with(layer);
        tracing::subscriber::with_default(subscriber, || {
            let (_, times) = csat_mission::stages::collect(|| {
                tracing::info_span!("sense").in_scope(|| {});
            });
            assert!(times.sense.is_some(), "the layer is at work");
            fly(&scenario, STEPS)
        })
    });
    assert_eq!(measured, fly(&scenario, STEPS));
}

/// Agents of one process share results; with all faults the results are the same as if each agent had
/// computed them itself.
#[test]
fn sharing_work_changes_nothing() {
    let perfect = small(3, 120.0, 4);
    let alone = SetMembership::new(&perfect).each_by_itself();
    assert_eq!(fly(&perfect, STEPS), fly_mission(alone, &perfect, STEPS));
    for_seeds(["determinism", "sharing_work_changes_nothing"], 0..24, |seed| {
        let Draw { scenario, steps, .. } = Draw::new(seed);
        let alone = SetMembership::new(&scenario).each_by_itself();
        assert_eq!(fly(&scenario, steps), fly_mission(alone, &scenario, steps));
    });
}

/// The sender of a snapshot does not receive it, and has the same bits as the receivers. While one
/// agent is cut off the others know the same, and afterwards all receive two different snapshots.
#[test]
fn a_neighbour_that_comes_back_changes_nothing_in_that() {
    for mode in [ExchangeMode::Snapshot, ExchangeMode::FactsRepair] {
        for (seed, agent) in [(1, 2), (2, 1), (3, 2)] {
            let mut scenario = with_mode(small(seed, 120.0, 4), mode);
            let (from_s, until_s) = (4.9, 7.1);
            let kind = OutageKind::Radio;
            scenario.netem.outage.push(OutageConfig { agent, from_s, until_s, kind });
            let alone = SetMembership::new(&scenario).each_by_itself();
            let together = fly(&scenario, STEPS);
            assert_eq!(together, fly_mission(alone, &scenario, STEPS), "{mode:?}, seed {seed}");
            together.check("a neighbour that comes back");
        }
    }
}
