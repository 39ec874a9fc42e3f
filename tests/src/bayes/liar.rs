//! An aircraft that says two different things of one frame.

use csat_bayes::agent::BayesAgent;
use csat_bayes::config::BeliefKind;
use csat_bayes::exchange::message::Message;
use csat_proto::agent::Agent;
use csat_proto::envelope::Envelope;

use super::script::{Heard, Script, reception};

/// Whatever is said of a factor that is held, the first one stays, and so does the belief.
///
/// # Errors
/// What changed.
pub fn check() -> Result<(), String> {
    let mut script = Script::new(BeliefKind::Adaptive, 12.5);
    for _ in 0..12 {
        script.step(Heard::All);
    }
    let (_, honest) = script.said.iter().rfind(|(from, _)| *from == 1).ok_or("nobody speaks")?;
    let mut envelope = Envelope::decode(honest).map_err(|e| e.to_string())?;
    let mut message: Message = postcard::from_bytes(&envelope.body).map_err(|e| e.to_string())?;
    for factor in &mut message.factors {
        factor.pose.p_world[0] += 30.0;
        factor.sighting = Some([320.0, 240.0]);
    }
    envelope.body = postcard::to_stdvec(&message).map_err(|e| e.to_string())?;
    let (now, lie) = (script.now(), envelope.encode());
    let [hearer, liar] = &mut script.agents[..] else { return Err("two aircraft fly".into()) };
    let before = bits(hearer);
    hearer.handle_message(now, &reception(now, &lie));
    while hearer.poll_timeout().is_some_and(|due| due <= now) {
        hearer.handle_timeout(now);
    }
    for factor in &message.factors {
        let (held, stated) = (hearer.factors().get(factor.id), liar.factors().get(factor.id));
        if held != stated {
            return Err(format!("{held:?} is held, {stated:?} was stated"));
        }
    }
    let conflicts = hearer.rejected().get("conflict").copied().unwrap_or_default();
    if conflicts == 0 || conflicts != message.factors.len() as u64 {
        return Err(format!("{conflicts} conflicts in {} factors", message.factors.len()));
    }
    if bits(hearer) == before { Ok(()) } else { Err("a lie changed the belief".into()) }
}

/// All numbers of a belief.
fn bits(agent: &BayesAgent) -> Vec<u64> {
    let mut bits = Vec::new();
    agent.filter().belief().numbers(&mut |x| bits.push(x.to_bits()));
    bits
}
