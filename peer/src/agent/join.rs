//! How an agent's process learns its mission: it asks for a world.

use std::time::Duration;

use csat_proto::control::{Join, PROTOCOL, Welcome};
use csat_proto::ids::{AgentId, RunId};
use csat_proto::keys::{self, Keys};
use zenoh::query::Reply;
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use super::AgentError;
use super::error::WelcomeError;
use super::input::{AgentInput, Inlet, Timer};
use crate::arguments::AgentArguments;
use crate::wire::notice::WaitNotice;
use crate::wire::publish::to_json;
use crate::wire::session::{self, Role};
use csat_mission::timing::Stopwatch;

/// How long a world may take to answer a query.
const ANSWER_LIMIT: Duration = Duration::from_secs(2);
/// How often the process asks.
const ASK_PERIOD: Duration = Duration::from_millis(200);

/// Asks until a world answers. `why_no_world` explains that none does.
///
/// # Errors
/// When no world answers in time, the world refuses the process, or the process is to end.
pub fn join(
    session: &Session,
    arguments: &AgentArguments,
    process: u64,
    inlet: &Inlet,
    why_no_world: impl Fn(&Session) -> String,
) -> Result<Welcome, AgentError> {
    let agent = AgentId(arguments.id);
    let program = concat!("csat ", env!("CARGO_PKG_VERSION")).to_owned();
    let payload = to_json(&Join { protocol: PROTOCOL, program, agent, process });
    let key = match arguments.run {
        Some(run) => Keys(RunId(run)).join(agent),
        None => format!("csat/*/join/{agent}"),
    };
    let watch = Stopwatch::start();
    let mut notice = WaitNotice::start();
    loop {
        let replies = session.get(&key).payload(&payload).timeout(ANSWER_LIMIT).wait();
        let replies = replies.map_err(AgentError::zenoh("ask for a world"))?;
        if let Ok(reply) = replies.recv() {
            return read_reply(reply, agent);
        }
        if watch.left(arguments.patience).is_zero() {
            let limit_s = arguments.patience.as_secs();
            return Err(AgentError::NoWorld { key, cause: why_no_world(session), limit_s });
        }
        // The parent of a spawned agent says itself what the agent waits for.
        if !arguments.end_with_parent {
            notice.tell(|| {
                let connect = session::shown_endpoints(&arguments.wire, Role::Agent(arguments.id));
                format!(
                    "a world to answer on `{key}` at {connect}; `csat doctor` tells who is there"
                )
            });
        }
        wait(inlet)?;
    }
}

/// Waits until it is time to ask again. There is no port yet, so that nothing but the end can come.
fn wait(inlet: &Inlet) -> Result<(), AgentError> {
    match inlet.next(Some((Timer::Join, ASK_PERIOD))) {
        AgentInput::End(by) => Err(AgentError::Ended(by)),
        _ => Ok(()),
    }
}

fn read_reply(reply: Reply, agent: AgentId) -> Result<Welcome, AgentError> {
    match reply.into_result() {
        Ok(sample) => Ok(read_welcome(&sample)?),
        Err(error) => {
            let reason = String::from_utf8_lossy(&error.payload().to_bytes()).into_owned();
            Err(AgentError::Refused { agent, reason })
        }
    }
}

fn read_welcome(sample: &Sample) -> Result<Welcome, WelcomeError> {
    let welcome: Welcome = serde_json::from_slice(&sample.payload().to_bytes())?;
    let (run, key) = (welcome.run, sample.key_expr().to_string());
    match keys::split(&key) {
        Some((named, _)) if named == run => {}
        _ => return Err(WelcomeError::Run { run, key }),
    }
    if welcome.protocol != PROTOCOL {
        return Err(WelcomeError::Protocol(welcome.protocol));
    }
    Ok(welcome)
}
