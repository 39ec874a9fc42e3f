//! Which facts the agent's own knowledge contains: a version vector.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::HeldFacts;

use crate::config::AgentConfig;
use crate::mutant::{Mutant, is_on};

/// Incarnations that are remembered per agent: whatever messages claim, memory and digests stay
/// bounded.
pub const MAX_INCARNATIONS: usize = 64;

/// Per incarnation of each agent, the facts that the own knowledge contains.
#[derive(Debug, Clone)]
pub struct VersionVector {
    entries: BTreeMap<(AgentId, Incarnation), VersionEntry>,
    /// How many numbers are remembered per incarnation: those of facts young enough to be accepted.
    window: usize,
}

#[derive(Debug, Clone, Default)]
struct VersionEntry {
    /// Facts 0 to `count` - 1 are contained, applied one by one or through a snapshot.
    count: u32,
    /// The greatest numbers of facts that were applied one by one.
    applied: BTreeSet<u32>,
}

impl VersionEntry {
    /// Advances `count` over the facts that were applied.
    fn count_on(&mut self) {
        while self.count < u32::MAX && self.applied.contains(&self.count) {
            self.count += 1;
        }
    }
}

impl VersionVector {
    /// A version vector without any fact.
    pub fn new(config: &AgentConfig) -> Self {
        let window = config.steps(config.exchange.max_age_s).max(1) as usize + 2;
        Self { entries: BTreeMap::new(), window }
    }

    /// Whether a fact was applied already; a repeat would change nothing.
    pub fn has_applied(&self, src: AgentId, incarnation: Incarnation, number: u32) -> bool {
        if is_on(Mutant::RepeatsOfOtherIncarnationsIgnored) {
            return self
                .entries
                .iter()
                .any(|((of, _), entry)| *of == src && entry.applied.contains(&number));
        }
        self.entries.get(&(src, incarnation)).is_some_and(|entry| entry.applied.contains(&number))
    }

    /// A fact was applied.
    pub fn apply(&mut self, src: AgentId, incarnation: Incarnation, number: u32) {
        let window = self.window;
        let entry = self.entry(src, incarnation);
        entry.applied.insert(number);
        entry.count_on();
        while entry.applied.len() > window {
            entry.applied.pop_first();
        }
    }

    /// A snapshot that contains these facts was applied.
    pub fn adopt(&mut self, facts: &[HeldFacts]) {
        for facts in facts {
            let entry = self.entry(facts.origin, facts.incarnation);
            entry.count = entry.count.max(facts.count);
            entry.count_on();
        }
    }

    /// A snapshot was applied that counts as the claim of `src`, whoever told it what it contains. So
    /// of the facts that it contains, only those that `src` stated are contained.
    pub fn adopt_own(&mut self, src: AgentId, incarnation: Incarnation, facts: &[HeldFacts]) {
        let key = (src, incarnation);
        let own = facts.iter().filter(|facts| (facts.origin, facts.incarnation) == key);
        self.adopt(&own.copied().collect::<Vec<_>>());
    }

    /// The entry of an incarnation; a new one replaces the oldest of its agent if there are too many.
    fn entry(&mut self, src: AgentId, incarnation: Incarnation) -> &mut VersionEntry {
        let key = (src, incarnation);
        let all = (src, Incarnation(0))..=(src, Incarnation(u32::MAX));
        if !self.entries.contains_key(&key)
            && self.entries.range(all.clone()).count() >= MAX_INCARNATIONS
        {
            let oldest = self.entries.range(all).next().map(|(key, _)| *key);
            oldest.map(|oldest| self.entries.remove(&oldest));
        }
        self.entries.entry(key).or_default()
    }

    /// The entries that digests tell the other agents.
    pub fn facts(&self) -> Vec<HeldFacts> {
        let facts = |(&(origin, incarnation), entry): (&(AgentId, Incarnation), &VersionEntry)| {
            (entry.count > 0).then_some(HeldFacts { origin, incarnation, count: entry.count })
        };
        self.entries.iter().filter_map(facts).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIFE: (AgentId, Incarnation) = (AgentId(1), Incarnation(0));

    fn held() -> VersionVector {
        VersionVector { entries: BTreeMap::new(), window: 5 }
    }

    fn count(held: &VersionVector) -> u32 {
        held.facts().first().map_or(0, |facts| facts.count)
    }

    #[test]
    fn a_gap_ends_what_is_held_until_it_is_filled() {
        let mut held = held();
        for (number, expected) in [(1, 0), (0, 2), (3, 2), (4, 2), (2, 5), (2, 5)] {
            held.apply(LIFE.0, LIFE.1, number);
            assert_eq!(count(&held), expected, "after {number}");
        }
        assert!(held.has_applied(LIFE.0, LIFE.1, 3) && !held.has_applied(LIFE.0, LIFE.1, 5));
        assert!(!held.has_applied(LIFE.0, Incarnation(1), 3), "a new entry begins anew");
    }

    #[test]
    fn a_snapshot_fills_gaps_but_its_facts_are_still_news() {
        let mut held = held();
        held.apply(LIFE.0, LIFE.1, 9);
        held.adopt(&[HeldFacts { origin: LIFE.0, incarnation: LIFE.1, count: 9 }]);
        assert_eq!(count(&held), 10);
        assert!(!held.has_applied(LIFE.0, LIFE.1, 7), "itself it says more than the snapshot");
        held.adopt(&[HeldFacts { origin: LIFE.0, incarnation: LIFE.1, count: 3 }]);
        assert_eq!(count(&held), 10, "an older snapshot takes nothing away");
    }

    #[test]
    fn memory_is_bounded() {
        let mut held = held();
        (0..1000).map(|i| 2 * i).for_each(|number| held.apply(LIFE.0, LIFE.1, number));
        assert_eq!(held.entries[&LIFE].applied.len(), 5);
        assert_eq!(count(&held), 1);
        for incarnation in (0..1000).map(Incarnation) {
            held.adopt(&[HeldFacts { origin: AgentId(2), incarnation, count: 7 }]);
        }
        assert_eq!(held.facts().len(), 1 + MAX_INCARNATIONS);
        let newest = HeldFacts { origin: AgentId(2), incarnation: Incarnation(999), count: 7 };
        assert_eq!(held.facts().last(), Some(&newest));
    }

    #[test]
    fn the_last_number_is_no_trap() {
        let mut held = held();
        held.adopt(&[HeldFacts { origin: LIFE.0, incarnation: LIFE.1, count: u32::MAX }]);
        held.apply(LIFE.0, LIFE.1, u32::MAX);
        assert_eq!(count(&held), u32::MAX);
    }
}
