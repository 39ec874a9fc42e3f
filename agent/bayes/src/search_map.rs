//! The belief as guidance sees it: how probable each cell of a coarse raster is.

use csat_proto::raster::Grid;
use serde::{Deserialize, Serialize};

/// Side of the cells, metres: the paper's grid.
pub const CELL_M: f64 = 12.5;

/// A probability for each cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchMap {
    /// The cells.
    pub grid: Grid,
    /// Their probabilities, row by row from the south; their sum is 1.
    pub mass: Vec<f64>,
}

/// A Gaussian.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gaussian {
    /// The mean, `world`, metres.
    pub mean: [f64; 2],
    /// var(x), cov(x, y), var(y), m².
    pub covariance: [f64; 3],
}

impl Gaussian {
    /// The square root of the trace of the covariance, metres.
    pub fn sigma_m(&self) -> f64 {
        (self.covariance[0] + self.covariance[2]).max(0.0).sqrt()
    }

    /// The ellipse of `radius` standard deviations as a ring of `corners` points, `world`, metres.
    pub fn ellipse(&self, radius: f64, corners: u32) -> Vec<[f64; 2]> {
        let [xx, xy, yy] = self.covariance;
        // Cholesky: a circle becomes the ellipse.
        let a = xx.max(0.0).sqrt();
        let b = if a > 0.0 { xy / a } else { 0.0 };
        let c = (yy - b * b).max(0.0).sqrt();
        let [x, y] = self.mean;
        let corner = |i: u32| {
            let angle = f64::from(i) / f64::from(corners) * std::f64::consts::TAU;
            let [u, v] = [angle.cos(), angle.sin()].map(|part| radius * part);
            [x + a * u, y + b * u + c * v]
        };
        (0..corners).map(corner).collect()
    }
}
