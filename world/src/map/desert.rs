//! A suburb in the desert: streets without buildings, as around Lancaster, California (Gagliardi et al. 2014,
//! figure 8).
//!
//! The corners are a grid whose points are displaced at random. A random spanning tree of the grid's pieces is
//! always built, so that all streets are connected. Of the other pieces some are built, each of which closes a
//! loop, some end half-way, and the rest is left out. A few pieces lead to the border.

use csat_proto::model::Ground;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::{Map, MapConfig};
use crate::plane::{Point, between};
use crate::random::{StreamPurpose, stream};

/// Corners are displaced by at most this share of the spacing, along either axis.
const JITTER: f64 = 0.1;
/// How far dead ends reach, as a share of their piece.
const DEAD_END: std::ops::RangeInclusive<f64> = 0.3..=0.65;
/// The most streets that cross the border.
const MAX_EXITS: usize = 4;

/// `[map.desert]`: which streets a desert suburb has beside those that connect all its corners.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DesertModel {
    /// The share of the further pieces of street that are built, 0..1: each closes a loop. With 0 the network
    /// is a tree.
    pub loop_share: f64,
    /// The share of the further pieces of street that end half-way, 0..1.
    pub dead_end_share: f64,
}

impl Default for DesertModel {
    fn default() -> Self {
        Self { loop_share: 0.1, dead_end_share: 0.3 }
    }
}

impl DesertModel {
    /// Whether it is the default.
    pub(super) fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

/// The suburb of `seed`.
pub(super) fn streets(config: &MapConfig, seed: u64) -> Map {
    let mut rng = stream(seed, StreamPurpose::Desert);
    let grid = Grid::draw(config, &mut rng);
    let mut roads = grid.inner_streets(&config.desert, &mut rng);
    roads.extend(grid.exits(&mut rng));
    Map { roads, ..Map::open(Ground { size_m: config.size_m }) }
}

/// The corners of the streets, row by row.
struct Grid {
    half_m: [f64; 2],
    count: [usize; 2],
    corners: Vec<Point>,
}

impl Grid {
    fn draw(config: &MapConfig, rng: &mut ChaCha8Rng) -> Self {
        let count = config.size_m.map(|size_m| (size_m / config.road_spacing_m).round().max(1.0));
        let half_m = config.size_m.map(|size_m| size_m / 2.0);
        let pitch_m = [0, 1].map(|axis| config.size_m[axis] / count[axis]);
        let mut corner = |index: [usize; 2]| {
            [0, 1].map(|axis| {
                let jitter = rng.random_range(-JITTER..=JITTER);
                (index[axis] as f64 + 0.5 + jitter) * pitch_m[axis] - half_m[axis]
            })
        };
        let count = count.map(|n| n as usize);
        let corners =
            (0..count[0] * count[1]).map(|i| corner([i % count[0], i / count[0]])).collect();
        Self { half_m, count, corners }
    }

    /// The pieces between neighbouring corners.
    fn pieces(&self) -> Vec<[usize; 2]> {
        let [columns, rows] = self.count;
        let all = 0..columns * rows;
        let east = all.clone().filter(|i| i % columns + 1 < columns).map(|i| [i, i + 1]);
        let north = all.filter(|i| i / columns + 1 < rows).map(|i| [i, i + columns]);
        east.chain(north).collect()
    }

    /// A spanning tree, and what is built of the other pieces.
    fn inner_streets(&self, model: &DesertModel, rng: &mut ChaCha8Rng) -> Vec<Vec<Point>> {
        let mut pieces = self.pieces();
        pieces.shuffle(rng);
        let mut network: Vec<usize> = (0..self.corners.len()).collect();
        let mut roads = Vec::new();
        for [a, b] in pieces {
            let ends = [self.corners[a], self.corners[b]];
            if network[a] != network[b] {
                let (kept, joined) = (network[a], network[b]);
                network.iter_mut().filter(|n| **n == joined).for_each(|n| *n = kept);
                roads.push(ends.to_vec());
            } else {
                roads.extend(further(ends, model, rng));
            }
        }
        roads
    }

