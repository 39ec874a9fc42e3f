//! An agent's Zenoh keys: what its process publishes, and its inputs from Zenoh.

use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use csat_proto::control::{Announcement, Done, FrameHeader, Probe, Ready, Welcome};
use csat_proto::ids::{AgentId, ChannelId};
use csat_proto::keys::{Keys, split_agent};
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::Step;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::query::{Query, Queryable, Reply};
use zenoh::sample::{Locality, Sample, SampleKind};
use zenoh::{Session, Wait};

use super::frame_gate::FrameGate;
use super::input::{AgentInput, Inlet, RawFrame, RawMessage, Timer};
use crate::wire::publish::{congestion_control, put, put_json, to_json};
use crate::wire::receive::{bytes, enqueue, json, name, parse};
use crate::wire::refusals::Refusals;
use csat_mission::node::Said;

/// How long other agents may take to send their snapshots.
const ANSWER_LIMIT: Duration = Duration::from_secs(5);

/// An agent's Zenoh keys.
pub struct AgentPort {
    inlet: Inlet,
    gate: SharedGate,
    refusals: Refusals,
    publishers: AgentPublishers,
    session: Session,
    keys: Keys,
    _subscribers: Vec<Subscriber<()>>,
    _queryables: [Queryable<()>; 3],
    _token: LivelinessToken,
}

struct AgentPublishers {
    probe: Publisher<'static>,
    /// By radio.
    messages: Vec<Publisher<'static>>,
    ready: Publisher<'static>,
    command: Publisher<'static>,
    report: Publisher<'static>,
}

impl AgentPort {
    /// Declares the keys of agent `id` with `channels` radios in the run of `welcome`.
    ///
    /// # Errors
    /// When Zenoh does not declare one.
    pub fn declare(
        session: &Session,
        welcome: &Welcome,
        period_s: f64,
        id: AgentId,
        channels: usize,
        inlet: Inlet,
    ) -> zenoh::Result<Self> {
        let (keys, refusals) = (Keys(welcome.run), Refusals::default());
        let gate = Arc::new(Mutex::new(FrameGate::new(welcome, period_s)));
        let subscribers = subscribe(session, keys, id, (&inlet.sender(), &refusals), &gate)?;
        let queryable = |key: String, input: fn(Query) -> AgentInput| {
            session.declare_queryable(key).callback(enqueue_query(&inlet.sender(), input)).wait()
        };
        Ok(Self {
            publishers: AgentPublishers::declare(session, welcome, id, channels)?,
            _subscribers: subscribers,
            _queryables: [
                queryable(keys.state(id, "snapshot"), AgentInput::SnapshotQuery)?,
                queryable(keys.state(id, "oem"), AgentInput::ViewQuery)?,
                queryable(keys.view(id, "*"), AgentInput::ViewQuery)?,
            ],
            session: session.clone(),
            keys,
            _token: session.liveliness().declare_token(keys.alive(id)).wait()?,
            inlet,
            gate,
            refusals,
        })
    }

    /// The next input; [`AgentInput::Timeout`] if none comes until the timer expires.
    pub fn next(&self, timer: Option<(Timer, Duration)>) -> AgentInput {
        self.inlet.next(timer)
    }

    /// The step of the newest frame that came, whether or not the process has taken it from the queue.
    pub fn newest_frame(&self) -> Option<Step> {
        lock(&self.gate).newest()
    }

    /// The same in lockstep: see [`FrameGate::newest_in_lockstep`].
    pub fn newest_in_lockstep(&self) -> Option<Step> {
        lock(&self.gate).newest_in_lockstep()
    }

    /// Whether a frame is out of date: see [`FrameGate::is_outdated`].
    pub fn is_outdated(&self, step: Step) -> bool {
        lock(&self.gate).is_outdated(step)
    }

    /// The samples that this process refused.
    pub fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// Sends a message to all agents.
    pub fn send(&self, said: &Said, physical: &PhysicalHeader) {
        match self.publishers.messages.get(usize::from(said.channel.0)) {
            Some(radio) => put(radio.put(said.bytes.to_vec()).attachment(to_json(physical))),
            None => tracing::error!(channel = %said.channel, "there is no such radio"),
        }
    }

    /// Sends a probe to all agents.
    pub fn probe(&self, probe: &Probe) {
        put_json(&self.publishers.probe, probe);
    }

    /// Tells the world which agents this process hears.
    pub fn ready(&self, ready: &Ready) {
        put_json(&self.publishers.ready, ready);
    }

    /// Tells the world that a frame or a turn is done.
    pub fn done(&self, done: &Done) {
        put_json(&self.publishers.command, done);
    }

    /// Sends the world a report, encoded.
    pub fn report(&self, report: Vec<u8>) {
        put(self.publishers.report.put(report));
    }

    /// Asks all agents for snapshots of what they know; the answers are inputs.
    pub fn request_snapshots(&self) {
        let sender = self.inlet.sender();
        let answer = move |reply: Reply| {
            let Ok(sample) = reply.into_result() else { return };
            let named = name(&sample).and_then(|name| split_agent(name, "state"));
            if let Some((agent, _)) = named {
                let _ = sender.try_send(AgentInput::Snapshot(raw_message(agent, &sample)));
            }
        };
        let get = self.session.get(self.keys.of("state/*/snapshot"));
        let get = get.allowed_destination(Locality::Remote).timeout(ANSWER_LIMIT);
        if let Err(error) = get.callback(answer).wait() {
            tracing::warn!(%error, "cannot ask the others what they know");
        }
    }
}

