//! A belief in a message: squares, each with one density.

use csat_proto::raster::Grid;
use serde::{Deserialize, Serialize};

/// The most tiles of a message.
pub const MAX_TILES: usize = 65_536;
/// The deepest level: tiles of 12.5 m / 2⁸.
pub const MAX_LEVEL: u8 = 8;
/// Steps of a density per nat.
pub const STEPS_PER_NAT: f64 = 64.0;

/// A square and its density. Tiles of level ℓ are cells of a grid whose side is 2^-ℓ of that of level 0, which
/// is [`CELL_M`](crate::search_map::CELL_M) for all agents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tile {
    /// ℓ.
    pub level: u8,
    /// The column in the grid of its level, from the west.
    pub column: u32,
    /// The row in the grid of its level, from the south.
    pub row: u32,
    /// How far the natural logarithm of its density is below the greatest of all tiles, in 64ths.
    pub depth: u16,
}

/// A belief in tiles that cover the region once, in the order of [`Tile::place`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Tiles(pub Vec<Tile>);

impl Tile {
    /// Its place in the order: by cells of level 0, row by row, and within them along a Z-order curve.
    pub fn place(&self) -> (u32, u32, u64) {
        let level = self.level.min(MAX_LEVEL);
        let (column, row) = (self.column >> level, self.row >> level);
        let shift = MAX_LEVEL - level;
        let mask = (1u32 << level) - 1;
        let (c, r) = ((self.column & mask) << shift, (self.row & mask) << shift);
        let spread =
            |x: u32| (0..MAX_LEVEL).fold(0u64, |z, bit| z | u64::from(x >> bit & 1) << (2 * bit));
        (row, column, spread(c) | spread(r) << 1)
    }

    /// How many of the smallest tiles it covers.
    fn size(&self) -> u64 {
        1 << (2 * (MAX_LEVEL - self.level))
    }
}

impl Tiles {
    /// ln of the density at a point, `world`, metres, relative to the greatest; of the nearest tile for a point
    /// outside. `grid` is that of level 0.
    pub fn ln_density(&self, grid: &Grid, p: [f64; 2]) -> f64 {
        let [x, y] = grid.origin();
        let smallest = grid.cell_m / f64::from(1u32 << MAX_LEVEL);
        let along = |distance: f64, count: u32| {
            let most = f64::from((count << MAX_LEVEL) - 1);
            (distance / smallest).floor().clamp(0.0, most) as u32
        };
        let (column, row) = (along(p[0] - x, grid.columns), along(p[1] - y, grid.rows));
        let place = Tile { level: MAX_LEVEL, column, row, depth: 0 }.place();
        let after = self.0.partition_point(|tile| tile.place() <= place);
        let tile = after.checked_sub(1).and_then(|index| self.0.get(index));
        tile.map_or(0.0, |tile| -f64::from(tile.depth) / STEPS_PER_NAT)
    }

    /// Whether they cover the cells of `grid` (level 0), each place once. Tiles of others may be anything.
    pub fn is_cover(&self, grid: &Grid) -> bool {
        let is_valid = |tile: &Tile| {
            tile.level <= MAX_LEVEL
                && tile.column >> tile.level < grid.columns
                && tile.row >> tile.level < grid.rows
        };
        if self.0.len() > MAX_TILES || !self.0.iter().all(is_valid) {
            return false;
        }
        let whole = 1u64 << (2 * MAX_LEVEL);
        let mut next = (0u32, 0u32, 0u64);
        for tile in &self.0 {
            if tile.place() != next {
                return false;
            }
            next.2 += tile.size();
            if next.2 == whole {
                next = (next.0, next.1 + 1, 0);
                if next.1 == grid.columns {
                    next = (next.0 + 1, 0, 0);
                }
            }
        }
        next == (grid.rows, 0, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::model::Ground;

    fn tile(level: u8, column: u32, row: u32) -> Tile {
        Tile { level, column, row, depth: 0 }
    }

    #[test]
    fn a_cover_has_each_place_once() {
        let grid = Grid::covering(&Ground { size_m: [25.0, 12.5] }, 12.5);
        let cover = vec![
            tile(1, 0, 0),
            tile(2, 2, 0),
            tile(2, 3, 0),
            tile(2, 2, 1),
            tile(2, 3, 1),
            tile(1, 0, 1),
            tile(1, 1, 1),
            tile(0, 1, 0),
        ];
        assert!(Tiles(cover.clone()).is_cover(&grid));
        for index in 0..cover.len() {
            let mut without = cover.clone();
            let taken = without.remove(index);
            assert!(!Tiles(without.clone()).is_cover(&grid));
            without.push(taken);
            assert!(index + 1 == cover.len() || !Tiles(without.clone()).is_cover(&grid));
            without.push(tile(0, 1, 0));
            assert!(!Tiles(without).is_cover(&grid));
        }
        assert!(!Tiles(vec![tile(40, u32::MAX, u32::MAX)]).is_cover(&grid));
        assert!(!Tiles(vec![]).is_cover(&grid));
    }
}
