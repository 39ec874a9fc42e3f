//! Messages that wait to be sent, numbered by channel.

use std::collections::{BTreeMap, VecDeque};

use csat_proto::agent::Transmit;
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::ids::ChannelId;
use csat_proto::time::{SimTime, Step};

use super::message::Message;
use crate::config::AgentConfig;

/// When and where a message is sent.
#[derive(Debug, Clone, Copy)]
pub struct Stamp {
    /// The time.
    pub now: SimTime,
    /// The step.
    pub step: Step,
    /// Where the sender is, in its own frame: nobody else can use it.
    pub pose: Pose,
}

/// See the module.
#[derive(Debug, Clone, Default)]
pub struct Outbox {
    sequences: BTreeMap<ChannelId, u64>,
    waiting: VecDeque<Transmit>,
}

impl Outbox {
    /// Adds a message.
    pub fn send(&mut self, config: &AgentConfig, channel: ChannelId, at: &Stamp, said: &Message) {
        let next = self.sequences.entry(channel).or_default();
        let sequence = *next;
        *next += 1;
        let envelope = Envelope {
            run: config.run,
            src: config.id,
            incarnation: config.incarnation,
            channel,
            sequence,
            step: at.step,
            time: at.now,
            pose: at.pose.into(),
            body: postcard::to_stdvec(said).expect("messages always serialise"),
        };
        self.waiting.push_back(Transmit { channel, sequence, bytes: envelope.encode() });
    }

    /// The next message to send.
    pub fn pop(&mut self) -> Option<Transmit> {
        self.waiting.pop_front()
    }
}
