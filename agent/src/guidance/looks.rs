//! What neighbours would see, found once for all agents that know the same.
//!
//! In a large fleet an agent looks from more of its neighbours' planned poses than from poses of its
//! own, and so does everybody else: from the same ones.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use csat_proto::camera::Pose;
use csat_proto::raster::Raster;

use super::views::View;

/// What was seen from where in one world, for one camera and criterion. It changes the time that a
/// look takes and nothing else.
#[derive(Default)]
pub struct Looks(Mutex<BTreeMap<[u64; 6], Arc<OnceLock<View>>>>);

impl Looks {
    /// Adds what is seen from `pose` to `seen`; `look` finds it if nobody has before.
    pub(super) fn add(&self, pose: &Pose, look: impl FnOnce() -> View, seen: &mut Raster) {
        let Pose { p_world: [x, y, z], yaw_rad, pitch_rad, roll_rad } = *pose;
        let key = [x, y, z, yaw_rad, pitch_rad, roll_rad].map(f64::to_bits);
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let view = known.entry(key).or_default().clone();
        drop(known);
        view.get_or_init(look).add_to(seen);
    }

    /// How many poses were looked from.
    #[cfg(test)]
    pub(super) fn poses(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }
}

impl fmt::Debug for Looks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Looks").finish_non_exhaustive()
    }
}
