//! Numbers messages, pays for them and queues them to be sent.

use std::collections::VecDeque;

use csat_proto::agent::{FIRST_ANSWER, Transmit};
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::time::{SimTime, Step};

use super::budget::Budget;
use super::message::{Message, size_of};
use crate::config::AgentConfig;

/// Bytes of a message outside envelope and body: magic, checksum and the length of the body.
const FRAME_BYTES: usize = 9 + 3;

/// When and where a message is sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamp {
    /// The time of the agent.
    pub now: SimTime,
    /// The step of its last frame.
    pub step: Step,
    /// Where it is.
    pub pose: Pose,
}

/// The messages to be sent.
#[derive(Debug, Clone)]
pub struct Outbox {
    config: AgentConfig,
    /// What may be sent.
    pub budget: Budget,
    sequence: u64,
    answers: u64,
    queue: VecDeque<Transmit>,
}

impl Outbox {
    /// An outbox that has sent nothing.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            config: config.clone(),
            budget: Budget::new(config.exchange.budget_bytes_s),
            sequence: 0,
            answers: 0,
            queue: VecDeque::new(),
        }
    }

    /// The next message to send.
    pub fn pop(&mut self) -> Option<Transmit> {
        self.queue.pop_front()
    }

    /// The most bytes that the next message has around its body.
    pub fn envelope_bytes(&self, stamp: &Stamp) -> usize {
        size_of(&self.envelope(stamp, self.sequence, Vec::new())) + FRAME_BYTES
    }

    /// Sends a message to all.
    pub fn send(&mut self, stamp: &Stamp, message: &Message) {
        let transmit = self.transmit(stamp, self.sequence, message);
        self.sequence += 1;
        self.budget.spend(transmit.bytes.len());
        self.queue.push_back(transmit);
    }

    /// A message to an agent that asked for it, outside the budget.
    pub fn answer(&mut self, stamp: &Stamp, message: &Message) -> Transmit {
        let transmit = self.transmit(stamp, FIRST_ANSWER + self.answers, message);
        self.answers += 1;
        transmit
    }

    fn transmit(&self, stamp: &Stamp, sequence: u64, message: &Message) -> Transmit {
        let body = postcard::to_stdvec(message).expect("a message always serialises");
        let bytes = self.envelope(stamp, sequence, body).encode();
        Transmit { channel: self.config.channel, sequence, bytes }
    }

    fn envelope(&self, stamp: &Stamp, sequence: u64, body: Vec<u8>) -> Envelope {
        Envelope {
            run: self.config.run,
            src: self.config.id,
            incarnation: self.config.incarnation,
            channel: self.config.channel,
            sequence,
            step: stamp.step,
            time: stamp.now,
            pose: stamp.pose.into(),
            body,
        }
    }
}
