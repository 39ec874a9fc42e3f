//! How an agent's process gets to know its mission: it asks the world.

use std::time::Duration;

use csat_proto::control::{Join, PROTOCOL, Welcome};
use csat_proto::ids::{AgentId, RunId};
use csat_proto::keys::{self, Keys};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use super::desk::{Inbox, News};
use super::{AgentError, zenoh_error};
use crate::arguments::AgentArguments;
use crate::wire::session::{self, Role};
use crate::wire::waiting::Waiting;
use csat_mission::timing::Stopwatch;

/// How long a world may take to answer a query.
const ANSWER_LIMIT: Duration = Duration::from_secs(2);
/// How often the world is asked again.
const ASK_PERIOD: Duration = Duration::from_millis(200);

/// Asks until a world answers, or somebody wants this process to end.
///
/// # Errors
/// When none does in time, or one refuses.
pub fn join(
    session: &Session,
    arguments: &AgentArguments,
    process: u64,
    inbox: &Inbox,
    why_nobody: impl Fn(&Session) -> String,
) -> Result<Welcome, AgentError> {
    let agent = AgentId(arguments.id);
    let program = concat!("csat ", env!("CARGO_PKG_VERSION")).to_owned();
    let join = Join { protocol: PROTOCOL, program, agent, process };
    let payload = serde_json::to_string(&join).expect("a query is JSON");
    let key = match arguments.run {
        Some(run) => Keys(RunId(run)).join(agent),
        None => format!("csat/*/join/{agent}"),
    };
    let watch = Stopwatch::start();
    let mut waiting = Waiting::start();
    loop {
        let replies = session.get(&key).payload(&payload).timeout(ANSWER_LIMIT).wait();
        if let Ok(reply) = replies.map_err(zenoh_error)?.recv() {
            return match reply.into_result() {
                Ok(sample) => welcome(&sample),
                Err(error) => Err(AgentError::Refused {
                    agent,
                    reason: String::from_utf8_lossy(&error.payload().to_bytes()).into_owned(),
                }),
            };
        }
        if watch.left(arguments.patience).is_zero() {
            let limit_s = arguments.patience.as_secs();
            let cause = why_nobody(session);
            return Err(AgentError::NoWorld { key, cause, limit_s });
        }
        // What a spawned agent waits for, its spawner sees.
        if !arguments.leashed {
            waiting.tell(|| {
                let connect = session::shown_endpoints(&arguments.wire, Role::Agent(arguments.id));
                format!(
                    "a world to answer on `{key}` at {connect}; `csat doctor` tells who is there"
                )
            });
        }
        // Nothing else comes before there is a desk.
        if let Some(News::End(who)) = inbox.next(ASK_PERIOD) {
            return Err(AgentError::Ended(who));
        }
    }
}

fn welcome(sample: &Sample) -> Result<Welcome, AgentError> {
    let welcome: Welcome = serde_json::from_slice(&sample.payload().to_bytes())
        .map_err(|error| AgentError::Version(error.to_string()))?;
    let key = sample.key_expr();
    match keys::split(key.as_str()) {
        Some((run, _)) if run == welcome.run => Ok(welcome),
        _ => Err(AgentError::Version(format!("of run {} under `{key}`", welcome.run))),
    }
}
