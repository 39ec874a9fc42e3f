//! How much a factor tells: what decides which factors a budget pays for.

use crate::factor::Factor;
use crate::filter::Filter;
use crate::search_map::SearchMap;

/// A detection is said before all frames without one.
const DETECTION: f64 = 10.0;

/// What factors tell an agent that knows the rest.
pub struct Worth<'a> {
    filter: &'a Filter,
    map: SearchMap,
}

impl<'a> Worth<'a> {
    /// Measured by the belief of a filter.
    pub fn new(filter: &'a Filter) -> Self {
        Self { filter, map: filter.belief().map() }
    }

    /// The Kullback-Leibler divergence, nats, from the belief without a factor to the belief, which contains it:
    /// E\[ln ℓ\] + ln E\[1/ℓ\], on a coarse raster.
    pub fn of(&self, factor: &Factor) -> f64 {
        let likelihood = self.filter.likelihood(factor);
        let first = if factor.sighting.is_some() { DETECTION } else { 0.0 };
        let Some(bounds) = likelihood.bounds() else { return first };
        let SearchMap { grid, mass } = &self.map;
        let columns = grid.columns_between(bounds.min[0], bounds.max[0]);
        let (mut held, mut mean, mut inverse) = (0.0, 0.0, 0.0);
        for row in grid.rows_between(bounds.min[1], bounds.max[1]) {
            for column in columns.clone() {
                let m = mass[grid.index(column, row)];
                let ln = likelihood.ln_within(grid.centre(column, row));
                held += m;
                mean += m * ln;
                inverse += m * (-ln).exp();
            }
        }
        // Elsewhere ℓ is 1.
        let outside = (1.0 - held).max(0.0);
        first + (mean + (outside + inverse).ln()).max(0.0)
    }
}
