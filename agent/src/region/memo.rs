//! Results of operations on sets, by what went in.
//!
//! Where nothing changed since the step before, and where another agent of the process knows the same of a
//! place, an operation has the same input, to the last bit, and so the same result. It is looked up instead
//! of computed again. A result is a function of its key, so no agent behaves differently with a memo.

use std::collections::BTreeMap;
use std::mem::{replace, take};
use std::sync::{Arc, Mutex, PoisonError};

use csat_proto::region::Shape;
use csat_proto::time::Step;

use crate::identity::Identity;

/// Results of one step and of the step before it. Agents of a process that are at the same step may share
/// one.
#[derive(Debug, Default)]
pub struct Memo(Mutex<Results>);

#[derive(Debug, Default)]
struct Results {
    step: Step,
    /// Those that were asked for in `step`.
    new: BTreeMap<Identity, Arc<[Shape]>>,
    /// Those of the step before that were not asked for since.
    old: BTreeMap<Identity, Arc<[Shape]>>,
}

impl Memo {
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
    pub(super) fn result(&self, key: Identity, compute: impl FnOnce() -> Vec<Shape>) -> Vec<Shape> {
        let known = self.with(|results| {
            if let Some(old) = results.old.remove(&key) {
                results.new.insert(key, old);
            }
            results.new.get(&key).cloned()
        });
        if let Some(shapes) = known {
            return shapes.to_vec();
        }
        let shapes = compute();
        let kept = Arc::from(shapes.as_slice());
        self.with(|results| results.new.insert(key, kept));
        shapes
    }

    fn with<T>(&self, work: impl FnOnce(&mut Results) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
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
            memo.result(Identity::of(b"input"), || {
                is_new = true;
                Vec::new()
            });
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
