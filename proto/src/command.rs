//! Commands of agents to their vehicles.

use serde::{Deserialize, Serialize};

/// To fly at this heading, at constant speed and altitude (5.35).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct YawCommand {
    /// The heading, counter-clockwise from east, radians. It is not wrapped, so that a turn by u goes
    /// in the direction of u.
    pub yaw_rad: f64,
}
