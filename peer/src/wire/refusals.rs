//! Samples that a process refuses: counted by kind, some of them logged.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Arc, Mutex, PoisonError};

/// Counts by kind; clones share them.
#[derive(Debug, Clone, Default)]
pub struct Refusals(Arc<Mutex<BTreeMap<String, u64>>>);

impl Refusals {
    /// Counts a refusal, and logs it if [`is_logged`] says so.
    pub fn count(&self, kind: &str, reason: &dyn Display) {
        let mut counts = self.lock();
        let count = counts.entry(kind.to_owned()).or_default();
        *count += 1;
        if is_logged(*count) {
            tracing::warn!(kind, %reason, times = *count, "refused");
        }
    }

    /// How many refusals of each kind there were so far.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        self.lock().clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, u64>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether the event of this number, from 1, is logged: the first, second, fourth, eighth..., because a
/// flood of samples must not become a flood of lines.
pub fn is_logged(number: u64) -> bool {
    number.is_power_of_two()
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

    #[test]
    fn a_million_events_are_twenty_lines() {
        assert_eq!((1..=1_000_000).filter(|number| is_logged(*number)).count(), 20);
    }
}
