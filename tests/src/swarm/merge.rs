//! The laws of merging, on the knowledge and messages of a mission: two messages in either order, or
//! repeated, make the same knowledge.

use std::sync::Arc;

use csat_agent::estimate::Estimator;
use csat_agent::estimate::evidence::ReceivedFact;
use csat_agent::estimate::state::Knowledge;
use csat_agent::identity::Identity;
use csat_mission::engine::StepTrace;
use csat_proto::agent::FIRST_ANSWER;
use csat_proto::envelope::Envelope;
use csat_proto::ids::AgentId;
use csat_proto::message::Message;

use super::{Handicapped, Swarm};
use crate::geometry::difference_m2;

/// The difference that rounding may make, m².
const ROUNDING_M2: f64 = 1e-3;

/// In every third step, takes one agent after the other and merges the first two messages it received
/// in both orders, and one of them again. Returns how many pairs were merged.
pub fn check(engine: &Swarm, trace: &StepTrace<Handicapped>) -> Result<u64, String> {
    if !trace.step.0.is_multiple_of(3) {
        return Ok(0);
    }
    let index = trace.step.0 as usize / 3 % engine.nodes().len();
    let node = &engine.nodes()[index];
    let heard = trace.arrivals.iter().filter(|a| usize::from(a.dst.0) == index);
    let mut heard = heard.filter_map(|arrival| decode(&arrival.bytes));
    let (Some(a), Some(b)) = (heard.next(), heard.next()) else { return Ok(0) };
    // Where own frames are false, it is a matter of order which of the others they accuse first.
    if !node.is_alive() || engine.is_false(AgentId(index as u16)) {
        return Ok(0);
    }
    let estimator = Estimator::new(node.agent.inner.config());
    let with = |knowledge: &Knowledge, news: &ReceivedFact| {
        let mut knowledge = knowledge.clone();
        estimator.update(&mut knowledge, None, vec![news.clone()]);
        knowledge
    };
    let start = node.agent.inner.knowledge();
    let expected = with(&with(start, &a), &b);
    let swapped = with(&with(start, &b), &a);
    compare(&expected, &swapped).map_err(|law| format!("order matters: {law}"))?;
    let repeated = with(&expected, &a);
    compare(&expected, &repeated).map_err(|law| format!("a repeat matters: {law}"))?;
    Ok(1)
}

fn decode(bytes: &[u8]) -> Option<ReceivedFact> {
    let Envelope { src, incarnation, sequence, body, .. } = Envelope::decode(bytes).ok()?;
    let (fact, known) = match postcard::from_bytes(&body).ok()? {
        Message::Fact(fact) => (fact, None),
        Message::Snapshot(snapshot) => (snapshot.fact, Some(snapshot.known)),
        Message::Plan(_) | Message::Relay(_) => return None,
    };
    Some(ReceivedFact {
        src,
        incarnation,
        fact: Arc::new(fact),
        known: known.map(Arc::new),
        is_answer: sequence >= FIRST_ANSWER,
        identity: Identity::of(bytes),
    })
}

fn compare(a: &Knowledge, b: &Knowledge) -> Result<(), String> {
    if !a.targets.keys().eq(b.targets.keys()) {
        return Err(format!("{:?} and {:?} are known", a.targets.keys(), b.targets.keys()));
    }
    if a.oem != b.oem {
        return Err("the maps differ".into());
    }
    if a.hidden != b.hidden {
        return Err("what is hidden differs".into());
    }
    // The margin is simplified whenever it grows, so its result depends a little on the order, and so
    // do the sets from which it is subtracted.
    let allowed_m2 = ROUNDING_M2 + difference_m2(a.margin.region(), b.margin.region());
    let sets = a.targets.values().zip(b.targets.values()).chain([(&a.unexplored, &b.unexplored)]);
    for (a, b) in sets {
        let apart_m2 = difference_m2(a.region(), b.region());
        if apart_m2 > allowed_m2 {
            return Err(format!("sets are {apart_m2} m² apart"));
        }
    }
    Ok(())
}
