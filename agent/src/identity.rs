//! Hashes that identify messages and knowledge.

use csat_proto::region::GridPoint;
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

    /// The identity of an operation on paths: what else decides its result, and groups of paths.
    pub fn of_operation<P: AsRef<[GridPoint]>>(
        numbers: [u64; 2],
        groups: impl IntoIterator<Item = impl IntoIterator<Item = P, IntoIter: ExactSizeIterator>>,
    ) -> Self {
        let mut hasher = Xxh3Default::new();
        numbers.iter().for_each(|number| hasher.update(&number.to_le_bytes()));
        for group in groups {
            hash_paths(&mut hasher, group);
        }
        Self(hasher.digest128())
    }

    /// The hash.
    pub fn bits(self) -> u128 {
        self.0
    }
}

/// Adds the number of paths, and the points of each, to a hash.
pub(crate) fn hash_paths<P: AsRef<[GridPoint]>>(
    hasher: &mut Xxh3Default,
    paths: impl IntoIterator<Item = P, IntoIter: ExactSizeIterator>,
) {
    let paths = paths.into_iter();
    hasher.update(&(paths.len() as u64).to_le_bytes());
    for path in paths {
        let points = path.as_ref();
        hasher.update(&(points.len() as u64).to_le_bytes());
        for p in points {
            hasher.update([p.x.to_le_bytes(), p.y.to_le_bytes()].as_flattened());
        }
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

    #[test]
    fn what_belongs_to_which_path_makes_another_identity() {
        let of = |groups: &[&[&[i32]]]| {
            let point = |&x: &i32| GridPoint::new(x, 0);
            let path = |path: &&[i32]| path.iter().map(point).collect::<Vec<_>>();
            let group = |group: &&[&[i32]]| group.iter().map(path).collect::<Vec<_>>();
            Identity::of_operation([0; 2], groups.iter().map(group))
        };
        let all = [
            of(&[&[&[1, 2, 3, 4]]]),
            of(&[&[&[1, 2], &[3, 4]]]),
            of(&[&[&[1, 2]], &[&[3, 4]]]),
            of(&[&[&[1, 2, 3], &[4]]]),
            of(&[&[], &[&[1, 2, 3, 4]]]),
        ];
        let different: std::collections::BTreeSet<_> = all.iter().collect();
        assert_eq!(different.len(), all.len());
        assert_ne!(Identity::of_operation([0, 1], [[[]]]), Identity::of_operation([1, 0], [[[]]]));
    }
}
