//! A receiver and valid messages for it, which tests change.

use csat_agent::agent::{Event, SetMembershipAgent};
use csat_proto::agent::Agent;
use csat_proto::envelope::Envelope;
use csat_proto::ids::Incarnation;
use csat_proto::message::{Fact, Known, Message, Plan, Snapshot};
use csat_proto::region::{Region, grid_point};
use csat_proto::time::{SimTime, Step};
use csat_tests::geometry::Point;
use csat_tests::hears::Hears;

use super::packets::{body, digest, unread_fact};

/// A receiver and a valid message that it has not received.
pub struct Bench {
    pub agent: SetMembershipAgent,
    pub now: SimTime,
    pub envelope: Envelope,
    pub fact: Fact,
}

impl Bench {
    /// UAV 0 in the 10th second or later, after messages of a second incarnation of UAV 1.
    pub fn new() -> Self {
        let (flight, packet) = unread_fact(3);
        let mut agent = flight.pair.agent(0).clone();
        let mut envelope = Envelope::decode(&packet.bytes).unwrap();
        let Message::Fact(mut fact) = body(&packet) else { panic!("a fact was asked for") };
        envelope.incarnation = Incarnation(4);
        let now = flight.pair.time;
        agent.hear(now, &envelope.encode());
        agent.handle_timeout(now);
        assert!(agent.rejected().is_empty(), "{:?}", agent.rejected());
        while agent.poll_event().is_some() {}
        // Another number, so that it is not skipped as a repeat.
        fact.number += 1;
        envelope.body = postcard::to_stdvec(&Message::Fact(fact.clone())).unwrap();
        Self { agent, now, envelope, fact }
    }

    pub fn header(&self, spoil: impl FnOnce(&mut Envelope)) -> Vec<u8> {
        let mut envelope = self.envelope.clone();
        spoil(&mut envelope);
        envelope.encode()
    }

    fn say(&self, message: &Message) -> Vec<u8> {
        self.header(|e| e.body = postcard::to_stdvec(message).unwrap())
    }

    pub fn fact(&self, spoil: impl FnOnce(&mut Fact)) -> Vec<u8> {
        let mut fact = self.fact.clone();
        spoil(&mut fact);
        self.say(&Message::Fact(fact))
    }

    pub fn snapshot(&self, spoil: impl FnOnce(&mut Snapshot)) -> Vec<u8> {
        let known = Known {
            step: Step(self.fact.step.0 - 1),
            targets: Vec::new(),
            unexplored: self.agent.knowledge().unexplored.region().clone(),
            obstacle_margin: Region::EMPTY,
        };
        let mut snapshot = Snapshot { fact: self.fact.clone(), known };
        spoil(&mut snapshot);
        self.say(&Message::Snapshot(Box::new(snapshot)))
    }

    pub fn known(&self, spoil: impl FnOnce(&mut Known)) -> Vec<u8> {
        self.snapshot(|s| spoil(&mut s.known))
    }

    pub fn plan(&self, spoil: impl FnOnce(&mut Plan)) -> Vec<u8> {
        let step = Step(self.fact.step.0 / 6 * 6);
        let mut plan = Plan { step, pass: 0, poses: vec![self.envelope.pose; 2] };
        spoil(&mut plan);
        let step = plan.step;
        let message = Message::Plan(plan);
        self.header(|e| (e.step, e.body) = (step, postcard::to_stdvec(&message).unwrap()))
    }

    /// # Panics
    /// When a message is not rejected for that reason, or changes anything else.
    pub fn expect(&self, reason: &'static str, bytes: &[u8]) {
        let mut agent = self.agent.clone();
        let before = digest(&agent);
        for count in 1..=3 {
            agent.hear(self.now, bytes);
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

    /// # Panics
    /// When a message is not believed, or changes nothing.
    pub fn expect_believed(&self, bytes: &[u8]) {
        let mut agent = self.agent.clone();
        agent.hear(self.now, bytes);
        assert!(agent.rejected().is_empty(), "{:?}", agent.rejected());
        let before = agent.clone();
        agent.handle_timeout(self.now);
        assert_ne!(digest(&agent), digest(&before), "nothing was learnt from it");
    }
}

/// A ring through points, metres.
pub fn ring(points: &[Point]) -> Vec<csat_proto::region::GridPoint> {
    points.iter().map(|&p| grid_point(p)).collect()
}

/// A set of one shape.
pub fn shape(rings: &[&[Point]]) -> Region {
    Region::from_shapes(vec![rings.iter().map(|points| ring(points)).collect()])
}

/// A square around the origin.
pub fn square(half_m: f64, clockwise: bool) -> Region {
    let mut corners =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|p| p.map(|x: f64| x * half_m));
    if clockwise {
        corners.reverse();
    }
    shape(&[&corners])
}
