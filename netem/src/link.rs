//! Messages in flight.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use csat_proto::ids::AgentId;
use csat_proto::time::SimTime;
use serde::Serialize;

use crate::config::NetemConfig;
use crate::fate::Sent;
use crate::rule::{Fate, Reason, Rule, fate, rules};

/// What the links did so far. Always: sent + duplicated = delivered + dropped + in flight.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Counters {
    /// Messages handed over, one per receiver.
    pub sent: u64,
    /// Messages that arrived.
    pub delivered: u64,
    /// Further copies of messages.
    pub duplicated: u64,
    /// Messages that were lost, by reason.
    pub dropped: BTreeMap<Reason, u64>,
    /// Messages on their way.
    pub in_flight: u64,
    /// Bytes handed over.
    pub bytes_sent: u64,
}

impl Counters {
    /// Whether no message appeared or vanished.
    pub fn conserved(&self) -> bool {
        let dropped: u64 = self.dropped.values().sum();
        self.sent + self.duplicated == self.delivered + dropped + self.in_flight
    }
}

/// A message that arrives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arrival {
    /// When.
    pub at: SimTime,
    /// The receiver.
    pub dst: AgentId,
    /// The encoded envelope.
    pub bytes: Arc<[u8]>,
}

/// The links of a fleet: decides fates, holds what is in flight, counts.
pub struct Links {
    rules: Vec<Box<dyn Rule>>,
    in_flight: BinaryHeap<Reverse<InFlight>>,
    counters: Counters,
}

/// Ordered by arrival, then by identity, so that ties are broken the same way everywhere.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct InFlight {
    at: SimTime,
    src: AgentId,
    sequence: u64,
    dst: AgentId,
    bytes: Arc<[u8]>,
}

impl Links {
    /// Links that follow `config`, with fates of `seed`.
    pub fn new(config: &NetemConfig, seed: u64) -> Self {
        Self {
            rules: rules(&config.radio, seed),
            in_flight: BinaryHeap::new(),
            counters: Counters::default(),
        }
    }

    /// Hands a message over and tells its fate.
    pub fn send(&mut self, sent: &Sent, bytes: Arc<[u8]>) -> Fate {
        self.counters.sent += 1;
        self.counters.bytes_sent += bytes.len() as u64;
        let fate = fate(&self.rules, sent);
        match fate {
            Fate::Delivered(at) => {
                self.counters.in_flight += 1;
                let Sent { src, dst, sequence, .. } = *sent;
                self.in_flight.push(Reverse(InFlight { at, src, sequence, dst, bytes }));
            }
            Fate::Lost(reason) => *self.counters.dropped.entry(reason).or_default() += 1,
        }
        fate
    }

    /// When the next message arrives.
    pub fn next_arrival(&self) -> Option<SimTime> {
        self.in_flight.peek().map(|Reverse(message)| message.at)
    }

    /// The next message that arrives no later than `now`.
    pub fn receive(&mut self, now: SimTime) -> Option<Arrival> {
        if self.next_arrival()? > now {
            return None;
        }
        let Reverse(InFlight { at, dst, bytes, .. }) = self.in_flight.pop()?;
        self.counters.in_flight -= 1;
        self.counters.delivered += 1;
        Some(Arrival { at, dst, bytes })
    }

    /// What happened so far.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ChannelConfig, DelayConfig, LossConfig};
    use crate::fate::tests::sent;

    #[test]
    fn messages_arrive_in_order_and_are_counted() {
        let radio = ChannelConfig {
            loss: LossConfig::Iid { p: 0.5 },
            delay: DelayConfig::Constant { mean_s: 0.25 },
            ..Default::default()
        };
        let mut links = Links::new(&NetemConfig { radio }, 1);
        for sequence in 0..100 {
            links.send(&sent(sequence), Arc::from([0u8; 10]));
            assert!(links.counters().conserved());
        }
        assert_eq!(links.receive(SimTime::from_seconds(1.2)), None);
        let in_flight = links.counters().in_flight;
        let arrived = std::iter::from_fn(|| links.receive(SimTime::from_seconds(1.25))).count();
        assert_eq!(arrived as u64, in_flight);
        assert!((20..80).contains(&arrived));
        let counters = links.counters();
        assert!(counters.conserved());
        assert_eq!((counters.in_flight, counters.bytes_sent), (0, 1000));
    }
}
