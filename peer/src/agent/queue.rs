//! The messages of other agents until the agent's links take them.
//!
//! Zenoh delivers messages in any order. The links take them in the order of sender, radio and number,
//! and in lockstep not before all that the world announced are here.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use csat_proto::control::{SaidSoFar, number_limit};
use csat_proto::envelope::{Envelope, EnvelopeError};
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::{SimTime, Step};

use super::input::RawMessage;
use csat_mission::node::Said;

/// The most messages that wait.
const MAX_WAITING: usize = 65_536;
/// The most bytes that wait.
const MAX_WAITING_BYTES: usize = 256 << 20;
/// The most streams that are known.
const MAX_STREAMS: usize = 4096;
/// How many messages that were taken out of order are remembered of each stream.
const WINDOW: usize = 1024;
/// In lockstep, how far ahead of this process's newest frame another agent may be, steps.
const MAX_AHEAD: u32 = 64;

/// Sender, life and radio.
type Stream = (AgentId, Incarnation, ChannelId);

/// Messages that wait for the links.
#[derive(Debug, Default)]
pub struct MessageQueue {
    waiting: BTreeMap<(Stream, u64), Said>,
    waiting_bytes: usize,
    taken: BTreeMap<Stream, Taken>,
}

/// The numbers of a stream whose messages were taken.
#[derive(Debug, Default)]
struct Taken {
    /// All below this one were taken, or are out of date.
    below: u64,
    /// Others that were taken.
    others: BTreeSet<u64>,
}

impl Taken {
    fn contains(&self, number: u64) -> bool {
        number < self.below || self.others.contains(&number)
    }

    fn skip_to(&mut self, next: u64) {
        self.below = self.below.max(next);
        self.others = self.others.split_off(&self.below);
    }

    /// Numbers that were left out may still come, so that one far ahead does not mute its sender.
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

/// Why a message is refused.
#[derive(Debug, thiserror::Error)]
pub enum QueueError {
    /// It is no message.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// It names another sender than its key.
    #[error("a message of agent {got} under the key of agent {key}")]
    Forged {
        /// The sender that it names.
        got: AgentId,
        /// The sender of its key.
        key: AgentId,
    },
    /// Its attachment does not say where it was sent.
    #[error("a message of agent {from} without a physical header")]
    Physical {
        /// Its sender.
        from: AgentId,
    },
    /// No agent sends so many messages.
    #[error("message {number} of agent {from} at step {step}: it can have said {max} by then")]
    Number {
        /// Its sender.
        from: AgentId,
        /// Its number.
        number: u64,
        /// Its step.
        step: Step,
        /// The limit of numbers at that step.
        max: u64,
    },
    /// No agent is so far ahead.
    #[error("a message of agent {from} of step {step}, but the newest frame is of step {newest}")]
    Ahead {
        /// Its sender.
        from: AgentId,
        /// Its step.
        step: Step,
        /// That of this process's newest frame.
        newest: Step,
    },
    /// Another message with this number came before.
    #[error("a second message {number} of agent {from}")]
    Twice {
        /// Its sender.
        from: AgentId,
        /// Its number.
        number: u64,
    },
    /// The queue is full.
    #[error("{messages} messages of {bytes} bytes wait already, of {streams} senders' lives")]
    Full {
        /// How many messages wait.
        messages: usize,
        /// How long they are.
        bytes: usize,
        /// How many streams are known.
        streams: usize,
    },
}

impl MessageQueue {
    /// Adds a message; the first one with its number counts. `newest` is the step of this process's newest
    /// frame, `None` if other agents may be far ahead of it.
    ///
    /// # Errors
    /// When the message is refused.
    pub fn push(&mut self, message: RawMessage, newest: Option<Step>) -> Result<(), QueueError> {
        let (said, step) = read(message)?;
        let (from, number) = (said.src, said.sequence);
        let max = number_limit(step);
        if number >= max {
            return Err(QueueError::Number { from, number, step, max });
        }
        if let Some(newest) = newest.filter(|newest| step.0 > newest.0.saturating_add(MAX_AHEAD)) {
            return Err(QueueError::Ahead { from, step, newest });
        }
        let stream = (from, said.incarnation, said.channel);
        let taken = self.taken.get(&stream);
        if taken.is_some_and(|taken| number < taken.below) {
            return Ok(());
        }
        let is_known = taken.is_some_and(|taken| taken.contains(number));
        if is_known || self.waiting.contains_key(&(stream, number)) {
            return Err(QueueError::Twice { from, number });
        }
        let (messages, bytes) = (self.waiting.len(), self.waiting_bytes);
        let is_crowded = taken.is_none() && self.taken.len() >= MAX_STREAMS;
        if is_crowded || messages >= MAX_WAITING || bytes + said.bytes.len() > MAX_WAITING_BYTES {
            return Err(QueueError::Full { messages, bytes, streams: self.taken.len() });
        }
        self.waiting_bytes += said.bytes.len();
        self.waiting.insert((stream, number), said);
        Ok(())
    }

