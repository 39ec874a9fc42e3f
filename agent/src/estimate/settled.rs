//! Knowledge between two updates.

use std::ops::Deref;
use std::sync::OnceLock;

use csat_proto::raster::Raster;

use super::oem::BlockHashes;
use super::state::Knowledge;
use crate::guidance::Looks;
use crate::identity::Identity;

/// Knowledge that does not change any more, and what follows from it, found when first asked for.
#[derive(Debug)]
pub struct Settled {
    knowledge: Knowledge,
    /// A hash of all that ever went into it.
    lineage: Identity,
    unexplored_cells: OnceLock<Raster>,
    coarse: OnceLock<Coarse>,
    looks: Looks,
    block_hashes: OnceLock<BlockHashes>,
    digest: OnceLock<u64>,
}

/// The sets that the planner reads, as rasters.
#[derive(Debug)]
pub struct Coarse {
    /// X^Δ (5.11).
    pub wanted: Raster,
    /// X°.
    pub margin: Raster,
    /// What was hidden to anybody of late (5.30).
    pub hidden_recently: Raster,
}

impl Coarse {
    /// The sets of `knowledge`, whose X̄ is `unexplored`.
    pub fn of(knowledge: &Knowledge, unexplored: Raster) -> Self {
        let grid = *unexplored.grid();
        let mut wanted = unexplored;
        for set in knowledge.targets.values() {
            wanted.union_with(&Raster::of_region(grid, set.region()));
        }
        Self {
            wanted,
            margin: Raster::of_region(grid, knowledge.margin.region()),
            hidden_recently: knowledge.hidden_recently(),
        }
    }
}

impl Settled {
    /// Knowledge and a hash of all that went into it.
    pub fn new(knowledge: Knowledge, lineage: Identity) -> Self {
        Self {
            knowledge,
            lineage,
            unexplored_cells: OnceLock::new(),
            coarse: OnceLock::new(),
            looks: Looks::default(),
            block_hashes: OnceLock::new(),
            digest: OnceLock::new(),
        }
    }

    /// A hash of all that ever went into it: equal lineages mean equal knowledge.
    pub fn lineage(&self) -> Identity {
        self.lineage
    }

    /// X̄ as a raster; asked for at every step, unlike the planner's sets.
    pub fn unexplored_cells(&self) -> &Raster {
        self.unexplored_cells.get_or_init(|| {
            Raster::of_region(*self.knowledge.hidden.grid(), self.knowledge.unexplored.region())
        })
    }

    /// The planner's sets as rasters.
    pub fn coarse(&self) -> &Coarse {
        self.coarse.get_or_init(|| Coarse::of(&self.knowledge, self.unexplored_cells().clone()))
    }

    /// What is seen of its X^Δ from where in the world of its map, by the criterion of all who know this.
    pub fn looks(&self) -> &Looks {
        &self.looks
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

impl Deref for Settled {
    type Target = Knowledge;

    fn deref(&self) -> &Knowledge {
        &self.knowledge
    }
}
