//! The knowledge of an agent.

use std::collections::{BTreeMap, VecDeque};

use csat_proto::ids::TargetId;
use csat_proto::raster::Raster;
use csat_proto::region::Region;
use csat_proto::time::Step;
use xxhash_rust::xxh3::Xxh3Default;

use super::oem::Oem;
use crate::config::AgentConfig;
use crate::region::{Inner, Outer};

/// What agent i knows at step k.
///
/// The guarantee: a target in [`Self::targets`] is inside its set, every other one is inside
/// [`Self::unexplored`].
#[derive(Debug, Clone)]
pub struct Knowledge {
    /// k.
    pub step: Step,
    /// L_i and X_ij, outer.
    pub targets: BTreeMap<TargetId, Outer>,
    /// X̄_i, outer: contains the location of every target not in L_i.
    pub unexplored: Outer,
    /// X°_i, inner: contains no target location at any step.
    pub margin: Inner,
    /// M_i.
    pub oem: Oem,
    /// X^h (5.43): ground that was hidden and has not been seen since.
    pub hidden: Raster,
    recent_views: VecDeque<FleetView>,
    /// Views of earlier steps are dropped.
    views_from: Step,
    ground: Region,
    simplify_margin_m: f64,
    max_vertices: usize,
}

impl Knowledge {
    /// The start: nothing identified, everything unexplored.
    pub fn at_start(config: &AgentConfig) -> Self {
        let ground = Region::rectangle(config.ground.size_m);
        Self {
            step: Step(0),
            targets: BTreeMap::new(),
            unexplored: Outer::containing(ground.clone()),
            margin: Inner::default(),
            oem: Oem::unexplored(config.oem_grid()),
            hidden: Raster::empty(config.raster_grid()),
            recent_views: VecDeque::new(),
            views_from: Step(0),
            simplify_margin_m: config.estimator.simplify_margin_m,
            max_vertices: config.estimator.max_vertices as usize,
            ground,
        }
    }

    /// X_g.
    pub fn ground(&self) -> &Region {
        &self.ground
    }

    /// The set that is known to contain a target: X_ij, or X̄_i if j is not identified.
    pub fn set_of(&self, target: TargetId) -> &Outer {
        self.targets.get(&target).unwrap_or(&self.unexplored)
    }

    /// X° ∪= parts (4.28), simplified inward.
    pub(super) fn learn_margin<'a>(&mut self, parts: impl IntoIterator<Item = &'a Inner>) {
        let new: Vec<&Inner> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        if !new.is_empty() {
            let margin = std::mem::take(&mut self.margin);
            let margin = margin.absorbing(&new, self.simplify_margin_m);
            self.margin = margin.limited(self.max_vertices);
        }
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
        match self.recent_views.iter_mut().find(|view| view.step == step) {
            Some(view) => {
                view.hidden.union_with(hidden);
                view.seen.union_with(seen);
            }
            None => {
                let view = FleetView { step, hidden: hidden.clone(), seen: seen.clone() };
                self.recent_views.push_back(view);
            }
        }
        let mut newly_hidden = hidden.clone();
        for later in self.recent_views.iter().filter(|view| view.step >= step) {
            newly_hidden.subtract(&later.seen);
        }
        // Ground seen at `step` is no longer hidden, except where a later view hid it again.
        let mut newly_seen = seen.clone();
        for later in self.recent_views.iter().filter(|view| view.step > step) {
            newly_seen.subtract(&later.hidden);
        }
        self.hidden.subtract(&newly_seen);
        self.hidden.union_with(&newly_hidden);
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

    /// Restarts sets that became empty at X_g \ X° and returns their targets: an empty set proves
    /// that an assumption failed or that a message was false.
    pub(super) fn restart_empty_sets(&mut self) -> Vec<TargetId> {
        let empty: Vec<TargetId> =
            self.targets.iter().filter(|(_, set)| set.is_empty()).map(|(&j, _)| j).collect();
        if !empty.is_empty() {
            let anywhere = Outer::containing(self.ground.clone()).minus([&self.margin]);
            for j in &empty {
                self.targets.insert(*j, anywhere.clone());
            }
        }
        empty
    }

    /// A hash of all fields above: equal digests mean equal knowledge.
    pub fn digest(&self) -> u64 {
        let mut hasher = Xxh3Default::new();
        hasher.update(&self.step.0.to_le_bytes());
        for (target, set) in &self.targets {
            hasher.update(&target.0.to_le_bytes());
            hash_region(&mut hasher, set.region());
        }
        hash_region(&mut hasher, self.unexplored.region());
        hash_region(&mut hasher, self.margin.region());
        for delta in self.oem.known() {
            hasher.update(&delta.cell.to_le_bytes());
            hasher.update(&delta.state.code().to_le_bytes());
        }
        for row in 0..self.hidden.grid().rows {
            for word in self.hidden.row(row) {
                hasher.update(&word.to_le_bytes());
            }
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

fn hash_region(hasher: &mut Xxh3Default, region: &Region) {
    for shape in region.shapes() {
        hasher.update(&(shape.len() as u64).to_le_bytes());
        for ring in shape {
            hasher.update(&(ring.len() as u64).to_le_bytes());
            for p in ring {
                hasher.update(&p.x.to_le_bytes());
                hasher.update(&p.y.to_le_bytes());
            }
        }
    }
    hasher.update(&u64::MAX.to_le_bytes());
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
