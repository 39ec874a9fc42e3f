//! Sets of numbers as half-open intervals.

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3Default;

/// A set of numbers below `u32::MAX`: intervals [from, to) in increasing order, none empty, no two of them
/// adjacent. Encoded as pairs (numbers left out, numbers held), which cannot express anything else.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "Vec<(u32, u32)>", into = "Vec<(u32, u32)>")]
pub struct Intervals(Vec<[u32; 2]>);

impl Intervals {
    /// No number.
    pub const EMPTY: Self = Self(Vec::new());

    /// Adds a number. `false` if it was held already, or is `u32::MAX`.
    pub fn insert(&mut self, number: u32) -> bool {
        if number == u32::MAX || self.contains(number) {
            return false;
        }
        let index = self.0.partition_point(|[from, _]| *from <= number);
        let joins_before = index > 0 && self.0[index - 1][1] == number;
        let joins_after = self.0.get(index).is_some_and(|[from, _]| *from == number + 1);
        match (joins_before, joins_after) {
            (true, true) => {
                self.0[index - 1][1] = self.0[index][1];
                self.0.remove(index);
            }
            (true, false) => self.0[index - 1][1] = number + 1,
            (false, true) => self.0[index][0] = number,
            (false, false) => self.0.insert(index, [number, number + 1]),
        }
        true
    }

    /// Whether a number is held.
    pub fn contains(&self, number: u32) -> bool {
        let index = self.0.partition_point(|[from, _]| *from <= number);
        index > 0 && number < self.0[index - 1][1]
    }

    /// How many numbers are held.
    pub fn count(&self) -> u64 {
        self.0.iter().map(|[from, to]| u64::from(to - from)).sum()
    }

    /// Whether no number is held.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// One more than the greatest number; 0 without any.
    pub fn end(&self) -> u32 {
        self.0.last().map_or(0, |[_, to]| *to)
    }

    /// The intervals, in increasing order.
    pub fn as_slice(&self) -> &[[u32; 2]] {
        &self.0
    }

    /// The numbers, in increasing order.
    pub fn numbers(&self) -> impl DoubleEndedIterator<Item = u32> + '_ {
        self.0.iter().flat_map(|[from, to]| *from..*to)
    }

    /// The numbers that are not in `other`.
    pub fn minus(&self, other: &Self) -> Self {
        let mut rest = Vec::new();
        let mut index = 0;
        for &[mut from, to] in &self.0 {
            // An interval of `other` may reach into several of these.
            while let Some(&[cut_from, cut_to]) = other.0.get(index)
                && cut_from < to
            {
                if from < cut_from {
                    rest.push([from, cut_from]);
                }
                from = from.max(cut_to);
                if cut_to > to {
                    break;
                }
                index += 1;
            }
            if from < to {
                rest.push([from, to]);
            }
        }
        Self(rest)
    }

    /// The numbers below `limit`, and the others.
    pub fn split_at(&self, limit: u32) -> (Self, Self) {
        let below = self.0.iter().map(|[from, to]| [*from, (*to).min(limit)]);
        let above = self.0.iter().map(|[from, to]| [(*from).max(limit), *to]);
        let kept = |[from, to]: &[u32; 2]| from < to;
        (Self(below.filter(kept).collect()), Self(above.filter(kept).collect()))
    }

    /// The first `count` intervals, and the others.
    pub fn first(&self, count: usize) -> (Self, Self) {
        let (first, others) = self.0.split_at(self.0.len().min(count));
        (Self(first.to_vec()), Self(others.to_vec()))
    }

    /// A hash: equal ones mean equal sets.
    pub fn hash(&self) -> u64 {
        let mut hasher = Xxh3Default::new();
        self.0.iter().flatten().for_each(|bound| hasher.update(&bound.to_le_bytes()));
        hasher.digest()
    }
}

impl From<Intervals> for Vec<(u32, u32)> {
    fn from(intervals: Intervals) -> Self {
        let mut end = 0;
        let pair = |[from, to]: [u32; 2]| {
            let pair = (from - end, to - from);
            end = to;
            pair
        };
        intervals.0.into_iter().map(pair).collect()
    }
}

/// Pairs that do not describe intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interval {index} is empty, adjacent to the one before, or too far")]
pub struct IntervalError {
    /// The position of the first wrong pair.
    pub index: usize,
}

impl TryFrom<Vec<(u32, u32)>> for Intervals {
    type Error = IntervalError;

    fn try_from(pairs: Vec<(u32, u32)>) -> Result<Self, IntervalError> {
        let mut end = 0u32;
        let interval = |(index, (gap, length)): (usize, (u32, u32))| {
            let from = end.checked_add(gap);
            let to = from.and_then(|from| from.checked_add(length));
            match (from, to) {
                (Some(from), Some(to)) if length > 0 && (gap > 0 || index == 0) => {
                    end = to;
                    Ok([from, to])
                }
                _ => Err(IntervalError { index }),
            }
        };
        pairs.into_iter().enumerate().map(interval).collect::<Result<_, _>>().map(Self)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn intervals(numbers: &BTreeSet<u32>) -> Intervals {
        let mut intervals = Intervals::EMPTY;
        // Not in increasing order.
        let (odd, even): (Vec<u32>, Vec<u32>) = numbers.iter().partition(|n| *n % 2 == 1);
        odd.iter().rev().chain(&even).for_each(|n| assert!(intervals.insert(*n)));
        intervals
    }

    proptest! {
        #[test]
        fn they_are_sets(
            a in proptest::collection::btree_set(0u32..60, 0..50),
            b in proptest::collection::btree_set(0u32..60, 0..50),
            limit in 0u32..60,
        ) {
            let (of_a, of_b) = (intervals(&a), intervals(&b));
            prop_assert!(of_a.0.is_sorted_by(|x, y| x[1] < y[0]) && of_a.0.iter().all(|[f, t]| f < t));
            prop_assert!((0..62).all(|n| of_a.contains(n) == a.contains(&n)));
            prop_assert_eq!((of_a.count(), of_a.is_empty()), (a.len() as u64, a.is_empty()));
            prop_assert_eq!(of_a.end(), a.last().map_or(0, |n| n + 1));
            prop_assert!(of_a.numbers().eq(a.iter().copied()));
            prop_assert_eq!(of_a.minus(&of_b), intervals(&(&a - &b)));
            let (below, above) = of_a.split_at(limit);
            prop_assert!(below.numbers().eq(a.range(..limit).copied()));
            prop_assert!(above.numbers().eq(a.range(limit..).copied()));
            prop_assert_eq!(of_a.hash() == of_b.hash(), a == b);
            let bytes = postcard::to_stdvec(&of_a).unwrap();
            prop_assert_eq!(postcard::from_bytes::<Intervals>(&bytes), Ok(of_a));
        }
    }

    #[test]
    fn what_is_no_interval_does_not_decode() {
        let of = |pairs: &[(u32, u32)]| Intervals::try_from(pairs.to_vec());
        assert_eq!(of(&[(0, 3), (1, 1)]), Ok(Intervals(vec![[0, 3], [4, 5]])));
        assert_eq!(of(&[(0, 3), (1, 0)]), Err(IntervalError { index: 1 }), "empty");
        assert_eq!(of(&[(0, 3), (0, 1)]), Err(IntervalError { index: 1 }), "adjacent");
        assert_eq!(of(&[(2, u32::MAX)]), Err(IntervalError { index: 0 }), "too far");
        assert!(!Intervals::EMPTY.clone().insert(u32::MAX));
    }
}
