//! A message's identity, and what becomes of it.

use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::SimTime;
use serde::{Deserialize, Serialize};

/// A message on its way from one agent to another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sent {
    /// The sender.
    pub src: AgentId,
    /// The receiver.
    pub dst: AgentId,
    /// The sender's incarnation.
    pub incarnation: Incarnation,
    /// The radio.
    pub channel: ChannelId,
    /// The number of the message among those of the sender on that channel.
    pub sequence: u64,
    /// When it was sent.
    pub time: SimTime,
    /// Its size, bytes.
    pub bytes: usize,
    /// Where the sender is, `world`, metres.
    pub src_p_world: [f64; 3],
    /// Where the receiver is, `world`, metres.
    pub dst_p_world: [f64; 3],
}

impl Sent {
    /// Distance between the ends, metres.
    pub fn distance_m(&self) -> f64 {
        let squares = self.src_p_world.iter().zip(&self.dst_p_world).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>().sqrt()
    }
}

/// Why a message was lost, in the order in which the rules are asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The scenario has no such channel.
    NoChannel,
    /// The sender was out when it sent, or the receiver when it would have arrived.
    Outage,
    /// The ends were in groups that could not hear each other.
    Partition,
    /// The distance exceeds the range.
    Range,
    /// The signal was too weak.
    Propagation,
    /// The receiver was jammed.
    Jamming,
    /// Random loss.
    Loss,
    /// The sender's queue was full.
    Queue,
}

impl Reason {
    /// All reasons, in order.
    pub const ALL: [Self; 8] = [
        Self::NoChannel,
        Self::Outage,
        Self::Partition,
        Self::Range,
        Self::Propagation,
        Self::Jamming,
        Self::Loss,
        Self::Queue,
    ];

    /// Its name in scenarios, events and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoChannel => "no-channel",
            Self::Outage => "outage",
            Self::Partition => "partition",
            Self::Range => "range",
            Self::Propagation => "propagation",
            Self::Jamming => "jamming",
            Self::Loss => "loss",
            Self::Queue => "queue",
        }
    }
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// A copy that arrives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Delivery {
    /// When it arrives.
    pub at: SimTime,
    /// Whether one of its bytes is damaged.
    pub corrupted: bool,
}

/// What becomes of a message and of its copy, if there is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fate {
    /// The message: how it arrives, or why it does not.
    pub first: Result<Delivery, Reason>,
    /// How its copy arrives, or why it does not; `None` when the link made no copy.
    pub duplicate: Option<Result<Delivery, Reason>>,
}

impl Fate {
    /// The message and its copy.
    pub fn copies(&self) -> impl Iterator<Item = Result<Delivery, Reason>> {
        std::iter::once(self.first).chain(self.duplicate)
    }
}

/// The instant `seconds` after `time`, at most the last instant of [`SimTime`].
pub(crate) fn after(time: SimTime, seconds: f64) -> SimTime {
    SimTime(time.0.saturating_add(SimTime::from_seconds(seconds).0))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A message over 50 m at 1 s.
    pub(crate) fn sent(sequence: u64) -> Sent {
        Sent {
            src: AgentId(0),
            dst: AgentId(1),
            incarnation: Incarnation(0),
            channel: ChannelId(0),
            sequence,
            time: SimTime::from_seconds(1.0),
            bytes: 100,
            src_p_world: [0.0, 0.0, 50.0],
            dst_p_world: [30.0, 40.0, 50.0],
        }
    }

    #[test]
    fn reasons_have_one_name_each_and_keep_their_order() {
        for (index, reason) in Reason::ALL.into_iter().enumerate() {
            assert_eq!(reason as usize, index);
            assert_eq!(serde_json::to_value(reason).unwrap(), reason.name());
        }
        assert!(Reason::ALL.is_sorted());
    }

    #[test]
    fn time_ends_instead_of_overflowing() {
        assert_eq!(after(SimTime(5), 1.0), SimTime(1_000_005));
        assert_eq!(after(SimTime(5), f64::INFINITY), SimTime(u64::MAX));
        assert_eq!(after(SimTime(u64::MAX), 1.0), SimTime(u64::MAX));
    }
}
