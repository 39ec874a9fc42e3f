//! What agents of one process need not find out twice.
//!
//! Over good links agents hear the same and so know the same, to the last bit. In a process of its own
//! each of them works for that; in a mission of one process one of them does, and the others take
//! over the result. Nothing that an agent knows or does depends on it: an entry is a function of its
//! key. Agents that share [`Commons`] must be of one configuration but for their index and life.
//!
//! Knowledge is recognised by its lineage, a hash of all that ever went into it, so that it need not
//! be compared.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use csat_proto::time::Step;

use crate::estimate::Changes;
use crate::estimate::settled::Settled;
use crate::estimate::state::Knowledge;
use crate::exchange::inbox::Letter;
use crate::exchange::validate::Rejection;
use crate::identity::Identity;

/// What the agents of a process share; cloned, it is the same.
#[derive(Debug, Clone, Default)]
pub struct Commons(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    letters: Memo<Result<Arc<Letter>, Rejection>>,
    /// Alive as long as some agent knows it.
    updates: Memo<(Weak<Settled>, Changes)>,
}

impl Commons {
    /// The message of this identity, as read at the receiver's step `now`.
    ///
    /// # Errors
    /// Those of `read`.
    pub(crate) fn letter(
        &self,
        now: Step,
        identity: Identity,
        read: impl FnOnce() -> Result<Letter, Rejection>,
    ) -> Result<Arc<Letter>, Rejection> {
        self.0.letters.at(now, identity).get_or_init(|| read().map(Arc::new)).clone()
    }

    /// The knowledge of this lineage at step `now`, and what `update` changed to make it so.
    pub(crate) fn updated(
        &self,
        now: Step,
        lineage: Identity,
        update: impl Fn() -> (Knowledge, Changes),
    ) -> (Arc<Settled>, Changes) {
        let settle = || {
            let (knowledge, changes) = update();
            (Arc::new(Settled::new(knowledge, lineage)), changes)
        };
        let mut made = None;
        let cell = self.0.updates.at(now, lineage);
        let (known, changes) = cell.get_or_init(|| {
            let (settled, changes) = settle();
            (Arc::downgrade(made.insert(settled)), changes)
        });
        match made.or_else(|| known.upgrade()) {
            Some(settled) => (settled, changes.clone()),
            // Whoever knew it went on since.
            None => settle(),
        }
    }
}

type Cells<V> = BTreeMap<(Step, Identity), Arc<OnceLock<V>>>;

/// Results by key, each found once, of the last two steps.
struct Memo<V>(Mutex<Cells<V>>);

impl<V> Memo<V> {
    fn at(&self, now: Step, identity: Identity) -> Arc<OnceLock<V>> {
        let mut cells = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = cells.last_key_value().map_or(Step(0), |((step, _), _)| *step);
        if newest < now {
            *cells = cells.split_off(&(Step(now.0.saturating_sub(1)), Identity::default()));
        }
        cells.entry((now, identity)).or_default().clone()
    }
}

impl<V> Default for Memo<V> {
    fn default() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }
}

impl<V> fmt::Debug for Memo<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Memo").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_found_once_and_forgotten_two_steps_later() {
        let memo = Memo::<u32>::default();
        let id = Identity::of(b"news");
        assert_eq!(*memo.at(Step(5), id).get_or_init(|| 1), 1);
        assert_eq!(*memo.at(Step(5), id).get_or_init(|| 2), 1);
        assert_eq!(*memo.at(Step(6), id).get_or_init(|| 3), 3, "another step is another key");
        assert_eq!(*memo.at(Step(5), id).get_or_init(|| 4), 1);
        memo.at(Step(7), id);
        assert_eq!(*memo.at(Step(5), id).get_or_init(|| 5), 5);
    }

    #[test]
    fn order_makes_another_identity() {
        assert_ne!(Identity::of_all([1, 2]), Identity::of_all([2, 1]));
        assert_ne!(Identity::of_all([]), Identity::of_all([0]));
    }
}
