//! Knowledge between two updates.

use std::ops::Deref;
use std::sync::OnceLock;

use csat_proto::raster::Raster;

use crate::estimate::oem::BlockHashes;
use crate::estimate::state::Knowledge;
use crate::guidance::{PlannerRasters, ViewCache};
use crate::identity::Identity;

/// Knowledge that no longer changes, and what is derived from it at the first query.
#[derive(Debug)]
pub struct SettledKnowledge {
    knowledge: Knowledge,
    /// A hash of all evidence that it was made of.
    lineage: Identity,
    unexplored_cells: OnceLock<Raster>,
    planner_rasters: OnceLock<PlannerRasters>,
    view_cache: ViewCache,
    block_hashes: OnceLock<BlockHashes>,
    digest: OnceLock<u64>,
}

impl SettledKnowledge {
    /// Knowledge, and a hash of all evidence that it was made of.
    pub fn new(knowledge: Knowledge, lineage: Identity) -> Self {
        Self {
            knowledge,
            lineage,
            unexplored_cells: OnceLock::new(),
            planner_rasters: OnceLock::new(),
            view_cache: ViewCache::default(),
            block_hashes: OnceLock::new(),
            digest: OnceLock::new(),
        }
    }

    /// A hash of all evidence that it was made of: equal lineages mean equal knowledge.
    pub fn lineage(&self) -> Identity {
        self.lineage
    }

    /// X̄ as a raster. It is needed at every step, unlike the other rasters of the planner.
    pub fn unexplored_cells(&self) -> &Raster {
        self.unexplored_cells.get_or_init(|| {
            Raster::of_region(*self.knowledge.hidden.grid(), self.knowledge.unexplored.region())
        })
    }

    /// The sets that the planner reads, as rasters.
    pub fn planner_rasters(&self) -> &PlannerRasters {
        self.planner_rasters
            .get_or_init(|| PlannerRasters::of(&self.knowledge, self.unexplored_cells().clone()))
    }

    /// The views of its X^Δ given its map, by the criterion of the agents that hold this knowledge.
    pub fn view_cache(&self) -> &ViewCache {
        &self.view_cache
    }

    /// A hash of each block of its map.
    pub fn block_hashes(&self) -> &BlockHashes {
        self.block_hashes.get_or_init(|| self.knowledge.oem.block_hashes())
    }

    /// [`Knowledge::digest`].
    pub fn digest(&self) -> u64 {
        *self.digest.get_or_init(|| self.knowledge.digest())
    }
}

impl Deref for SettledKnowledge {
    type Target = Knowledge;

    fn deref(&self) -> &Knowledge {
        &self.knowledge
    }
}
