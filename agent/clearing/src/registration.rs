//! Where the image is on the lattice of the masks: at the whole pixel nearest to the odometry.
//!
//! Only displacements between frames count, so it does not matter where the odometry has its origin.

use csat_proto::camera::Pose;

use crate::config::AgentConfig;
use crate::radii::DRIFT_PX;

/// The place of the image on the lattice, and how much the odometry may have drifted.
#[derive(Debug, Clone)]
pub struct Registration {
    pixel_m: f64,
    drift_share: f64,
    motion_error_m: f64,
    /// Row and column of the first pixel of the image on the lattice; `None` before the first frame.
    window: Option<[i32; 2]>,
    /// The most that was flown since the lattice was taken up, metres.
    path_m: f64,
}

/// What changed from one frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moved {
    /// How far the ground moved in the image: down and to the right, pixels.
    pub by: [i32; 2],
    /// Whether the lattice has to be taken up anew, by a pixel.
    pub is_drifted: bool,
}

impl Registration {
    /// An agent without a frame.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            pixel_m: config.pixel_m(),
            drift_share: config.odometry.drift_share,
            motion_error_m: config.motion_error_m,
            window: None,
            path_m: 0.0,
        }
    }

    /// Takes the lattice up at the present frame.
    pub fn restart(&mut self) {
        self.path_m = 0.0;
    }

    /// Places the next frame, after a command to fly `commanded_m` metres.
    pub fn place(&mut self, pose: &Pose, commanded_m: [f64; 2]) -> Moved {
        let [east, north, _] = pose.p_world;
        let next = [-north, east].map(|metres| (metres / self.pixel_m).round() as i32);
        let last = self.window.replace(next).unwrap_or(next);
        let flown_m = commanded_m[0].hypot(commanded_m[1]);
        self.path_m += flown_m + std::f64::consts::SQRT_2 * self.motion_error_m;
        // The reserve has to last for the next period, too.
        let is_drifted = self.drift_share * (self.path_m + 1.0) >= DRIFT_PX * self.pixel_m;
        if is_drifted {
            self.restart();
        }
        Moved { by: [0, 1].map(|axis| last[axis].saturating_sub(next[axis])), is_drifted }
    }

    /// How far the mask of an agent that was at this offset (east, north, metres) is to be moved, down and to
    /// the right, to lie on the own masks.
    pub fn placement(&self, offset_m: [f64; 2]) -> [i32; 2] {
        let [east, north] = offset_m;
        [-north, east].map(|metres| (metres / self.pixel_m).round() as i32)
    }
}
