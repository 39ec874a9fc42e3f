//! The links of a fleet: messages handed over, in flight, delivered in order, and counted.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::SimTime;

use crate::config::{ChannelConfig, NetemConfig, RateConfig};
pub use crate::counters::{Counters, LinkCounters};
use crate::draw::Block;
use crate::fate::{Delivery, Fate, Reason, Sent, after};
use crate::outage::Outages;
use crate::propagation::Obstruction;
use crate::rate::Sender;
use crate::repeat::damage;
use crate::rule::{Case, LinkState, Rule, judge, rules};

/// A message that arrives.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrival {
    /// When.
    pub at: SimTime,
    /// The sender.
    pub src: AgentId,
    /// The receiver.
    pub dst: AgentId,
    /// The radio.
    pub channel: ChannelId,
    /// Where the sender was when it sent, `world`, metres.
    pub src_p_world: [f64; 3],
    /// The encoded envelope.
    pub bytes: Arc<[u8]>,
}

/// Sender, receiver and channel.
pub type LinkId = (AgentId, AgentId, ChannelId);

/// The links of a fleet: decides fates, holds what is in flight, counts.
///
/// Parameters ([`Links::reconfigure`]) live apart from what was and is: chains of losses and
/// delays, queues, messages in flight, counts.
pub struct Links {
    seed: u64,
    obstruction: Option<Arc<dyn Obstruction>>,
    /// What the rules were made from.
    config: Option<NetemConfig>,
    outages: Outages,
    channels: Vec<Channel>,
    links: BTreeMap<LinkId, Link>,
    senders: BTreeMap<(AgentId, ChannelId), Sender>,
    in_flight: BinaryHeap<Reverse<InFlight>>,
    counters: Counters,
}

/// A channel's parameters.
struct Channel {
    rate: RateConfig,
    rules: Vec<Box<dyn Rule>>,
}

/// A link's memory.
#[derive(Default)]
struct Link {
    counters: LinkCounters,
    /// Of the life that was asked about last: any other can be computed again.
    life: Option<(Incarnation, Box<LinkState>)>,
}

/// A message, or its copy, on its way.
struct InFlight {
    turn: Turn,
    sent_at: SimTime,
    src_p_world: [f64; 3],
    corrupted: bool,
    bytes: Arc<[u8]>,
}

/// By arrival, then by identity, so that ties are broken the same way everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Turn {
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
        self.turn == other.turn
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
        self.turn.cmp(&other.turn)
    }
}

impl Links {
    /// Links that follow `config`, with fates of `seed`, among what may stand in the way.
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

    /// Follows `config` from now on. Nothing else changes: chains go on from where they are, queues
    /// stay as long as they are and what is in flight arrives as it would have. Channels are known
    /// by their ids, so `config` should have the same names as before.
    pub fn reconfigure(&mut self, config: &NetemConfig) {
        if self.config.as_ref() == Some(config) {
            return;
        }
        self.config = Some(config.clone());
        self.outages = Outages::new(config);
        let channel = |(index, (_, channel)): (usize, (&str, &ChannelConfig))| {
            let id = ChannelId(u8::try_from(index).ok()?);
            let rules = rules(config, id, channel, self.obstruction.as_ref());
            Some(Channel { rate: channel.rate, rules })
        };
        self.channels = config.all_channels().enumerate().map_while(channel).collect();
    }

    /// Hands a message over and tells its fate.
    pub fn send(&mut self, sent: &Sent, bytes: Arc<[u8]>) -> Fate {
        let size = bytes.len() as u64;
        let (fate, is_new) = self.decide(sent);
        self.counters.count_sent(&fate);
        self.counters.bytes_sent += if is_new { size } else { 0 };
        let link = self.links.entry((sent.src, sent.dst, sent.channel)).or_default();
        link.counters.count_sent(&fate, size, sent.distance_m());
        for (index, copy) in fate.copies().enumerate() {
            let Ok(Delivery { at, corrupted }) = copy else { continue };
            let bytes = match corrupted {
                true => damaged(&bytes, &link.block(self.seed, sent)),
                false => bytes.clone(),
            };
            let Sent { src, dst, incarnation, channel, sequence, time: sent_at, .. } = *sent;
            let is_copy = index > 0;
            let turn = Turn { at, src, incarnation, channel, sequence, dst, is_copy };
            let src_p_world = sent.src_p_world;
            self.in_flight.push(Reverse(InFlight { turn, sent_at, src_p_world, corrupted, bytes }));
        }
        fate
    }

    /// The fate of a message that nobody hands over: nothing is counted and nothing arrives. It
    /// takes its place in its sender's queue, as the same message handed over would.
    pub fn fate(&mut self, sent: &Sent) -> Fate {
        self.decide(sent).0
    }

    /// When the next message arrives.
    pub fn next_arrival(&self) -> Option<SimTime> {
        self.in_flight.peek().map(|Reverse(message)| message.turn.at)
    }

    /// The next message that arrives no later than `now`.
    pub fn receive(&mut self, now: SimTime) -> Option<Arrival> {
        if self.next_arrival()? > now {
            return None;
        }
        let Reverse(message) = self.in_flight.pop()?;
        let InFlight { turn, sent_at, src_p_world, corrupted, bytes } = message;
        let Turn { at, src, dst, channel, .. } = turn;
        self.counters.count_arrival(corrupted);
        let link = self.links.entry((src, dst, channel)).or_default();
        let size = bytes.len() as u64;
        link.counters.count_arrival(corrupted, size, at.seconds_since(sent_at));
        Some(Arrival { at, src, dst, channel, src_p_world, bytes })
    }

    /// What happened so far.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// What happened so far on each link that was used, by sender, receiver and channel.
    pub fn per_link(&self) -> impl Iterator<Item = (LinkId, &LinkCounters)> {
        self.links.iter().map(|(id, link)| (*id, &link.counters))
    }

    /// A message's fate, and whether its sender's queue has not seen it before.
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
        let block = *link.draws.block(sent.sequence);
        let mut case = Case {
            sent,
            block,
            link,
            departure,
            corrupted: false,
            duplicated: false,
            delays_s: [0.0; 2],
        };
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
    /// The memory of the life that `sent` is of.
    fn state(&mut self, seed: u64, sent: &Sent) -> &mut LinkState {
        let fresh = || (sent.incarnation, Box::new(LinkState::new(seed, sent)));
        if self.life.as_ref().is_some_and(|(life, _)| *life != sent.incarnation) {
            self.life = None;
        }
        &mut self.life.get_or_insert_with(fresh).1
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
