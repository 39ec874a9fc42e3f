//! What the links did, counted.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::fate::{Fate, Reason};

/// What all links did so far. Always: sent + duplicated = delivered + dropped + in flight.
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
    /// Bytes handed over; a broadcast counts once however many hear it.
    pub bytes_sent: u64,
}

/// What one link did so far, with the same equation.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LinkCounters {
    /// Messages handed over.
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
    /// Bytes handed over.
    pub bytes_sent: u64,
    /// Sum of the delays of what arrived, seconds.
    pub delay_s: f64,
    /// Sum of the distances over which messages were sent, metres.
    pub distance_m: f64,
}

impl Counters {
    /// Whether no message appeared or vanished.
    pub fn conserved(&self) -> bool {
        let dropped: u64 = self.dropped.values().sum();
        self.sent + self.duplicated == self.delivered + dropped + self.in_flight
    }

    /// Adds what other links did. Bytes of a broadcast that both sides heard count twice.
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

    pub(crate) fn count_sent(&mut self, fate: &Fate) {
        self.sent += 1;
        self.duplicated += u64::from(fate.duplicate.is_some());
        count_copies(fate, &mut self.in_flight, &mut self.dropped);
    }

    pub(crate) fn count_arrival(&mut self, corrupted: bool) {
        self.in_flight -= 1;
        self.delivered += 1;
        self.corrupted += u64::from(corrupted);
    }
}

impl LinkCounters {
    /// Whether no message appeared or vanished.
    pub fn conserved(&self) -> bool {
        let dropped: u64 = self.dropped.values().sum();
        self.sent + self.duplicated == self.delivered + dropped + self.in_flight
    }

    /// Adds what the same link did at other times.
    pub fn add(&mut self, other: &Self) {
        self.sent += other.sent;
        self.delivered += other.delivered;
        self.duplicated += other.duplicated;
        self.corrupted += other.corrupted;
        for (reason, count) in &other.dropped {
            *self.dropped.entry(*reason).or_default() += count;
        }
        self.in_flight += other.in_flight;
        self.bytes_sent += other.bytes_sent;
        self.delay_s += other.delay_s;
        self.distance_m += other.distance_m;
    }

    /// The mean delay of what arrived, seconds; `None` before anything did.
    pub fn mean_delay_s(&self) -> Option<f64> {
        (self.delivered > 0).then(|| self.delay_s / self.delivered as f64)
    }

    /// The mean distance over which messages were sent, metres; `None` before any was.
    pub fn mean_distance_m(&self) -> Option<f64> {
        (self.sent > 0).then(|| self.distance_m / self.sent as f64)
    }

    pub(crate) fn count_sent(&mut self, fate: &Fate, bytes: u64, distance_m: f64) {
        self.sent += 1;
        self.bytes_sent += bytes;
        self.distance_m += distance_m;
        self.duplicated += u64::from(fate.duplicate.is_some());
        count_copies(fate, &mut self.in_flight, &mut self.dropped);
    }

    pub(crate) fn count_arrival(&mut self, corrupted: bool, delay_s: f64) {
        self.in_flight -= 1;
        self.delivered += 1;
        self.corrupted += u64::from(corrupted);
        self.delay_s += delay_s;
    }
}

fn count_copies(fate: &Fate, in_flight: &mut u64, dropped: &mut BTreeMap<Reason, u64>) {
    for copy in fate.copies() {
        match copy {
            Ok(_) => *in_flight += 1,
            Err(reason) => *dropped.entry(reason).or_default() += 1,
        }
    }
}