impl AgentPublishers {
    fn declare(
        session: &Session,
        welcome: &Welcome,
        id: AgentId,
        channels: usize,
    ) -> zenoh::Result<Self> {
        let (keys, control) = (Keys(welcome.run), congestion_control(welcome.pace));
        let publish = |key: String| {
            session
                .declare_publisher(key)
                .congestion_control(control)
                .allowed_destination(Locality::Remote)
                .express(true)
                .wait()
        };
        let messages = (0..channels).map(|c| publish(keys.link(id, ChannelId(c as u8))));
        Ok(Self {
            messages: messages.collect::<zenoh::Result<_>>()?,
            probe: publish(keys.probe(id))?,
            ready: publish(keys.ready(id))?,
            command: publish(keys.command(id))?,
            report: publish(keys.report(id))?,
        })
    }
}

/// The gate for frames, shared with Zenoh's callbacks.
type SharedGate = Arc<Mutex<FrameGate>>;

fn lock(gate: &Mutex<FrameGate>) -> MutexGuard<'_, FrameGate> {
    gate.lock().unwrap_or_else(PoisonError::into_inner)
}

fn subscribe(
    session: &Session,
    keys: Keys,
    id: AgentId,
    (queue, refusals): (&SyncSender<AgentInput>, &Refusals),
    gate: &SharedGate,
) -> zenoh::Result<Vec<Subscriber<()>>> {
    let alive = session
        .liveliness()
        .declare_subscriber(keys.of("alive/*"))
        .history(true)
        .callback(enqueue(queue, refusals, read_presence))
        .wait()?;
    let links = session
        .declare_subscriber(keys.links())
        .allowed_origin(Locality::Remote)
        .callback(enqueue(queue, refusals, read_link))
        .wait()?;
    let frames = session
        .declare_subscriber(keys.frame(id))
        .allowed_origin(Locality::Remote)
        .callback(enqueue(queue, refusals, exactly(keys.frame(id), gate.clone(), read_frame)))
        .wait()?;
    let clock = session
        .declare_subscriber(keys.clock())
        .allowed_origin(Locality::Remote)
        .callback(enqueue(queue, refusals, exactly(keys.clock(), gate.clone(), read_order)))
        .wait()?;
    Ok(vec![links, frames, clock, alive])
}

/// Reads the samples under a key, and refuses those under a pattern of keys: access control by key does
/// not cover them.
fn exactly(
    key: String,
    gate: SharedGate,
    read: fn(&Sample, &Refusals, &SharedGate) -> Option<AgentInput>,
) -> impl Fn(&Sample, &Refusals) -> Option<AgentInput> + Send + Sync + 'static {
    move |sample, refusals| {
        if sample.key_expr().as_str() == key {
            return read(sample, refusals, &gate);
        }
        refusals.count("key", &format!("`{}`, expected `{key}`", sample.key_expr()));
        None
    }
}

fn enqueue_query(
    queue: &SyncSender<AgentInput>,
    input: fn(Query) -> AgentInput,
) -> impl Fn(Query) + Send + Sync + 'static {
    let queue = queue.clone();
    move |query: Query| {
        if queue.try_send(input(query)).is_err() {
            tracing::error!("the input queue is full: a query is not answered");
        }
    }
}

fn raw_message(key: AgentId, sample: &Sample) -> RawMessage {
    let physical =
        sample.attachment().and_then(|attachment| parse_physical(&attachment.to_bytes()));
    RawMessage { key, physical, bytes: bytes(sample) }
}

fn parse_physical(header: &[u8]) -> Option<PhysicalHeader> {
    serde_json::from_slice(header).ok().filter(PhysicalHeader::is_place)
}

fn read_link(sample: &Sample, refusals: &Refusals) -> Option<AgentInput> {
    let Some((agent, rest)) = name(sample).and_then(|name| split_agent(name, "link")) else {
        refusals.count("key", &format!("`{}` names no agent", sample.key_expr()));
        return None;
    };
    match rest {
        "probe" => Some(AgentInput::Probe(agent, json(sample, refusals)?)),
        _ => Some(AgentInput::Message(raw_message(agent, sample))),
    }
}

fn read_frame(sample: &Sample, refusals: &Refusals, gate: &SharedGate) -> Option<AgentInput> {
    let header: FrameHeader = parse(sample, &sample.attachment()?.to_bytes(), refusals)?;
    if let Err(error) = lock(gate).admit(header.world, header.step) {
        refusals.count("frame", &error);
        return None;
    }
    Some(AgentInput::Frame(Box::new(RawFrame { header, pixels: bytes(sample) })))
}

fn read_order(sample: &Sample, refusals: &Refusals, gate: &SharedGate) -> Option<AgentInput> {
    let Announcement { world, order } = json(sample, refusals)?;
    if let Err(error) = lock(gate).check_world(world) {
        refusals.count("order", &error);
        return None;
    }
    Some(AgentInput::Order(order))
}

fn read_presence(sample: &Sample, _: &Refusals) -> Option<AgentInput> {
    match (name(sample)?, sample.kind()) {
        ("alive/world", SampleKind::Put) => Some(AgentInput::WorldAlive),
        ("alive/world", SampleKind::Delete) => Some(AgentInput::WorldGone),
        (_, SampleKind::Put) => None,
        (name, SampleKind::Delete) => {
            split_agent(name, "alive").map(|(agent, _)| AgentInput::Gone(agent))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_survives_to_the_last_bit_and_anything_else_is_none() {
        let header = PhysicalHeader { p_world: [0.1 + 0.2, -1e-300, 52.000_000_000_000_01] };
        assert_eq!(parse_physical(to_json(&header).as_bytes()), Some(header));
        for text in ["", "{}", "{\"p_world\": [1, 2]}", "{\"p_world\": [1, 2, 1e999]}", "7"] {
            assert_eq!(parse_physical(text.as_bytes()), None, "{text}");
        }
    }
}
