//! Pieces of a belief as squares, and what can be made of them.

use csat_proto::raster::Grid;

use crate::search_map::{CELL_M, SearchMap};
use crate::tiles::{MAX_LEVEL, MAX_TILES, STEPS_PER_NAT, Tile, Tiles};

/// A square piece of a belief.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Its centre, `world`, metres.
    pub centre: [f64; 2],
    /// Its side, metres.
    pub side_m: f64,
    /// Its probability, up to a factor that is the same for all.
    pub mass: f64,
}

/// A density is not said to be farther below the greatest than this.
const DEEPEST_NATS: f64 = 64.0;
/// A tile with more of the probability than this is divided, if the belief is finer there.
const MAX_SHARE: f64 = 1.0 / 512.0;

impl Square {
    /// Parts that are not larger than `side_m`.
    fn parts(&self, side_m: f64) -> impl Iterator<Item = Self> + use<> {
        let square = *self;
        let is_whole = square.side_m <= side_m;
        let count = if is_whole { 1 } else { (square.side_m / side_m - 1e-9).ceil() as u32 };
        let part = square.side_m / f64::from(count);
        let at =
            move |middle: f64, i: u32| middle - square.side_m / 2.0 + (f64::from(i) + 0.5) * part;
        let mass = square.mass / f64::from(count * count);
        (0..count).flat_map(move |j| {
            (0..count).map(move |i| Self {
                centre: [at(square.centre[0], i), at(square.centre[1], j)],
                side_m: part,
                mass,
            })
        })
    }
}

/// The probability of each cell of a raster: a square counts where its centre is.
pub fn map(grid: Grid, squares: &[Square]) -> SearchMap {
    let mut mass = vec![0.0; grid.cells()];
    for part in squares.iter().flat_map(|square| square.parts(grid.cell_m)) {
        if let Some((column, row)) = grid.cell_of(part.centre) {
            mass[grid.index(column, row)] += part.mass;
        }
    }
    let sum: f64 = mass.iter().sum();
    mass.iter_mut().for_each(|m| *m /= sum);
    SearchMap { grid, mass }
}

/// The same as tiles, for a message.
pub fn tiles(grid: &Grid, squares: &[Square]) -> Tiles {
    let mut cells: Vec<Vec<Square>> = vec![Vec::new(); grid.cells()];
    for part in squares.iter().flat_map(|square| square.parts(CELL_M)) {
        if let Some((column, row)) = grid.cell_of(part.centre) {
            cells[grid.index(column, row)].push(part);
        }
    }
    let total: f64 = squares.iter().map(|square| square.mass).sum();
    let mut divided = Division { grid, most: MAX_SHARE * total, tiles: Vec::new() };
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            divided.add(0, column, row, std::mem::take(&mut cells[grid.index(column, row)]));
        }
    }
    let densities = divided.tiles.iter().map(|(_, density)| *density);
    let peak = densities.fold(0.0, f64::max);
    let depth = |density: f64| {
        let nats = (peak / density).ln();
        (nats.min(DEEPEST_NATS) * STEPS_PER_NAT).round() as u16
    };
    let tile = |(tile, density): (Tile, f64)| Tile { depth: depth(density), ..tile };
    Tiles(divided.tiles.into_iter().map(tile).collect())
}

/// Tiles under way, with their densities.
struct Division<'a> {
    grid: &'a Grid,
    most: f64,
    tiles: Vec<(Tile, f64)>,
}

impl Division<'_> {
    fn add(&mut self, level: u8, column: u32, row: u32, squares: Vec<Square>) {
        let side_m = CELL_M / f64::from(1u32 << level);
        let mass: f64 = squares.iter().map(|square| square.mass).sum();
        let is_finer = squares.iter().any(|square| square.side_m < 0.75 * side_m);
        let is_full = self.tiles.len() + self.grid.cells() + 64 > MAX_TILES;
        if mass <= self.most || !is_finer || level == MAX_LEVEL || is_full {
            let tile = Tile { level, column, row, depth: 0 };
            return self.tiles.push((tile, mass / (side_m * side_m)));
        }
        let [x, y] = self.grid.origin();
        let middle = [x + (f64::from(column) + 0.5) * side_m, y + (f64::from(row) + 0.5) * side_m];
        let mut quarters: [Vec<Square>; 4] = Default::default();
        for part in squares.into_iter().flat_map(|square| square.parts(side_m / 2.0)) {
            let east = usize::from(part.centre[0] >= middle[0]);
            quarters[east + 2 * usize::from(part.centre[1] >= middle[1])].push(part);
        }
        for (index, quarter) in (0..).zip(quarters) {
            self.add(level + 1, 2 * column + index % 2, 2 * row + index / 2, quarter);
        }
    }
}
