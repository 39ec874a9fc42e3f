//! What others say on the links, until it is heard.
//!
//! Messages come by Zenoh in whatever order; an agent's links are told in the order of sender, radio
//! and number, and in lockstep not before all that was announced is here.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use csat_proto::control::{SaidSoFar, number_limit};
use csat_proto::envelope::{Envelope, EnvelopeError};
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::{SimTime, Step};

use csat_mission::node::Said;

/// The most messages that wait to be heard.
const MAX_WAITING: usize = 65_536;
/// The most bytes that wait to be heard.
const MAX_WAITING_BYTES: usize = 256 << 20;
/// The most senders' lives and radios that are kept account of.
const MAX_STREAMS: usize = 4096;
/// How many messages that were heard out of order are remembered of each stream.
const WINDOW: usize = 1024;
/// In lockstep, how far ahead of this process's newest frame another may be, steps.
const MAX_AHEAD: u32 = 64;

/// Sender, life and radio.
type Stream = (AgentId, Incarnation, ChannelId);

/// Messages that wait to be heard.
#[derive(Debug, Default)]
pub struct MessageQueue {
    waiting: BTreeMap<(Stream, u64), Said>,
    waiting_bytes: usize,
    heard: BTreeMap<Stream, Heard>,
}

/// Which numbers of a stream were heard.
#[derive(Debug, Default)]
struct Heard {
    /// All below this were, or need not be any more.
    below: u64,
    /// And these.
    others: BTreeSet<u64>,
}

impl Heard {
    fn contains(&self, number: u64) -> bool {
        number < self.below || self.others.contains(&number)
    }

    fn skip_to(&mut self, next: u64) {
        self.below = self.below.max(next);
        self.others = self.others.split_off(&self.below);
    }

    /// Numbers that were left out stay welcome, so that one that is far off mutes no sender.
    fn add(&mut self, number: u64) {
        self.others.insert(number);
        if self.others.len() > WINDOW
            && let Some(oldest) = self.others.pop_first()
        {
            self.below = oldest + 1;
        }
        while self.others.remove(&self.below) {
            self.below += 1;
        }
    }
}

/// Why a message was not kept.
#[derive(Debug, thiserror::Error)]
pub enum QueueError {
    /// It is no message.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// It does not say of itself what its key says of it.
    #[error("a message of agent {got} under the key of agent {key}")]
    Forged {
        /// Whose it says it is.
        got: AgentId,
        /// Under whose key it came.
        key: AgentId,
    },
    /// Nothing says where it was sent.
    #[error("a message of agent {from} without a physical header")]
    Physical {
        /// Whose.
        from: AgentId,
    },
    /// No agent says so much.
    #[error("message {number} of agent {from} at step {step}: it can have said {max} by then")]
    Number {
        /// Whose.
        from: AgentId,
        /// Its number.
        number: u64,
        /// Its step.
        step: Step,
        /// What would do.
        max: u64,
    },
    /// No agent is so far ahead.
    #[error("a message of agent {from} of step {step}, but the newest frame is of step {newest}")]
    Ahead {
        /// Whose.
        from: AgentId,
        /// Its step.
        step: Step,
        /// This process's.
        newest: Step,
    },
    /// Another one with this number came before.
    #[error("a second message {number} of agent {from}")]
    Twice {
        /// Whose.
        from: AgentId,
        /// Its number.
        number: u64,
    },
    /// Too many wait.
    #[error("{messages} messages of {bytes} bytes wait already, of {streams} senders' lives")]
    Full {
        /// How many.
        messages: usize,
        /// How long they are.
        bytes: usize,
        /// Of how many streams.
        streams: usize,
    },
}

