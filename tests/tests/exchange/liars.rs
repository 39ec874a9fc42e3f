//! False messages that are believed, because nothing in them is impossible, and that do no harm.

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::{AgentConfig, ExchangeMode};
use csat_agent::exchange::validate;
use csat_mission::timing::Stopwatch;
use csat_proto::agent::Agent;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{HeldFacts, TargetFact};
use csat_proto::raster::Grid;
use csat_proto::region::Region;
use csat_proto::time::{SimTime, Step};
use csat_tests::geometry::Point;
use csat_tests::hears::Hears;

use super::spoiling::{Bench, ring};

/// The receiver with the default exchange.
fn talking(bench: &Bench) -> SetMembershipAgent {
    let mut config: AgentConfig = bench.agent.config().clone();
    config.exchange.mode = ExchangeMode::FactsRepair;
    let mut agent = SetMembershipAgent::new(&config);
    fly(&mut agent, bench.fact.step);
    agent
}

/// Handles a blind frame of a step, and returns the messages after it.
fn fly(agent: &mut SetMembershipAgent, step: Step) -> Vec<Envelope> {
    let config = agent.config().clone();
    let now = SimTime::from_seconds(f64::from(step.0) * config.period_s);
    let pose = csat_proto::camera::Pose::level([0.0, 0.0, 40.0], 0.0);
    agent.handle_frame(now, &csat_tests::scenes::blind(&config.camera, step, pose));
    agent.handle_timeout(now);
    let said = std::iter::from_fn(|| agent.poll_transmit());
    said.map(|transmit| Envelope::decode(&transmit.bytes).expect("its own")).collect()
}

/// A sender that claims to hold any number of facts of any number of incarnations does not silence
/// the receiver: a digest of too many incarnations would not be believed.
#[test]
fn claims_of_many_lives_do_not_silence_whoever_hears_them() {
    let bench = Bench::new();
    let mut agent = talking(&bench);
    let first = bench.fact.number;
    for round in 0..10 {
        let lives = (0..64).flat_map(|i| {
            let incarnation = Incarnation(round * 64 + i);
            (0..2).map(move |origin| HeldFacts { origin: AgentId(origin), incarnation, count: 9 })
        });
        let mut lives: Vec<HeldFacts> = lives.collect();
        lives.sort();
        let bytes = bench.snapshot(|s| {
            (s.fact.number, s.fact.held.facts) = (first + round, lives);
        });
        agent.hear(bench.now, &bytes);
        agent.handle_timeout(bench.now);
        assert!(agent.rejected().is_empty(), "{:?}", agent.rejected());
    }
    let mut other = bench.agent.config().clone();
    other.id = AgentId(1);
    let now = Step(bench.fact.step.0 + 1);
    let said = fly(&mut agent, now);
    assert!(!said.is_empty());
    for envelope in said {
        assert_eq!(validate::check(&other, now, &envelope).err(), None);
    }
}

/// The greatest numbers, in fields to which numbers are added.
#[test]
fn the_greatest_numbers_are_no_trap() {
    let bench = Bench::new();
    let mut agent = talking(&bench);
    let all = |count| {
        (0..2).map(move |i| HeldFacts { origin: AgentId(i), incarnation: Incarnation(4), count })
    };
    for number in [u32::MAX, u32::MAX - 1] {
        for bytes in [
            bench.fact(|f| (f.number, f.held.facts) = (number, all(u32::MAX).collect())),
            bench.snapshot(|s| {
                (s.fact.number, s.fact.held.facts) = (number - 2, all(u32::MAX).collect());
            }),
        ] {
            agent.hear(bench.now, &bytes);
            agent.handle_timeout(bench.now);
            assert!(agent.rejected().is_empty(), "{:?}", agent.rejected());
        }
    }
    for step in 1..4 {
        fly(&mut agent, Step(bench.fact.step.0 + step));
    }
}

/// A few bytes that claim a raster with one cell per row, each row as large as a word.
#[test]
fn a_narrow_raster_takes_no_more_memory_than_it_has_cells() {
    let bytes = |columns, rows| {
        let grid = Grid { cell_m: 1.0, columns, rows };
        postcard::to_stdvec(&(grid, Vec::<u32>::new())).unwrap()
    };
    let read = |columns, rows| {
        postcard::from_bytes::<csat_proto::raster::Raster>(&bytes(columns, rows)).is_ok()
    };
    assert!(read(4096, 4096) && read(1, 1000));
    assert!(!read(1, 1 << 24) && !read(1 << 24, 2));
}

/// Very many small old squares, which all overlap when they grow by their age.
fn dust(n: u32, side_m: f64) -> Region {
    let step = side_m / f64::from(n);
    let square = |k: u32| {
        let at = |i: u32| step * (f64::from(i) + 0.25) - side_m / 2.0;
        let ([x, y], s) = ([at(k % n), at(k / n)], step / 2.0);
        let corners: [Point; 4] = [[x, y], [x + s, y], [x + s, y + s], [x, y + s]];
        vec![ring(&corners)]
    };
    Region::from_shapes((0..n * n).map(square).collect())
}

#[test]
fn dust_of_long_ago_does_not_take_long() {
    let bench = Bench::new();
    let then = bench.fact.step.0.saturating_sub(20);
    let side_m = 0.9 * bench.agent.config().ground.size_m[0];
    let some: Vec<TargetFact> = (0..200)
        .map(|j| TargetFact {
            target: csat_proto::ids::TargetId(j),
            location: dust(4, 10.0),
            exclusion: dust(3, 10.0),
        })
        .collect();
    let old = |bytes: Vec<u8>| {
        let mut envelope = Envelope::decode(&bytes).expect("its own");
        envelope.step = Step(then);
        envelope.encode()
    };
    let messages = [
        bench.fact(|f| (f.step, f.clear_ground) = (Step(then), dust(110, side_m))),
        bench.fact(|f| (f.step, f.targets) = (Step(then), some)),
        bench.snapshot(|s| {
            (s.fact.step, s.known.step) = (Step(then), Step(then));
            s.known.unexplored = dust(110, side_m);
        }),
    ];
    for bytes in messages.map(old) {
        let mut agent = bench.agent.clone();
        let watch = Stopwatch::start();
        agent.hear(bench.now, &bytes);
        agent.handle_timeout(bench.now);
        let took_ms = watch.elapsed_ms();
        println!("{} kB took {took_ms:.0} ms", bytes.len() / 1000);
        assert!(agent.rejected().is_empty(), "{:?}", agent.rejected());
        assert!(took_ms < 2000.0, "{took_ms} ms");
    }
}
