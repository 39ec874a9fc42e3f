//! Messages that are not believed are dropped, counted by reason, reported once, and change nothing.

use csat_agent::agent::{DropReason, Event, SetMembershipAgent};
use csat_agent::config::Criterion;
use csat_agent::exchange::validate::Rejection;
use csat_proto::agent::{Agent, MAX_MESSAGE_BYTES};
use csat_proto::envelope::{Envelope, EnvelopeError};
use csat_proto::ids::{AgentId, Incarnation, RunId, TargetId};
use csat_proto::message::{HeldFacts, Message, Plan, Relay, RelayedPlan};
use csat_proto::oem::{OemCell, OemDelta, OemPatch};
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::Region;
use csat_proto::time::{SimTime, Step};
use csat_tests::geometry::Point;
use csat_tests::hears::Hears;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::packets::{digest, unread_fact};
use super::spoiling::{Bench, ring, shape, square};

/// Does not compile when a reason is added that no test below covers.
fn every_reason(reason: &DropReason) {
    let rejection = match reason {
        DropReason::Message(rejection) => rejection,
        DropReason::OldFrame { .. } | DropReason::Plan(_) => return,
    };
    match rejection {
        Rejection::Envelope(
            EnvelopeError::TooLong { .. }
            | EnvelopeError::Magic
            | EnvelopeError::Checksum
            | EnvelopeError::Malformed,
        )
        | Rejection::Run
        | Rejection::Sender { .. }
        | Rejection::Incarnation { .. }
        | Rejection::Future { .. }
        | Rejection::TooOld { .. }
        | Rejection::Malformed
        | Rejection::Relay
        | Rejection::RelayOrder
        | Rejection::Step { .. }
        | Rejection::KnownStep { .. }
        | Rejection::TooManyVertices { .. }
        | Rejection::Outside
        | Rejection::Winding
        | Rejection::Crossing
        | Rejection::Bundle
        | Rejection::Targets
        | Rejection::Grid
        | Rejection::Cell { .. }
        | Rejection::Digest { .. }
        | Rejection::Full { .. } => {}
        // In experiments/tests/liars.rs: it takes a fleet.
        Rejection::Liar { .. } => {}
    }
}

#[test]
fn honest_messages_are_believed() {
    let bench = Bench::new();
    every_reason(&Rejection::Run.into());
    bench.expect_believed(&bench.fact(|f| f.clear_ground = square(20.0, false)));
    bench.expect_believed(&bench.known(|k| k.unexplored = square(20.0, false)));
    let mut agent = bench.agent.clone();
    agent.hear(bench.now, &bench.plan(|_| {}));
    assert!(agent.rejected().is_empty(), "an honest plan is taken over");
}

#[test]
fn spoilt_headers_are_rejected() {
    let bench = Bench::new();
    let whole = bench.envelope.encode();
    bench.expect("envelope", &vec![0; MAX_MESSAGE_BYTES + 1]);
    bench.expect("envelope", b"what is this?");
    bench.expect("envelope", &whole[..7]);
    bench.expect("envelope", b"");
    bench.expect("checksum", &whole[..whole.len() - 1]);
    let mut damaged = whole.clone();
    *damaged.last_mut().unwrap() ^= 1;
    bench.expect("checksum", &damaged);
    bench.expect("run", &bench.header(|e| e.run = RunId(e.run.0 + 1)));
    bench.expect("sender", &bench.header(|e| e.src = AgentId(0)));
    bench.expect("sender", &bench.header(|e| e.src = AgentId(2)));
    bench.expect("incarnation", &bench.header(|e| e.incarnation = Incarnation(3)));
    bench.expect("future", &bench.header(|e| e.step = Step(e.step.0 + 2)));
    bench.expect("step", &bench.header(|e| e.step = Step(e.step.0 + 1)));
}

#[test]
fn old_messages_are_rejected() {
    let mut bench = Bench::new();
    let config = bench.agent.config().clone();
    let late = (config.exchange.max_age_s / config.period_s) as u32 + bench.fact.step.0;
    let pose = *bench.agent.pose();
    let at = |step: u32| SimTime::from_seconds(f64::from(step) * config.period_s);
    let blind = |step| csat_tests::scenes::blind(&config.camera, Step(step), pose);
    bench.agent.handle_frame(at(late), &blind(late));
    let mut just_in_time = bench.agent.clone();
    just_in_time.hear(at(late), &bench.envelope.encode());
    assert!(just_in_time.rejected().is_empty(), "{:?}", just_in_time.rejected());
    bench.now = at(late + 1);
    bench.agent.handle_frame(bench.now, &blind(late + 1));
    bench.agent.handle_timeout(bench.now);
    while bench.agent.poll_event().is_some() || bench.agent.poll_transmit().is_some() {}
    while bench.agent.poll_command().is_some() {}
    bench.expect("too-old", &bench.envelope.encode());
}

