//! The cumulative probability of detection (8): how likely it was that the frames so far would have detected the
//! target, wherever it is.

use csat_proto::model::Ground;
use csat_proto::raster::Grid;

use crate::belief::grid::diffused;
use crate::likelihood::Likelihood;
use crate::search_map::CELL_M;

/// ∫ p(x) Π (1 − p(D, V | x)) dx over the frames, on a coarse raster. A false alarm detects nothing.
#[derive(Debug, Clone)]
pub struct Survival {
    grid: Grid,
    /// The probability that the target is in a cell and was not detected.
    mass: Vec<f64>,
}

impl Survival {
    /// Before the first frame.
    pub fn new(ground: &Ground) -> Self {
        let grid = Grid::covering(ground, CELL_M);
        Self { mass: vec![1.0 / grid.cells() as f64; grid.cells()], grid }
    }

    /// A frame was taken; what it showed does not count.
    pub fn look(&mut self, frame: &Likelihood) {
        let Some(footprint) = frame.footprint() else { return };
        let columns = self.grid.columns_between(footprint.min[0], footprint.max[0]);
        for row in self.grid.rows_between(footprint.min[1], footprint.max[1]) {
            for column in columns.clone() {
                let p = frame.p_detection(self.grid.centre(column, row));
                self.mass[self.grid.index(column, row)] *= 1.0 - p;
            }
        }
    }

    /// The target moved by a normal displacement of this standard deviation per axis.
    pub fn diffuse(&mut self, sigma_m: f64) {
        self.mass = diffused(&self.grid, &self.mass, sigma_m);
    }

    /// P(D).
    pub fn cumulative_detection(&self) -> f64 {
        (1.0 - self.mass.iter().sum::<f64>()).clamp(0.0, 1.0)
    }
}
