//! The laws of merging: order and repeats change nothing, and delays never break the guarantee.

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::ExchangeMode;
use csat_agent::estimate::state::Knowledge;
use csat_proto::agent::Agent;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::{SimTime, Step};
use csat_tests::flight::Flight;
use csat_tests::geometry::difference_m2;
use csat_tests::hears::Hears;
use csat_tests::missions::small;
use csat_tests::pair::Packet;
use csat_tests::replay::{for_seeds, is_replay};
use csat_tests::scenes::blind;
use csat_tests::truth;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The steps whose messages are merged: ages 0 to 20.
const STEPS: u32 = 20;

/// A script around the town, each UAV from a different start.
pub fn rounds(step: u32, agent: u16) -> f64 {
    f64::from(step / 6) * 0.45 + f64::from(agent) * 0.7 - 1.0
}

/// A flight at its last step, and the facts and snapshots to UAV 0.
fn recorded(seed: u64, simplify_margin_m: f64) -> (Flight, Vec<Packet>) {
    let mut scenario = small(seed, 140.0, 3);
    scenario.exchange.mode = ExchangeMode::FactsRepair;
    scenario.exchange.snapshot_period_s = 3.0;
    scenario.estimator.simplify_margin_m = simplify_margin_m;
    scenario.agents.start_offset_m = 0.0;
    let mut flight = Flight::scripted(&scenario, rounds);
    flight.pair.keep_packets();
    for _ in 0..=STEPS {
        flight.step();
    }
    let mut packets = std::mem::take(&mut flight.pair.packets);
    packets.retain(|packet| packet.dst == AgentId(0));
    (flight, packets)
}

/// UAV 0 after its own frames were lost, with all sets grown to the last step, before it receives the
/// packets: facts that arrive without a frame are not predicted any more.
fn unread(flight: &Flight) -> SetMembershipAgent {
    let mut config = flight.pair.agent(0).config().clone();
    config.incarnation = Incarnation(1);
    let mut agent = SetMembershipAgent::new(&config);
    let pose = flight.world.poses()[0];
    agent.handle_frame(flight.pair.time, &blind(&config.camera, Step(STEPS), pose));
    agent.handle_timeout(flight.pair.time);
    agent
}

/// Receives packets in chunks; each chunk is applied at once.
fn read<'a>(
    mut agent: SetMembershipAgent,
    time: SimTime,
    packets: impl IntoIterator<Item = &'a Packet>,
    chunk: usize,
) -> SetMembershipAgent {
    let packets: Vec<_> = packets.into_iter().collect();
    for chunk in packets.chunks(chunk) {
        for packet in chunk {
            agent.hear(time, &packet.bytes);
        }
        agent.handle_timeout(time);
    }
    // Rejected plans do not matter here; all facts and snapshots must be believed.
    assert!(agent.rejected().keys().all(|reason| *reason == "plan"), "{:?}", agent.rejected());
    agent
}

/// The greatest symmetric difference between corresponding sets, m²; and that of the margins.
fn apart_m2(a: &Knowledge, b: &Knowledge) -> [f64; 2] {
    assert!(a.targets.keys().eq(b.targets.keys()), "{:?} {:?}", a.targets.keys(), b.targets.keys());
    assert_eq!(a.oem, b.oem);
    let pairs = a.targets.values().zip(b.targets.values());
    let targets = pairs.map(|(a, b)| difference_m2(a.region(), b.region()));
    let unexplored = difference_m2(a.unexplored.region(), b.unexplored.region());
    [
        targets.chain([unexplored]).fold(0.0, f64::max),
        difference_m2(a.margin.region(), b.margin.region()),
    ]
}

/// Packets in another order, some twice.
fn mixed<'a>(packets: &'a [Packet], rng: &mut ChaCha8Rng) -> Vec<&'a Packet> {
    let mut mixed: Vec<&Packet> = packets.iter().collect();
    mixed.extend(packets.iter().filter(|_| rng.random_bool(0.4)));
    mixed.shuffle(rng);
    mixed
}

