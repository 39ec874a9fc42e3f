//! Rule 9: a token bucket and a bounded queue per sender and channel.
//!
//! Tokens come at `bytes_s` up to `burst_bytes`. A message takes one token per byte, and may take
//! them in advance: then it leaves once these tokens have come, after all messages before it (first
//! in, first out). Bytes whose tokens have not come yet form the queue. A message that would make the
//! queue longer than `queue_bytes` is lost (tail drop) and takes no tokens.
//!
//! A broadcast is sent once, whatever the number of its receivers, and it takes its tokens even if a
//! later rule loses it. So there is one verdict per (sender, channel, incarnation, sequence), which
//! is kept for the other receivers.

use std::collections::VecDeque;

use csat_proto::ids::Incarnation;
use csat_proto::time::SimTime;

use crate::config::RateConfig;
use crate::fate::{Reason, Sent};
use crate::rule::{Case, Rule};

/// When a message leaves its sender.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Departure {
    /// After this many seconds in the queue.
    After(f64),
    /// Never: the queue was full.
    Dropped,
}

/// Applies the verdict of the sender's queue, in its place among the rules.
pub struct Queue;

impl Rule for Queue {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        match case.departure {
            Departure::After(seconds) => {
                case.delays_s = case.delays_s.map(|delay| delay + seconds);
                Ok(())
            }
            Departure::Dropped => Err(Reason::Queue),
        }
    }
}

/// Verdicts that are kept per sender and channel. The queries for all receivers of a message come at
/// the same time, so a few would suffice.
const REMEMBERED: usize = 1024;

/// One sender on one channel: its bucket and the latest verdicts.
#[derive(Debug, Clone, Default)]
pub struct SenderBucket {
    /// Of the newest incarnation: an agent that restarts begins with an empty queue.
    bucket: Bucket,
    incarnation: Incarnation,
    /// By incarnation and sequence number.
    verdicts: VecDeque<((Incarnation, u64), Departure)>,
}

impl SenderBucket {
    /// When `sent` leaves, and whether this is the first query about it. A message that is `silenced`
    /// (the radio is off) takes no tokens. A message so old that its verdict was dropped leaves as if
    /// it were sent now, and takes no tokens either.
    pub fn depart(
        &mut self,
        config: &RateConfig,
        sent: &Sent,
        silenced: bool,
    ) -> (Departure, bool) {
        let key = (sent.incarnation, sent.sequence);
        // Nearly all queries are about the latest message or a newer one.
        let place = match self.verdicts.back() {
            Some((latest, departure)) if *latest == key => return (*departure, false),
            Some((latest, _)) if *latest > key => {
                match self.verdicts.binary_search_by_key(&key, |(key, _)| *key) {
                    Ok(index) => return (self.verdicts[index].1, false),
                    Err(0) if self.verdicts.len() == REMEMBERED => {
                        return (self.bucket.clone().take(config, sent), false);
                    }
                    Err(index) => index,
                }
            }
            _ => self.verdicts.len(),
        };
        if sent.incarnation > self.incarnation {
            (self.incarnation, self.bucket) = (sent.incarnation, Bucket::default());
        }
        let departure = match silenced {
            true => Departure::After(0.0),
            false => self.bucket.take(config, sent),
        };
        self.verdicts.insert(place, (key, departure));
        if self.verdicts.len() > REMEMBERED {
            self.verdicts.pop_front();
        }
        (departure, true)
    }
}

/// A token bucket whose level may be negative.
#[derive(Debug, Clone, Default)]
struct Bucket {
    /// Tokens at `at`, bytes; a negative number is the length of the queue. `None` for a full bucket.
    tokens: Option<f64>,
    at: SimTime,
}

