//! The distances by which masks are dilated and shrunk, from the bounds of all errors. All of them are Chebyshev
//! distances in pixels, rounded up.
//!
//! Masks lie on a lattice of pixels that is fixed to the ground, up to the errors of the odometry. Along each axis
//! the place of a frame on the lattice is wrong by at most `placed`: half a pixel, because frames are placed at
//! whole pixels; half of the jitter of the odometry; and [`DRIFT_PX`], the drift that is allowed before the lattice
//! is taken up anew.

use crate::config::AgentConfig;

/// The drift of the odometry after which the lattice is taken up anew, pixels.
pub const DRIFT_PX: f64 = 1.0;

/// See the module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Radii {
    /// The segmentation, dilated by this, contains the pixels of the middles of all cells of road, and the
    /// pixels around each of them.
    pub out: u16,
    /// ρ: a pixel of another agent's mask is at most so far from where it is placed.
    pub rho: u16,
    /// A cell that touches a pixel of the image has its middle at most so far from it on the lattice.
    pub claim: u16,
    /// The pixels of the middles of cells that touch are at most so far apart: frontier pixels are those that have
    /// unknown road within this distance.
    pub reach: u16,
    /// What the vehicle errs in a period.
    pub motion: u16,
    /// What a frontier may seem to move in a period without any motion: the jitter, the rounding to whole pixels, and
    /// the lattice that is taken up anew.
    pub jitter: u16,
}

impl Radii {
    /// Those of a configuration.
    pub fn new(config: &AgentConfig) -> Self {
        let pixel_m = config.pixel_m();
        let placed = 0.5 + config.odometry.jitter_m / 2.0 / pixel_m + DRIFT_PX;
        // From the middle of a cell to the farthest point of it; some pixel's middle is not farther away.
        let cell = config.cell_m / 2.0 / pixel_m;
        let offset = config.offset_error_m / pixel_m;
        Self {
            // Half a pixel from the middle of a pixel to its edge; one pixel around each.
            out: up(f64::from(config.gap_px) + cell + placed + 0.5).saturating_add(1),
            // Both frames are placed wrongly, and the offset is rounded to whole pixels.
            rho: up(offset + 2.0 * placed + 0.5),
            claim: up(placed + cell),
            // Two middles that are so far apart are in pixels that are at most one farther apart.
            reach: (2.0 * cell + 1e-9) as u16 + 1,
            motion: up(config.motion_error_m / pixel_m),
            jitter: up(config.odometry.jitter_m / pixel_m + 1.0 + DRIFT_PX),
        }
    }

    /// The width of the edge of the image within which nothing is decided: a pixel there may be a road whose
    /// label is outside the image.
    pub fn blind(&self) -> u16 {
        self.out
    }

    /// A frontier is held as long as it is at least so far from the edge of the image: then all unknown road beside
    /// it is decided.
    pub fn rim(&self) -> u16 {
        self.blind().saturating_add(self.reach)
    }

    /// The least distance from the edge to which a frontier may be driven, for what then may happen in a period
    /// leaves it off the rim.
    pub fn least_guard(&self) -> u16 {
        self.rim().saturating_add(self.jitter)
    }
}

/// Whole pixels, rounded up.
fn up(pixels: f64) -> u16 {
    (pixels - 1e-9).ceil().clamp(0.0, f64::from(u16::MAX)) as u16
}
