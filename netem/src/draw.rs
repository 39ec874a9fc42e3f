//! The random numbers that belong to a message.
//!
//! ChaCha8 keyed by seed, link, incarnation and channel gives one block of 32 words per sequence
//! number. Each purpose has two words of the block at a fixed place; a third of the words is free. No
//! number is drawn in sequence, so none depends on which other messages are sent.

use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::fate::Sent;

/// What a random number is for: its place in the block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The next state of the chain of losses.
    Chain = 0,
    /// Random loss.
    Loss = 1,
    /// Packet errors.
    Propagation = 2,
    /// Jamming.
    Jamming = 3,
    /// Whether the message is damaged.
    Corruption = 4,
    /// Whether it is duplicated.
    Duplication = 5,
    /// Its delay.
    Delay = 6,
    /// Which byte is damaged, and how.
    Damage = 7,
    /// The error of the bearing.
    Bearing = 8,
    /// The error of the offset to the east.
    OffsetEast = 9,
    /// The error of the offset to the north.
    OffsetNorth = 10,
}

impl Purpose {
    /// The last purpose.
    const LAST: Self = Self::OffsetNorth;
}

/// Words of a block. A change of it changes every fate, so there is room for more purposes.
const WORDS: usize = 32;
const _: () = assert!(2 * (Purpose::LAST as usize + 1) <= WORDS, "a purpose without words");
/// Blocks that the generator makes at once: two take about as long as one.
const AT_ONCE: usize = 2;

/// All random numbers of one message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block([u32; WORDS]);

impl Block {
    /// 64 random bits.
    pub fn bits(&self, purpose: Purpose) -> u64 {
        let place = 2 * purpose as usize;
        u64::from(self.0[place]) | u64::from(self.0[place + 1]) << 32
    }

    /// A number in (0, 1), never 0 nor 1: the middle of one of 2⁵² equal parts.
    pub fn uniform(&self, purpose: Purpose) -> f64 {
        const PART: f64 = 1.0 / (1u64 << 52) as f64;
        ((self.bits(purpose) >> 12) as f64 + 0.5) * PART
    }

    /// A standard normal number.
    pub fn normal(&self, purpose: Purpose) -> f64 {
        normal_quantile(self.uniform(purpose))
    }
}

/// Φ⁻¹(u), for u in (0, 1).
pub fn normal_quantile(u: f64) -> f64 {
    -std::f64::consts::SQRT_2 * statrs::function::erf::erfc_inv(2.0 * u)
}

/// Φ(z).
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// The random numbers of a link for one incarnation of its sender, by sequence number.
#[derive(Debug, Clone)]
pub struct Draws {
    generator: ChaCha8Rng,
    /// The sequence number of the first of `blocks`, which are the blocks of the last query.
    first: Option<u64>,
    blocks: [Block; AT_ONCE],
}

impl Draws {
    /// The random numbers of the messages of the same link, incarnation and channel as `sent`.
    pub fn of_messages(seed: u64, sent: &Sent) -> Self {
        Self::new(ChaCha8Rng::from_seed(key(seed, sent, *b"csat fates v3  ")))
    }

    /// The random numbers of the copies that the link makes of such messages.
    pub fn of_copies(seed: u64, sent: &Sent) -> Self {
        Self::new(ChaCha8Rng::from_seed(key(seed, sent, *b"csat copies v3 ")))
    }

    fn new(generator: ChaCha8Rng) -> Self {
        Self { generator, first: None, blocks: [Block([0; WORDS]); AT_ONCE] }
    }

    /// The random numbers of a sequence number.
    #[inline]
    pub fn block(&mut self, sequence: u64) -> &Block {
        let first = sequence - sequence % AT_ONCE as u64;
        if self.first != Some(first) {
            self.fill(first);
        }
        &self.blocks[(sequence - first) as usize]
    }

    fn fill(&mut self, first: u64) {
        self.generator.set_word_pos(u128::from(first) * WORDS as u128);
        for Block(words) in &mut self.blocks {
            words.fill_with(|| self.generator.next_u32());
        }
        self.first = Some(first);
    }
}

fn key(seed: u64, sent: &Sent, tag: [u8; 15]) -> [u8; 32] {
    let mut key = [0u8; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..10].copy_from_slice(&sent.src.0.to_le_bytes());
    key[10..12].copy_from_slice(&sent.dst.0.to_le_bytes());
    key[12..16].copy_from_slice(&sent.incarnation.0.to_le_bytes());
    key[16] = sent.channel.0;
    key[17..].copy_from_slice(&tag);
    key
}

/// 64 random bits of a link. They are the same for all incarnations of its ends and differ per
/// direction.
pub fn of_link(seed: u64, sent: &Sent) -> u64 {
    let any_incarnation = Sent { incarnation: Incarnation(0), ..*sent };
    ChaCha8Rng::from_seed(key(seed, &any_incarnation, *b"csat links v2  ")).next_u64()
}

