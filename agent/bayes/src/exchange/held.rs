//! What messages tell of the factors that an agent holds: a version vector with gaps.

use csat_proto::ids::{AgentId, Incarnation};
use serde::{Deserialize, Serialize};

use super::intervals::Intervals;

/// The most incarnations of one aircraft whose factors are held.
pub const MAX_INCARNATIONS: usize = 64;
/// The most intervals that are told of an incarnation.
pub const MAX_INTERVALS: usize = 32;

/// The numbers of the factors that an agent holds, for each incarnation of each aircraft, in this order.
/// What is not in it counts as missing.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Held(pub Vec<HeldNumbers>);

/// The factors of one incarnation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeldNumbers {
    /// The aircraft.
    pub source: AgentId,
    /// Its incarnation.
    pub incarnation: Incarnation,
    /// The numbers of its factors: the first [`MAX_INTERVALS`] intervals, so that the oldest gaps are told.
    pub numbers: Intervals,
    /// The hash of the intervals that were left out, if any. Gaps that nobody can fill any more stay for ever;
    /// by the hash an agent that holds the same knows that nothing is missing behind them.
    pub rest: Option<u64>,
}

/// Numbers that an agent is missing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Those between the intervals that it told.
    pub told: Intervals,
    /// Those behind them, some of which it may hold.
    pub untold: Intervals,
}

impl HeldNumbers {
    /// What is told of an incarnation.
    pub fn of(source: AgentId, incarnation: Incarnation, held: &Intervals) -> Self {
        let (numbers, others) = held.first(MAX_INTERVALS);
        let rest = (!others.is_empty()).then(|| others.hash());
        Self { source, incarnation, numbers, rest }
    }

    fn key(&self) -> (AgentId, Incarnation) {
        (self.source, self.incarnation)
    }
}

impl Held {
    /// How many factors it tells.
    pub fn count(&self) -> u64 {
        self.0.iter().map(|held| held.numbers.count()).sum()
    }

    /// Which of the numbers `ours` of an incarnation are missing.
    pub fn lacks(&self, source: AgentId, incarnation: Incarnation, ours: &Intervals) -> Missing {
        let found = self.0.binary_search_by_key(&(source, incarnation), HeldNumbers::key);
        let Ok(index) = found else {
            return Missing { told: ours.clone(), untold: Intervals::EMPTY };
        };
        let HeldNumbers { numbers, rest, .. } = &self.0[index];
        let Some(rest) = rest else {
            return Missing { told: ours.minus(numbers), untold: Intervals::EMPTY };
        };
        let (below, behind) = ours.split_at(numbers.end());
        let untold = if behind.hash() == *rest { Intervals::EMPTY } else { behind };
        Missing { told: below.minus(numbers), untold }
    }

    /// Whether it may come from an agent of a fleet of `aircraft` aircraft that knows numbers up to `last`:
    /// incarnations in order, not too many, each with some numbers, at most [`MAX_INTERVALS`] intervals.
    pub fn is_sane(&self, aircraft: u16, last: u32) -> bool {
        let is_sane = |held: &HeldNumbers| {
            let intervals = held.numbers.as_slice().len();
            held.source.0 < aircraft
                && (1..=MAX_INTERVALS).contains(&intervals)
                && (held.rest.is_none() || intervals == MAX_INTERVALS)
                && held.numbers.end() <= last.saturating_add(1)
        };
        let too_many =
            |entries: &[HeldNumbers]| entries[0].source == entries[MAX_INCARNATIONS].source;
        self.0.is_sorted_by(|a, b| a.key() < b.key())
            && self.0.iter().all(is_sane)
            && !self.0.windows(MAX_INCARNATIONS + 1).any(too_many)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIFE: (AgentId, Incarnation) = (AgentId(1), Incarnation(0));

    fn intervals(numbers: impl IntoIterator<Item = u32>) -> Intervals {
        let mut intervals = Intervals::EMPTY;
        numbers.into_iter().for_each(|number| {
            intervals.insert(number);
        });
        intervals
    }

    fn told(ours: &Intervals) -> Held {
        Held(vec![HeldNumbers::of(LIFE.0, LIFE.1, ours)])
    }

    fn lacks(told: &Held, ours: &Intervals) -> Vec<u32> {
        let Missing { told, untold } = told.lacks(LIFE.0, LIFE.1, ours);
        told.numbers().chain(untold.numbers()).collect()
    }

    #[test]
    fn what_is_not_told_counts_as_missing() {
        let all = intervals(0..200);
        let gaps = intervals((0..200).filter(|n| n % 2 == 0));
        let told_gaps = told(&gaps);
        assert_eq!(told_gaps.0[0].numbers.as_slice().len(), MAX_INTERVALS);
        assert_eq!(told_gaps.count(), 32);
        let missing: Vec<u32> = (0..63).filter(|n| n % 2 == 1).chain(63..200).collect();
        assert_eq!(lacks(&told_gaps, &all), missing, "the oldest gaps are told");
        assert_eq!(lacks(&told_gaps, &gaps), [], "the same is held behind them");
        let one_more = intervals(gaps.numbers().chain([199]));
        assert_eq!(lacks(&told_gaps, &one_more).len(), 69);
        assert_eq!(told_gaps.lacks(LIFE.0, Incarnation(1), &all).told, all);
        assert_eq!(Held::default().lacks(LIFE.0, LIFE.1, &all).told, all);
    }

    #[test]
    fn what_no_agent_would_tell_is_noticed() {
        let good = told(&intervals([1, 2, 5]));
        assert!(good.is_sane(2, 5) && good.is_sane(2, u32::MAX));
        assert!(!good.is_sane(1, 5), "no aircraft");
        assert!(!good.is_sane(2, 4), "a number of later");
        assert!(!told(&Intervals::EMPTY).is_sane(2, 5));
        assert!(!Held([&good.0[..], &good.0[..]].concat()).is_sane(2, 5), "twice");
        let mut with_rest = good.clone();
        with_rest.0[0].rest = Some(7);
        assert!(!with_rest.is_sane(2, 5), "there was room for more intervals");
        let entry = |i| HeldNumbers { incarnation: Incarnation(i), ..good.0[0].clone() };
        let many = |count| Held((0..count).map(entry).collect());
        assert!(many(64).is_sane(2, 5) && !many(65).is_sane(2, 5));
    }

    #[test]
    fn a_fleet_without_gaps_takes_few_bytes() {
        let of = |source| HeldNumbers::of(AgentId(source), Incarnation(1), &intervals(0..2400));
        let held = Held((0..8).map(of).collect());
        assert!(postcard::to_stdvec(&held).unwrap().len() <= 60);
    }
}