    /// A step begins at `now`: drops the messages of before, which `said` counts.
    pub fn skip(&mut self, said: &[SaidSoFar], now: SimTime) {
        for (stream, next) in streams(said) {
            self.taken.entry(stream).or_default().skip_to(next);
        }
        let taken = &self.taken;
        self.waiting.retain(|(stream, number), said| {
            said.time >= now && !taken.get(stream).is_some_and(|taken| taken.contains(*number))
        });
        self.waiting_bytes = self.waiting.values().map(|said| said.bytes.len()).sum();
    }

    /// The first message that `said` announces and that is not here, other than those of agent `own`.
    pub fn first_missing(
        &self,
        said: &[SaidSoFar],
        own: AgentId,
    ) -> Option<(AgentId, ChannelId, u64)> {
        streams(said).filter(|((src, ..), _)| *src != own).find_map(|(stream, next)| {
            let mut open = self.below(stream)..next;
            let missing = open.find(|number| !self.waiting.contains_key(&(stream, *number)));
            missing.map(|number| (stream.0, stream.2, number))
        })
    }

    fn below(&self, stream: Stream) -> u64 {
        self.taken.get(&stream).map_or(0, |taken| taken.below)
    }

    /// Takes the messages that `said` announces, by sender, radio and number; none may be missing.
    pub fn take(&mut self, said: &[SaidSoFar], own: AgentId) -> Vec<Said> {
        let mut all = Vec::new();
        for (stream, next) in streams(said).filter(|((src, ..), _)| *src != own) {
            let open = self.below(stream)..next;
            all.extend(open.map_while(|number| self.waiting.remove(&(stream, number))));
            self.taken.entry(stream).or_default().skip_to(next);
        }
        self.waiting_bytes -= all.iter().map(|said| said.bytes.len()).sum::<usize>();
        all
    }

    /// Takes all messages, by sender, life, radio and number.
    pub fn take_all(&mut self) -> Vec<Said> {
        for &(stream, number) in self.waiting.keys() {
            self.taken.entry(stream).or_default().add(number);
        }
        self.waiting_bytes = 0;
        std::mem::take(&mut self.waiting).into_values().collect()
    }
}

/// A message with what its envelope says of it, and its step.
///
/// # Errors
/// When it is no message, names another sender than its key, or does not say where it was sent.
pub fn read(message: RawMessage) -> Result<(Said, Step), QueueError> {
    let RawMessage { key, physical, bytes } = message;
    let envelope = Envelope::decode(&bytes)?;
    let Envelope { src, incarnation, channel, sequence, step, time, .. } = envelope;
    if src != key {
        return Err(QueueError::Forged { got: src, key });
    }
    let PhysicalHeader { p_world } = physical.ok_or(QueueError::Physical { from: src })?;
    let bytes = Arc::from(bytes);
    Ok((Said { src, incarnation, channel, sequence, time, p_world, bytes }, step))
}

/// The streams that `said` counts, with the number of the next message of each.
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

