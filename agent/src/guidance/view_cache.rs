//! What is seen from where, found once for all agents that know the same.
//!
//! The second pass of a decision looks from the same poses as the first, and neighbours look from the poses
//! that somebody plans: in a large fleet from more of those than from poses of their own. All that counts
//! is what is seen of X^Δ, to which it may grow within the horizon.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use csat_proto::camera::Pose;
use csat_proto::raster::Raster;

use super::rounded_views::VisibleCells;

/// What was seen of one X^Δ from where in one world, for one camera and criterion. It changes the time
/// that a look takes and nothing else.
#[derive(Default)]
pub struct ViewCache {
    grown: OnceLock<Raster>,
    known: Mutex<BTreeMap<[u64; 6], Arc<VisibleCells>>>,
}

impl ViewCache {
    /// All that X^Δ may cover within the horizon; `grow` finds it if nobody has before.
    pub(super) fn grown(&self, grow: impl FnOnce() -> Raster) -> &Raster {
        self.grown.get_or_init(grow)
    }

    /// What is seen from `pose`; `look` finds it if nobody has before.
    pub(super) fn at(&self, pose: &Pose, look: impl FnOnce() -> VisibleCells) -> Arc<VisibleCells> {
        let Pose { p_world: [x, y, z], yaw_rad, pitch_rad, roll_rad } = *pose;
        let key = [x, y, z, yaw_rad, pitch_rad, roll_rad].map(f64::to_bits);
        let known = self.known().get(&key).cloned();
        // Two who look at the same time see the same: nobody waits.
        known.unwrap_or_else(|| {
            let view = Arc::new(look());
            self.known().entry(key).or_insert(view).clone()
        })
    }

    /// How many poses were looked from.
    #[cfg(test)]
    pub(super) fn poses(&self) -> usize {
        self.known().len()
    }

    fn known(&self) -> MutexGuard<'_, BTreeMap<[u64; 6], Arc<VisibleCells>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for ViewCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ViewCache").finish_non_exhaustive()
    }
}
