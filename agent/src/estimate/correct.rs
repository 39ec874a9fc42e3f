//! Correction (4.28)-(4.33) with what the own frame and the frames of other agents prove.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::ids::TargetId;

use super::evidence::Evidence;
use super::predict::Predicted;
use super::sets::Sets;
use crate::mutant::{Mutant, is_on};
use crate::region::{Inner, Memo, Outer};
use crate::sense::MeasuredTarget;

/// Corrects predicted sets.
///
/// All detections are intersected with the predicted sets before any exclusion is applied: a
/// detection must not be intersected with an X̄ from which its own exclusion was taken already.
pub(super) fn correct(sets: &mut Sets, predicted: &Predicted, evidence: &[Evidence], memo: &Memo) {
    sets.learn_margin(evidence.iter().map(|e| &e.obstacle_margin), memo); // (4.28)
    let margin = &sets.margin;
    let seen = || evidence.iter().flat_map(|e| &e.targets);
    let disproved = |target: Option<TargetId>| {
        let exclusions = seen().filter(move |s| applies_to(s, target)).map(|s| &s.exclusion);
        // X° was simplified as it grew. The parts are applied unsimplified as well, so that their
        // order does not matter.
        let parts = evidence.iter().flat_map(|e| [&e.clear_ground, &e.obstacle_margin]);
        parts.chain([margin]).chain(exclusions).collect::<Vec<&Inner>>()
    };
    let mut known: BTreeSet<TargetId> =
        predicted.targets.keys().copied().chain(seen().map(|s| s.target)).collect();
    if is_on(Mutant::ExclusionWithoutDetection) {
        known.retain(|j| predicted.targets.contains_key(j));
    }
    let mut targets: BTreeMap<TargetId, Outer> = BTreeMap::new();
    for j in known {
        let before = predicted.targets.get(&j);
        let mut locations = seen().filter(|s| s.target == j).map(|s| &s.location).peekable();
        let set = match before {
            Some(set) if locations.peek().is_none() => set.minus(disproved(Some(j))), // (4.30)
            _ => {
                // Seen again (4.31), or seen for the first time (4.32), when it was in X̄.
                let mut set = before.unwrap_or(&predicted.unexplored).resolved();
                if is_on(Mutant::DetectionAfterExclusion) && before.is_none() {
                    set = predicted.unexplored.minus(disproved(None));
                }
                if is_on(Mutant::FirstSeenNotDilated) && before.is_none() {
                    set = sets.unexplored.clone();
                }
                locations
                    .fold(set, |set, location| set.intersection(location))
                    .minus(disproved(Some(j)))
            }
        };
        targets.insert(j, set);
    }
    sets.unexplored = predicted.unexplored.minus(disproved(None)); // (4.29)
    sets.targets = targets;
}

/// Whether the exclusion of `seen` applies to `target`, or for `None` to unidentified targets.
fn applies_to(seen: &MeasuredTarget, target: Option<TargetId>) -> bool {
    Some(seen.target) != target || is_on(Mutant::ExclusionOfItself)
}
