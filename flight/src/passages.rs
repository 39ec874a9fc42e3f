//! What the links did, written down: lines of `events.jsonl` and rows of `links.csv`.

use csat_netem::config::TraceLevel;
use csat_netem::counters::LinkCounters;
use csat_netem::fate::{Fate, Reason, Sent};
use csat_netem::link::LinkId;
use csat_proto::ids::{AgentId, ChannelId};
use serde::Serialize;

use csat_mission::engine::Passage;

/// What became of a message for those receivers for whom the same became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum PassageLine {
    /// It was lost.
    Drop {
        /// The step it was sent in.
        step: u32,
        /// When it was sent, simulated seconds.
        time_s: f64,
        /// The sender.
        src: AgentId,
        /// The receivers.
        dst: Vec<AgentId>,
        /// The radio.
        channel: ChannelId,
        /// Its number among the sender's messages on that radio.
        sequence: u64,
        /// Why.
        reason: Reason,
    },
    /// It is to arrive.
    Delivery {
        /// The step it was sent in.
        step: u32,
        /// When it was sent, simulated seconds.
        time_s: f64,
        /// The sender.
        src: AgentId,
        /// The receivers.
        dst: Vec<AgentId>,
        /// The radio.
        channel: ChannelId,
        /// Its number among the sender's messages on that radio.
        sequence: u64,
        /// After how long, seconds.
        delay_s: f64,
        /// Whether it is damaged.
        corrupted: bool,
        /// Whether it is a copy that the link made.
        duplicate: bool,
    },
}

/// The lines of one step, as many as `level` asks for.
pub fn passage_lines(step: u32, passages: &[Passage], level: TraceLevel) -> Vec<PassageLine> {
    let mut lines: Vec<PassageLine> = Vec::new();
    if level == TraceLevel::None {
        return lines;
    }
    for Passage { sent, fate: Fate { first, duplicate }, .. } in passages {
        for (copy, duplicate) in
            std::iter::once((*first, false)).chain(duplicate.map(|c| (c, true)))
        {
            let line = line(step, sent, copy, duplicate);
            if level == TraceLevel::All || matches!(line, PassageLine::Drop { .. }) {
                add(&mut lines, line);
            }
        }
    }
    lines
}

fn line(
    step: u32,
    sent: &Sent,
    copy: Result<csat_netem::fate::Delivery, Reason>,
    duplicate: bool,
) -> PassageLine {
    let &Sent { src, channel, sequence, .. } = sent;
    let time_s = sent.time.seconds();
    let dst = vec![sent.dst];
    match copy {
        Err(reason) => PassageLine::Drop { step, time_s, src, dst, channel, sequence, reason },
        Ok(delivery) => PassageLine::Delivery {
            step,
            time_s,
            src,
            dst,
            channel,
            sequence,
            delay_s: delivery.at.seconds_since(sent.time),
            corrupted: delivery.corrupted,
            duplicate,
        },
    }
}

/// Appends a line, or its receiver to one that says the same of the same message.
fn add(lines: &mut Vec<PassageLine>, mut line: PassageLine) {
    let receiver = std::mem::take(line.receivers());
    // A message's passages come one after the other.
    for last in lines.iter_mut().rev() {
        let others = std::mem::take(last.receivers());
        let is_same = *last == line;
        *last.receivers() = others;
        if is_same {
            last.receivers().extend(receiver);
            return;
        }
        if last.message() != line.message() {
            break;
        }
    }
    *line.receivers() = receiver;
    lines.push(line);
}

impl PassageLine {
    fn receivers(&mut self) -> &mut Vec<AgentId> {
        match self {
            Self::Drop { dst, .. } | Self::Delivery { dst, .. } => dst,
        }
    }

    fn message(&self) -> (AgentId, ChannelId, u64) {
        match *self {
            Self::Drop { src, channel, sequence, .. }
            | Self::Delivery { src, channel, sequence, .. } => (src, channel, sequence),
        }
    }
}

