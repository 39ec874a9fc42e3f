//! The checks of the fuzzers on arbitrary bytes: `fuzz/` finds inputs, `tests/fuzz.rs` replays those
//! it kept.
//!
//! | function | the bytes are | must hold |
//! |---|---|---|
//! | [`envelope`] | a message, or what follows its checksum | decoding inverts encoding; no panic |
//! | [`fact`] | the body of a fact | believed or not, the agent works on, and others accept its messages |
//! | [`snapshot`] | the body of a snapshot | the same |
//! | [`factors()`] | messages of the Bayesian search, one after the other | each is dropped, or what of it is not held is counted; own factors stay, beliefs are finite |
//! | [`clearing()`] | the body of a message of the road clearing | believed or not, the agents work on, and others accept their messages |
//! | [`mod@scenario`] | a scenario file | it is loaded, or every mistake is reported |
//! | [`wire::frame`] | a frame's header and pixels | no panic; accepted input is the same after encoding and decoding |
//! | [`wire::control`] | JSON or a report between world and agents | the same |
//! | [`wire::queue`] | messages and orders in any sequence | each message is delivered once, and only when announced |

pub mod clearing;
pub mod factors;
mod moment;
pub mod spoil;
pub mod wire;

use crate::hears::Hears;
use csat_agent::agent::SetMembershipAgent;
use csat_agent::exchange::validate;
use csat_experiments::scenario::{self, Request};
use csat_proto::agent::Agent;
use csat_proto::envelope::Envelope;
use csat_proto::message::{Fact, Message, Snapshot};
use csat_proto::region::{metres, to_units};
use csat_proto::time::Step;

pub use clearing::clearing;
pub use factors::factors;
pub use moment::Moment;

/// Panics when a property does not hold.
pub type Check = fn(&[u8]);

/// The targets, as folders of `fuzz/corpus` and as functions.
pub const TARGETS: [(&str, Check); 9] = [
    ("envelope", envelope),
    ("fact", fact),
    ("snapshot", snapshot),
    ("factors", factors),
    ("clearing", clearing),
    ("scenario", scenario),
    ("frame", wire::frame),
    ("control", wire::control),
    ("queue", wire::queue),
];

/// Magic and version, before the checksum.
const MAGIC_BYTES: usize = 5;

/// A received message, once as it is and once with corrected first bytes and checksum.
///
/// # Panics
/// When a property does not hold.
pub fn envelope(bytes: &[u8]) {
    let moment = Moment::shared();
    let magic = &moment.envelope.encode()[..MAGIC_BYTES];
    let sealed = [magic, &crc32fast::hash(bytes).to_le_bytes(), bytes].concat();
    for bytes in [bytes, &sealed] {
        if let Ok(envelope) = Envelope::decode(bytes) {
            let again = Envelope::decode(&envelope.encode());
            assert_eq!(again.as_ref(), Ok(&envelope), "decoding does not invert encoding");
        }
        tell(moment, bytes);
    }
}

/// The body of a fact.
///
/// # Panics
/// When a property does not hold.
pub fn fact(bytes: &[u8]) {
    let step = postcard::from_bytes(bytes).ok().map(|fact: Fact| fact.step);
    say(0, step, bytes);
}

/// The body of a snapshot.
///
/// # Panics
/// When a property does not hold.
pub fn snapshot(bytes: &[u8]) {
    let step = postcard::from_bytes(bytes).ok().map(|snapshot: Snapshot| snapshot.fact.step);
    say(1, step, bytes);
}

/// Sends a body of a kind of [`Message`] in a valid envelope of the same step.
fn say(kind: u8, step: Option<Step>, bytes: &[u8]) {
    let moment = Moment::shared();
    let body = [&[kind], bytes].concat();
    let step = step.unwrap_or(moment.envelope.step);
    tell(moment, &Envelope { step, body, ..moment.envelope.clone() }.encode());
}