/// A standard normal number of an unordered pair of agents at a pair of cells. The cell of the
/// agent of the lower index comes first.
pub fn of_place(seed: u64, pair: [AgentId; 2], channel: ChannelId, cells: [[i32; 3]; 2]) -> f64 {
    let mut first = [0u8; 32];
    first[..8].copy_from_slice(&seed.to_le_bytes());
    first[8..10].copy_from_slice(&pair[0].0.to_le_bytes());
    first[10..12].copy_from_slice(&pair[1].0.to_le_bytes());
    first[12] = channel.0;
    first[17..].copy_from_slice(b"csat places v2 ");
    // A key has no room for two cells: the block of the first cell is the key of the second one.
    let mut generator = cells.iter().fold(ChaCha8Rng::from_seed(first), |generator, cell| {
        let mut at_cell = at_cell(generator, *cell);
        let mut key = [0u8; 32];
        at_cell.fill_bytes(&mut key);
        ChaCha8Rng::from_seed(key)
    });
    let mut words = [0; WORDS];
    words.fill_with(|| generator.next_u32());
    Block(words).normal(Purpose::Propagation)
}

fn at_cell(mut generator: ChaCha8Rng, [x, y, z]: [i32; 3]) -> ChaCha8Rng {
    let bits = |i: i32| u64::from(i.cast_unsigned());
    generator.set_stream(bits(x) | bits(y) << 32);
    generator.set_word_pos(u128::from(bits(z)) * WORDS as u128);
    generator
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fate::tests::sent;

    fn uniform(seed: u64, sent: &Sent, purpose: Purpose) -> f64 {
        Draws::of_messages(seed, sent).block(sent.sequence).uniform(purpose)
    }

    #[test]
    fn numbers_belong_to_messages_and_spread_evenly() {
        let draw = |i| uniform(7, &sent(i), Purpose::Loss);
        assert_eq!(draw(5), draw(5));
        let mean = (0..20_000).map(draw).sum::<f64>() / 20_000.0;
        assert!((mean - 0.5).abs() < 4.0 * (1.0f64 / 12.0 / 20_000.0).sqrt(), "{mean}");
        let others = [
            Sent { dst: AgentId(2), ..sent(5) },
            Sent { src: AgentId(2), ..sent(5) },
            Sent { src: AgentId(1), dst: AgentId(0), ..sent(5) },
            Sent { incarnation: Incarnation(1), ..sent(5) },
            Sent { channel: ChannelId(1), ..sent(5) },
        ];
        for other in others {
            assert_ne!(draw(5), uniform(7, &other, Purpose::Loss));
        }
        assert_ne!(draw(5), uniform(8, &sent(5), Purpose::Loss));
        assert_ne!(draw(5), uniform(7, &sent(5), Purpose::Chain));
        assert_ne!(draw(5), Draws::of_copies(7, &sent(5)).block(5).uniform(Purpose::Loss));
    }

    /// Seeking in the stream changes no block.
    #[test]
    fn any_order_gives_the_same_blocks() {
        let mut draws = Draws::of_messages(7, &sent(0));
        let forward: Vec<Block> = (0..40).map(|i| *draws.block(i)).collect();
        for i in (0..40u64).rev().chain([3, 17, 3, 39]) {
            assert_eq!(*draws.block(i), forward[i as usize]);
            assert_eq!(*Draws::of_messages(7, &sent(0)).block(i), forward[i as usize]);
        }
        // The greatest sequence number has a block too.
        assert_ne!(*draws.block(u64::MAX), forward[0]);
    }

    #[test]
    fn the_ends_of_the_unit_interval_are_never_drawn() {
        assert!(Block([u32::MAX; WORDS]).uniform(Purpose::Delay) < 1.0);
        assert!(Block([0; WORDS]).uniform(Purpose::Delay) > 0.0);
        assert!(Block([u32::MAX; WORDS]).normal(Purpose::Delay).is_finite());
        assert!(Block([0; WORDS]).normal(Purpose::Delay).is_finite());
    }

    #[test]
    fn the_normal_distribution_is_the_one_of_the_tables() {
        for (z, cdf) in [(0.0, 0.5), (1.0, 0.841344746068543), (-2.5, 0.006209665325776)] {
            assert!((normal_cdf(z) - cdf).abs() < 1e-14);
            assert!((normal_quantile(cdf) - z).abs() < 1e-12);
        }
    }

    #[test]
    fn places_are_kept_and_differ() {
        let pair = [AgentId(0), AgentId(1)];
        let draw = |cells| of_place(7, pair, ChannelId(0), cells);
        let here = [[1, 2, 3], [4, 5, 6]];
        assert_eq!(draw(here), draw(here));
        let others = [
            [[-1, 2, 3], [4, 5, 6]],
            [[1, 2, 2], [4, 5, 6]],
            [[1, 2, 3], [4, 5, 7]],
            [[4, 5, 6], [1, 2, 3]],
        ];
        assert!(others.iter().all(|&other| draw(other) != draw(here)));
        let n = 4000;
        let all: Vec<f64> = (0..n).map(|i| draw([[i, 0, 0], [0, -i, 1]])).collect();
        let mean = all.iter().sum::<f64>() / f64::from(n);
        let variance = all.iter().map(|z| z * z).sum::<f64>() / f64::from(n);
        assert!(mean.abs() < 4.0 / f64::from(n).sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / f64::from(n)).sqrt(), "{variance}");
    }
}
