//! The links of a fleet: messages handed over, in flight, delivered in order, and counted.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::SimTime;

use crate::config::{ChannelConfig, NetemConfig, RateConfig};
use crate::counters::{Counters, LinkCounters};
use crate::draw::{Block, Purpose};
use crate::fate::{Delivery, Fate, Reason, Sent, after};
use crate::outage::Outages;
use crate::propagation::Obstruction;
use crate::rate::SenderBucket;
use crate::repeat::damage;
use crate::rule::{Case, LinkState, Rule, judge, rules};

/// A message that arrives.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrival {
    /// When it arrives.
    pub at: SimTime,
    /// The sender.
    pub src: AgentId,
    /// The receiver.
    pub dst: AgentId,
    /// The radio.
    pub channel: ChannelId,
    /// Where the sender was when it sent, `world`, metres.
    pub src_p_world: [f64; 3],
    /// What the receiver measures of the sender, and how wrong.
    pub measured: Measured,
    /// The encoded envelope.
    pub bytes: Arc<[u8]>,
}

/// What a receiver measures of the sender of a message: how far off it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measured {
    /// The error of the bearing, radians.
    pub bearing_error_rad: f64,
    /// The error of the offset, east and north, metres; `None` where it is not measured.
    pub offset_error_m: Option<[f64; 2]>,
}

/// The most by which receivers of a channel err.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    bearing_rad: f64,
    offset_m: Option<f64>,
}

impl Bounds {
    fn new(channel: &ChannelConfig) -> Self {
        let bearing_rad = channel.bearing_error_deg.to_radians();
        Self { bearing_rad, offset_m: channel.offset_error_m }
    }

    /// Whether nothing has to be drawn.
    fn is_exact(&self) -> bool {
        self.bearing_rad == 0.0 && self.offset_m.is_none()
    }

    /// Errors uniform within the bounds.
    fn draw(&self, block: &Block) -> Measured {
        let within = |bound: f64, purpose| bound * (2.0 * block.uniform(purpose) - 1.0);
        let axes = [Purpose::OffsetEast, Purpose::OffsetNorth];
        Measured {
            bearing_error_rad: within(self.bearing_rad, Purpose::Bearing),
            offset_error_m: self.offset_m.map(|bound| axes.map(|axis| within(bound, axis))),
        }
    }
}

/// One end of a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Who.
    pub agent: AgentId,
    /// Where, `world`, metres.
    pub p_world: [f64; 3],
}

/// What a working link carries, bytes: a little more than a fact of the set-membership mission.
const PROBE_BYTES: usize = 1500;

/// Sender, receiver and channel.
pub type LinkId = (AgentId, AgentId, ChannelId);

/// The links of a fleet: decides fates, holds what is in flight, counts.
///
/// Parameters ([`Links::reconfigure`]) are kept apart from state: chains of losses and delays, queues,
/// messages in flight, counters.
pub struct Links {
    seed: u64,
    obstruction: Option<Arc<dyn Obstruction>>,
    /// The configuration that the rules were made from.
    config: Option<NetemConfig>,
    outages: Outages,
    channels: Vec<ChannelRules>,
    links: BTreeMap<LinkId, Link>,
    senders: BTreeMap<(AgentId, ChannelId), SenderBucket>,
    in_flight: BinaryHeap<Reverse<InFlight>>,
    counters: Counters,
}

/// The parameters of a channel.
struct ChannelRules {
    rate: RateConfig,
    errors: Bounds,
    rules: Vec<Box<dyn Rule>>,
}

/// The state of a link.
#[derive(Default)]
struct Link {
    counters: LinkCounters,
    /// Of the incarnation of the last query; the state of any other incarnation can be computed again.
    state: Option<(Incarnation, Box<LinkState>)>,
}

/// A message, or its copy, in flight.
struct InFlight {
    order: ArrivalOrder,
    sent_at: SimTime,
    src_p_world: [f64; 3],
    measured: Measured,
    corrupted: bool,
    bytes: Arc<[u8]>,
}

