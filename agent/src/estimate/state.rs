//! The knowledge of an agent.

use std::ops::{Deref, DerefMut};

use csat_proto::ids::AgentId;
use csat_proto::raster::Raster;
use csat_proto::time::Step;
use xxhash_rust::xxh3::Xxh3Default;

use super::oem::Oem;
use super::origins::Origins;
use super::sets::Sets;
use super::views::Views;
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
    views: Views,
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
            views: Views::default(),
        }
    }

    /// The agents that were proven to have said something false, where some may lie.
    pub fn liars(&self) -> impl Iterator<Item = AgentId> + '_ {
        self.origins.iter().flat_map(|origins| origins.named())
    }

    /// Notes the ground that was hidden to an agent and the ground that it saw at `step`.
    pub(super) fn note_view(&mut self, step: Step, hidden: &Raster, seen: &Raster) {
        self.views.note(&mut self.hidden, step, hidden, seen);
    }

    /// Drops views before `oldest`.
    pub(super) fn forget_views_before(&mut self, oldest: Step) {
        self.views.forget_before(oldest);
    }

    /// The union of the ground that was hidden to an agent in the last h steps (5.30).
    pub fn hidden_recently(&self) -> Raster {
        self.views.hidden(*self.hidden.grid())
    }

    /// A hash of all fields but the views of the last steps.
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
