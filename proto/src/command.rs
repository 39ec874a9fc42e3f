//! Commands of agents to their vehicles.

use serde::{Deserialize, Serialize};

/// What a vehicle is told to do from now on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Command {
    /// To fly at this heading, at constant speed and altitude (5.35).
    Yaw {
        /// The heading, counter-clockwise from east, radians. It is not wrapped, so that a turn by u goes
        /// in the direction of u.
        yaw_rad: f64,
    },
    /// To be displaced by this much within the next period T, and to hover after it.
    Displace {
        /// East and north, metres.
        by_m: [f64; 2],
    },
}

impl Command {
    /// Whether all its numbers are finite.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Yaw { yaw_rad } => yaw_rad.is_finite(),
            Self::Displace { by_m } => by_m.iter().all(|metres| metres.is_finite()),
        }
    }
}