impl MessageQueue {
    /// Takes a message that came under the key of `key` with a physical header; the first one with its number counts. `newest` is
    /// the step of this process's newest frame, `None` where others may be far ahead of it.
    ///
    /// # Errors
    /// When it is not kept.
    pub fn take(
        &mut self,
        key: AgentId,
        physical: Option<PhysicalHeader>,
        bytes: Vec<u8>,
        newest: Option<Step>,
    ) -> Result<(), QueueError> {
        let (said, step) = read(key, physical, bytes)?;
        let (from, number) = (said.src, said.sequence);
        let max = number_limit(step);
        if number >= max {
            return Err(QueueError::Number { from, number, step, max });
        }
        if let Some(newest) = newest.filter(|newest| step.0 > newest.0.saturating_add(MAX_AHEAD)) {
            return Err(QueueError::Ahead { from, step, newest });
        }
        let stream = (from, said.incarnation, said.channel);
        let heard = self.heard.get(&stream);
        if heard.is_some_and(|heard| number < heard.below) {
            return Ok(());
        }
        let is_known = heard.is_some_and(|heard| heard.contains(number));
        if is_known || self.waiting.contains_key(&(stream, number)) {
            return Err(QueueError::Twice { from, number });
        }
        let (messages, bytes) = (self.waiting.len(), self.waiting_bytes);
        let is_crowded = heard.is_none() && self.heard.len() >= MAX_STREAMS;
        if is_crowded || messages >= MAX_WAITING || bytes + said.bytes.len() > MAX_WAITING_BYTES {
            return Err(QueueError::Full { messages, bytes, streams: self.heard.len() });
        }
        self.waiting_bytes += said.bytes.len();
        self.waiting.insert((stream, number), said);
        Ok(())
    }

    /// A step begins at `now`: what was said before, of which `said` tells, need not be heard any more.
    pub fn skip(&mut self, said: &[SaidSoFar], now: SimTime) {
        for (stream, next) in streams(said) {
            self.heard.entry(stream).or_default().skip_to(next);
        }
        let heard = &self.heard;
        self.waiting.retain(|(stream, number), said| {
            said.time >= now && !heard.get(stream).is_some_and(|heard| heard.contains(*number))
        });
        self.waiting_bytes = self.waiting.values().map(|said| said.bytes.len()).sum();
    }

    /// The first message that `said` announces and that is not here, but for those of `own`.
    pub fn lacks(&self, said: &[SaidSoFar], own: AgentId) -> Option<(AgentId, ChannelId, u64)> {
        streams(said).filter(|((src, ..), _)| *src != own).find_map(|(stream, next)| {
            let mut open = self.below(stream)..next;
            let lacked = open.find(|number| !self.waiting.contains_key(&(stream, *number)));
            lacked.map(|number| (stream.0, stream.2, number))
        })
    }

    fn below(&self, stream: Stream) -> u64 {
        self.heard.get(&stream).map_or(0, |heard| heard.below)
    }

    /// Takes what `said` announces and is here, by sender, radio and number; nothing may lack.
    pub fn hear(&mut self, said: &[SaidSoFar], own: AgentId) -> Vec<Said> {
        let mut all = Vec::new();
        for (stream, next) in streams(said).filter(|((src, ..), _)| *src != own) {
            let open = self.below(stream)..next;
            all.extend(open.map_while(|number| self.waiting.remove(&(stream, number))));
            self.heard.entry(stream).or_default().skip_to(next);
        }
        self.waiting_bytes -= all.iter().map(|said| said.bytes.len()).sum::<usize>();
        all
    }

    /// Takes all that is here, by sender, life, radio and number.
    pub fn hear_all(&mut self) -> Vec<Said> {
        for &(stream, number) in self.waiting.keys() {
            self.heard.entry(stream).or_default().add(number);
        }
        self.waiting_bytes = 0;
        std::mem::take(&mut self.waiting).into_values().collect()
    }
}

/// What the headers of a message that came under the key of `key` say, and its step.
///
/// # Errors
/// When it is no message, another agent's, or comes from no place.
pub fn read(
    key: AgentId,
    physical: Option<PhysicalHeader>,
    bytes: Vec<u8>,
) -> Result<(Said, Step), QueueError> {
    let envelope = Envelope::decode(&bytes)?;
    let Envelope { src, incarnation, channel, sequence, step, time, .. } = envelope;
    if src != key {
        return Err(QueueError::Forged { got: src, key });
    }
    let PhysicalHeader { p_world } = physical.ok_or(QueueError::Physical { from: src })?;
    let bytes = Arc::from(bytes);
    Ok((Said { src, incarnation, channel, sequence, time, p_world, bytes }, step))
}

