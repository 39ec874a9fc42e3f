//! The physical properties of a message. Agents do not state them, so what agents believe cannot change
//! them.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::camera::Pose;
use crate::ids::ChannelId;
use crate::time::SimTime;

/// What the process of a sender adds to each message for the links: the attachment of `link/{i}/{r}`,
/// as JSON. It is not part of the message: it takes no bytes of a budget and has no fate of its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PhysicalHeader {
    /// The true position of the sender's antenna, `world`, metres. The envelope has the position that
    /// the sender believes.
    pub p_world: [f64; 3],
}

impl PhysicalHeader {
    /// Whether the position is finite.
    pub fn is_place(&self) -> bool {
        self.p_world.iter().all(|x| x.is_finite())
    }
}

/// A message as its receiver gets it.
#[derive(Debug, Clone, PartialEq)]
pub struct Reception {
    /// The radio.
    pub channel: ChannelId,
    /// When it arrived.
    pub at: SimTime,
    /// The angle of arrival: from the receiver's nose to the position of the sender when it sent, in
    /// the horizontal plane, counter-clockwise, radians in (-π, π].
    pub bearing_rad: f64,
    /// Where the sender was when it sent, from where the receiver is now, east and north, metres: what a
    /// receiver gets from the registration of images or from ranging. `None` on a channel that does not measure
    /// it.
    pub offset_m: Option<[f64; 2]>,
    /// The encoded [`Envelope`](crate::envelope::Envelope).
    pub bytes: Arc<[u8]>,
}

/// The bearing of a point, `world`, metres, from an agent at `pose`: see [`Reception::bearing_rad`].
/// 0 for a point straight above or below the agent.
pub fn bearing_rad(pose: &Pose, p_world: [f64; 3]) -> f64 {
    let [x, y] = [0, 1].map(|axis| p_world[axis] - pose.p_world[axis]);
    if x == 0.0 && y == 0.0 {
        return 0.0;
    }
    let (sin, cos) = pose.yaw_rad.sin_cos();
    (y * cos - x * sin).atan2(x * cos + y * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn bearings_are_from_the_nose_counter_clockwise() {
        let north = Pose::level([10.0, 20.0, 50.0], FRAC_PI_2);
        for (p, expected) in [
            ([10.0, 99.0, 0.0], 0.0),
            ([-5.0, 20.0, 50.0], FRAC_PI_2),
            ([90.0, 20.0, 60.0], -FRAC_PI_2),
            ([10.0, 20.0, 0.0], 0.0),
        ] {
            assert!((bearing_rad(&north, p) - expected).abs() < 1e-12, "{p:?}");
        }
    }
}
