//! The factors that an agent holds.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use super::held::{Held, HeldNumbers, MAX_INCARNATIONS};
use super::intervals::Intervals;
use crate::factor::{Factor, FactorId};
use crate::mutant::{Mutant, is_on};

/// A set of factors that only grows.
///
/// An aircraft has one frame per step, and a later incarnation may have the frame of that step again. What
/// others say in excess of this is refused, and so is the 64th incarnation of an aircraft: memory is bounded by the
/// steps of the mission. There is always room for what the agent states itself.
#[derive(Debug, Clone, Default)]
pub struct FactorSet {
    factors: BTreeMap<FactorId, Factor>,
    order: BTreeSet<(Step, FactorId)>,
    numbers: BTreeMap<(AgentId, Incarnation), Intervals>,
    /// How many factors there are of an aircraft.
    counts: BTreeMap<AgentId, u64>,
    conflicts: u64,
    refused: u64,
}

impl FactorSet {
    /// The empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a factor of the agent itself. Its identity is new: nobody else can state it.
    pub fn state(&mut self, factor: Factor) {
        let id = factor.id;
        self.numbers.entry((id.source, id.incarnation)).or_default().insert(id.number);
        *self.counts.entry(id.source).or_default() += 1;
        self.order.insert((factor.step, id));
        self.factors.insert(id, factor);
    }

    /// Adds a factor of anyone. `false` if one of the same id is held, which stays, or if there are too many of its
    /// aircraft.
    pub fn insert(&mut self, factor: Factor) -> bool {
        let id = factor.id;
        if self.holds(id) {
            if is_on(Mutant::NewerStays) {
                self.factors.insert(id, factor);
            }
            self.conflicts += u64::from(self.factors.get(&id).is_some_and(|held| *held != factor));
            return false;
        }
        if !self.has_room(&factor) {
            self.refused += 1;
            return false;
        }
        self.state(factor);
        true
    }

    fn has_room(&self, factor: &Factor) -> bool {
        let FactorId { source, incarnation, number } = factor.id;
        let all = (source, Incarnation(0))..=(source, Incarnation(u32::MAX));
        let is_known = self.numbers.contains_key(&(source, incarnation));
        // The last one is for the incarnation of the agent itself.
        let is_full = self.numbers.range(all).count() >= MAX_INCARNATIONS - 1;
        if number == u32::MAX || !is_known && is_full {
            return false;
        }
        let latest = self.order.last().map_or(factor.step, |(step, _)| factor.step.max(*step));
        let most = u64::from(latest.0) + MAX_INCARNATIONS as u64;
        self.counts.get(&source).is_none_or(|count| *count <= most)
    }

    /// Whether a factor of this id is held.
    pub fn holds(&self, id: FactorId) -> bool {
        if is_on(Mutant::IncarnationIgnored) {
            let is_same = |held: &FactorId| (held.source, held.number) == (id.source, id.number);
            return self.factors.keys().any(is_same);
        }
        self.factors.contains_key(&id)
    }

    /// The factor of an id.
    pub fn get(&self, id: FactorId) -> Option<&Factor> {
        self.factors.get(&id)
    }

    /// How many factors are held.
    pub fn len(&self) -> usize {
        self.factors.len()
    }

    /// Whether no factor is held.
    pub fn is_empty(&self) -> bool {
        self.factors.is_empty()
    }

    /// The factors by id.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Factor> {
        self.factors.values()
    }

    /// The factors of step `first` and later, by step and then by id.
    pub fn since(&self, first: Step) -> impl DoubleEndedIterator<Item = &Factor> {
        let least = FactorId { source: AgentId(0), incarnation: Incarnation(0), number: 0 };
        self.order.range((first, least)..).filter_map(|(_, id)| self.factors.get(id))
    }

    /// The numbers of the factors of each incarnation.
    pub fn numbers(&self) -> impl Iterator<Item = ((AgentId, Incarnation), &Intervals)> {
        self.numbers.iter().map(|(key, numbers)| (*key, numbers))
    }

    /// What messages tell of the set.
    pub fn held(&self) -> Held {
        let told = |((source, incarnation), numbers): (_, &Intervals)| {
            if is_on(Mutant::GapsNotTold) {
                let mut all = Intervals::EMPTY;
                (0..numbers.end()).for_each(|number| {
                    all.insert(number);
                });
                return HeldNumbers::of(source, incarnation, &all);
            }
            HeldNumbers::of(source, incarnation, numbers)
        };
        Held(self.numbers().map(told).collect())
    }

    /// How often a factor was given whose id belongs to a different one.
    pub fn conflicts(&self) -> u64 {
        self.conflicts
    }

    /// How many factors were refused because there were too many of their aircraft.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::fixture::factor;

    #[test]
    fn a_factor_counts_once_and_the_first_one_stays() {
        let mut set = FactorSet::new();
        let first = factor(1, 0, 3);
        assert!(set.is_empty() && set.insert(first) && !set.insert(first));
        let other = Factor { sighting: Some([1.0, 2.0]), ..first };
        assert!(!set.insert(other));
        assert_eq!((set.get(first.id), set.len(), set.conflicts()), (Some(&first), 1, 1));
        assert!(set.insert(factor(1, 1, 3)), "another incarnation");
        assert!(set.insert(Factor { step: Step(2), ..factor(2, 0, 0) }));
        let order: Vec<_> = set.since(Step(0)).map(|f| (f.step.0, f.id.source.0)).collect();
        assert_eq!(order, [(2, 2), (3, 1), (3, 1)]);
        assert_eq!(set.since(Step(3)).count(), 2);
        assert!(set.iter().map(|f| f.id).is_sorted());
        assert_eq!((set.held().count(), set.held().0.len()), (3, 3));
    }

    #[test]
    fn memory_is_bounded_by_the_steps() {
        let mut set = FactorSet::new();
        for incarnation in 0..1000 {
            for number in 0..=100 {
                set.insert(Factor { step: Step(100), ..factor(0, incarnation, number) });
            }
        }
        assert_eq!(set.len(), 101 + MAX_INCARNATIONS);
        assert!(set.refused() > 0 && set.held().is_sane(1, 100));
        let mut set = FactorSet::new();
        (0..1000).for_each(|incarnation| {
            set.insert(Factor { step: Step(999), ..factor(0, incarnation, 0) });
        });
        assert_eq!(set.held().0.len(), MAX_INCARNATIONS - 1);
        set.state(factor(0, 1000, 0));
        assert!(
            set.holds(factor(0, 1000, 0).id) && set.held().is_sane(1, 999),
            "there is room for own ones"
        );
        assert!(!set.insert(factor(1, 0, u32::MAX)));
    }
}
