//! What agents tell their vehicles.

use serde::{Deserialize, Serialize};

/// Fly at this heading, at constant speed and altitude (5.35).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct YawCommand {
    /// The heading, counter-clockwise from east, radians; not wrapped, so that a turn by u goes the
    /// way of u.
    pub yaw_rad: f64,
}
