//! The world's Zenoh keys: what it hears from processes and says to them.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use csat_proto::control::{Announcement, Done, FrameHeader, Join, Order, Ready, Welcome};
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
use crate::wire::refusals::Refusals;

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
    refusals: Refusals,
    voice: Voice,
    _subscribers: Vec<Subscriber<()>>,
    _join: Queryable<()>,
    _token: LivelinessToken,
}

/// What the world says to processes; threads may share it.
pub struct Voice {
    world: u64,
    clock: Publisher<'static>,
    frames: Vec<Publisher<'static>>,
}

impl Port {
    /// Declares everything for a fleet of `count` that is told `welcome`.
    ///
    /// # Errors
    /// What Zenoh says.
    pub fn declare(session: &Session, welcome: &Welcome, count: usize) -> zenoh::Result<Self> {
        let (sender, news) = sync_channel(QUEUE);
        let (keys, refusals) = (Keys(welcome.run), Refusals::default());
        let control = congestion_control(welcome.pace);
        let publish = |key: String| {
            session.declare_publisher(key).congestion_control(control).express(true).wait()
        };
        let subscribe = |key: &str, read: Read| {
            session
                .declare_subscriber(keys.of(key))
                .callback(queueing(&sender, &refusals, of_agent("uav", read)))
                .wait()
        };
        let presence: Read = |agent, sample, _| match sample.kind() {
            SampleKind::Put => Some(News::Here(agent)),
            SampleKind::Delete => Some(News::Gone(agent)),
        };
        let alive = session
            .liveliness()
            .declare_subscriber(keys.of("alive/*"))
            .callback(queueing(&sender, &refusals, of_agent("alive", presence)))
            .wait()?;
        let subscribers = vec![
            subscribe("uav/*/ready", |agent, s, r| Some(News::Ready(agent, json(s, r)?)))?,
            subscribe("uav/*/command", |agent, s, r| Some(News::Done(agent, json(s, r)?)))?,
            subscribe("uav/*/report", |agent, s, _| {
                Some(News::Account(agent, s.payload().to_bytes().into_owned()))
            })?,
            alive,
        ];
        let frames = (0..count).map(|index| publish(keys.frame(AgentId(index as u16))));
        Ok(Self {
            news,
            refusals,
            voice: Voice {
                world: welcome.world,
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

    /// What is not believed of what comes.
    pub fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// What the world says.
    pub fn voice(&self) -> &Voice {
        &self.voice
    }
}

impl Voice {
    /// Says something to all processes.
    pub fn say(&self, order: Order) {
        let announcement = Announcement { world: self.world, order };
        let text = serde_json::to_string(&announcement).expect("an order is JSON");
        put(self.clock.put(text).encoding(Encoding::APPLICATION_JSON));
    }

    /// The number that frames bear, too.
    pub fn world(&self) -> u64 {
        self.world
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

/// Reads a sample of an agent.
type Read = fn(AgentId, &Sample, &Refusals) -> Option<News>;

/// Reads what an agent says under a key below `below`; of a pattern of keys nothing is read.
fn of_agent(
    below: &'static str,
    read: Read,
) -> impl Fn(&Sample, &Refusals) -> Option<News> + Send + Sync + 'static {
    move |sample, refusals| {
        let key = sample.key_expr();
        let named = split(key.as_str()).and_then(|(_, name)| split_agent(name, below));
        // The world's own token is no agent's either.
        if named.is_none() && below == "uav" {
            refusals.count("key", &format!("`{key}` names no agent"));
        }
        read(named?.0, sample, refusals)
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

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::time::Step;

    /// As docs/simulator.md has it.
    #[test]
    fn an_order_bears_its_world() {
        let order = Order::Close { step: Step(7), full: false };
        let text = serde_json::to_string(&Announcement { world: 5, order }).unwrap();
        assert_eq!(text, r#"{"world":5,"order":"close","step":7,"full":false}"#);
        let back: Announcement = serde_json::from_str(&text).unwrap();
        assert_eq!(back.world, 5);
        assert!(serde_json::from_str::<Announcement>(r#"{"order":"end","reason":""}"#).is_err());
    }
}