#[test]
fn order_and_repeats_of_what_is_equally_old_change_nothing() {
    let mut worst_m2 = 0.0f64;
    let (mut targets, mut known_m2) = (0, 0.0);
    let name = ["estimator", "order_and_repeats_of_what_is_equally_old_change_nothing"];
    for_seeds(name, 0..8, |seed| {
        // Margins that are simplified whenever they grow depend on the order: see below.
        let (flight, packets) = recorded(seed, 0.0);
        let time = flight.pair.time;
        let expected = read(unread(&flight), time, &packets, packets.len());
        targets += expected.knowledge().targets.len();
        let whole_m2 = expected.knowledge().ground().area_m2();
        known_m2 += whole_m2 - expected.knowledge().unexplored.region().area_m2();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for chunk in [1, 7] {
            let got = read(unread(&flight), time, mixed(&packets, &mut rng), chunk);
            let [sets_m2, margins_m2] = apart_m2(got.knowledge(), expected.knowledge());
            assert!(sets_m2 < 1e-3, "{sets_m2} m² apart in chunks of {chunk}");
            assert!(margins_m2 < 1e-3, "margins {margins_m2} m² apart in chunks of {chunk}");
            worst_m2 = worst_m2.max(sets_m2);
        }
        let broken = truth::broken(expected.knowledge(), flight.world.targets());
        assert!(broken.is_empty(), "{broken:?}");
    });
    println!("{targets} targets and {known_m2:.0} m² told; sets at most {worst_m2:.1e} m² apart");
    assert!(is_replay() || (targets > 5 && known_m2 > 1000.0));
}

/// In one update, the order of arrival and repeats do not change a bit. In several updates simplified
/// margins differ a little, and so do the sets.
#[test]
fn order_and_repeats_do_not_change_a_bit_of_one_update() {
    let (mut worst, mut worst_margin) = (0.0f64, 0.0f64);
    let name = ["estimator", "order_and_repeats_do_not_change_a_bit_of_one_update"];
    for_seeds(name, 0..8, |seed| {
        let (flight, packets) = recorded(seed, 0.5);
        let time = flight.pair.time;
        let expected = read(unread(&flight), time, &packets, packets.len());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..3 {
            let mixed = mixed(&packets, &mut rng);
            let all = mixed.len();
            let got = read(unread(&flight), time, mixed, all);
            assert_eq!(got.digest(), expected.digest());
        }
        let got = read(unread(&flight), time, mixed(&packets, &mut rng), 1);
        let [sets_m2, margins_m2] = apart_m2(got.knowledge(), expected.knowledge());
        worst = worst.max(sets_m2 / expected.knowledge().ground().area_m2());
        worst_margin =
            worst_margin.max(margins_m2 / expected.knowledge().margin.region().area_m2());
        for agent in [&expected, &got] {
            let broken = truth::broken(agent.knowledge(), flight.world.targets());
            assert!(broken.is_empty(), "{broken:?}");
        }
    });
    println!(
        "one by one: sets {:.2} % of the region apart, margins {:.1} %",
        100.0 * worst,
        100.0 * worst_margin
    );
    assert!(worst < 0.002 && worst_margin < 0.1, "{worst} {worst_margin}");
}

#[test]
fn late_repeated_and_reordered_messages_keep_the_guarantee() {
    let (mut late, mut identified) = (0, 0);
    let name = ["estimator", "late_repeated_and_reordered_messages_keep_the_guarantee"];
    for_seeds(name, 0..16, |seed| {
        let mut scenario = small(seed, 140.0, 3);
        let modes = [ExchangeMode::Facts, ExchangeMode::FactsRepair, ExchangeMode::Snapshot];
        scenario.exchange.mode = modes[seed as usize % 3];
        scenario.exchange.snapshot_period_s = 4.0;
        scenario.targets.v_max_m_s = [1.0, 3.0][seed as usize % 2];
        scenario.agents.start_offset_m = 0.0;
        let mut flight = Flight::scripted(&scenario, rounds);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        flight.pair.filter = Box::new(move |_| {
            // 0, 1 or 2 copies, each up to 20 steps late.
            let copies = rng.random_range(0..3);
            (0..copies).map(|_| rng.random_range(0.0..10.0)).collect()
        });
        for _ in 0..50 {
            flight.step();
            flight.check_guarantee();
            flight.check_consistency();
        }
        let others = |e: &csat_agent::agent::Event| {
            matches!(e, csat_agent::agent::Event::Identified { by_others: true, .. })
        };
        late += flight.pair.events.iter().filter(|(_, event)| others(event)).count();
        let agents = &flight.pair.agents;
        identified += agents.iter().map(|a| a.knowledge().targets.len()).sum::<usize>();
    });
    println!("{identified} targets known, {late} of them from late messages");
    assert!(is_replay() || late > 10);
}
