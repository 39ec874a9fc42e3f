//! Correction with the own frame (4.28)-(4.33).

use std::collections::BTreeMap;

use csat_proto::ids::TargetId;
use csat_proto::message::OemDelta;

use super::predict::Predicted;
use super::state::Knowledge;
use crate::region::Outer;
use crate::sense::Measured;

/// What a correction changed besides the sets.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Changes {
    /// Targets identified for the first time.
    pub identified: Vec<TargetId>,
    /// Targets whose set had become empty and was restarted.
    pub inconsistent: Vec<TargetId>,
    /// Cells of the OEM that changed, with their new state.
    pub oem: Vec<OemDelta>,
}

/// Corrects predicted knowledge with what the own frame of the same step proves.
pub fn correct(knowledge: &mut Knowledge, predicted: &Predicted, measured: &Measured) -> Changes {
    let mut changes = Changes::default();
    knowledge.learn_margin([&measured.obstacle_margin]);
    let margin = &knowledge.margin;
    let disproved = |target: Option<TargetId>| {
        let others = measured.targets.iter().filter(move |other| Some(other.target) != target);
        let exclusions = others.map(|other| &other.exclusion);
        [&measured.clear_ground, margin].into_iter().chain(exclusions)
    };
    let mut targets: BTreeMap<TargetId, Outer> = BTreeMap::new();
    for (&target, set) in &predicted.targets {
        if !measured.targets.iter().any(|seen| seen.target == target) {
            targets.insert(target, set.minus(disproved(Some(target)))); // (4.30)
        }
    }
    for seen in &measured.targets {
        let target = seen.target;
        // Seen again (4.31), or seen first (4.32): then it was in X̄.
        let before = predicted.targets.get(&target).unwrap_or_else(|| {
            changes.identified.push(target);
            &predicted.unexplored
        });
        let set = before.resolved().intersection(&seen.location);
        targets.insert(target, set.minus(disproved(Some(target))));
    }
    let unexplored = predicted.unexplored.minus(disproved(None)); // (4.29)
    (knowledge.targets, knowledge.unexplored) = (targets, unexplored);

    let mut oem = BTreeMap::new();
    for &delta in &measured.oem {
        if knowledge.oem.join(delta) {
            oem.insert(delta.cell, knowledge.oem.cells()[delta.cell as usize]);
        }
    }
    changes.oem = oem.into_iter().map(|(cell, state)| OemDelta { cell, state }).collect();
    let step = knowledge.step;
    knowledge.note_view(step, &measured.hidden, &measured.seen);
    changes.inconsistent = knowledge.restart_empty_sets();
    changes
}
