//! The world's Zenoh keys: what it publishes, and its inputs from agents' processes.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use csat_proto::control::{Announcement, Done, FrameHeader, Join, Order, Ready, Welcome};
use csat_proto::frame::Frame;
use csat_proto::frame_wire;
use csat_proto::ids::AgentId;
use csat_proto::keys::{Keys, split_agent};
use zenoh::bytes::Encoding;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::query::{Query, Queryable};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use crate::wire::publish::{congestion_control, put, put_json, to_json};
use crate::wire::receive::{QUEUE, bytes, enqueue, json, name};
use crate::wire::refusals::Refusals;

/// What an agent's process sends to the world.
#[derive(Debug)]
pub enum WorldInput {
    /// It asks to take part.
    Join(JoinRequest),
    /// It says which others it hears.
    Ready(AgentId, Ready),
    /// Its liveliness token appeared.
    Alive(AgentId),
    /// Its liveliness token is gone.
    Gone(AgentId),
    /// Its answer to a frame or a turn.
    Done(AgentId, Done),
    /// Its report at the end of a step, encoded.
    Report(AgentId, Vec<u8>),
}

/// A process asks to take part, and waits for the reply.
#[derive(Debug)]
pub struct JoinRequest {
    /// What it says of itself.
    pub join: Join,
    query: Query,
}

impl JoinRequest {
    /// Lets the process take part.
    pub fn welcome(self, welcome: &Welcome) {
        let reply = self.query.reply(Keys(welcome.run).join(self.join.agent), to_json(welcome));
        if let Err(error) = reply.encoding(Encoding::APPLICATION_JSON).wait() {
            tracing::warn!(%error, "cannot answer a process");
        }
    }

    /// Refuses the process.
    pub fn refuse(self, reason: &str) {
        tracing::warn!(agent = %self.join.agent, reason, "a process was refused");
        if let Err(error) = self.query.reply_err(reason).encoding(Encoding::TEXT_PLAIN).wait() {
            tracing::warn!(%error, "cannot answer a process");
        }
    }
}

/// The world's Zenoh keys.
pub struct WorldPort {
    inputs: Receiver<WorldInput>,
    refusals: Refusals,
    publishers: WorldPublishers,
    _subscribers: Vec<Subscriber<()>>,
    _join: Queryable<()>,
    _token: LivelinessToken,
}

/// The world's publishers; threads may share them.
pub struct WorldPublishers {
    world: u64,
    clock: Publisher<'static>,
    /// By agent.
    frames: Vec<Publisher<'static>>,
}

impl WorldPort {
    /// Declares the keys for a fleet of `count` agents.
    ///
    /// # Errors
    /// When Zenoh does not declare one.
    pub fn declare(session: &Session, welcome: &Welcome, count: usize) -> zenoh::Result<Self> {
        let (queue, inputs) = sync_channel(QUEUE);
        let refusals = Refusals::default();
        let keys = Keys(welcome.run);
        Ok(Self {
            _subscribers: subscribe(session, keys, &queue, &refusals)?,
            publishers: WorldPublishers::declare(session, welcome, count)?,
            _join: session.declare_queryable(keys.of("join/*")).callback(joining(&queue)).wait()?,
            _token: session.liveliness().declare_token(keys.alive_world()).wait()?,
            inputs,
            refusals,
        })
    }

    /// The next input, `None` if none comes within `limit`.
    pub fn next(&self, limit: Duration) -> Option<WorldInput> {
        self.inputs.recv_timeout(limit).ok()
    }

    /// The samples that this process refused.
    pub fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// What the world publishes with.
    pub fn publishers(&self) -> &WorldPublishers {
        &self.publishers
    }
}

impl WorldPublishers {
    fn declare(session: &Session, welcome: &Welcome, count: usize) -> zenoh::Result<Self> {
        let (keys, control) = (Keys(welcome.run), congestion_control(welcome.pace));
        let publish = |key: String| {
            session.declare_publisher(key).congestion_control(control).express(true).wait()
        };
        let frames = (0..count).map(|index| publish(keys.frame(AgentId(index as u16))));
        Ok(Self {
            world: welcome.world,
            frames: frames.collect::<zenoh::Result<_>>()?,
            clock: publish(keys.clock())?,
        })
    }

