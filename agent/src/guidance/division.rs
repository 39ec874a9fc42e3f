//! The division of the region among the UAVs: rows, and the rows into shares. It needs no radio.

use csat_proto::ids::AgentId;
use csat_proto::raster::Raster;

use crate::config::AgentConfig;

/// The share of a UAV: which one of how many from west to east, in which one of how many rows from south to north.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Share {
    column: f64,
    columns: f64,
    row: f64,
    rows: f64,
}

impl Share {
    /// The share of a UAV of the fleet. Shares are about as wide as they are deep.
    pub(super) fn of(config: &AgentConfig, id: AgentId) -> Self {
        let [width, depth] = config.ground.size_m;
        let count = f64::from(config.fleet.count.max(config.id.0.saturating_add(1)));
        let index = f64::from(id.0);
        let rows = (count * depth / width).sqrt().round().clamp(1.0, count);
        let row = (index * rows / count).floor();
        let first = (row * count / rows).ceil();
        let columns = ((row + 1.0) * count / rows).ceil() - first;
        Self { column: index - first, columns, row, rows }
    }

    /// Its middle, from west to east and from south to north, as parts of the region.
    pub(super) fn middle(&self) -> [f64; 2] {
        [(self.column + 0.5) / self.columns, (self.row + 0.5) / self.rows]
    }

    /// Adds its cells to a raster that covers the region `size_m`, metres.
    pub(super) fn add_to(&self, set: &mut Raster, [width, depth]: [f64; 2]) {
        let x = |column: f64| (column / self.columns - 0.5) * width;
        let y = |row: f64| (row / self.rows - 0.5) * depth;
        let columns = set.grid().columns_between(x(self.column), x(self.column + 1.0));
        for row in set.grid().rows_between(y(self.row), y(self.row + 1.0)) {
            set.set_run(row, columns.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use csat_proto::raster::Grid;

    use super::*;
    use crate::guidance::tests::default_config;

    /// Each cell is in one share, and the middle of a share is that of its cells.
    #[test]
    fn shares_cover_the_region_once() {
        for (count, size_m) in [
            (1, [900.0, 200.0]),
            (2, [100.0, 900.0]),
            (4, [400.0, 400.0]),
            (7, [900.0, 300.0]),
            (5, [100.0, 400.0]),
        ] {
            let mut config = default_config();
            config.fleet.count = count;
            config.ground.size_m = size_m;
            let grid = Grid::covering(&config.ground, 2.0);
            let (mut all, mut cells) = (Raster::empty(grid), 0);
            for id in 0..count {
                let mut own = Raster::empty(grid);
                Share::of(&config, AgentId(id)).add_to(&mut own, size_m);
                let of_all = f64::from(own.count()) * f64::from(count) / grid.cells() as f64;
                assert!(of_all > 0.6 && of_all < 1.8, "{count} {size_m:?}: {of_all}");
                let middle = Share::of(&config, AgentId(id)).middle();
                for axis in 0..2 {
                    let of = |(column, row)| grid.centre(column, row)[axis];
                    let mean = own.iter().map(of).sum::<f64>() / f64::from(own.count());
                    let expected = (middle[axis] - 0.5) * size_m[axis];
                    assert!((mean - expected).abs() <= 2.0, "{count} {id}: {mean} {expected}");
                }
                cells += own.count();
                all.union_with(&own);
            }
            assert_eq!((all.count() as usize, cells as usize), (grid.cells(), grid.cells()));
        }
    }
}
