//! Hostile talk to agents of the Bayesian search: factors, plans, beliefs, and what others are said to hold.
//!
//! | module | what it holds |
//! |---|---|
//! | `moment` | agents in the middle of a mission |
//! | [`lie`] | false messages that decode |

pub mod lie;
mod moment;

use csat_bayes::agent::BayesAgent;
use csat_bayes::exchange::message::Message;
use csat_bayes::exchange::validate;
use csat_bayes::factor::{Factor, FactorId, ReportedPose};
use csat_bayes::search_map::Gaussian;
use csat_proto::agent::Agent;
use csat_proto::envelope::{Envelope, decode_whole};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::{SimTime, Step};
use serde::{Deserialize, Serialize};

use crate::hears::Hears;
pub use moment::Moment;

/// What somebody says in the name of an agent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Said {
    /// In whose name.
    pub src: AgentId,
    /// Its incarnation.
    pub incarnation: Incarnation,
    /// Its step.
    pub step: Step,
    /// What is said.
    pub message: Message,
}

/// The messages at the beginning of some bytes, and the bytes that are none.
pub fn split(bytes: &[u8]) -> (Vec<Said>, &[u8]) {
    let (mut said, mut rest) = (Vec::new(), bytes);
    while let Ok((one, behind)) = postcard::take_from_bytes::<Said>(rest) {
        said.push(one);
        rest = behind;
    }
    (said, rest)
}

/// The bytes of messages.
pub fn joined(said: &[Said]) -> Vec<u8> {
    said.iter().flat_map(|one| postcard::to_stdvec(one).expect("it serialises")).collect()
}

/// Messages one after the other, and a body that is none, to agents that fly on afterwards.
///
/// # Panics
/// When a property does not hold.
pub fn factors(bytes: &[u8]) {
    let (said, rest) = split(bytes);
    for moment in Moment::all() {
        let mut agent = moment.agent.clone();
        for one in &said {
            hear(moment, &mut agent, &moment.envelope(one));
        }
        if !rest.is_empty() {
            hear(moment, &mut agent, &Envelope { body: rest.to_vec(), ..moment.envelope.clone() });
        }
        fly_on(moment, &mut agent);
    }
}

fn hear(moment: &Moment, agent: &mut BayesAgent, envelope: &Envelope) {
    let before = agent.clone();
    agent.hear(moment.now, &envelope.encode());
    settle(agent, moment.now);
    check_counted(&before, agent, &envelope.body);
    check_kept(&before, agent);
    check_belief(agent);
}

fn fly_on(moment: &Moment, agent: &mut BayesAgent) {
    for (now, frame) in &moment.ahead {
        let before = agent.clone();
        agent.handle_frame(*now, frame);
        settle(agent, *now);
        let own = agent.own_factor().expect("a factor of the frame");
        assert!(is_held(agent, own), "it does not hold {own:?}, which it stated");
        check_kept(&before, agent);
        check_belief(agent);
        let answer = agent.answer(*now);
        for transmit in std::iter::from_fn(|| agent.poll_transmit()).chain(answer) {
            check_honest(moment, frame.step, &transmit.bytes);
        }
    }
}

fn settle(agent: &mut BayesAgent, now: SimTime) {
    while agent.poll_timeout().is_some_and(|due| due <= now) {
        agent.handle_timeout(now);
    }
    while agent.poll_command().is_some() || agent.poll_event().is_some() {}
}

/// Either the message is dropped, counts once and changes nothing, or each of its factors is held as it was said or
/// counts as dropped.
fn check_counted(before: &BayesAgent, agent: &BayesAgent, body: &[u8]) {
    let total = |agent: &BayesAgent| agent.rejected().values().sum::<u64>();
    let dropped = total(agent) - total(before);
    let is_unchanged = agent.digest() == before.digest();
    if dropped == 1 && is_unchanged {
        return;
    }
    let message: Message = decode_whole(body).expect("what is believed decodes");
    let not_held = message.factors.iter().filter(|factor| !is_held(agent, factor)).count();
    assert_eq!(dropped, not_held as u64, "dropped, but not counted: {:?}", agent.rejected());
}

/// Whatever is heard, factors stay as they were held: own ones as well as those of others.
fn check_kept(before: &BayesAgent, agent: &BayesAgent) {
    let changed = before.factors().iter().find(|factor| !is_held(agent, factor));
    assert!(changed.is_none(), "{changed:?} has changed");
}

/// Whether a factor is held bit for bit.
fn is_held(agent: &BayesAgent, factor: &Factor) -> bool {
    agent.factors().get(factor.id).is_some_and(|held| bits(held) == bits(factor))
}

/// A factor in numbers that can be compared: what is no number is not equal to itself.
fn bits(factor: &Factor) -> (FactorId, Step, [u32; 6], Option<[u32; 2]>) {
    let ReportedPose { p_world: [x, y, z], angles_rad: [yaw, pitch, roll] } = factor.pose;
    let pose = [x, y, z, yaw, pitch, roll].map(f32::to_bits);
    (factor.id, factor.step, pose, factor.sighting.map(|z| z.map(f32::to_bits)))
}

/// A belief is finite and its sum is 1.
fn check_belief(agent: &BayesAgent) {
    let (filter, ground) = (agent.filter(), agent.config().ground);
    let belief = filter.belief();
    belief.numbers(&mut |x| assert!(x.is_finite(), "{x} in a belief"));
    let map = belief.map();
    assert!(map.mass.iter().all(|mass| *mass >= 0.0), "negative, or no number");
    let sum: f64 = map.mass.iter().sum();
    assert!((sum - 1.0).abs() < 1e-9, "the sum of a belief is {sum}");
    let Gaussian { mean, covariance } = belief.gaussian();
    let is_inside = |axis: usize| mean[axis].abs() <= ground.size_m[axis] / 2.0;
    assert!(is_inside(0) && is_inside(1), "the mean is {mean:?}");
    assert!(covariance[0] >= 0.0 && covariance[2] >= 0.0, "{covariance:?}");
    assert!(covariance[1].is_finite(), "{covariance:?}");
    assert!(belief.highest_density(0.95).area_m2() > 0.0);
    let detection = filter.cumulative_detection();
    assert!((0.0..=1.0).contains(&detection), "P(D) is {detection}");
}

/// After any message, the messages of an agent are still accepted; otherwise a false message could silence it.
fn check_honest(moment: &Moment, now: Step, bytes: &[u8]) {
    let envelope = Envelope::decode(bytes).expect("an agent's own message");
    let verdict = validate::check(&moment.listener, now, &envelope);
    assert!(verdict.is_ok(), "what it says is not believed any more: {:?}", verdict.err());
}

/// Valid inputs, and talk that is the worst of its kind, by name.
pub fn seeds() -> Vec<(&'static str, String, Vec<u8>)> {
    let named = |(name, said): (String, Vec<Said>)| ("factors", name, joined(&said));
    let honest = Moment::all().iter().zip(0..).flat_map(|(moment, kind)| {
        let said = moment.heard.chunks(3).zip(0..);
        said.map(move |(said, i)| (format!("honest-{kind}-{i}"), said.to_vec()))
    });
    let worst = lie::worst(&Moment::all()[0].heard);
    honest.chain(worst.into_iter().map(|(name, said)| (name.to_owned(), said))).map(named).collect()
}
