//! Hashes that identify messages and knowledge.

use xxhash_rust::xxh3::{Xxh3Default, xxh3_128};

/// A hash that identifies its content: 128 bits, so that collisions are negligible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Identity(u128);

impl Identity {
    /// The identity of an encoded message.
    pub fn of(bytes: &[u8]) -> Self {
        Self(xxh3_128(bytes))
    }

    /// The identity of a sequence of parts.
    pub fn of_all(parts: impl IntoIterator<Item = u128>) -> Self {
        let mut hasher = Xxh3Default::new();
        parts.into_iter().for_each(|part| hasher.update(&part.to_le_bytes()));
        Self(hasher.digest128())
    }

    /// The hash.
    pub fn bits(self) -> u128 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_makes_another_identity() {
        assert_ne!(Identity::of_all([1, 2]), Identity::of_all([2, 1]));
        assert_ne!(Identity::of_all([]), Identity::of_all([0]));
    }
}