    /// The pose that an agent believes, or claims, does not decide what its radio reaches.
    #[test]
    fn the_place_of_a_sender_is_the_one_of_the_physical_header() {
        let mut queue = MessageQueue::default();
        let far = Envelope { pose: Pose::level([9e5, 0.0, 3.0], 0.0).into(), ..envelope(1, 0, 0) };
        push(&mut queue, 1, far.encode()).unwrap();
        assert_eq!(queue.take_all()[0].p_world, HERE.p_world);
        let nowhere = RawMessage { key: AgentId(1), physical: None, bytes: message(1, 0, 1) };
        let error = queue.push(nowhere, None).unwrap_err();
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
            pose: Pose::level([1.0, 2.0, 3.0], 0.0).into(),
            body: vec![sequence as u8],
        }
    }

    fn message(src: u16, channel: u8, sequence: u64) -> Vec<u8> {
        envelope(src, channel, sequence).encode()
    }

    fn said(agent: u16, next: &[u64]) -> SaidSoFar {
        SaidSoFar { agent: AgentId(agent), incarnation: Incarnation(0), next: next.to_vec() }
    }

    fn push(queue: &mut MessageQueue, src: u16, bytes: Vec<u8>) -> Result<(), QueueError> {
        let message = RawMessage { key: AgentId(src), physical: Some(HERE), bytes };
        queue.push(message, Some(Step(0)))
    }

    fn numbers(said: &[Said]) -> Vec<u64> {
        said.iter().map(|said| said.sequence).collect()
    }

    #[test]
    fn announced_messages_are_taken_once_and_in_order() {
        let mut queue = MessageQueue::default();
        let announced = [said(0, &[9]), said(1, &[2, 1]), said(2, &[1])];
        for (src, channel, sequence) in [(2, 0, 0), (1, 1, 0), (1, 0, 1), (1, 0, 2)] {
            push(&mut queue, src, message(src, channel, sequence)).unwrap();
        }
        let own = AgentId(0);
        assert_eq!(queue.first_missing(&announced, own), Some((AgentId(1), ChannelId(0), 0)));
        push(&mut queue, 1, message(1, 0, 0)).unwrap();
        assert_eq!(queue.first_missing(&announced, own), None);
        let taken = queue.take(&announced, own);
        let order: Vec<_> = taken.iter().map(|s| (s.src.0, s.channel.0, s.sequence)).collect();
        assert_eq!(order, [(1, 0, 0), (1, 0, 1), (1, 1, 0), (2, 0, 0)]);
        // A repeat changes nothing; a message that was not announced waits.
        push(&mut queue, 1, message(1, 0, 0)).unwrap();
        assert!(queue.take(&announced, own).is_empty());
        assert_eq!(numbers(&queue.take_all()), [2]);
    }

    #[test]
    fn a_process_that_joins_late_waits_for_no_earlier_message() {
        let mut queue = MessageQueue::default();
        push(&mut queue, 1, message(1, 0, 3)).unwrap();
        queue.skip(&[said(1, &[4])], SimTime(0));
        assert!(queue.take_all().is_empty());
        assert_eq!(queue.first_missing(&[said(1, &[4])], AgentId(0)), None);
        assert!(queue.first_missing(&[said(1, &[5])], AgentId(0)).is_some());
    }

    /// Messages that were not announced, of another name or life, do not stay in memory.
    #[test]
    fn messages_that_were_not_announced_are_dropped_when_the_next_step_begins() {
        let mut queue = MessageQueue::default();
        let life = Incarnation(7);
        let forged = Envelope { incarnation: life, ..envelope(1, 0, 5) }.encode();
        push(&mut queue, 1, forged).unwrap();
        let next = SimTime(500_000);
        // An agent that has its frame already sends before this process has its own.
        let early = Envelope { step: Step(1), time: next, ..envelope(1, 0, 4) }.encode();
        push(&mut queue, 1, early).unwrap();
        queue.skip(&[said(1, &[4])], next);
        assert_eq!((queue.waiting.len(), queue.waiting_bytes > 0), (1, true));
        assert_eq!(numbers(&queue.take(&[said(1, &[5])], AgentId(0))), [4]);
        assert_eq!(queue.waiting_bytes, 0);
    }

    #[test]
    fn messages_that_no_agent_can_have_sent_are_refused() {
        let mut queue = MessageQueue::default();
        let error = push(&mut queue, 1, vec![1, 2]).unwrap_err();
        assert!(matches!(error, QueueError::Envelope(_)), "{error}");
        let error = push(&mut queue, 2, message(1, 0, 0)).unwrap_err();
        assert_eq!(error.to_string(), "a message of agent 1 under the key of agent 2");
        for number in [u64::MAX, u64::MAX - 1, number_limit(Step(0))] {
            let error = push(&mut queue, 1, message(1, 0, number)).unwrap_err();
            assert!(matches!(error, QueueError::Number { .. }), "{error}");
        }
        let forged = Envelope { step: Step(u32::MAX), ..envelope(1, 0, 1 << 40) }.encode();
        let error = push(&mut queue, 1, forged).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a message of agent 1 of step 4294967295, but the newest frame is of step 0"
        );
        assert!(queue.take_all().is_empty());
    }

    #[test]
    fn the_first_message_with_a_number_counts() {
        let mut queue = MessageQueue::default();
        let forged = Envelope { body: b"forged".to_vec(), ..envelope(1, 0, 0) }.encode();
        push(&mut queue, 1, message(1, 0, 0)).unwrap();
        let error = push(&mut queue, 1, forged.clone()).unwrap_err();
        assert_eq!(error.to_string(), "a second message 0 of agent 1");
        let taken = queue.take_all();
        assert_eq!(*taken[0].bytes, *message(1, 0, 0));
        assert!(
            push(&mut queue, 1, forged).is_ok(),
            "older messages were taken: it is out of date"
        );
        assert!(queue.take_all().is_empty());
    }

    /// The sender might have reached number 4000.
    #[test]
    fn a_number_that_is_far_off_mutes_no_sender() {
        let mut queue = MessageQueue::default();
        for number in [0, 4000, 2, 1, 3] {
            push(&mut queue, 1, message(1, 0, number)).unwrap();
            assert_eq!(numbers(&queue.take_all()), [number]);
        }
        let error = push(&mut queue, 1, message(1, 0, 4000)).unwrap_err();
        assert!(matches!(error, QueueError::Twice { .. }), "{error}");
    }

    #[test]
    fn bytes_that_wait_are_bounded() {
        let mut queue = MessageQueue::default();
        let long = |sequence| Envelope { body: vec![0; 1 << 20], ..envelope(1, 0, sequence) };
        let taken = (0..300).map(|n| push(&mut queue, 1, long(n).encode()));
        let refused = taken.filter(Result::is_err).count();
        assert!((44..48).contains(&refused), "{refused} of 300 MiB do not fit into 256 MiB");
        assert!(queue.waiting_bytes <= MAX_WAITING_BYTES);
        assert_eq!(queue.take_all().len() + refused, 300);
        push(&mut queue, 1, long(300).encode()).unwrap();
    }

    proptest! {
        /// In real time each message is taken once, whatever their order, and the memory is bounded.
        #[test]
        fn each_number_is_taken_once(order in prop::collection::vec(0_u64..2000, 0..600)) {
            let mut queue = MessageQueue::default();
            let mut seen = BTreeSet::new();
            for number in order {
                let pushed = push(&mut queue, 1, message(1, 0, number));
                let taken = numbers(&queue.take_all());
                let is_new = seen.insert(number);
                prop_assert_eq!(taken.len(), usize::from(is_new));
                prop_assert!(pushed.is_ok() || !is_new);
                let state = &queue.taken[&(AgentId(1), Incarnation(0), ChannelId(0))];
                prop_assert!(state.others.len() <= WINDOW);
            }
        }
    }
}
