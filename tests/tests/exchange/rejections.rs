//! Everything that is not believed is dropped, counted by reason, reported once, and changes nothing.

use csat_agent::agent::{Event, SetMembershipAgent};
use csat_agent::exchange::validate::Rejection;
use csat_proto::agent::{Agent, MAX_MESSAGE_BYTES};
use csat_proto::envelope::{Envelope, EnvelopeError};
use csat_proto::ids::{AgentId, Incarnation, RunId, TargetId};
use csat_proto::message::{Fact, Message, OemCell, OemDelta, Plan, Snapshot};
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::{Region, grid_point};
use csat_proto::time::{SimTime, Step};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::letters::{body, digest, unread_fact};

/// A receiver and an honest message for it, to be spoilt.
struct Bench {
    agent: SetMembershipAgent,
    now: SimTime,
    envelope: Envelope,
    fact: Fact,
}

impl Bench {
    /// UAV 0, having heard a second life of UAV 1, in the 10th second or later.
    fn new() -> Self {
        let (flight, letter) = unread_fact(3);
        let mut agent = flight.pair.agent(0).clone();
        let mut envelope = Envelope::decode(&letter.bytes).unwrap();
        let Message::Fact(fact) = body(&letter) else { panic!("a fact was asked for") };
        envelope.incarnation = Incarnation(4);
        let now = flight.pair.time;
        agent.handle_message(now, &envelope.encode());
        agent.handle_timeout(now);
        assert!(agent.rejected().is_empty(), "{:?}", agent.rejected());
        while agent.poll_event().is_some() {}
        Self { agent, now, envelope, fact }
    }

    fn header(&self, spoil: impl FnOnce(&mut Envelope)) -> Vec<u8> {
        let mut envelope = self.envelope.clone();
        spoil(&mut envelope);
        envelope.encode()
    }

    fn say(&self, message: &Message) -> Vec<u8> {
        self.header(|e| e.body = postcard::to_stdvec(message).unwrap())
    }

    fn fact(&self, spoil: impl FnOnce(&mut Fact)) -> Vec<u8> {
        let mut fact = self.fact.clone();
        spoil(&mut fact);
        self.say(&Message::Fact(fact))
    }

    fn snapshot(&self, spoil: impl FnOnce(&mut Snapshot)) -> Vec<u8> {
        let mut snapshot = Snapshot {
            step: self.fact.step,
            targets: Vec::new(),
            unexplored: Region::rectangle([10.0; 2]),
            obstacle_margin: Region::EMPTY,
            hidden: self.fact.hidden.clone(),
            seen: self.fact.seen.clone(),
            oem: Vec::new(),
        };
        spoil(&mut snapshot);
        self.say(&Message::Snapshot(snapshot))
    }

    fn plan(&self, spoil: impl FnOnce(&mut Plan)) -> Vec<u8> {
        let step = Step(self.fact.step.0 / 6 * 6);
        let mut plan = Plan { step, pass: 0, poses: vec![self.envelope.pose; 2] };
        spoil(&mut plan);
        let step = plan.step;
        let message = Message::Plan(plan);
        self.header(|e| (e.step, e.body) = (step, postcard::to_stdvec(&message).unwrap()))
    }

    /// # Panics
    /// When a message is not rejected for that reason, or leaves a trace beyond it.
    fn expect(&self, reason: &'static str, bytes: &[u8]) {
        let mut agent = self.agent.clone();
        let before = digest(&agent);
        for count in 1..=3 {
            agent.handle_message(self.now, bytes);
            let rejected: Vec<_> = agent.rejected().iter().map(|(r, n)| (*r, *n)).collect();
            assert_eq!(rejected, [(reason, count)]);
        }
        agent.handle_timeout(self.now);
        assert_eq!(digest(&agent), before, "{reason} changed what is known");
        assert!(agent.poll_transmit().is_none() && agent.poll_command().is_none(), "{reason}");
        let events: Vec<Event> = std::iter::from_fn(|| agent.poll_event()).collect();
        let reported = matches!(&events[..], [Event::Rejected { reason: r, detail, .. }]
            if *r == reason && !detail.is_empty());
        assert!(reported, "{reason} is to be reported once: {events:?}");
    }
}

/// Does not compile when a reason is added that is not tried below.
fn every_reason(rejection: &Rejection) {
    match rejection {
        Rejection::Envelope(
            EnvelopeError::TooLong { .. }
            | EnvelopeError::Magic
            | EnvelopeError::Checksum
            | EnvelopeError::Malformed
            | EnvelopeError::Pose,
        )
        | Rejection::Run
        | Rejection::Sender { .. }
        | Rejection::Incarnation { .. }
        | Rejection::Future { .. }
        | Rejection::TooOld { .. }
        | Rejection::Malformed
        | Rejection::Step { .. }
        | Rejection::TooManyVertices { .. }
        | Rejection::Outside
        | Rejection::Winding
        | Rejection::Targets
        | Rejection::Grid
        | Rejection::Cell { .. }
        | Rejection::Full { .. }
        | Rejection::Plan(_) => {}
    }
}

