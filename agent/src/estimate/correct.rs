//! Correction with the own frame (4.28)-(4.33).

use std::collections::BTreeMap;

use csat_proto::ids::TargetId;
use csat_proto::message::OemDelta;

use super::state::Knowledge;
use crate::region::Inner;
use crate::sense::{Measured, MeasuredTarget};

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
pub fn correct(knowledge: &mut Knowledge, measured: &Measured) -> Changes {
    let mut changes = Changes::default();
    knowledge.margin = Inner::union([&knowledge.margin, &measured.obstacle_margin]);
    // Seen again: ∩ X^{t,m} (4.31); seen first: X̄ ∩ X^{t,m} (4.32), with X̄ still as predicted.
    for seen in &measured.targets {
        if !knowledge.targets.contains_key(&seen.target) {
            changes.identified.push(seen.target);
        }
        let set = knowledge.set_of(seen.target).intersection(&seen.location);
        knowledge.targets.insert(seen.target, set);
    }
    let Knowledge { targets, unexplored, margin, .. } = knowledge;
    let everywhere = [&measured.clear_ground, &*margin];
    for (&target, set) in targets.iter_mut() {
        let exclusions = exclusions_of_others(&measured.targets, target);
        *set = set.minus(everywhere.into_iter().chain(exclusions));
    }
    let exclusions = measured.targets.iter().map(|t| &t.exclusion);
    *unexplored = unexplored.minus(everywhere.into_iter().chain(exclusions));

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

/// The exclusion zones of all targets but `target`.
fn exclusions_of_others(
    measured: &[MeasuredTarget],
    target: TargetId,
) -> impl Iterator<Item = &Inner> {
    measured.iter().filter(move |other| other.target != target).map(|other| &other.exclusion)
}
