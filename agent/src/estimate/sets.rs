//! The sets that carry the guarantee.

use std::collections::BTreeMap;

use csat_proto::ids::TargetId;
use csat_proto::region::Region;
use csat_proto::time::Step;
use xxhash_rust::xxh3::Xxh3Default;

use crate::config::AgentConfig;
use crate::identity::hash_paths;
use crate::region::{Inner, Memo, Outer};

/// What is guaranteed at step k: by all evidence of an agent, or by that of one origin.
///
/// The guarantee: a target in [`Self::targets`] is inside its set, every other one is inside
/// [`Self::unexplored`].
#[derive(Debug, Clone)]
pub struct Sets {
    /// k.
    pub step: Step,
    /// L_i and X_ij, outer.
    pub targets: BTreeMap<TargetId, Outer>,
    /// X̄_i, outer: contains the location of every target not in L_i.
    pub unexplored: Outer,
    /// X°_i, inner: contains no target location at any step.
    pub margin: Inner,
    ground: Region,
    simplify_margin_m: f64,
    max_vertices: usize,
}

impl Sets {
    /// The start: nothing identified, everything unexplored.
    pub fn at_start(config: &AgentConfig) -> Self {
        let ground = Region::rectangle(config.ground.size_m);
        Self {
            step: Step(0),
            targets: BTreeMap::new(),
            unexplored: Outer::containing(ground.clone()),
            margin: Inner::default(),
            simplify_margin_m: config.estimator.simplify_margin_m,
            max_vertices: config.estimator.max_vertices as usize,
            ground,
        }
    }

    /// What holds at the same step without any evidence.
    pub(super) fn without_evidence(&self) -> Self {
        Self {
            step: self.step,
            targets: BTreeMap::new(),
            unexplored: Outer::containing(self.ground.clone()),
            margin: Inner::default(),
            ground: self.ground.clone(),
            ..*self
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

    /// X_g \ X°: where a target may be of which nothing else is known.
    pub(super) fn anywhere(&self) -> Outer {
        Outer::containing(self.ground.clone()).minus([&self.margin])
    }

    /// The targets whose sets are empty: an assumption failed or a message was false.
    pub(super) fn empty(&self) -> Vec<TargetId> {
        self.targets.iter().filter(|(_, set)| set.is_empty()).map(|(&j, _)| j).collect()
    }

    /// Restarts sets that became empty at X_g \ X° and returns their targets: an empty set proves
    /// that an assumption failed or that a message was false.
    pub(super) fn restart_empty_sets(&mut self) -> Vec<TargetId> {
        let empty = self.empty();
        if !empty.is_empty() {
            let anywhere = self.anywhere();
            for j in &empty {
                self.targets.insert(*j, anywhere.clone());
            }
        }
        empty
    }

    /// X° ∪= parts (4.28), simplified inward.
    pub(super) fn learn_margin<'a>(
        &mut self,
        parts: impl IntoIterator<Item = &'a Inner>,
        memo: &Memo,
    ) {
        let new: Vec<&Inner> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        if !new.is_empty() {
            let margin = std::mem::take(&mut self.margin);
            let margin = margin.absorbing(&new, self.simplify_margin_m, memo);
            self.margin = margin.limited(self.max_vertices);
        }
    }

    /// Adds all fields above to a hash.
    pub(super) fn hash(&self, hasher: &mut Xxh3Default) {
        hasher.update(&self.step.0.to_le_bytes());
        for (target, set) in &self.targets {
            hasher.update(&target.0.to_le_bytes());
            hash_region(hasher, set.region());
        }
        hash_region(hasher, self.unexplored.region());
        hash_region(hasher, self.margin.region());
    }
}

fn hash_region(hasher: &mut Xxh3Default, region: &Region) {
    for shape in region.shapes() {
        hash_paths(hasher, shape);
    }
    hasher.update(&u64::MAX.to_le_bytes());
}