    /// Between 1 and [`MAX_EXITS`] streets from the outermost corners to the border, one of them to the west.
    fn exits(&self, rng: &mut ChaCha8Rng) -> Vec<Vec<Point>> {
        let [columns, rows] = self.count;
        let [x, y] = self.half_m;
        let to_side = |corner: usize, axis: usize, border_m: f64| {
            let mut end = self.corners[corner];
            end[axis] = border_m;
            vec![self.corners[corner], end]
        };
        let west = |row: usize| to_side(row * columns, 0, -x);
        let first = rng.random_range(0..rows);
        let mut others: Vec<_> = (0..rows).filter(|row| *row != first).map(west).collect();
        others.extend((0..rows).map(|row| to_side((row + 1) * columns - 1, 0, x)));
        others.extend((0..columns).map(|column| to_side(column, 1, -y)));
        others.extend((0..columns).map(|column| to_side((rows - 1) * columns + column, 1, y)));
        others.shuffle(rng);
        others.truncate(rng.random_range(0..MAX_EXITS));
        std::iter::once(west(first)).chain(others).collect()
    }
}

/// What is built of a piece of street that the tree can do without.
fn further(ends: [Point; 2], model: &DesertModel, rng: &mut ChaCha8Rng) -> Option<Vec<Point>> {
    let (u, reach): (f64, f64) = (rng.random(), rng.random_range(DEAD_END));
    let [from, to] = if rng.random_bool(0.5) { ends } else { [ends[1], ends[0]] };
    if u < model.loop_share {
        return Some(vec![from, to]);
    }
    (u < model.loop_share + model.dead_end_share).then(|| vec![from, between(from, to, reach)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapKind;
    use crate::road_area::{CELL_M, RoadArea, neighbours};
    use crate::start_line::StartLine;

    fn config(desert: DesertModel) -> MapConfig {
        MapConfig { kind: MapKind::Desert, desert, ..MapConfig::default() }
    }

    /// Pieces that are built in full less those that a tree of the corners has; dead ends; and exits.
    fn census(desert: DesertModel, seed: u64) -> [usize; 3] {
        let config = config(desert);
        let map = streets(&config, seed);
        let grid = Grid::draw(&config, &mut stream(seed, StreamPurpose::Desert));
        let is_corner = |p: &Point| grid.corners.contains(p);
        let on_border = |p: &Point| (0..2).any(|axis| p[axis].abs() == 250.0);
        let ends = |is: &dyn Fn(&Point) -> bool| map.roads.iter().filter(|r| is(&r[1])).count();
        let (full, exits) = (ends(&is_corner), ends(&on_border));
        [full + 1 - grid.corners.len(), map.roads.len() - full - exits, exits]
    }

    #[test]
    fn some_seeds_give_trees_and_some_loops_and_all_have_exits() {
        let all: Vec<[usize; 3]> =
            (0..60).map(|seed| census(DesertModel::default(), seed)).collect();
        let trees = all.iter().filter(|[loops, ..]| *loops == 0).count();
        assert!((5..40).contains(&trees), "{trees} trees of 60");
        assert!(all.iter().any(|[_, dead_ends, _]| *dead_ends > 3), "{all:?}");
        for exits in 1..=MAX_EXITS {
            assert!(all.iter().any(|one| one[2] == exits), "{exits} exits: {all:?}");
        }
        assert!(all.iter().all(|one| (1..=MAX_EXITS).contains(&one[2])));
    }

    #[test]
    fn the_shares_say_what_is_built() {
        let model = |loop_share, dead_end_share| DesertModel { loop_share, dead_end_share };
        for seed in 0..10 {
            // A grid of 5 x 5 corners has 40 pieces, and a tree of them 24.
            assert_eq!(census(model(0.0, 0.0), seed)[..2], [0, 0]);
            assert_eq!(census(model(1.0, 0.0), seed)[..2], [16, 0]);
            assert_eq!(census(model(0.0, 1.0), seed)[..2], [0, 16]);
        }
    }

    #[test]
    fn the_seed_is_the_suburb_and_one_exit_leads_to_the_west() {
        let config = config(DesertModel::default());
        assert_eq!(streets(&config, 4), streets(&config, 4));
        assert_ne!(streets(&config, 4).roads, streets(&config, 5).roads);
        for seed in 0..20 {
            let map = streets(&config, seed);
            assert!(map.roads.iter().any(|road| road[1][0] == -250.0), "{seed}");
            assert!(map.obstacles.is_empty() && map.warnings.is_empty());
            assert!(map.roads.iter().flatten().all(|p| map.ground.contains(*p)));
        }
    }

    /// How many pieces of ground the roads enclose: those without a way to the outside over sides of cells.
    fn enclosed(roads: &RoadArea) -> usize {
        // A margin of one cell around the raster is outside.
        let size = [roads.columns() + 2, roads.rows() + 2];
        let index = |[column, row]: [usize; 2]| row * size[0] + column;
        let mut is_done = vec![false; size[0] * size[1]];
        for cell in roads.cells() {
            let [column, row] = roads.place(cell);
            is_done[index([column + 1, row + 1])] = true;
        }
        let mut pieces = 0;
        for start in 0..is_done.len() {
            pieces += usize::from(!is_done[start]);
            let mut found = vec![[start % size[0], start / size[0]]];
            while let Some(cell) = found.pop() {
                if !std::mem::replace(&mut is_done[index(cell)], true) {
                    let is_side =
                        |[c, r]: &[usize; 2]| c.abs_diff(cell[0]) + r.abs_diff(cell[1]) == 1;
                    found.extend(neighbours(cell, size).filter(is_side));
                }
            }
        }
        pieces - 1
    }

    #[test]
    fn the_road_area_is_connected_and_has_the_loops_of_the_streets() {
        for (seed, loop_share) in [(1, 0.0), (2, 0.0), (3, 0.3), (4, 1.0)] {
            let desert = DesertModel { loop_share, ..DesertModel::default() };
            let desert = DesertModel { dead_end_share: 0.3 * (1.0 - loop_share), ..desert };
            let roads = RoadArea::new(&streets(&config(desert), seed), CELL_M);
            assert_eq!(enclosed(&roads), census(desert, seed)[0], "{seed}");
            let start = StartLine::choose(&roads, None).unwrap();
            assert_eq!(roads.component(&start), roads, "{seed}");
            assert_eq!(StartLine::all(&roads).len(), census(desert, seed)[2], "{seed}");
        }
    }
}