/// By stream, the number of the next message.
fn streams(said: &[SaidSoFar]) -> impl Iterator<Item = (Stream, u64)> {
    said.iter().flat_map(|SaidSoFar { agent, incarnation, next }| {
        let channels = next.iter().enumerate();
        channels.map(|(index, next)| ((*agent, *incarnation, ChannelId(index as u8)), *next))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::camera::Pose;
    use csat_proto::ids::RunId;
    use proptest::prelude::*;

    const HERE: PhysicalHeader = PhysicalHeader { p_world: [1.0, 2.0, 3.0] };

    /// What an agent believes, or claims, changes nothing for the links.
    #[test]
    fn the_place_of_a_sender_is_the_one_of_the_physical_header() {
        let mut queue = MessageQueue::default();
        let far = Envelope { pose: Pose::level([9e5, 0.0, 3.0], 0.0), ..envelope(1, 0, 0) };
        take(&mut queue, 1, far.encode()).unwrap();
        assert_eq!(queue.hear_all()[0].p_world, HERE.p_world);
        let error = queue.take(AgentId(1), None, message(1, 0, 1), None).unwrap_err();
        assert_eq!(error.to_string(), "a message of agent 1 without a physical header");
    }

    fn envelope(src: u16, channel: u8, sequence: u64) -> Envelope {
        Envelope {
            run: RunId(1),
            src: AgentId(src),
            incarnation: Incarnation(0),
            channel: ChannelId(channel),
            sequence,
            step: Step(0),
            time: SimTime(0),
            pose: Pose::level([1.0, 2.0, 3.0], 0.0),
            body: vec![sequence as u8],
        }
    }

    fn message(src: u16, channel: u8, sequence: u64) -> Vec<u8> {
        envelope(src, channel, sequence).encode()
    }

    fn said(agent: u16, next: &[u64]) -> SaidSoFar {
        SaidSoFar { agent: AgentId(agent), incarnation: Incarnation(0), next: next.to_vec() }
    }

    fn take(queue: &mut MessageQueue, src: u16, bytes: Vec<u8>) -> Result<(), QueueError> {
        queue.take(AgentId(src), Some(HERE), bytes, Some(Step(0)))
    }

    fn numbers(heard: &[Said]) -> Vec<u64> {
        heard.iter().map(|said| said.sequence).collect()
    }

    #[test]
    fn what_was_announced_is_heard_once_and_in_order() {
        let mut queue = MessageQueue::default();
        let announced = [said(0, &[9]), said(1, &[2, 1]), said(2, &[1])];
        for (src, channel, sequence) in [(2, 0, 0), (1, 1, 0), (1, 0, 1), (1, 0, 2)] {
            take(&mut queue, src, message(src, channel, sequence)).unwrap();
        }
        let own = AgentId(0);
        assert_eq!(queue.lacks(&announced, own), Some((AgentId(1), ChannelId(0), 0)));
        take(&mut queue, 1, message(1, 0, 0)).unwrap();
        assert_eq!(queue.lacks(&announced, own), None);
        let heard = queue.hear(&announced, own);
        let order: Vec<_> = heard.iter().map(|s| (s.src.0, s.channel.0, s.sequence)).collect();
        assert_eq!(order, [(1, 0, 0), (1, 0, 1), (1, 1, 0), (2, 0, 0)]);
        // Again changes nothing; what was not announced waits.
        take(&mut queue, 1, message(1, 0, 0)).unwrap();
        assert!(queue.hear(&announced, own).is_empty());
        assert_eq!(numbers(&queue.hear_all()), [2]);
    }

    #[test]
    fn who_joins_late_waits_for_nothing_that_was() {
        let mut queue = MessageQueue::default();
        take(&mut queue, 1, message(1, 0, 3)).unwrap();
        queue.skip(&[said(1, &[4])], SimTime(0));
        assert!(queue.hear_all().is_empty());
        assert_eq!(queue.lacks(&[said(1, &[4])], AgentId(0)), None);
        assert!(queue.lacks(&[said(1, &[5])], AgentId(0)).is_some());
    }

    /// Who says what was not announced, in another's name or life, fills no memory for good.
    #[test]
    fn what_was_not_announced_is_forgotten_when_the_next_step_begins() {
        let mut queue = MessageQueue::default();
        let life = Incarnation(7);
        let forged = Envelope { incarnation: life, ..envelope(1, 0, 5) }.encode();
        take(&mut queue, 1, forged).unwrap();
        let next = SimTime(500_000);
        // One that has its frame already speaks before this process has its own.
        let early = Envelope { step: Step(1), time: next, ..envelope(1, 0, 4) }.encode();
        take(&mut queue, 1, early).unwrap();
        queue.skip(&[said(1, &[4])], next);
        assert_eq!((queue.waiting.len(), queue.waiting_bytes > 0), (1, true));
        assert_eq!(numbers(&queue.hear(&[said(1, &[5])], AgentId(0))), [4]);
        assert_eq!(queue.waiting_bytes, 0);
    }

    #[test]
    fn what_no_agent_can_have_said_is_refused() {
        let mut queue = MessageQueue::default();
        let error = take(&mut queue, 1, vec![1, 2]).unwrap_err();
        assert!(matches!(error, QueueError::Envelope(_)), "{error}");
        let error = take(&mut queue, 2, message(1, 0, 0)).unwrap_err();
        assert_eq!(error.to_string(), "a message of agent 1 under the key of agent 2");
        for number in [u64::MAX, u64::MAX - 1, number_limit(Step(0))] {
            let error = take(&mut queue, 1, message(1, 0, number)).unwrap_err();
            assert!(matches!(error, QueueError::Number { .. }), "{error}");
        }
        let forged = Envelope { step: Step(u32::MAX), ..envelope(1, 0, 1 << 40) }.encode();
        let error = take(&mut queue, 1, forged).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a message of agent 1 of step 4294967295, but the newest frame is of step 0"
        );
        assert!(queue.hear_all().is_empty());
    }

    #[test]
    fn the_first_message_with_a_number_counts() {
        let mut queue = MessageQueue::default();
        let forged = Envelope { body: b"forged".to_vec(), ..envelope(1, 0, 0) }.encode();
        take(&mut queue, 1, message(1, 0, 0)).unwrap();
        let error = take(&mut queue, 1, forged.clone()).unwrap_err();
        assert_eq!(error.to_string(), "a second message 0 of agent 1");
        let heard = queue.hear_all();
        assert_eq!(*heard[0].bytes, *message(1, 0, 0));
        assert!(take(&mut queue, 1, forged).is_ok(), "it is older than what was heard: no news");
        assert!(queue.hear_all().is_empty());
    }

    /// Number 4000 is one that the sender might have reached.
    #[test]
    fn a_number_that_is_far_off_mutes_no_sender() {
        let mut queue = MessageQueue::default();
        for number in [0, 4000, 2, 1, 3] {
            take(&mut queue, 1, message(1, 0, number)).unwrap();
            assert_eq!(numbers(&queue.hear_all()), [number]);
        }
        let error = take(&mut queue, 1, message(1, 0, 4000)).unwrap_err();
        assert!(matches!(error, QueueError::Twice { .. }), "{error}");
    }

    #[test]
    fn bytes_that_wait_are_bounded() {
        let mut queue = MessageQueue::default();
        let long = |sequence| Envelope { body: vec![0; 1 << 20], ..envelope(1, 0, sequence) };
        let taken = (0..300).map(|n| take(&mut queue, 1, long(n).encode()));
        let refused = taken.filter(Result::is_err).count();
        assert!((44..48).contains(&refused), "{refused} of 300 MiB do not fit into 256 MiB");
        assert!(queue.waiting_bytes <= MAX_WAITING_BYTES);
        assert_eq!(queue.hear_all().len() + refused, 300);
        take(&mut queue, 1, long(300).encode()).unwrap();
    }

    proptest! {
        /// In real time each message is heard once, whatever their order, and the memory is bounded.
        #[test]
        fn each_number_is_heard_once(order in prop::collection::vec(0_u64..2000, 0..600)) {
            let mut queue = MessageQueue::default();
            let mut seen = BTreeSet::new();
            for number in order {
                let taken = take(&mut queue, 1, message(1, 0, number));
                let heard = numbers(&queue.hear_all());
                let is_new = seen.insert(number);
                prop_assert_eq!(heard.len(), usize::from(is_new));
                prop_assert!(taken.is_ok() || !is_new);
                let state = &queue.heard[&(AgentId(1), Incarnation(0), ChannelId(0))];
                prop_assert!(state.others.len() <= WINDOW);
            }
        }
    }
}
