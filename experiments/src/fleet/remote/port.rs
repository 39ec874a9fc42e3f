//! The world's Zenoh keys: what it hears from processes and says to them.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use csat_proto::control::{Done, FrameHeader, Join, Order, Pace, Ready, Welcome};
use csat_proto::frame::Frame;
use csat_proto::frame_wire;
use csat_proto::ids::AgentId;
use csat_proto::keys::{Keys, split, split_agent};
use zenoh::bytes::Encoding;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::query::{Query, Queryable};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use crate::wire::hearing::{json, queueing};
use crate::wire::pace::congestion_control;

/// How much may wait to be read: a few rounds of a fleet of hundreds.
const QUEUE: usize = 16_384;

/// What processes say to the world.
#[derive(Debug)]
pub enum News {
    /// A process wants to take part.
    Join(JoinQuery),
    /// It hears others.
    Ready(AgentId, Ready),
    /// It holds its token.
    Here(AgentId),
    /// It is gone.
    Gone(AgentId),
    /// It is done with a frame or a turn.
    Done(AgentId, Done),
    /// What it tells at the end of a step, encoded.
    Account(AgentId, Vec<u8>),
}

/// A process wants to take part, and waits for the answer.
#[derive(Debug)]
pub struct JoinQuery {
    /// What it says.
    pub join: Join,
    query: Query,
}

impl JoinQuery {
    /// It may.
    pub fn welcome(self, welcome: &Welcome) {
        let text = serde_json::to_string(welcome).expect("a welcome is JSON");
        let reply = self.query.reply(Keys(welcome.run).join(self.join.agent), text);
        if let Err(error) = reply.encoding(Encoding::APPLICATION_JSON).wait() {
            tracing::warn!(%error, "cannot answer a process");
        }
    }

    /// It may not.
    pub fn refuse(self, reason: &str) {
        tracing::warn!(agent = %self.join.agent, reason, "a process was refused");
        if let Err(error) = self.query.reply_err(reason).encoding(Encoding::TEXT_PLAIN).wait() {
            tracing::warn!(%error, "cannot answer a process");
        }
    }
}

/// The world's side of the wire.
pub struct Port {
    news: Receiver<News>,
    voice: Voice,
    _subscribers: Vec<Subscriber<()>>,
    _join: Queryable<()>,
    _token: LivelinessToken,
}

/// What the world says to processes; threads may share it.
pub struct Voice {
    clock: Publisher<'static>,
    frames: Vec<Publisher<'static>>,
}

impl Port {
    /// Declares everything for a fleet of `count` that flies at this pace.
    ///
    /// # Errors
    /// What Zenoh says.
    pub fn declare(session: &Session, keys: Keys, count: usize, pace: Pace) -> zenoh::Result<Self> {
        let (sender, news) = sync_channel(QUEUE);
        let control = congestion_control(pace);
        let publish = |key: String| {
            session.declare_publisher(key).congestion_control(control).express(true).wait()
        };
        let subscribe = |key: &str, read: fn(AgentId, &Sample) -> Option<News>| {
            session
                .declare_subscriber(keys.of(key))
                .callback(queueing(&sender, of_agent("uav", read)))
                .wait()
        };
        let presence = |agent, sample: &Sample| match sample.kind() {
            SampleKind::Put => Some(News::Here(agent)),
            SampleKind::Delete => Some(News::Gone(agent)),
        };
        let alive = session
            .liveliness()
            .declare_subscriber(keys.of("alive/*"))
            .callback(queueing(&sender, of_agent("alive", presence)))
            .wait()?;
        let subscribers = vec![
            subscribe("uav/*/ready", |agent, s| Some(News::Ready(agent, json(s)?)))?,
            subscribe("uav/*/command", |agent, s| Some(News::Done(agent, json(s)?)))?,
            subscribe("uav/*/report", |agent, s| {
                Some(News::Account(agent, s.payload().to_bytes().into_owned()))
            })?,
            alive,
        ];
        let frames = (0..count).map(|index| publish(keys.frame(AgentId(index as u16))));
        Ok(Self {
            news,
            voice: Voice {
                clock: publish(keys.clock())?,
                frames: frames.collect::<zenoh::Result<_>>()?,
            },
            _subscribers: subscribers,
            _join: session
                .declare_queryable(keys.of("join/*"))
                .callback(joining(&sender))
                .wait()?,
            _token: session.liveliness().declare_token(keys.alive_world()).wait()?,
        })
    }

    /// What comes next within `limit`.
    pub fn next(&self, limit: Duration) -> Option<News> {
        self.news.recv_timeout(limit).ok()
    }

    /// What the world says.
    pub fn voice(&self) -> &Voice {
        &self.voice
    }
}

impl Voice {
    /// Says something to all processes.
    pub fn say(&self, order: &Order) {
        let text = serde_json::to_string(order).expect("an order is JSON");
        put(self.clock.put(text).encoding(Encoding::APPLICATION_JSON));
    }

    /// Sends a frame to an agent; `frame` is `None` while it is down.
    pub fn frame(&self, agent: AgentId, header: &FrameHeader, frame: Option<&Frame>) {
        let header = serde_json::to_string(header).expect("a header is JSON");
        let pixels = frame.map(|frame| frame_wire::encode(&frame.labels, &frame.depth));
        let publisher = &self.frames[usize::from(agent.0)];
        put(publisher.put(pixels.unwrap_or_default()).attachment(header));
    }
}

fn put(put: zenoh::pubsub::PublisherPutBuilder<'_>) {
    if let Err(error) = put.wait() {
        tracing::error!(%error, "cannot publish");
    }
}

/// Reads what an agent says under a key below `below`.
fn of_agent(
    below: &'static str,
    read: fn(AgentId, &Sample) -> Option<News>,
) -> impl Fn(&Sample) -> Option<News> + Send + Sync + 'static {
    move |sample| {
        let (_, name) = split(sample.key_expr().as_str())?;
        let (agent, _) = split_agent(name, below)?;
        read(agent, sample)
    }
}

fn joining(sender: &SyncSender<News>) -> impl Fn(Query) + Send + Sync + 'static {
    let sender = sender.clone();
    move |query: Query| {
        let payload = query.payload().map(|payload| payload.to_bytes().into_owned());
        match serde_json::from_slice::<Join>(&payload.unwrap_or_default()) {
            Ok(join) => {
                let _ = sender.try_send(News::Join(JoinQuery { join, query }));
            }
            Err(error) => {
                let reason = format!("not understood: {error}; expected {{\"protocol\": …}}");
                let _ = query.reply_err(reason).wait();
            }
        }
    }
}
