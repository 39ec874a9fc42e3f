//! Results that the agents of one process share instead of each computing them.
//!
//! Agents that received the same messages hold the same knowledge, to the last bit. Where one process
//! drives several agents, the first one that needs a result computes it, and the others read it from
//! the [`SharedCache`]. The driver of the agents owns the cache and hands it to each of them, for one
//! mission. Every entry is a function of its key, so no agent behaves differently with a cache. Agents
//! that share a cache must have the same configuration except for their index and incarnation.
//!
//! The key of knowledge is its lineage, a hash of all evidence that it was made of, so no sets are
//! compared.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use csat_proto::time::Step;

use crate::estimate::Changes;
use crate::estimate::state::Knowledge;
use crate::exchange::receiver::CheckedMessage;
use crate::exchange::validate::Rejection;
use crate::identity::Identity;
use crate::region::Memo;
use crate::settled::SettledKnowledge;

/// What the agents of a process share.
#[derive(Debug, Default)]
pub struct SharedCache {
    messages: ByStep<Result<Arc<CheckedMessage>, Rejection>>,
    /// Kept alive by the agents that hold this knowledge.
    updates: ByStep<(Weak<SettledKnowledge>, Changes)>,
    /// Results of operations on sets, also of agents whose knowledge differs elsewhere.
    operations: Arc<Memo>,
}

impl SharedCache {
    /// Results of operations on sets.
    pub(crate) fn memo(&self) -> Arc<Memo> {
        Arc::clone(&self.operations)
    }

    /// The message of this identity, as `check` decodes it at the receiver's step `now`.
    ///
    /// # Errors
    /// Those of `check`.
    pub(crate) fn message(
        &self,
        now: Step,
        identity: Identity,
        check: impl FnOnce() -> Result<CheckedMessage, Rejection>,
    ) -> Result<Arc<CheckedMessage>, Rejection> {
        self.messages.at(now, identity).get_or_init(|| check().map(Arc::new)).clone()
    }

    /// The knowledge of this lineage at step `now`, and what `update` changed to make it so.
    pub(crate) fn updated(
        &self,
        now: Step,
        lineage: Identity,
        update: impl Fn() -> (Knowledge, Changes),
    ) -> (Arc<SettledKnowledge>, Changes) {
        let settle = || {
            let (knowledge, changes) = update();
            (Arc::new(SettledKnowledge::new(knowledge, lineage)), changes)
        };
        let mut made = None;
        let cell = self.updates.at(now, lineage);
        let (known, changes) = cell.get_or_init(|| {
            let (settled, changes) = settle();
            (Arc::downgrade(made.insert(settled)), changes)
        });
        match made.or_else(|| known.upgrade()) {
            Some(settled) => (settled, changes.clone()),
            // The agents that held this knowledge have replaced it since.
            None => settle(),
        }
    }
}

type Entries<V> = BTreeMap<(Step, Identity), Arc<OnceLock<V>>>;

/// Results by key, each computed once, of the last two steps.
struct ByStep<V>(Mutex<Entries<V>>);

impl<V> ByStep<V> {
    fn at(&self, now: Step, identity: Identity) -> Arc<OnceLock<V>> {
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = entries.last_key_value().map_or(Step(0), |((step, _), _)| *step);
        if newest < now {
            *entries = entries.split_off(&(Step(now.0.saturating_sub(1)), Identity::default()));
        }
        entries.entry((now, identity)).or_default().clone()
    }
}

impl<V> Default for ByStep<V> {
    fn default() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }
}

impl<V> fmt::Debug for ByStep<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ByStep").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_computed_once_and_dropped_two_steps_later() {
        let results = ByStep::<u32>::default();
        let id = Identity::of(b"key");
        assert_eq!(*results.at(Step(5), id).get_or_init(|| 1), 1);
        assert_eq!(*results.at(Step(5), id).get_or_init(|| 2), 1);
        assert_eq!(*results.at(Step(6), id).get_or_init(|| 3), 3, "another step is another key");
        assert_eq!(*results.at(Step(5), id).get_or_init(|| 4), 1);
        results.at(Step(7), id);
        assert_eq!(*results.at(Step(5), id).get_or_init(|| 5), 5);
    }
}