/// The order of arrivals: by time, then by identity, so that every process breaks ties the same way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct ArrivalOrder {
    at: SimTime,
    src: AgentId,
    incarnation: Incarnation,
    channel: ChannelId,
    sequence: u64,
    dst: AgentId,
    is_copy: bool,
}

impl PartialEq for InFlight {
    fn eq(&self, other: &Self) -> bool {
        self.order == other.order
    }
}

impl Eq for InFlight {}

impl PartialOrd for InFlight {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for InFlight {
    fn cmp(&self, other: &Self) -> Ordering {
        self.order.cmp(&other.order)
    }
}

impl Links {
    /// Links with the rules of `config` and the fates of `seed`, among the obstacles of `obstruction`.
    pub fn new(config: &NetemConfig, seed: u64, obstruction: Option<Arc<dyn Obstruction>>) -> Self {
        let mut links = Self {
            seed,
            obstruction,
            config: None,
            outages: Outages::default(),
            channels: Vec::new(),
            links: BTreeMap::new(),
            senders: BTreeMap::new(),
            in_flight: BinaryHeap::new(),
            counters: Counters::default(),
        };
        links.reconfigure(config);
        links
    }

    /// Uses the rules of `config` from now on. All state stays: chains go on from their current
    /// states, queues keep their lengths, and messages in flight arrive as they would have. Channels
    /// are identified by their ids, so `config` should have the same names as before.
    pub fn reconfigure(&mut self, config: &NetemConfig) {
        if self.config.as_ref() == Some(config) {
            return;
        }
        self.config = Some(config.clone());
        self.outages = Outages::new(config);
        let channel = |(index, (_, channel)): (usize, (&str, &ChannelConfig))| {
            let id = ChannelId(u8::try_from(index).ok()?);
            let rules = rules(config, id, channel, self.obstruction.as_ref());
            Some(ChannelRules { rate: channel.rate, errors: Bounds::new(channel), rules })
        };
        self.channels = config.all_channels().enumerate().map_while(channel).collect();
    }

    /// Sends a message and returns its fate.
    pub fn send(&mut self, sent: &Sent, bytes: Arc<[u8]>) -> Fate {
        let size = bytes.len() as u64;
        let (fate, is_new) = self.decide(sent);
        self.counters.count_sent(&fate);
        self.counters.bytes_sent += if is_new { size } else { 0 };
        let link = self.links.entry((sent.src, sent.dst, sent.channel)).or_default();
        link.counters.count_sent(&fate, size, sent.distance_m());
        let errors = self.channels.get(usize::from(sent.channel.0)).map(|channel| channel.errors);
        let measured = match errors.filter(|errors| !errors.is_exact()) {
            Some(errors) => errors.draw(&link.block(self.seed, sent)),
            None => Measured::default(),
        };
        for (index, copy) in fate.copies().enumerate() {
            let Ok(Delivery { at, corrupted }) = copy else { continue };
            let bytes = match corrupted {
                true => damaged(&bytes, &link.block(self.seed, sent)),
                false => bytes.clone(),
            };
            let Sent { src, dst, incarnation, channel, sequence, time: sent_at, .. } = *sent;
            let is_copy = index > 0;
            let order = ArrivalOrder { at, src, incarnation, channel, sequence, dst, is_copy };
            let src_p_world = sent.src_p_world;
            self.in_flight.push(Reverse(InFlight {
                order,
                sent_at,
                src_p_world,
                measured,
                corrupted,
                bytes,
            }));
        }
        fate
    }

    /// The fate of a message without sending it: it is not counted and does not arrive. It takes the
    /// same place in its sender's queue as a message that is sent.
    pub fn fate(&mut self, sent: &Sent) -> Fate {
        self.decide(sent).0
    }