#[test]
fn spoilt_bodies_are_rejected() {
    let bench = Bench::new();
    bench.expect("malformed", &bench.header(|e| e.body.clear()));
    bench.expect("malformed", &bench.header(|e| e.body[0] = 77));
    bench.expect("malformed", &bench.header(|e| e.body.truncate(40)));
    bench.expect("malformed", &bench.header(|e| e.body.push(0)));
    bench.expect("step", &bench.fact(|f| f.step = Step(f.step.0 - 1)));
    bench.expect("known-step", &bench.known(|k| k.step = Step(k.step.0 + 2)));
    bench.expect("targets", &bench.fact(|f| f.targets.push(f.targets[0].clone())));
    let twice = vec![(TargetId(3), square(3.0, false)); 2];
    bench.expect("targets", &bench.known(|k| k.targets = twice));
    bench.expect("targets", &bench.fact(|f| f.targets[0].target = TargetId(1024)));
    bench.expect(
        "targets",
        &bench.known(|k| k.targets = vec![(TargetId(1024), square(3.0, false))]),
    );
    let grid = Grid { cell_m: 2.0, columns: 7, rows: 7 };
    bench.expect("grid", &bench.fact(|f| f.hidden = Raster::empty(grid)));
    bench.expect("grid", &bench.snapshot(|s| s.fact.seen = Raster::empty(grid)));
}

