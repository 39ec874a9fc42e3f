//! Rules 7 and 8: messages that arrive damaged, and messages that arrive twice.
//!
//! A message is damaged before it is duplicated, so a copy has the same damage as its original.

use crate::config::ChannelConfig;
use crate::draw::{Block, Purpose};
use crate::fate::Reason;
use crate::rule::{Case, Rule};

/// Damages messages. They are delivered; the receiver detects the damage by their checksum.
pub struct Corruption {
    p: f64,
}

impl Corruption {
    /// `None` when nothing is damaged.
    pub fn new(channel: &ChannelConfig) -> Option<Self> {
        (channel.corruption > 0.0).then_some(Self { p: channel.corruption })
    }
}

impl Rule for Corruption {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        // A message without bytes cannot be damaged.
        case.corrupted = case.sent.bytes > 0 && case.block.uniform(Purpose::Corruption) < self.p;
        Ok(())
    }
}

/// Changes one byte; the random numbers of the message choose the byte and its new value.
pub fn damage(bytes: &mut [u8], block: &Block) {
    let bits = block.bits(Purpose::Damage);
    let (place, change) = (bits & 0xFFFF_FFFF, (bits >> 32) % 255 + 1);
    if !bytes.is_empty() {
        let index = (place % bytes.len() as u64) as usize;
        bytes[index] ^= change as u8;
    }
}

/// Duplicates messages.
pub struct Duplication {
    p: f64,
}

impl Duplication {
    /// `None` when nothing is duplicated.
    pub fn new(channel: &ChannelConfig) -> Option<Self> {
        (channel.duplication > 0.0).then_some(Self { p: channel.duplication })
    }
}

impl Rule for Duplication {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        case.duplicated = case.block.uniform(Purpose::Duplication) < self.p;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draws;
    use crate::fate::Sent;
    use crate::fate::tests::sent;
    use crate::rule::tests::judge_alone;

    #[test]
    fn one_byte_is_damaged_always_the_same_one() {
        let mut draws = Draws::of_messages(3, &sent(0));
        let mut places = [0; 20];
        for i in 0..2000 {
            let mut bytes = [7u8; 20];
            damage(&mut bytes, draws.block(i));
            let changed: Vec<usize> = (0..20).filter(|&j| bytes[j] != 7).collect();
            assert_eq!(changed.len(), 1);
            places[changed[0]] += 1;
            let mut again = [7u8; 20];
            damage(&mut again, draws.block(i));
            assert_eq!(again, bytes);
        }
        assert!(places.iter().all(|&n| (50..160).contains(&n)), "{places:?}");
        damage(&mut [], draws.block(0));
    }

    #[test]
    fn shares_are_the_configured_ones() {
        let channel =
            ChannelConfig { corruption: 0.2, duplication: 0.1, ..ChannelConfig::default() };
        let (corruption, duplication) =
            (Corruption::new(&channel).unwrap(), Duplication::new(&channel).unwrap());
        let n = 20_000;
        let share =
            |hit: &dyn Fn(u64) -> bool| (0..n).filter(|&i| hit(i)).count() as f64 / n as f64;
        let corrupted = share(&|i| judge_alone(&corruption, &sent(i)).unwrap().0);
        let duplicated = share(&|i| judge_alone(&duplication, &sent(i)).unwrap().1);
        for (got, p) in [(corrupted, 0.2f64), (duplicated, 0.1)] {
            assert!((got - p).abs() < 4.0 * (p * (1.0 - p) / n as f64).sqrt(), "{got} {p}");
        }
        let empty = Sent { bytes: 0, ..sent(0) };
        let always = Corruption { p: 1.0 };
        assert!(
            !judge_alone(&always, &empty).unwrap().0 && judge_alone(&always, &sent(0)).unwrap().0
        );
    }
}