    /// Whether the link from `src` to `dst` works at `time`, over one channel at least: no outage, partition,
    /// range, propagation or jamming cuts it there and then. Of the rules that lose messages with a probability, the
    /// last two, it takes those for cuts that lose more than half of all messages of 1500 bytes; random loss cuts no
    /// link. Nothing is sent, counted or drawn.
    pub fn works(&self, src: End, dst: End, time: SimTime) -> bool {
        let works_over = |(channel, of_channel): (u8, &ChannelRules)| {
            let probe = Sent {
                src: src.agent,
                dst: dst.agent,
                incarnation: Incarnation(0),
                channel: ChannelId(channel),
                sequence: 0,
                time,
                bytes: PROBE_BYTES,
                src_p_world: src.p_world,
                dst_p_world: dst.p_world,
            };
            !of_channel.rules.iter().any(|rule| rule.cuts(&probe, self.seed))
        };
        !self.outages.is_out(dst.agent, time) && (0..).zip(&self.channels).any(works_over)
    }

    /// When the next message arrives.
    pub fn next_arrival(&self) -> Option<SimTime> {
        self.in_flight.peek().map(|Reverse(message)| message.order.at)
    }

    /// The next message that arrives no later than `now`.
    pub fn receive(&mut self, now: SimTime) -> Option<Arrival> {
        if self.next_arrival()? > now {
            return None;
        }
        let Reverse(message) = self.in_flight.pop()?;
        let InFlight { order, sent_at, src_p_world, measured, corrupted, bytes } = message;
        let ArrivalOrder { at, src, dst, channel, .. } = order;
        self.counters.count_arrival(corrupted);
        let link = self.links.entry((src, dst, channel)).or_default();
        let size = bytes.len() as u64;
        link.counters.count_arrival(corrupted, size, at.seconds_since(sent_at));
        Some(Arrival { at, src, dst, channel, src_p_world, measured, bytes })
    }

    /// The counters of all links together.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The counters of each link that was used, by sender, receiver and channel.
    pub fn per_link(&self) -> impl Iterator<Item = (LinkId, &LinkCounters)> {
        self.links.iter().map(|(id, link)| (*id, &link.counters))
    }

    /// A message's fate, and whether this is the first query about it to its sender's queue.
    fn decide(&mut self, sent: &Sent) -> (Fate, bool) {
        let silenced = self.outages.is_out(sent.src, sent.time);
        let channel = self.channels.get(usize::from(sent.channel.0));
        let rate = channel.map_or(RateConfig::default(), |channel| channel.rate);
        let sender = self.senders.entry((sent.src, sent.channel)).or_default();
        let (departure, is_new) = sender.depart(&rate, sent, silenced);
        let Some(channel) = channel else {
            return (Fate { first: Err(Reason::NoChannel), duplicate: None }, is_new);
        };
        let link = self.links.entry((sent.src, sent.dst, sent.channel)).or_default();
        let link = link.state(self.seed, sent);
        let mut case = Case::new(sent, link, departure);
        let verdict = judge(&channel.rules, &mut case);
        let Case { corrupted, duplicated, delays_s, .. } = case;
        let arrive = |delay_s: f64| {
            verdict?;
            let at = after(sent.time, delay_s);
            let is_out = self.outages.is_out(sent.dst, at);
            if is_out { Err(Reason::Outage) } else { Ok(Delivery { at, corrupted }) }
        };
        let duplicate = duplicated.then(|| arrive(delays_s[1]));
        (Fate { first: arrive(delays_s[0]), duplicate }, is_new)
    }
}

impl Link {
    /// The state for the incarnation of `sent`.
    fn state(&mut self, seed: u64, sent: &Sent) -> &mut LinkState {
        let fresh = || (sent.incarnation, Box::new(LinkState::new(seed, sent)));
        if self.state.as_ref().is_some_and(|(incarnation, _)| *incarnation != sent.incarnation) {
            self.state = None;
        }
        &mut self.state.get_or_insert_with(fresh).1
    }

    fn block(&mut self, seed: u64, sent: &Sent) -> Block {
        *self.state(seed, sent).draws.block(sent.sequence)
    }
}

fn damaged(bytes: &[u8], block: &Block) -> Arc<[u8]> {
    let mut bytes = bytes.to_vec();
    damage(&mut bytes, block);
    bytes.into()
}

#[cfg(test)]
mod tests;
