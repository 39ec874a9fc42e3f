//! Counters of what the links did.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::fate::{Fate, Reason};

/// What all links did so far. Invariant: sent + duplicated = delivered + dropped + in flight.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Messages handed over, one per receiver.
    pub sent: u64,
    /// Messages that arrived, damaged ones among them.
    pub delivered: u64,
    /// Further copies of messages.
    pub duplicated: u64,
    /// Messages that arrived damaged.
    pub corrupted: u64,
    /// Messages that were lost, by reason.
    pub dropped: BTreeMap<Reason, u64>,
    /// Messages on their way.
    pub in_flight: u64,
    /// Bytes handed over; a broadcast counts once, whatever the number of its receivers.
    pub bytes_sent: u64,
}

/// What one link did so far.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LinkCounters {
    /// The messages of the link and their bytes. A link has one receiver, so each message counts once.
    pub counts: Counters,
    /// Bytes that arrived, those of copies and of damaged messages among them.
    pub bytes_delivered: u64,
    /// Sum of the delays of what arrived, seconds.
    pub delay_s: f64,
    /// Sum of the distances over which messages were sent, metres.
    pub distance_m: f64,
}

impl Counters {
    /// Whether the invariant holds: no message appeared or vanished.
    pub fn conserved(&self) -> bool {
        let dropped: u64 = self.dropped.values().sum();
        self.sent + self.duplicated == self.delivered + dropped + self.in_flight
    }

    /// Adds the counters of other links, or of the same links at other times. The bytes of a broadcast
    /// count twice if both sides counted it.
    pub fn add(&mut self, other: &Counters) {
        self.sent += other.sent;
        self.delivered += other.delivered;
        self.duplicated += other.duplicated;
        self.corrupted += other.corrupted;
        for (reason, count) in &other.dropped {
            *self.dropped.entry(*reason).or_default() += count;
        }
        self.in_flight += other.in_flight;
        self.bytes_sent += other.bytes_sent;
    }

    /// Counts all messages in flight as lost for this reason.
    pub fn lose_in_flight(&mut self, reason: Reason) {
        let lost = std::mem::take(&mut self.in_flight);
        if lost > 0 {
            *self.dropped.entry(reason).or_default() += lost;
        }
    }

    pub(crate) fn count_sent(&mut self, fate: &Fate) {
        self.sent += 1;
        self.duplicated += u64::from(fate.duplicate.is_some());
        for copy in fate.copies() {
            match copy {
                Ok(_) => self.in_flight += 1,
                Err(reason) => *self.dropped.entry(reason).or_default() += 1,
            }
        }
    }

    pub(crate) fn count_arrival(&mut self, corrupted: bool) {
        self.in_flight -= 1;
        self.delivered += 1;
        self.corrupted += u64::from(corrupted);
    }
}

impl LinkCounters {
    /// Adds the counters of the same link at other times.
    pub fn add(&mut self, other: &Self) {
        self.counts.add(&other.counts);
        self.bytes_delivered += other.bytes_delivered;
        self.delay_s += other.delay_s;
        self.distance_m += other.distance_m;
    }

    /// The mean delay of what arrived, seconds; `None` before the first arrival.
    pub fn mean_delay_s(&self) -> Option<f64> {
        (self.counts.delivered > 0).then(|| self.delay_s / self.counts.delivered as f64)
    }

    /// The mean distance over which messages were sent, metres; `None` before the first one.
    pub fn mean_distance_m(&self) -> Option<f64> {
        (self.counts.sent > 0).then(|| self.distance_m / self.counts.sent as f64)
    }

    pub(crate) fn count_sent(&mut self, fate: &Fate, bytes: u64, distance_m: f64) {
        self.counts.count_sent(fate);
        self.counts.bytes_sent += bytes;
        self.distance_m += distance_m;
    }

    pub(crate) fn count_arrival(&mut self, corrupted: bool, bytes: u64, delay_s: f64) {
        self.counts.count_arrival(corrupted);
        self.bytes_delivered += bytes;
        self.delay_s += delay_s;
    }
}