impl Bucket {
    fn take(&mut self, config: &RateConfig, sent: &Sent) -> Departure {
        if config.bytes_s == f64::INFINITY {
            return Departure::After(0.0);
        }
        let full = config.burst_bytes as f64;
        let earned = sent.time.seconds_since(self.at) * config.bytes_s;
        let tokens = self.tokens.map_or(full, |tokens| (tokens + earned).min(full));
        self.at = self.at.max(sent.time);
        let left = tokens - sent.bytes as f64;
        if -left > config.queue_bytes as f64 {
            self.tokens = Some(tokens);
            return Departure::Dropped;
        }
        self.tokens = Some(left);
        Departure::After((-left).max(0.0) / config.bytes_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fate::tests::sent;
    use csat_proto::ids::AgentId;

    const CONFIG: RateConfig = RateConfig { bytes_s: 100.0, burst_bytes: 150, queue_bytes: 250 };

    fn message(sequence: u64, time_s: f64) -> Sent {
        Sent { time: SimTime::from_seconds(time_s), ..sent(sequence) }
    }

    #[test]
    fn a_burst_leaves_at_once_the_rest_waits_and_the_queue_is_bounded() {
        let mut sender = SenderBucket::default();
        let mut depart =
            |sequence, time_s| sender.depart(&CONFIG, &message(sequence, time_s), false).0;
        // Messages of 100 bytes, all at 1 s: 150 tokens, then 50, 150 and 250 bytes of queue.
        let waits = [0.0, 0.5, 1.5, 2.5].map(Departure::After);
        assert_eq!([0, 1, 2, 3].map(|i| depart(i, 1.0)), waits);
        assert_eq!(depart(4, 1.0), Departure::Dropped);
        // The dropped message took no tokens: a second later there is room for exactly one.
        assert_eq!(depart(5, 2.0), Departure::After(2.5));
        assert_eq!(depart(6, 2.0), Departure::Dropped);
        // A long pause fills the bucket and no more.
        assert_eq!(
            [7, 8].map(|i| depart(i, 100.0)),
            [Departure::After(0.0), Departure::After(0.5)]
        );
    }

    #[test]
    fn all_receivers_get_the_same_verdict_and_the_bytes_are_spent_once() {
        let mut sender = SenderBucket::default();
        let to = |dst, i| Sent { dst: AgentId(dst), ..message(i, 1.0) };
        for (i, wait) in [0.0, 0.5, 1.5].into_iter().enumerate() {
            for dst in 1..5 {
                let verdict = sender.depart(&CONFIG, &to(dst, i as u64), false);
                assert_eq!(verdict, (Departure::After(wait), dst == 1));
            }
        }
        assert_eq!(sender.depart(&CONFIG, &to(9, 1), false), (Departure::After(0.5), false));
    }

    #[test]
    fn memory_is_bounded_and_what_is_forgotten_costs_nothing() {
        let mut sender = SenderBucket::default();
        let config = RateConfig { queue_bytes: u64::MAX, ..CONFIG };
        let next = 3 * REMEMBERED as u64;
        for i in 0..next {
            sender.depart(&config, &message(i, 1.0), false);
        }
        assert_eq!(sender.verdicts.len(), REMEMBERED);
        let mut unasked = sender.clone();
        assert!(!sender.depart(&config, &message(0, 1.0), false).1);
        let wait = sender.depart(&config, &message(next, 1.0), false);
        assert_eq!(wait, unasked.depart(&config, &message(next, 1.0), false));
        assert_eq!(wait, (Departure::After(next as f64 - 0.5), true), "a second for each before");
    }

    #[test]
    fn a_new_incarnation_begins_with_an_empty_queue() {
        let mut sender = SenderBucket::default();
        for i in 0..3 {
            sender.depart(&CONFIG, &message(i, 1.0), false);
        }
        let reborn = |i| Sent { incarnation: Incarnation(1), ..message(i, 1.0) };
        let waits = [0, 1].map(|i| sender.depart(&CONFIG, &reborn(i), false));
        assert_eq!(waits, [0.0, 0.5].map(|wait| (Departure::After(wait), true)));
        // Every receiver of the old message gets the verdict that the first one got.
        assert_eq!(sender.depart(&CONFIG, &message(2, 1.0), false), (Departure::After(1.5), false));
    }

    #[test]
    fn who_is_silenced_spends_nothing() {
        let mut sender = SenderBucket::default();
        for i in 0..10 {
            sender.depart(&CONFIG, &message(i, 1.0), true);
        }
        assert_eq!(sender.depart(&CONFIG, &message(10, 1.0), false).0, Departure::After(0.0));
    }
}
