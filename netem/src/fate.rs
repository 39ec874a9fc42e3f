//! A message's identity, and the random numbers that belong to it.

use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::SimTime;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A message on its way from one agent to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sent {
    /// The sender.
    pub src: AgentId,
    /// The receiver.
    pub dst: AgentId,
    /// The sender's life.
    pub incarnation: Incarnation,
    /// The radio.
    pub channel: ChannelId,
    /// Its number among the sender's messages on that channel.
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

/// What a random number is for; part of its key, so that rules never share one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Random loss.
    Loss = 0,
}

/// The uniform random number in [0, 1) that belongs to a message and a purpose.
///
/// ChaCha8 keyed by seed, link, life, channel and purpose, at the counter of the sequence number:
/// nothing is drawn in order, so nothing depends on what else is sent.
pub fn uniform(seed: u64, sent: &Sent, purpose: Purpose) -> f64 {
    /// Words of one ChaCha block.
    const BLOCK: u128 = 16;
    let mut key = [0u8; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..10].copy_from_slice(&sent.src.0.to_le_bytes());
    key[10..12].copy_from_slice(&sent.dst.0.to_le_bytes());
    key[12..16].copy_from_slice(&sent.incarnation.0.to_le_bytes());
    key[16] = sent.channel.0;
    key[17] = purpose as u8;
    key[18..].copy_from_slice(b"csat fates v1 ");
    let mut generator = ChaCha8Rng::from_seed(key);
    generator.set_word_pos(u128::from(sent.sequence) * BLOCK);
    generator.random()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

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
    fn numbers_belong_to_messages_and_spread_evenly() {
        let draw = |i| uniform(7, &sent(i), Purpose::Loss);
        assert_eq!(draw(5), draw(5));
        let mean = (0..20_000).map(draw).sum::<f64>() / 20_000.0;
        assert!((mean - 0.5).abs() < 4.0 * (1.0f64 / 12.0 / 20_000.0).sqrt(), "{mean}");
        let other_link = Sent { dst: AgentId(2), ..sent(5) };
        let other_life = Sent { incarnation: Incarnation(1), ..sent(5) };
        for other in [other_link, other_life] {
            assert_ne!(draw(5), uniform(7, &other, Purpose::Loss));
        }
        assert_ne!(draw(5), uniform(8, &sent(5), Purpose::Loss));
    }
}
