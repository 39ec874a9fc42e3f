//! Knowledge between two updates.

use std::ops::Deref;
use std::sync::OnceLock;

use csat_proto::raster::Raster;

use super::oem::BlockHashes;
use super::state::Knowledge;
use crate::commons::Identity;

/// Knowledge that does not change any more, and what follows from it, found when first asked for.
#[derive(Debug)]
pub struct Settled {
    knowledge: Knowledge,
    /// A hash of all that ever went into it.
    lineage: Identity,
    coarse: OnceLock<Coarse>,
    block_hashes: OnceLock<BlockHashes>,
    digest: OnceLock<u64>,
}

/// The sets that the planner and the metrics read, as rasters.
#[derive(Debug)]
pub struct Coarse {
    /// X̄.
    pub unexplored: Raster,
    /// X^Δ (5.11).
    pub wanted: Raster,
    /// X°.
    pub margin: Raster,
    /// What was hidden to anybody of late (5.30).
    pub hidden_recently: Raster,
}

impl Coarse {
    /// The sets of `knowledge`.
    pub fn of(knowledge: &Knowledge) -> Self {
        let grid = *knowledge.hidden.grid();
        let unexplored = Raster::of_region(grid, knowledge.unexplored.region());
        let mut wanted = unexplored.clone();
        for set in knowledge.targets.values() {
            wanted.union_with(&Raster::of_region(grid, set.region()));
        }
        Self {
            unexplored,
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
            coarse: OnceLock::new(),
            block_hashes: OnceLock::new(),
            digest: OnceLock::new(),
        }
    }

    /// A hash of all that ever went into it: equal lineages mean equal knowledge.
    pub fn lineage(&self) -> Identity {
        self.lineage
    }

    /// Its sets as rasters.
    pub fn coarse(&self) -> &Coarse {
        self.coarse.get_or_init(|| Coarse::of(&self.knowledge))
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
