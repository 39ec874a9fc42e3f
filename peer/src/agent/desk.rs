//! An agent's Zenoh keys: what its process hears, says and shows.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use csat_proto::control::{Announcement, Done, FrameHeader, Order, Probe, Ready, Welcome};
use csat_proto::ids::{AgentId, ChannelId};
use csat_proto::keys::{Keys, split, split_agent};
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::Step;
use zenoh::bytes::Encoding;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::query::{Query, Queryable, Reply};
use zenoh::sample::{Locality, Sample, SampleKind};
use zenoh::{Session, Wait};

use super::EndedBy;
use super::gate::Gate;
use crate::wire::hearing::{json, parse, queueing};
use crate::wire::pace::congestion_control;
use crate::wire::refusals::Refusals;
use csat_mission::node::Said;

/// How long others may take to answer what they know.
const ANSWER_LIMIT: Duration = Duration::from_secs(5);

/// How much may wait to be read: some steps of a fleet of hundreds.
const QUEUE: usize = 16_384;

/// What an agent's process hears.
#[derive(Debug)]
pub enum News {
    /// A frame: header and pixels.
    Frame(Box<FrameHeader>, Vec<u8>),
    /// What the world says to all.
    Order(Order),
    /// A message of another agent, still encoded, and where it was sent.
    Link(AgentId, Option<PhysicalHeader>, Vec<u8>),
    /// A sign of life of another agent's process.
    Probe(AgentId, Probe),
    /// Another agent's process is gone.
    Gone(AgentId),
    /// The world is there.
    WorldHere,
    /// The world is gone.
    WorldGone,
    /// Somebody wants to know what the agent knows.
    Asked(Query),
    /// Somebody wants to see documents of the agent.
    Looked(Query),
    /// What another agent knows, because this process asked: a message, still encoded, and where it was sent.
    Answer(AgentId, Option<PhysicalHeader>, Vec<u8>),
    /// This process is to end.
    End(EndedBy),
}

/// What has come and is not read yet, of which there is never too much: it drops what does not fit.
/// It is there before the desk, for whoever wants the process to end.
pub struct Inbox {
    sender: SyncSender<News>,
    news: Receiver<News>,
}

impl Default for Inbox {
    fn default() -> Self {
        let (sender, news) = sync_channel(QUEUE);
        Self { sender, news }
    }
}

impl Inbox {
    /// What comes next within `limit`.
    pub fn next(&self, limit: Duration) -> Option<News> {
        self.news.recv_timeout(limit).ok()
    }

    /// Where others may leave news.
    pub fn sender(&self) -> SyncSender<News> {
        self.sender.clone()
    }
}

/// Queues what others say under a key.
fn subscribe(
    session: &Session,
    key: String,
    (sender, refusals): (&SyncSender<News>, &Refusals),
    read: impl Fn(&Sample, &Refusals) -> Option<News> + Send + Sync + 'static,
) -> zenoh::Result<Subscriber<()>> {
    session
        .declare_subscriber(key)
        .allowed_origin(Locality::Remote)
        .callback(queueing(sender, refusals, read))
        .wait()
}

/// Reads what comes under a key, and nothing of a pattern of keys: access control by key would not see it.
fn exactly(
    key: String,
    read: impl Fn(&Sample, &Refusals) -> Option<News> + Send + Sync + 'static,
) -> impl Fn(&Sample, &Refusals) -> Option<News> + Send + Sync + 'static {
    move |sample, refusals| {
        if sample.key_expr().as_str() == key {
            return read(sample, refusals);
        }
        refusals.count("key", &format!("`{}`, expected `{key}`", sample.key_expr()));
        None
    }
}

/// An agent's side of the wire.
pub struct Desk {
    inbox: Inbox,
    /// What frames come through, read or not.
    gate: Arc<Mutex<Gate>>,
    refusals: Refusals,
    probe: Publisher<'static>,
    links: Vec<Publisher<'static>>,
    ready: Publisher<'static>,
    command: Publisher<'static>,
    report: Publisher<'static>,
    session: Session,
    keys: Keys,
    _subscribers: Vec<Subscriber<()>>,
    _queryables: [Queryable<()>; 3],
    _token: LivelinessToken,
}

