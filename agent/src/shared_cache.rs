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

use std::sync::{Arc, Weak};

use csat_proto::time::Step;

use crate::estimate::Changes;
use crate::estimate::state::Knowledge;
use crate::exchange::receiver::CheckedMessage;
use crate::exchange::validate::Rejection;
use crate::identity::Identity;
use crate::memo::Memo;
use crate::region;
use crate::settled::SettledKnowledge;

/// What the agents of a process share.
#[derive(Debug, Default)]
pub struct SharedCache {
    messages: Memo<Result<Arc<CheckedMessage>, Rejection>>,
    /// Kept alive by the agents that hold this knowledge.
    updates: Memo<(Weak<SettledKnowledge>, Changes)>,
    /// Results of operations on sets, also of agents whose knowledge differs elsewhere.
    operations: Arc<region::Memo>,
}

impl SharedCache {
    /// Results of operations on sets.
    pub(crate) fn memo(&self) -> Arc<region::Memo> {
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
        self.messages.begin(now);
        self.messages.result(at(now, identity), || check().map(Arc::new))
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
        self.updates.begin(now);
        let cell = self.updates.cell(at(now, lineage));
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

/// The identity of what is done at a step.
fn at(now: Step, identity: Identity) -> Identity {
    Identity::of_all([now.0.into(), identity.bits()])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a message counts depends on the step at which it is heard.
    #[test]
    fn a_message_is_checked_once_a_step() {
        let cache = SharedCache::default();
        let checks = |step: u32| {
            let mut checks = 0;
            let mut check = || {
                checks += 1;
                Err(Rejection::Run)
            };
            for _ in 0..2 {
                let found = cache.message(Step(step), Identity::of(b"message"), &mut check);
                assert!(found.is_err());
            }
            checks
        };
        assert_eq!([0, 1, 0, 2].map(checks), [1, 1, 0, 1]);
    }
}
