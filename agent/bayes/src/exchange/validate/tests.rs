use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, Incarnation, RunId};
use csat_proto::time::SimTime;
use proptest::prelude::*;

use super::*;
use crate::exchange::factor_set::FactorSet;
use crate::exchange::fixture::{POSE, config, factor};
use crate::exchange::held::HeldNumbers;
use crate::exchange::intervals::Intervals;
use crate::exchange::message::Plan;
use crate::exchange::protocol::{Exchange, Stamp};
use crate::tiles::{Tile, Tiles};

const NOW: u32 = 130;

fn held(numbers: std::ops::Range<u32>) -> HeldNumbers {
    let mut intervals = Intervals::EMPTY;
    numbers.for_each(|number| {
        intervals.insert(number);
    });
    HeldNumbers::of(AgentId(3), Incarnation(0), &intervals)
}

/// A good message with all that there can be.
fn message() -> Message {
    let seen = Factor { sighting: Some([0.0, 1.0]), ..factor(3, 5, 100) };
    let tiles = (0..4).flat_map(|row| (0..8).map(move |column| (column, row)));
    let tile = |(column, row)| Tile { level: 0, column, row, depth: 9 };
    Message {
        held: Some(Held(vec![held(0..40)])),
        factors: vec![factor(2, 0, 17), seen, factor(1, 0, 3)],
        plan: Plan { first: Step(120), period: 2, poses: vec![(&POSE).into(); 20] },
        belief: Some(Tiles(tiles.map(tile).collect())),
    }
}

fn envelope(message: &Message) -> Envelope {
    Envelope {
        run: RunId(7),
        src: AgentId(2),
        incarnation: Incarnation(0),
        channel: csat_proto::ids::ChannelId(0),
        sequence: 9,
        step: Step(120),
        time: SimTime(5),
        pose: POSE.into(),
        body: postcard::to_stdvec(message).unwrap(),
    }
}

/// The name of the check that a message fails, for agent 1.
fn verdict_of(envelope: &Envelope) -> &'static str {
    let checked = check(&config(1), Step(NOW), envelope);
    checked.map_or_else(|rejection| rejection.name(), |_| "good")
}

#[test]
fn headers_are_checked() {
    let with = |change: &dyn Fn(&mut Envelope)| {
        let mut changed = envelope(&message());
        change(&mut changed);
        verdict_of(&changed)
    };
    assert_eq!(with(&|_| {}), "good");
    assert_eq!(with(&|e| e.run = RunId(8)), "run");
    assert_eq!(with(&|e| e.src = AgentId(1)), "sender");
    assert_eq!(with(&|e| e.src = AgentId(5)), "sender");
    assert_eq!(with(&|e| e.src = AgentId(4)), "good", "a station relays");
    assert_eq!(with(&|e| e.step = Step(NOW + 1)), "good");
    assert_eq!(with(&|e| e.step = Step(NOW + 2)), "future");
    assert_eq!(with(&|e| e.step = Step(9)), "too-old");
    assert_eq!(with(&|e| e.pose = Pose::level([0.0, 0.0, -1e7], 0.0).into()), "pose");
    assert_eq!(with(&|e| e.body.push(0)), "malformed");
    assert_eq!(with(&|e| e.body.truncate(9)), "malformed");
}

#[test]
fn factors_are_checked() {
    let with = |change: &dyn Fn(&mut Factor)| {
        let mut changed = message();
        change(&mut changed.factors[1]);
        verdict_of(&envelope(&changed))
    };
    assert_eq!(with(&|f| f.id.source = AgentId(4)), "source");
    assert_eq!(with(&|f| f.step = Step(121)), "factor-step");
    assert_eq!(with(&|f| f.id.number = 101), "number");
    for bad in [f32::NAN, f32::INFINITY, 2051.0, -2051.0] {
        assert_eq!(with(&|f| f.pose.p_world[0] = bad), "pose", "{bad}");
        assert_eq!(with(&|f| f.sighting = Some([bad, 1.0])), "sighting", "{bad}");
    }
    for bad in [f32::NAN, 0.0, -1.0, 10_000.0] {
        assert_eq!(with(&|f| f.pose.p_world[2] = bad), "pose", "{bad}");
    }
    for bad in [f32::NAN, std::f32::consts::FRAC_PI_2, -1.6] {
        assert_eq!(with(&|f| f.pose.angles_rad[1] = bad), "pose", "{bad}");
        assert_eq!(with(&|f| f.pose.angles_rad[2] = bad), "pose", "{bad}");
    }
    assert_eq!(with(&|f| f.pose.angles_rad[0] = f32::NAN), "pose");
    assert_eq!(with(&|f| f.sighting = Some([1.0, -0.1])), "sighting");
    let mut many = message();
    many.factors = vec![factor(2, 0, 17); MAX_FACTORS + 1];
    assert_eq!(verdict_of(&envelope(&many)), "factors");
}