impl Desk {
    /// Declares everything for UAV `id` with `channels` radios, in the run that `welcome` tells of.
    ///
    /// # Errors
    /// What Zenoh says.
    pub fn declare(
        session: &Session,
        welcome: &Welcome,
        period_s: f64,
        id: AgentId,
        channels: usize,
        inbox: Inbox,
    ) -> zenoh::Result<Self> {
        let (sender, keys, refusals) = (inbox.sender(), Keys(welcome.run), Refusals::default());
        let control = congestion_control(welcome.pace);
        let publish = |key: String| {
            session
                .declare_publisher(key)
                .congestion_control(control)
                .allowed_destination(Locality::Remote)
                .express(true)
                .wait()
        };
        let gate = Arc::new(Mutex::new(Gate::new(welcome, period_s)));
        let alive = session
            .liveliness()
            .declare_subscriber(keys.of("alive/*"))
            .history(true)
            .callback(queueing(&sender, &refusals, presence))
            .wait()?;
        let subscribers = vec![
            subscribe(session, keys.links(), (&sender, &refusals), link)?,
            subscribe(session, keys.frame(id), (&sender, &refusals), {
                exactly(keys.frame(id), frame(gate.clone()))
            })?,
            subscribe(session, keys.clock(), (&sender, &refusals), {
                exactly(keys.clock(), order(gate.clone()))
            })?,
            alive,
        ];
        let queryable = |key: String, news: fn(Query) -> News| {
            session.declare_queryable(key).callback(asking(&sender, news)).wait()
        };
        let links = (0..channels).map(|c| publish(keys.link(id, ChannelId(c as u8))));
        Ok(Self {
            links: links.collect::<zenoh::Result<_>>()?,
            probe: publish(keys.probe(id))?,
            ready: publish(keys.ready(id))?,
            command: publish(keys.command(id))?,
            report: publish(keys.report(id))?,
            _subscribers: subscribers,
            _queryables: [
                queryable(keys.state(id, "snapshot"), News::Asked)?,
                queryable(keys.state(id, "oem"), News::Looked)?,
                queryable(keys.view(id, "*"), News::Looked)?,
            ],
            session: session.clone(),
            keys,
            _token: session.liveliness().declare_token(keys.alive(id)).wait()?,
            inbox,
            gate,
            refusals,
        })
    }

    /// What comes next within `limit`.
    pub fn next(&self, limit: Duration) -> Option<News> {
        self.inbox.next(limit)
    }

    /// The step of the newest frame that has come, read or not.
    pub fn newest_frame(&self) -> Option<Step> {
        lock(&self.gate).newest()
    }

    /// What is not believed of what comes.
    pub fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// Says a message to all agents.
    pub fn say(&self, said: &Said) {
        match self.links.get(usize::from(said.channel.0)) {
            Some(publisher) => {
                put(publisher.put(said.bytes.to_vec()).attachment(text(&said.physical())));
            }
            None => tracing::error!(channel = %said.channel, "there is no such radio"),
        }
    }

    /// Gives a sign of life to all agents.
    pub fn probe(&self, probe: &Probe) {
        put(self.probe.put(text(probe)).encoding(Encoding::APPLICATION_JSON));
    }

    /// Tells the world whom this process hears.
    pub fn ready(&self, ready: &Ready) {
        put(self.ready.put(text(ready)).encoding(Encoding::APPLICATION_JSON));
    }

    /// Tells the world that a frame or a turn is done.
    pub fn done(&self, done: &Done) {
        put(self.command.put(text(done)).encoding(Encoding::APPLICATION_JSON));
    }

    /// Asks all agents what they know; the answers are news.
    pub fn ask_all(&self) {
        let sender = self.inbox.sender();
        let answer = move |reply: Reply| {
            let Ok(sample) = reply.into_result() else { return };
            let named = name(&sample).and_then(|name| split_agent(name, "state"));
            if let Some((agent, _)) = named {
                let bytes = sample.payload().to_bytes().into_owned();
                let _ = sender.try_send(News::Answer(agent, physical(&sample), bytes));
            }
        };
        let get = self.session.get(self.keys.of("state/*/snapshot"));
        let get = get.allowed_destination(Locality::Remote).timeout(ANSWER_LIMIT);
        if let Err(error) = get.callback(answer).wait() {
            tracing::warn!(%error, "cannot ask the others what they know");
        }
    }