/// An agent in the middle of a mission receives a message and flies on.
fn tell(moment: &Moment, bytes: &[u8]) {
    let mut agent = moment.agent.clone();
    agent.hear(moment.now, bytes);
    let is_rejected = !agent.rejected().is_empty();
    agent.handle_timeout(moment.now);
    if is_rejected {
        assert_eq!(agent.digest(), moment.undisturbed, "rejected, but something changed");
        return;
    }
    check_sets(&agent);
    if agent.digest() == moment.undisturbed {
        return;
    }
    while agent.poll_transmit().is_some() {}
    for (now, frame) in &moment.ahead {
        agent.handle_frame(*now, frame);
        agent.handle_timeout(*now);
        check_sets(&agent);
        while let Some(transmit) = agent.poll_transmit() {
            check_honest(moment, frame.step, &transmit.bytes);
        }
    }
}

/// Sets stay inside the region whatever message was believed.
fn check_sets(agent: &SetMembershipAgent) {
    let limit = agent.config().ground.size_m.map(|size| to_units(size / 2.0).unsigned_abs());
    let knowledge = agent.knowledge();
    for set in knowledge.targets.values().chain([&knowledge.unexplored]) {
        let outside = |p: &&_| {
            let p: csat_proto::region::GridPoint = **p;
            p.x.unsigned_abs() > limit[0] || p.y.unsigned_abs() > limit[1]
        };
        let found = set.region().rings().flatten().find(outside);
        assert!(found.is_none(), "a set leaves the region at {:?}", found.map(|&p| metres(p)));
    }
}

/// After any message, the messages of an agent are still accepted; otherwise a false message could
/// silence it.
fn check_honest(moment: &Moment, now: Step, bytes: &[u8]) {
    let envelope = Envelope::decode(bytes).expect("an agent's own message");
    let verdict = validate::check(moment.listener.config(), now, &envelope);
    assert!(verdict.is_ok(), "what it says is not believed any more: {:?}", verdict.err());
}

/// A scenario file. The world is not made: that takes as long as the world is large.
///
/// # Panics
/// When a property does not hold.
pub fn scenario(bytes: &[u8]) {
    // Files that it names would be read: endless ones are left out.
    if ["/dev", "/proc", "/sys"].iter().any(|p| bytes.windows(p.len()).any(|w| w == p.as_bytes())) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fuzz.toml");
    std::fs::write(&path, bytes).expect("a file");
    // Without its map a scenario is checked and no world is made.
    let sets = ["map.file=there-is-none.geojson".to_owned()];
    let request = Request { scenario: path.to_str(), sets: &sets, seed: None };
    let mistakes = scenario::load(request).expect_err("there is no map");
    assert!(mistakes.to_string().contains("there-is-none.geojson"), "{mistakes}");
}

/// Valid inputs of every target, by file name, from which fuzzers start.
pub fn seeds() -> Vec<(&'static str, String, Vec<u8>)> {
    let moment = Moment::shared();
    let mut seeds = Vec::new();
    for (i, envelope) in moment.heard.iter().enumerate() {
        let content = envelope.encode().split_off(MAGIC_BYTES + 4);
        seeds.push(("envelope", format!("honest-{i}"), content));
        let message: Message = postcard::from_bytes(&envelope.body).expect("an honest body");
        let mut keep = |target, body: Option<Vec<u8>>| {
            seeds.push((target, format!("honest-{i}"), body.expect("it serialises")));
        };
        match message {
            Message::Fact(fact) => keep("fact", postcard::to_stdvec(&fact).ok()),
            Message::Snapshot(snapshot) => {
                keep("fact", postcard::to_stdvec(&snapshot.fact).ok());
                keep("snapshot", postcard::to_stdvec(&snapshot).ok());
            }
            Message::Plan(_) | Message::Relay(_) => {}
        }
    }
    for shipped in scenario::shipped::SCENARIOS {
        let text = shipped.text.as_bytes().to_vec();
        seeds.push(("scenario", format!("{}.toml", shipped.name), text));
    }
    seeds.push(("scenario", "default.toml".into(), default_scenario().into_bytes()));
    seeds.extend(factors::seeds());
    seeds.extend(clearing::seeds());
    seeds.extend(wire::seeds());
    seeds
}

fn default_scenario() -> String {
    scenario::Scenario::default().to_toml()
}