#[test]
fn what_its_source_did_not_state_is_forged() {
    let config = crate::config::AgentConfig { incarnation: Incarnation(2), ..config(1) };
    let is_good = |source, incarnation, number| {
        check_own(&config, 10, &factor(source, incarnation, number)).is_ok()
    };
    assert!(is_good(1, 2, 9) && is_good(1, 1, 50) && is_good(2, 7, 50));
    assert!(!is_good(1, 2, 10) && !is_good(1, 3, 0));
}

#[test]
fn the_other_parts_are_checked() {
    let with = |change: &dyn Fn(&mut Message)| {
        let mut changed = message();
        change(&mut changed);
        verdict_of(&envelope(&changed))
    };
    assert_eq!(with(&|m| m.held = Some(Held(vec![held(0..122)]))), "good");
    assert_eq!(with(&|m| m.held = Some(Held(vec![held(0..123)]))), "held");
    assert_eq!(with(&|m| m.held = Some(Held(vec![held(0..1), held(0..1)]))), "held");
    assert_eq!(with(&|m| m.plan.poses = vec![(&POSE).into(); MAX_PLAN + 1]), "plan");
    assert_eq!(with(&|m| m.plan.period = 0), "plan");
    assert_eq!(with(&|m| m.plan.period = u32::MAX), "plan");
    assert_eq!(with(&|m| m.plan.first = Step(123)), "plan");
    assert_eq!(with(&|m| m.plan.poses[3].p_world[1] = f32::NAN), "pose");
    assert_eq!(with(&|m| m.belief.as_mut().unwrap().0[7].level = 200), "belief");
    assert_eq!(with(&|m| m.belief = Some(Tiles::default())), "belief");
    assert_eq!(with(&|m| *m = Message::default()), "good");
}

/// Whatever is believed must do no harm either.
fn live_with(bytes: &[u8]) {
    let config = config(1);
    let mut exchange = Exchange::new(&config);
    let mut set = FactorSet::new();
    let mut live = |step: u32| {
        set.insert(exchange.state(Step(step), &Pose::level([0.0, 0.0, 50.0], 0.0), None));
        for factor in exchange.receive(Step(step), bytes).map_or(Vec::new(), |r| r.factors) {
            set.insert(factor);
        }
        let stamp = Stamp { now: SimTime(9), step: Step(step), pose: POSE };
        exchange.say(&stamp, &set, &Plan::default(), None, &mut |_| f64::NAN);
        exchange.answer(&stamp, &set, None);
    };
    [0, 1, NOW, NOW + 5, u32::MAX - 1, u32::MAX].into_iter().for_each(&mut live);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn arbitrary_bytes_do_no_harm(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        live_with(&bytes);
        let mut changed = envelope(&message());
        changed.body = bytes;
        live_with(&changed.encode());
    }

    #[test]
    fn arbitrary_changes_of_good_messages_do_no_harm(
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        cut in any::<prop::sample::Index>(),
        header in any::<(u16, u32, u32, bool)>(),
        is_cut in any::<bool>(),
    ) {
        let mut changed = envelope(&message());
        for (index, byte) in changes {
            let index = index.index(changed.body.len());
            changed.body[index] = byte;
        }
        if is_cut {
            changed.body.truncate(cut.index(changed.body.len()));
        }
        let (src, incarnation, step, is_other) = header;
        if is_other {
            changed.src = AgentId(src % 6);
            changed.incarnation = Incarnation(incarnation);
            changed.step = Step(step);
        }
        live_with(&changed.encode());
        if let Ok(message) = check(&config(1), Step(NOW), &changed) {
            for factor in &message.factors {
                prop_assert!(factor.step <= Step(NOW + 1) && factor.id.source < AgentId(4));
                prop_assert!(factor.pose.p_world.iter().all(|x| x.abs() < 1e4));
            }
        }
    }
}
