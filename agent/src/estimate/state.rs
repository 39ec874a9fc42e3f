//! The knowledge of an agent.

use std::collections::VecDeque;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use csat_proto::ids::AgentId;
use csat_proto::raster::Raster;
use csat_proto::time::Step;
use xxhash_rust::xxh3::Xxh3Default;

use super::oem::Oem;
use super::origins::Origins;
use super::sets::Sets;
use crate::config::AgentConfig;

/// What agent i knows at step k.
#[derive(Debug, Clone)]
pub struct Knowledge {
    /// What is guaranteed.
    pub sets: Sets,
    /// M_i.
    pub oem: Oem,
    /// X^h (5.43): ground that was hidden and has not been seen since.
    pub hidden: Raster,
    /// Which agent proves what, where some of them may lie.
    pub(super) origins: Option<Box<Origins>>,
    recent_views: VecDeque<Arc<FleetView>>,
    /// Views of earlier steps are dropped.
    views_from: Step,
}

impl Deref for Knowledge {
    type Target = Sets;

    fn deref(&self) -> &Sets {
        &self.sets
    }
}

impl DerefMut for Knowledge {
    fn deref_mut(&mut self) -> &mut Sets {
        &mut self.sets
    }
}

impl Knowledge {
    /// The start: nothing identified, everything unexplored.
    pub fn at_start(config: &AgentConfig) -> Self {
        Self {
            sets: Sets::at_start(config),
            oem: Oem::unexplored(config.oem_grid()),
            hidden: Raster::empty(config.raster_grid()),
            origins: (config.exchange.liars > 0).then(|| Box::new(Origins::at_start(config))),
            recent_views: VecDeque::new(),
            views_from: Step(0),
        }
    }

    /// The agents that were proven to have said something false, where some may lie.
    pub fn liars(&self) -> impl Iterator<Item = AgentId> + '_ {
        self.origins.iter().flat_map(|origins| origins.named())
    }

    /// Notes the ground that was hidden to an agent and the ground that it saw at `step` (5.43),
    /// (5.44).
    ///
    /// Ground becomes hidden unless an agent saw it at that step or later. Views may arrive late, in
    /// any order and more than once. A view of a step whose views were dropped is skipped, because it
    /// is not known any more whether its ground was seen since.
    pub(super) fn note_view(&mut self, step: Step, hidden: &Raster, seen: &Raster) {
        if step < self.views_from {
            return;
        }
        // A frame shows little of a large town.
        let is_used = |&word: &usize| hidden.words()[word] | seen.words()[word] != 0;
        let used: Vec<usize> = (0..hidden.words().len()).filter(is_used).collect();
        match self.recent_views.iter_mut().find(|view| view.step == step) {
            Some(view) => {
                let view = Arc::make_mut(view);
                for &word in &used {
                    view.hidden.words_mut()[word] |= hidden.words()[word];
                    view.seen.words_mut()[word] |= seen.words()[word];
                }
            }
            None => {
                let view = FleetView { step, hidden: hidden.clone(), seen: seen.clone() };
                self.recent_views.push_back(Arc::new(view));
            }
        }
        let since: Vec<&FleetView> =
            self.recent_views.iter().map(Arc::as_ref).filter(|view| view.step >= step).collect();
        for word in used {
            let (mut newly_hidden, mut newly_seen) = (hidden.words()[word], seen.words()[word]);
            for view in &since {
                newly_hidden &= !view.seen.words()[word];
                // Ground seen at `step` is no longer hidden, except where a later view hid it again.
                if view.step > step {
                    newly_seen &= !view.hidden.words()[word];
                }
            }
            let known = &mut self.hidden.words_mut()[word];
            *known = *known & !newly_seen | newly_hidden;
        }
    }

    /// Drops views before `oldest`.
    pub(super) fn forget_views_before(&mut self, oldest: Step) {
        self.recent_views.retain(|view| view.step >= oldest);
        self.views_from = oldest;
    }

    /// The union of the ground that was hidden to an agent in the last h steps (5.30).
    pub fn hidden_recently(&self) -> Raster {
        let mut union = Raster::empty(*self.hidden.grid());
        for view in &self.recent_views {
            union.union_with(&view.hidden);
        }
        union
    }

    /// A hash of all fields above: equal digests mean equal knowledge.
    pub fn digest(&self) -> u64 {
        let mut hasher = Xxh3Default::new();
        self.sets.hash(&mut hasher);
        for delta in self.oem.known() {
            hasher.update(&delta.cell.to_le_bytes());
            hasher.update(&delta.state.code().to_le_bytes());
        }
        for row in 0..self.hidden.grid().rows {
            for word in self.hidden.row(row) {
                hasher.update(&word.to_le_bytes());
            }
        }
        if let Some(origins) = &self.origins {
            origins.hash(&mut hasher);
        }
        hasher.digest()
    }
}

/// The ground that was hidden to the fleet and the ground that it saw, at one step.
#[derive(Debug, Clone)]
struct FleetView {
    step: Step,
    hidden: Raster,
    seen: Raster,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A view may arrive when it is not known any more what was seen since.
    #[test]
    fn ground_seen_since_is_not_hidden_by_a_view_that_comes_late() {
        let config = crate::config::tests::default_config([500.0; 2]);
        let nothing = Raster::empty(config.raster_grid());
        let mut cell = nothing.clone();
        cell.set(3, 4);
        for window in [6, 12] {
            let mut knowledge = Knowledge::at_start(&config);
            knowledge.note_view(Step(10), &nothing, &cell);
            knowledge.forget_views_before(Step(20 - window));
            knowledge.note_view(Step(9), &cell, &nothing);
            assert!(!knowledge.hidden.get(3, 4), "the last {window} steps are remembered");
            knowledge.note_view(Step(15), &cell, &nothing);
            assert!(knowledge.hidden.get(3, 4));
        }
    }
}