fn square(half_m: f64, clockwise: bool) -> Region {
    let mut ring = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]: [f64; 2]| grid_point([x * half_m, y * half_m]))
        .to_vec();
    if clockwise {
        ring.reverse();
    }
    Region::from_shapes(vec![vec![ring]])
}

#[test]
fn spoilt_headers_are_rejected() {
    let bench = Bench::new();
    every_reason(&Rejection::Run);
    let whole = bench.envelope.encode();
    bench.expect("envelope", &vec![0; MAX_MESSAGE_BYTES + 1]);
    bench.expect("envelope", b"what is this?");
    bench.expect("envelope", &whole[..7]);
    bench.expect("envelope", b"");
    bench.expect("envelope", &bench.header(|e| e.pose.yaw_rad = f64::INFINITY));
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
    just_in_time.handle_message(at(late), &bench.envelope.encode());
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
    bench.expect("step", &bench.fact(|f| f.step = Step(f.step.0 - 1)));
    let limit = bench.agent.config().exchange.max_vertices as usize;
    let one = square(1.0, false).into_shapes();
    let many = Region::from_shapes(one.into_iter().cycle().take(limit / 4 + 1).collect());
    bench.expect("vertices", &bench.fact(|f| f.clear_ground = many));
    let side_m = bench.agent.config().ground.size_m[0];
    bench.expect("outside", &bench.fact(|f| f.obstacle_margin = square(side_m, false)));
    bench.expect("outside", &bench.snapshot(|s| s.unexplored = square(side_m, false)));
    bench.expect("winding", &bench.fact(|f| f.targets[0].location = square(3.0, true)));
    bench.expect("winding", &bench.snapshot(|s| s.obstacle_margin = square(3.0, true)));
    bench.expect("targets", &bench.fact(|f| f.targets.push(f.targets[0].clone())));
    let twice = vec![(TargetId(3), square(3.0, false)); 2];
    bench.expect("targets", &bench.snapshot(|s| s.targets = twice));
    let grid = Grid { cell_m: 2.0, columns: 7, rows: 7 };
    bench.expect("grid", &bench.fact(|f| f.hidden = Raster::empty(grid)));
    bench.expect("grid", &bench.snapshot(|s| s.seen = Raster::empty(grid)));
    let cell = bench.agent.config().oem_grid().cells() as u32;
    let beyond = vec![OemDelta { cell, state: OemCell::Empty }];
    bench.expect("cell", &bench.fact(|f| f.oem = beyond.clone()));
    bench.expect("cell", &bench.snapshot(|s| s.oem = beyond));
}

/// A fact and a snapshot of every UAV and step may wait, not more.
#[test]
fn a_flood_is_not_kept() {
    let mut bench = Bench::new();
    let config = bench.agent.config().clone();
    let steps = (config.exchange.max_age_s / config.period_s).ceil() as usize + 1;
    let (max, bytes) = (2 * steps * usize::from(config.fleet.count), bench.envelope.encode());
    let before = digest(&bench.agent);
    for _ in 0..max {
        bench.agent.handle_message(bench.now, &bytes);
    }
    assert!(bench.agent.rejected().is_empty(), "{:?}", bench.agent.rejected());
    for count in 1..=3 {
        bench.agent.handle_message(bench.now, &bytes);
        assert_eq!(bench.agent.rejected().get("full"), Some(&count));
    }
    let event = bench.agent.poll_event();
    assert!(matches!(event, Some(Event::Rejected { reason: "full", .. })), "{event:?}");
    assert!(bench.agent.poll_event().is_none() && digest(&bench.agent) == before);
}

#[test]
fn spoilt_plans_are_rejected() {
    let bench = Bench::new();
    bench.expect("plan", &bench.plan(|p| p.step = Step(p.step.0 + 1)));
    bench.expect("plan", &bench.plan(|p| p.pass = 2));
    bench.expect("plan", &bench.plan(|p| p.poses.clear()));
    bench.expect("plan", &bench.plan(|p| p.poses = vec![p.poses[0]; 256]));
    bench.expect("plan", &bench.plan(|p| p.poses[0].p_world[1] = f64::NAN));
    let mut agent = bench.agent.clone();
    agent.handle_message(bench.now, &bench.plan(|_| {}));
    assert!(agent.rejected().is_empty(), "an honest plan is taken over");
}

/// Bodies damaged under a correct checksum: a liar's, not a bad link's. Believed or not, no panic.
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
        agent.handle_message(bench.now, &bytes);
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