    /// Tells the world what the step came to.
    pub fn report(&self, account: Vec<u8>) {
        put(self.report.put(account));
    }
}

pub(super) fn text(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).expect("what processes say is JSON")
}

fn put(put: zenoh::pubsub::PublisherPutBuilder<'_>) {
    if let Err(error) = put.wait() {
        tracing::error!(%error, "cannot publish");
    }
}

fn asking(
    sender: &SyncSender<News>,
    news: fn(Query) -> News,
) -> impl Fn(Query) + Send + Sync + 'static {
    let sender = sender.clone();
    move |query: Query| {
        if sender.try_send(news(query)).is_err() {
            tracing::error!("too much to hear: a query is not answered");
        }
    }
}

fn name(sample: &Sample) -> Option<&str> {
    split(sample.key_expr().as_str()).map(|(_, name)| name)
}

fn lock(gate: &Mutex<Gate>) -> std::sync::MutexGuard<'_, Gate> {
    gate.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where a message was sent; `None` if nothing says so.
fn physical(sample: &Sample) -> Option<PhysicalHeader> {
    place(&sample.attachment()?.to_bytes())
}

fn place(header: &[u8]) -> Option<PhysicalHeader> {
    serde_json::from_slice(header).ok().filter(PhysicalHeader::is_place)
}

fn link(sample: &Sample, refusals: &Refusals) -> Option<News> {
    let Some((src, what)) = name(sample).and_then(|name| split_agent(name, "link")) else {
        refusals.count("key", &format!("`{}` names no agent", sample.key_expr()));
        return None;
    };
    match what {
        "probe" => Some(News::Probe(src, json(sample, refusals)?)),
        _ => Some(News::Link(src, physical(sample), sample.payload().to_bytes().into_owned())),
    }
}

/// Reads frames that the gate lets in.
fn frame(gate: Arc<Mutex<Gate>>) -> impl Fn(&Sample, &Refusals) -> Option<News> + Send + Sync {
    move |sample, refusals| {
        let header = sample.attachment()?.to_bytes().into_owned();
        let header: FrameHeader = parse(sample, &header, refusals)?;
        if let Err(error) = lock(&gate).admit(header.world, header.step) {
            refusals.count("frame", &error);
            return None;
        }
        let pixels = sample.payload().to_bytes().into_owned();
        Some(News::Frame(Box::new(header), pixels))
    }
}

/// Reads orders of this world.
fn order(gate: Arc<Mutex<Gate>>) -> impl Fn(&Sample, &Refusals) -> Option<News> + Send + Sync {
    move |sample, refusals| {
        let Announcement { world, order } = json(sample, refusals)?;
        if let Err(error) = lock(&gate).check_world(world) {
            refusals.count("order", &error);
            return None;
        }
        Some(News::Order(order))
    }
}

fn presence(sample: &Sample, _: &Refusals) -> Option<News> {
    match (name(sample)?, sample.kind()) {
        ("alive/world", SampleKind::Put) => Some(News::WorldHere),
        ("alive/world", SampleKind::Delete) => Some(News::WorldGone),
        (_, SampleKind::Put) => None,
        (name, SampleKind::Delete) => {
            split_agent(name, "alive").map(|(agent, _)| News::Gone(agent))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_survives_to_the_last_bit_and_anything_else_is_none() {
        let header = PhysicalHeader { p_world: [0.1 + 0.2, -1e-300, 52.000_000_000_000_01] };
        assert_eq!(place(text(&header).as_bytes()), Some(header));
        for text in ["", "{}", "{\"p_world\": [1, 2]}", "{\"p_world\": [1, 2, 1e999]}", "7"] {
            assert_eq!(place(text.as_bytes()), None, "{text}");
        }
    }
}