/// A row of `links.csv`: what one link did in the whole run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LinkRow {
    /// The sender.
    pub src: AgentId,
    /// The receiver.
    pub dst: AgentId,
    /// The radio.
    pub channel: ChannelId,
    /// Messages handed over.
    pub sent: u64,
    /// Messages that arrived, damaged ones among them.
    pub delivered: u64,
    /// Further copies of messages.
    pub duplicated: u64,
    /// Messages that arrived damaged.
    pub corrupted: u64,
    /// Messages still on their way at the end.
    pub in_flight: u64,
    /// Bytes handed over.
    pub bytes_sent: u64,
    /// Bytes that arrived, those of copies and of damaged messages among them.
    pub bytes_delivered: u64,
    /// The mean delay of what arrived, seconds.
    pub mean_delay_s: Option<f64>,
    /// The mean distance over which messages were sent, metres.
    pub mean_distance_m: Option<f64>,
    /// Lost: the scenario has no such radio.
    pub dropped_no_channel: u64,
    /// Lost: the sender was out, or the receiver.
    pub dropped_outage: u64,
    /// Lost: the ends were kept apart.
    pub dropped_partition: u64,
    /// Lost: too far.
    pub dropped_range: u64,
    /// Lost: too weak.
    pub dropped_propagation: u64,
    /// Lost: the receiver was jammed.
    pub dropped_jamming: u64,
    /// Lost at random.
    pub dropped_loss: u64,
    /// Lost: the sender's queue was full.
    pub dropped_queue: u64,
}

impl LinkRow {
    /// The row of one link.
    pub fn new((link, counters): (LinkId, &LinkCounters)) -> Self {
        let counts = &counters.counts;
        let dropped = |reason| counts.dropped.get(&reason).copied().unwrap_or_default();
        let (src, dst, channel) = link;
        Self {
            src,
            dst,
            channel,
            sent: counts.sent,
            delivered: counts.delivered,
            duplicated: counts.duplicated,
            corrupted: counts.corrupted,
            in_flight: counts.in_flight,
            bytes_sent: counts.bytes_sent,
            bytes_delivered: counters.bytes_delivered,
            mean_delay_s: counters.mean_delay_s(),
            mean_distance_m: counters.mean_distance_m(),
            dropped_no_channel: dropped(Reason::NoChannel),
            dropped_outage: dropped(Reason::Outage),
            dropped_partition: dropped(Reason::Partition),
            dropped_range: dropped(Reason::Range),
            dropped_propagation: dropped(Reason::Propagation),
            dropped_jamming: dropped(Reason::Jamming),
            dropped_loss: dropped(Reason::Loss),
            dropped_queue: dropped(Reason::Queue),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_netem::fate::Delivery;
    use csat_proto::ids::Incarnation;
    use csat_proto::time::SimTime;

    fn passage(
        sequence: u64,
        dst: u16,
        first: Result<f64, Reason>,
        copy_s: Option<f64>,
    ) -> Passage {
        let at = |seconds| Delivery { at: SimTime::from_seconds(3.0 + seconds), corrupted: false };
        let sent = Sent {
            src: AgentId(0),
            dst: AgentId(dst),
            incarnation: Incarnation(0),
            channel: ChannelId(0),
            sequence,
            time: SimTime::from_seconds(3.0),
            bytes: 10,
            src_p_world: [0.0; 3],
            dst_p_world: [1.0; 3],
        };
        let fate = Fate { first: first.map(at), duplicate: copy_s.map(|s| Ok(at(s))) };
        Passage { sent, bytes: [].into(), fate }
    }

    #[test]
    fn receivers_with_the_same_fate_share_a_line() {
        let passages = [
            passage(7, 1, Err(Reason::Range), None),
            passage(7, 2, Ok(0.5), Some(1.5)),
            passage(7, 3, Err(Reason::Range), None),
            passage(7, 4, Err(Reason::Loss), None),
            passage(8, 1, Err(Reason::Range), None),
        ];
        let text = |level| {
            let lines = passage_lines(6, &passages, level);
            lines.iter().map(|l| serde_json::to_string(l).unwrap()).collect::<Vec<_>>()
        };
        let losses = text(TraceLevel::Losses);
        assert_eq!(losses.len(), 3, "{losses:#?}");
        assert_eq!(
            losses[0],
            r#"{"event":"drop","step":6,"time_s":3.0,"src":0,"dst":[1,3],"channel":0,"sequence":7,"reason":"range"}"#
        );
        assert_eq!(text(TraceLevel::All).len(), 5);
        assert!(text(TraceLevel::All)[2].contains(r#""delay_s":1.5"#));
        assert!(text(TraceLevel::None).is_empty());
    }
}
