//! What others say on the links, until it is heard.
//!
//! Messages come by Zenoh in whatever order; an agent's links are told in the order of sender, radio
//! and number, and in lockstep not before all that was announced is here.

use std::collections::BTreeMap;
use std::sync::Arc;

use csat_proto::control::SaidSoFar;
use csat_proto::envelope::{Envelope, EnvelopeError};
use csat_proto::ids::{AgentId, ChannelId, Incarnation};

use crate::seat::Said;

/// The most messages that wait to be heard.
const MAX_WAITING: usize = 65_536;

/// Sender, life and radio.
type Stream = (AgentId, Incarnation, ChannelId);

/// Messages that wait to be heard.
#[derive(Debug, Default)]
pub struct Ether {
    waiting: BTreeMap<(Stream, u64), Said>,
    /// By stream, the number of the next message to be heard.
    next: BTreeMap<Stream, u64>,
    /// Messages that were not kept.
    refused: u64,
}

/// Why a message was not kept.
#[derive(Debug, thiserror::Error)]
pub enum EtherError {
    /// It is no message.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// It does not say of itself what its key says of it.
    #[error("a message of UAV {got} under the key of UAV {key}")]
    Forged {
        /// Whose it says it is.
        got: AgentId,
        /// Under whose key it came.
        key: AgentId,
    },
    /// Too many wait.
    #[error("{MAX_WAITING} messages wait already")]
    Full,
}

impl Ether {
    /// Takes a message that came under the key of `key`.
    ///
    /// # Errors
    /// When it is not kept, which is counted.
    pub fn take(&mut self, key: AgentId, bytes: Vec<u8>) -> Result<(), EtherError> {
        let taken = self.file(key, bytes);
        self.refused += u64::from(taken.is_err());
        taken
    }

    fn file(&mut self, key: AgentId, bytes: Vec<u8>) -> Result<(), EtherError> {
        let said = read(key, bytes)?;
        if self.waiting.len() >= MAX_WAITING {
            return Err(EtherError::Full);
        }
        let stream = (said.src, said.incarnation, said.channel);
        if said.sequence >= self.next.get(&stream).copied().unwrap_or_default() {
            self.waiting.insert((stream, said.sequence), said);
        }
        Ok(())
    }

    /// How many messages were not kept.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Whatever was said before `said` need not be heard.
    pub fn skip(&mut self, said: &[SaidSoFar]) {
        for (stream, next) in streams(said) {
            let known = self.next.entry(stream).or_default();
            *known = next.max(*known);
        }
        let next = &self.next;
        self.waiting
            .retain(|(stream, number), _| next.get(stream).is_none_or(|next| number >= next));
    }

    /// The first message that `said` announces and that is not here, but for those of `own`.
    pub fn lacks(&self, said: &[SaidSoFar], own: AgentId) -> Option<(AgentId, ChannelId, u64)> {
        streams(said).filter(|((src, ..), _)| *src != own).find_map(|(stream, next)| {
            let from = self.next.get(&stream).copied().unwrap_or_default();
            let lacked = (from..next).find(|number| !self.waiting.contains_key(&(stream, *number)));
            lacked.map(|number| (stream.0, stream.2, number))
        })
    }

    /// Takes what `said` announces and is here, by sender, radio and number.
    pub fn hear(&mut self, said: &[SaidSoFar], own: AgentId) -> Vec<Said> {
        let mut heard = Vec::new();
        for (stream, next) in streams(said).filter(|((src, ..), _)| *src != own) {
            let from = self.next.get(&stream).copied().unwrap_or_default();
            heard.extend((from..next).filter_map(|n| self.waiting.remove(&(stream, n))));
            self.next.insert(stream, next.max(from));
        }
        heard
    }

    /// Takes all that is here, by sender, life, radio and number.
    pub fn hear_all(&mut self) -> Vec<Said> {
        for &(stream, number) in self.waiting.keys() {
            self.next.insert(stream, number + 1);
        }
        std::mem::take(&mut self.waiting).into_values().collect()
    }
}

/// What the header of a message that came under the key of `key` says.
///
/// # Errors
/// When it is no message, or another agent's.
pub fn read(key: AgentId, bytes: Vec<u8>) -> Result<Said, EtherError> {
    let envelope = Envelope::decode(&bytes)?;
    let Envelope { src, incarnation, channel, sequence, time, pose, .. } = envelope;
    if src != key {
        return Err(EtherError::Forged { got: src, key });
    }
    let bytes = Arc::from(bytes);
    Ok(Said { src, incarnation, channel, sequence, time, p_world: pose.p_world, bytes })
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
    use csat_proto::time::{SimTime, Step};

    fn message(src: u16, channel: u8, sequence: u64) -> Vec<u8> {
        let envelope = Envelope {
            run: RunId(1),
            src: AgentId(src),
            incarnation: Incarnation(0),
            channel: ChannelId(channel),
            sequence,
            step: Step(0),
            time: SimTime(0),
            pose: Pose::level([1.0, 2.0, 3.0], 0.0),
            body: vec![sequence as u8],
        };
        envelope.encode()
    }

    fn said(agent: u16, next: &[u64]) -> SaidSoFar {
        SaidSoFar { agent: AgentId(agent), incarnation: Incarnation(0), next: next.to_vec() }
    }

    #[test]
    fn what_was_announced_is_heard_once_and_in_order() {
        let mut ether = Ether::default();
        let announced = [said(0, &[9]), said(1, &[2, 1]), said(2, &[1])];
        for (src, channel, sequence) in [(2, 0, 0), (1, 1, 0), (1, 0, 1), (1, 0, 2)] {
            ether.take(AgentId(src), message(src, channel, sequence)).unwrap();
        }
        let own = AgentId(0);
        assert_eq!(ether.lacks(&announced, own), Some((AgentId(1), ChannelId(0), 0)));
        ether.take(AgentId(1), message(1, 0, 0)).unwrap();
        assert_eq!(ether.lacks(&announced, own), None);
        let heard = ether.hear(&announced, own);
        let order: Vec<_> = heard.iter().map(|s| (s.src.0, s.channel.0, s.sequence)).collect();
        assert_eq!(order, [(1, 0, 0), (1, 0, 1), (1, 1, 0), (2, 0, 0)]);
        // Again changes nothing; what was not announced waits.
        ether.take(AgentId(1), message(1, 0, 0)).unwrap();
        assert!(ether.hear(&announced, own).is_empty());
        assert_eq!(ether.hear_all().iter().map(|s| s.sequence).collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn who_joins_late_waits_for_nothing_that_was() {
        let mut ether = Ether::default();
        ether.take(AgentId(1), message(1, 0, 3)).unwrap();
        ether.skip(&[said(1, &[4])]);
        assert!(ether.hear_all().is_empty());
        assert_eq!(ether.lacks(&[said(1, &[4])], AgentId(0)), None);
        assert!(ether.lacks(&[said(1, &[5])], AgentId(0)).is_some());
    }

    #[test]
    fn what_is_no_message_is_counted() {
        let mut ether = Ether::default();
        assert!(matches!(ether.take(AgentId(1), vec![1, 2]), Err(EtherError::Envelope(_))));
        let forged = ether.take(AgentId(2), message(1, 0, 0)).unwrap_err();
        assert_eq!(forged.to_string(), "a message of UAV 1 under the key of UAV 2");
        assert_eq!((ether.refused(), ether.hear_all().len()), (2, 0));
    }
}
