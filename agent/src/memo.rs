//! Results of functions, by what went in.
//!
//! Agents of a process often compute the same: they receive the same messages, and know the same of most
//! places. And where nothing changed since the step before, the same goes in again. A result is a function of
//! its key, so no agent behaves differently with a memo.

use std::collections::BTreeMap;
use std::fmt;
use std::mem::{replace, take};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use csat_proto::time::Step;

use crate::identity::Identity;

/// Results of one step and of the step before it, each computed once. Agents of a process may share one; those that are at
/// an earlier step than others may have to compute again.
pub struct Memo<V>(Mutex<Results<V>>);

/// Results by key: a thread that asks for one that another thread is computing waits for it.
type Cells<V> = BTreeMap<Identity, Arc<OnceLock<V>>>;

struct Results<V> {
    step: Step,
    /// Those that were asked for in `step`.
    new: Cells<V>,
    /// Those of the step before that were not asked for since.
    old: Cells<V>,
}

impl<V> Memo<V> {
    /// Begins `step` and forgets what was not asked for since the step before was begun. A step that is not
    /// later than the last one does nothing.
    pub fn begin(&self, step: Step) {
        let forgotten = self.with(|results| {
            (step > results.step).then(|| {
                results.step = step;
                let old = take(&mut results.new);
                replace(&mut results.old, old)
            })
        });
        // Other threads need not wait for this.
        drop(forgotten);
    }

    /// The result that has this key; `compute` makes it where it is not known.
    pub(crate) fn result(&self, key: Identity, compute: impl FnOnce() -> V) -> V
    where
        V: Clone,
    {
        self.cell(key).get_or_init(compute).clone()
    }

    /// Where the result that has this key is, or belongs.
    pub(crate) fn cell(&self, key: Identity) -> Arc<OnceLock<V>> {
        self.with(|results| {
            let known = results.old.remove(&key);
            let cell = results.new.entry(key).or_insert_with(|| known.unwrap_or_default());
            Arc::clone(cell)
        })
    }

    fn with<T>(&self, work: impl FnOnce(&mut Results<V>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl<V> Default for Memo<V> {
    fn default() -> Self {
        Self(Mutex::new(Results { step: Step(0), new: Cells::new(), old: Cells::new() }))
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

    /// The results are forgotten a step after nobody asked for them.
    #[test]
    fn a_result_is_computed_once_while_it_is_asked_for() {
        let memo = Memo::default();
        let computed = |step: u32| {
            memo.begin(Step(step));
            let mut is_new = false;
            memo.result(Identity::of(b"input"), || is_new = true);
            is_new
        };
        let steps = [0, 0, 1, 2, 1, 2, 4, 5];
        let expected = [true, false, false, false, false, false, false, false];
        assert_eq!(steps.map(computed), expected);
        memo.begin(Step(6));
        memo.begin(Step(7));
        assert!(computed(7));
    }
}