    /// Sends an order to all processes.
    pub fn order(&self, order: Order) {
        put_json(&self.clock, &Announcement { world: self.world, order });
    }

    /// The world's number, which its frames carry as well.
    pub fn world(&self) -> u64 {
        self.world
    }

    /// Sends a frame to an agent; `frame` is `None` while the agent is down.
    pub fn frame(&self, agent: AgentId, header: &FrameHeader, frame: Option<&Frame>) {
        // A detector has no image to send.
        let image = frame.filter(|frame| !frame.labels.is_empty());
        let pixels = image.map(|frame| frame_wire::encode(&frame.labels, &frame.depth));
        let publisher = &self.frames[usize::from(agent.0)];
        put(publisher.put(pixels.unwrap_or_default()).attachment(to_json(header)));
    }
}

fn subscribe(
    session: &Session,
    keys: Keys,
    queue: &SyncSender<WorldInput>,
    refusals: &Refusals,
) -> zenoh::Result<Vec<Subscriber<()>>> {
    let subscribe = |key: &str, read: Read| {
        session
            .declare_subscriber(keys.of(key))
            .callback(enqueue(queue, refusals, of_agent("uav", read)))
            .wait()
    };
    let presence: Read = |agent, sample, _| match sample.kind() {
        SampleKind::Put => Some(WorldInput::Alive(agent)),
        SampleKind::Delete => Some(WorldInput::Gone(agent)),
    };
    let alive = session
        .liveliness()
        .declare_subscriber(keys.of("alive/*"))
        .callback(enqueue(queue, refusals, of_agent("alive", presence)))
        .wait()?;
    Ok(vec![
        subscribe("uav/*/ready", |agent, s, r| Some(WorldInput::Ready(agent, json(s, r)?)))?,
        subscribe("uav/*/command", |agent, s, r| Some(WorldInput::Done(agent, json(s, r)?)))?,
        subscribe("uav/*/report", |agent, s, _| Some(WorldInput::Report(agent, bytes(s))))?,
        alive,
    ])
}

/// Reads a sample of an agent.
type Read = fn(AgentId, &Sample, &Refusals) -> Option<WorldInput>;

/// Reads the samples under an agent's key below `below`; refuses those under a pattern of keys.
fn of_agent(
    below: &'static str,
    read: Read,
) -> impl Fn(&Sample, &Refusals) -> Option<WorldInput> + Send + Sync + 'static {
    move |sample, refusals| {
        let named = name(sample).and_then(|name| split_agent(name, below));
        // The world's own token names no agent either.
        if named.is_none() && below == "uav" {
            refusals.count("key", &format!("`{}` names no agent", sample.key_expr()));
        }
        read(named?.0, sample, refusals)
    }
}

fn joining(queue: &SyncSender<WorldInput>) -> impl Fn(Query) + Send + Sync + 'static {
    let queue = queue.clone();
    move |query: Query| {
        let payload = query.payload().map(|payload| payload.to_bytes().into_owned());
        match serde_json::from_slice::<Join>(&payload.unwrap_or_default()) {
            Ok(join) => {
                let _ = queue.try_send(WorldInput::Join(JoinRequest { join, query }));
            }
            Err(error) => {
                let reason = format!("not understood: {error}; expected {{\"protocol\": …}}");
                let _ = query.reply_err(reason).wait();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::time::Step;

    /// As docs/simulator.md has it.
    #[test]
    fn an_order_carries_its_world() {
        let order = Order::Close { step: Step(7), full: false };
        let text = serde_json::to_string(&Announcement { world: 5, order }).unwrap();
        assert_eq!(text, r#"{"world":5,"order":"close","step":7,"full":false}"#);
        let back: Announcement = serde_json::from_str(&text).unwrap();
        assert_eq!(back.world, 5);
        assert!(serde_json::from_str::<Announcement>(r#"{"order":"end","reason":""}"#).is_err());
    }
}
