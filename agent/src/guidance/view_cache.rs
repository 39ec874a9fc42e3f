//! A cache of views by pose, shared by all agents with the same knowledge.
//!
//! The second pass of a decision has the same poses as the first, and each planner also predicts the
//! views from the planned poses of the other UAVs, which are more than its own poses in a large
//! fleet. A view is cut to the cells that X^Δ may cover within the horizon.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use csat_proto::camera::Pose;
use csat_proto::raster::Raster;

use super::rounded_views::VisibleCells;
use super::shadow::OccupiedCells;
use crate::estimate::oem::Oem;

/// The views of one X^Δ given one OEM, for one camera and criterion. The cache changes the time of a
/// look and no result.
#[derive(Default)]
pub struct ViewCache {
    grown: OnceLock<Raster>,
    occupied: OnceLock<OccupiedCells>,
    known: Mutex<BTreeMap<[u64; 6], Arc<VisibleCells>>>,
}

impl ViewCache {
    /// The cells that X^Δ may cover within the horizon; `grow` computes them at the first call.
    pub(super) fn grown(&self, grow: impl FnOnce() -> Raster) -> &Raster {
        self.grown.get_or_init(grow)
    }

    /// The cells of the OEM, which is `oem`, that hide ground.
    pub(super) fn occupied(&self, oem: &Oem) -> &OccupiedCells {
        self.occupied.get_or_init(|| OccupiedCells::of(oem))
    }

    /// The view from `pose`; `look` computes it if it is not cached.
    pub(super) fn at(&self, pose: &Pose, look: impl FnOnce() -> VisibleCells) -> Arc<VisibleCells> {
        let Pose { p_world: [x, y, z], yaw_rad, pitch_rad, roll_rad } = *pose;
        let key = [x, y, z, yaw_rad, pitch_rad, roll_rad].map(f64::to_bits);
        let known = self.known().get(&key).cloned();
        // Two threads may compute the same view at the same time; neither waits for the other.
        known.unwrap_or_else(|| {
            let view = Arc::new(look());
            self.known().entry(key).or_insert(view).clone()
        })
    }

    /// Number of cached poses.
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
