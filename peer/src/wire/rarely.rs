//! Complaints that a flood must not turn into another flood.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counts complaints and picks out the first, second, fourth, eighth...
#[derive(Debug, Default)]
pub struct Rarely(AtomicU64);

impl Rarely {
    /// Before the first one.
    pub const fn new() -> Self {
        Self(AtomicU64::new(0))
    }

    /// Another one: how many there were if it is to be told.
    pub fn another(&self) -> Option<u64> {
        let count = self.0.fetch_add(1, Ordering::Relaxed) + 1;
        count.is_power_of_two().then_some(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_complaints_are_twenty_lines() {
        let rarely = Rarely::default();
        let told: Vec<u64> = (0..1_000_000).filter_map(|_| rarely.another()).collect();
        assert_eq!((told.len(), &told[..4]), (20, &[1, 2, 4, 8][..]));
    }
}