#[test]
fn sets_that_cannot_be_are_rejected() {
    let bench = Bench::new();
    let limit = bench.agent.config().exchange.max_vertices as usize;
    let one = square(1.0, false).into_shapes();
    let many = Region::from_shapes(one.into_iter().cycle().take(limit / 4 + 1).collect());
    bench.expect("vertices", &bench.fact(|f| f.clear_ground = many));
    let side_m = bench.agent.config().ground.size_m[0];
    bench.expect("outside", &bench.fact(|f| f.obstacle_margin = square(side_m, false)));
    bench.expect("outside", &bench.known(|k| k.unexplored = square(side_m, false)));
    bench.expect("winding", &bench.fact(|f| f.targets[0].location = square(3.0, true)));
    bench.expect("winding", &bench.known(|k| k.obstacle_margin = square(3.0, true)));
    let outer: &[Point] = &[[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
    let hole: &[Point] = &[[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0]];
    bench.expect("winding", &bench.fact(|f| f.clear_ground = shape(&[outer, hole])));
    let eight: &[Point] = &[[0.0, 0.0], [9.0, 9.0], [9.0, 0.0], [0.0, 8.0]];
    bench.expect("crossing", &bench.fact(|f| f.targets[0].exclusion = shape(&[eight])));
    bench.expect("crossing", &bench.known(|k| k.unexplored = shape(&[eight])));
    let poking: &[Point] = &[[-3.0, -3.0], [0.0, 12.0], [3.0, -3.0]];
    bench.expect("crossing", &bench.fact(|f| f.clear_ground = shape(&[outer, poking])));
    // Two shapes, each valid on its own.
    let beside = Region::from_shapes(vec![
        vec![ring(outer)],
        vec![ring(&[[0.0, 0.0], [20.0, 1.0], [20.0, 2.0]])],
    ]);
    bench.expect("crossing", &bench.known(|k| k.targets = vec![(TargetId(3), beside)]));
}

/// A zigzag whose edges all lie side by side: the check for crossings stops early.
#[test]
fn a_dense_bundle_is_rejected_at_once() {
    let bench = Bench::new();
    // The other sets of the fact count as well.
    let vertices = bench.agent.config().exchange.max_vertices - 1000;
    let side_m = bench.agent.config().ground.size_m[0];
    for slant_m in [0.0, side_m / 2.0] {
        let zigzag = (0..vertices).map(|i| {
            let along = f64::from(i % 2);
            let p = [(along - 0.5) * side_m, slant_m * (along - 0.5) + f64::from(i) * 2e-5];
            p.map(|x| x.clamp(-side_m / 2.0, side_m / 2.0))
        });
        let bundle = shape(&[&zigzag.collect::<Vec<Point>>()]);
        let bytes = bench.fact(|f| f.clear_ground = bundle);
        bench.expect("bundle", &bytes);
    }
}

#[test]
fn maps_that_cannot_be_are_rejected() {
    let bench = Bench::new();
    let cells = bench.agent.config().oem_grid().cells() as u32;
    let upto = |end: u32| OemPatch::of([OemDelta { cell: end - 1, state: OemCell::Empty }]);
    bench.expect("cell", &bench.fact(|f| f.oem = upto(cells + 1)));
    bench.expect("cell", &bench.snapshot(|s| s.fact.oem = upto(cells + 1)));
    let mut agent = bench.agent.clone();
    agent.hear(bench.now, &bench.fact(|f| f.oem = upto(cells)));
    assert!(agent.rejected().is_empty(), "the last cell is one: {:?}", agent.rejected());
    // Runs of gap, length, state: bytes that claim 2³³ and 2⁴⁶ cells. Iterating over them would take
    // days.
    let runs = vec![(u32::MAX, u32::MAX, OemCell::Empty); 1 << 13];
    for runs in [&runs[..1], &runs] {
        let bytes = postcard::to_stdvec(runs).unwrap();
        let claim: OemPatch = postcard::from_bytes(&bytes).unwrap();
        assert!(bytes.len() < 100_000 && claim.end() >= (runs.len() as u64) << 32);
        bench.expect("cell", &bench.fact(|f| f.oem = claim.clone()));
    }
}

#[test]
fn digests_that_cannot_be_are_rejected() {
    let bench = Bench::new();
    let life = |origin, incarnation| HeldFacts {
        origin: AgentId(origin),
        incarnation: Incarnation(incarnation),
        count: 3,
    };
    let fleet = bench.agent.config().fleet.count;
    bench.expect("digest", &bench.fact(|f| f.held.facts = vec![life(fleet, 0)]));
    let unsorted = vec![life(1, 0), life(0, 0)];
    bench.expect("digest", &bench.fact(|f| f.held.facts = unsorted));
    bench.expect("digest", &bench.fact(|f| f.held.facts = vec![life(1, 2), life(1, 1)]));
    let lives = (0..=64 * u32::from(fleet)).map(|i| life(0, i)).collect();
    bench.expect("digest", &bench.snapshot(|s| s.fact.held.facts = lives));
    let blocks = csat_agent::estimate::oem::Oem::blocks(&bench.agent.config().oem_grid());
    for wrong in [1, blocks - 1, blocks + 1] {
        bench.expect("digest", &bench.fact(|f| f.held.oem = vec![7; wrong]));
    }
    bench.expect_believed(&bench.fact(|f| {
        (f.held.facts, f.held.oem) = (vec![life(0, 0), life(1, 4)], vec![7; blocks]);
        f.clear_ground = square(20.0, false);
    }));
}

/// Each reason is reported once per sender.
#[test]
fn a_reason_is_reported_of_every_sender() {
    let (flight, packet) = unread_fact(3);
    let mut config = flight.pair.agent(0).config().clone();
    config.fleet.count = 3;
    let mut agent = SetMembershipAgent::new(&config);
    let now = flight.pair.time;
    let mut reported = Vec::new();
    for src in [1, 2, 9, 1, 2, 8] {
        let mut envelope = Envelope::decode(&packet.bytes).unwrap();
        (envelope.src, envelope.body) = (AgentId(src), Vec::new());
        envelope.step = Step(0);
        agent.hear(now, &envelope.encode());
        reported.extend(std::iter::from_fn(|| agent.poll_event()).map(|event| match event {
            Event::Rejected { from, reason, .. } => (from, reason.into_owned()),
            other => panic!("{other:?}"),
        }));
    }
    let malformed = |src: Option<u16>| (src.map(AgentId), "malformed".to_owned());
    assert_eq!(reported, [malformed(Some(1)), malformed(Some(2)), malformed(None)]);
    assert_eq!(agent.rejected().get("malformed"), Some(&6));
}

/// One fact per UAV and step may wait, and no more.
#[test]
fn a_flood_is_not_kept() {
    let mut bench = Bench::new();
    let config = bench.agent.config().clone();
    let steps = (config.exchange.max_age_s / config.period_s).ceil() as u32 + 1;
    let (max, first) = (steps * u32::from(config.fleet.count), bench.fact.number);
    let another = |i: u32| bench.fact(|f| f.number = first + i);
    let before = digest(&bench.agent);
    let flood: Vec<Vec<u8>> = (0..max + 3).map(another).collect();
    let (kept, refused) = flood.split_at(max as usize);
    for bytes in kept {
        bench.agent.hear(bench.now, bytes);
        // Repeats do not count.
        bench.agent.hear(bench.now, bytes);
    }
    assert!(bench.agent.rejected().is_empty(), "{:?}", bench.agent.rejected());
    for (bytes, count) in refused.iter().zip(1..) {
        bench.agent.hear(bench.now, bytes);
        assert_eq!(bench.agent.rejected().get("full"), Some(&count));
    }
    let event = bench.agent.poll_event();
    assert!(
        matches!(&event, Some(Event::Rejected { reason, .. }) if reason == "full"),
        "{event:?}"
    );
    assert!(bench.agent.poll_event().is_none() && digest(&bench.agent) == before);
}

#[test]
fn spoilt_plans_are_rejected() {
    let bench = Bench::new();
    bench.expect("plan", &bench.plan(|p| p.step = Step(p.step.0 + 1)));
    bench.expect("plan", &bench.plan(|p| p.pass = 2));
    bench.expect("plan", &bench.plan(|p| p.poses.clear()));
    bench.expect("plan", &bench.plan(|p| p.poses = vec![p.poses[0]; 256]));
}

/// Plans of UAVs 0, 2 and 3 that UAV 1 passes on at the start, to UAV 0 of a fleet under this planner.
fn relay_to(
    criterion: Criterion,
    liars: u16,
    spoil: impl FnOnce(&mut Relay),
) -> SetMembershipAgent {
    let bench = Bench::new();
    let mut config = bench.agent.config().clone();
    (config.fleet.count, config.radio_range_m) = (4, 100.0);
    (config.guidance.criterion, config.exchange.liars) = (criterion, liars);
    let mut agent = SetMembershipAgent::new(&config);
    let plan = Plan { step: Step(0), pass: 0, poses: vec![bench.envelope.pose; 20] };
    let plans = [0, 2, 3].map(|id| RelayedPlan { uav: AgentId(id), plan: plan.clone() });
    let mut relay = Relay { step: Step(0), plans: plans.to_vec() };
    spoil(&mut relay);
    let body = postcard::to_stdvec(&Message::Relay(relay)).unwrap();
    agent.hear(bench.now, &bench.header(|e| (e.step, e.body) = (Step(0), body)));
    agent
}

#[test]
fn spoilt_relays_are_rejected() {
    let reasons = |agent: SetMembershipAgent| -> Vec<(&'static str, u64)> {
        agent.rejected().iter().map(|(reason, count)| (*reason, *count)).collect()
    };
    assert_eq!(reasons(relay_to(Criterion::Str5, 0, |_| {})), [], "the own plan is skipped");
    assert_eq!(reasons(relay_to(Criterion::Str4, 0, |_| {})), [("relay", 1)]);
    assert_eq!(reasons(relay_to(Criterion::Str5, 1, |_| {})), [("relay", 1)], "who may lie");
    let spoilt = |spoil: fn(&mut Relay)| reasons(relay_to(Criterion::Str5, 0, spoil));
    assert_eq!(spoilt(|r| r.plans.swap(1, 2)), [("relay-order", 1)]);
    assert_eq!(spoilt(|r| r.plans[2].uav = AgentId(2)), [("relay-order", 1)], "twice");
    assert_eq!(spoilt(|r| r.plans[2].uav = AgentId(4)), [("plan", 1)], "no such UAV");
    assert_eq!(spoilt(|r| r.plans[1].plan.pass = 1), [("plan", 1)]);
    assert_eq!(spoilt(|r| r.step = Step(1)), [("step", 1)]);
}

/// Damaged bodies with a correct checksum, as a malicious sender makes them. They cause no panic,
/// believed or not.
#[test]
fn nothing_in_a_body_makes_an_agent_panic() {
    let bench = Bench::new();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut believed, mut rejected) = (0, 0);
    for _ in 0..1500 {
        let bytes = bench.header(|e| {
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..e.body.len());
                e.body[at] = rng.random();
            }
        });
        let mut agent = bench.agent.clone();
        let before = digest(&agent);
        agent.hear(bench.now, &bytes);
        agent.handle_timeout(bench.now);
        if agent.rejected().is_empty() {
            believed += 1;
        } else {
            rejected += 1;
            assert_eq!(digest(&agent), before);
        }
    }
    println!("{believed} damaged bodies were believed, {rejected} were not");
    assert!(believed > 50 && rejected > 50);
}
