//! The cumulative probability of detection (8): how likely it was that the frames so far would have detected the
//! target, wherever it is.

use csat_proto::model::Ground;
use csat_proto::raster::Grid;

use crate::belief::grid::diffused;
use crate::likelihood::Likelihood;
use crate::likelihood::many::Weigher;
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
        let (Some(weigher), Some(footprint)) = (Weigher::of_survival(frame), frame.footprint())
        else {
            return;
        };
        let columns = self.grid.columns_between(footprint.min[0], footprint.max[0]);
        let x: Vec<f32> =
            columns.clone().map(|column| self.grid.centre(column, 0)[0] as f32).collect();
        let (mut y, mut unseen) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        for row in self.grid.rows_between(footprint.min[1], footprint.max[1]) {
            y.fill(self.grid.centre(0, row)[1] as f32);
            unseen.fill(1.0);
            weigher.weigh(&x, &y, &mut unseen);
            let first = self.grid.index(columns.start, row);
            let mass = self.mass[first..first + x.len()].iter_mut();
            mass.zip(&unseen).for_each(|(mass, unseen)| *mass *= f64::from(*unseen));
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
