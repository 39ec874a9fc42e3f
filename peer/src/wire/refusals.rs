//! What a process does not believe of what others say: counted, and told now and then.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Arc, Mutex, PoisonError};

/// Counts by kind; clones share them.
#[derive(Debug, Clone, Default)]
pub struct Refusals(Arc<Mutex<BTreeMap<String, u64>>>);

impl Refusals {
    /// Counts one of a kind. The first, second, fourth, eighth... is told, for a flood must not turn into
    /// another one.
    pub fn count(&self, kind: &str, reason: &dyn Display) {
        let mut counts = self.lock();
        let count = counts.entry(kind.to_owned()).or_default();
        *count += 1;
        if count.is_power_of_two() {
            tracing::warn!(kind, %reason, times = *count, "refused");
        }
    }

    /// How many of each kind so far.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        self.lock().clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, u64>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Adds counts by kind to others.
pub fn add(to: &mut BTreeMap<String, u64>, more: &BTreeMap<String, u64>) {
    for (kind, count) in more {
        *to.entry(kind.clone()).or_default() += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_counted_apart_and_summed() {
        let refusals = Refusals::default();
        for kind in ["frame", "order", "frame"] {
            refusals.clone().count(kind, &"too far");
        }
        let mut all = BTreeMap::from([("frame".to_owned(), 40)]);
        add(&mut all, &refusals.counts());
        assert_eq!(all, BTreeMap::from([("frame".to_owned(), 42), ("order".to_owned(), 1)]));
    }
}
