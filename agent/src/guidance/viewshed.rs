//! The cells of a map that buildings hide from a cell, for `str4`. They approximate [`super::shadow`]
//! on cells and rays: the search needs so many views that the time of one must not depend on the
//! number of buildings.
//!
//! Rays start in the middle of the cell of the eye (the camera); their cells relative to the eye are
//! the same for every eye. Along a ray the caster tracks the farthest end of the shadows so far: a
//! building of height h that ends at distance d hides, from height z, the ground up to d·z/(z-h).
//! Each cell belongs to the ray nearest to it.

use std::ops::Range;

use csat_proto::raster::Grid;

use super::height_map::{HeightMap, Layout, STOREY_M};
use crate::estimate::oem::Oem;

/// The unit of stretches is 1 / `STRETCH`.
const STRETCH: u64 = 1 << 10;
/// A stretch that exceeds every range.
const FARTHEST: u64 = 1 << 32;
/// The axes of the quadrants: east, north, west, south. To the left of each lies the next.
const AXES: [[i32; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// The position of a ray of a quadrant at some cell along its axis, in cells to the left of the axis.
#[derive(Debug, Clone, Copy)]
struct RayStep {
    /// The cell that the ray passes.
    passes: i16,
    /// The first cell that belongs to the ray; the last one is before the first cell of the next ray.
    first: i16,
}

/// A set of rays, a bit each.
pub(super) type Rays = Vec<u64>;

/// The cells of a map that are hidden from the middle of one of its cells, or of one outside it.
#[derive(Debug, Clone)]
pub(super) struct Viewshed {
    /// (column, row).
    eye: [i32; 2],
    z_m: f64,
    /// Its range, cells.
    reach: i32,
    /// The rays that were cast; cells of other rays are not computed yet.
    cast: Rays,
    /// The south-west corner of `hidden`: its row, and its word of a row of the map.
    corner: [i32; 2],
    words_per_row: i32,
    /// The hidden cells.
    hidden: Vec<u64>,
}

impl Viewshed {
    /// The cells of `bits` that are not hidden; `bits` are cells in one word of one row, in range,
    /// whose rays were cast.
    pub(super) fn seen(&self, row: i32, word: i32, bits: u64) -> u64 {
        let index = (row - self.corner[1]) * self.words_per_row + word - self.corner[0];
        bits & !self.hidden[index as usize]
    }

    /// The layout of the bits of `hidden`.
    fn layout(&self) -> Layout {
        let stride = 64 * self.words_per_row;
        Layout { stride, origin: -self.corner[1] * stride - 64 * self.corner[0] }
    }

    fn hide(&mut self, bit: i32) {
        self.hidden[bit as usize / 64] |= 1 << (bit % 64);
    }
}

/// Finds viewsheds in a map.
#[derive(Debug, Clone)]
pub(super) struct RayCaster {
    height_map: HeightMap,
    /// The length of rays, cells along the axis of their quadrant; each quadrant has as many rays.
    reach: i32,
    /// By ray of a quadrant, with one more than there are, and by cell along its axis.
    steps: Vec<RayStep>,
    /// By storeys: the factor from the distance of the far side of a building to the end of its
    /// shadow, seen from `z_m`; in units of 1 / [`STRETCH`].
    stretch: [u64; 256],
    z_m: f64,
}

impl RayCaster {
    /// A caster of an empty map on `grid`, for views up to `reach_m` on the ground.
    pub(super) fn new(grid: Grid, reach_m: f64) -> Self {
        let reach = (reach_m / grid.cell_m).ceil().clamp(1.0, f64::from(i16::MAX)) as i32;
        let step = |ray: i32, cell: i32| RayStep {
            passes: ((2 * ray + 1 - reach) * cell + reach / 2).div_euclid(reach) as i16,
            first: -((reach - 2 * ray) * cell).div_euclid(reach) as i16,
        };
        Self {
            height_map: HeightMap::of(&Oem::unexplored(grid), &grid, reach),
            reach,
            steps: (0..=reach).flat_map(|r| (0..=reach).map(move |c| step(r, c))).collect(),
            stretch: [0; 256],
            z_m: f64::NAN,
        }
    }

    /// The heights of its map.
    pub(super) fn height_map(&self) -> &HeightMap {
        &self.height_map
    }

    /// Loads `oem` for the next rays; false if its heights are the same as before.
    pub(super) fn load(&mut self, oem: &Oem) -> bool {
        let height_map = HeightMap::of(oem, self.height_map.grid(), self.reach);
        let is_new = height_map != self.height_map;
        self.height_map = height_map;
        is_new
    }

    /// The ray of a cell given relative to the eye (east, north); `None` for the cell of the eye.
    pub(super) fn ray_of(&self, cell: [i32; 2]) -> Option<usize> {
        let dot = |axis: [i32; 2]| axis[0] * cell[0] + axis[1] * cell[1];
        (0..4).find_map(|quadrant| {
            let (along, across) = (dot(AXES[quadrant]), dot(AXES[(quadrant + 1) % 4]));
            let ray = || (across + along) * self.reach / (2 * along);
            let is_inside = along > 0 && (-along..along).contains(&across);
            is_inside.then(|| quadrant * self.reach as usize + ray() as usize)
        })
    }

    /// The rays of these cells.
    pub(super) fn rays_of(&self, cells: impl Iterator<Item = [i32; 2]>) -> Rays {
        let mut rays = self.no_rays();
        cells
            .filter_map(|cell| self.ray_of(cell))
            .for_each(|ray| rays[ray / 64] |= 1 << (ray % 64));
        rays
    }

    fn no_rays(&self) -> Rays {
        vec![0; (4 * self.reach as usize).div_ceil(64)]
    }

    /// An empty viewshed from `z_m` above the middle of a cell (column, row), up to `reach_m` on the
    /// ground; no ray is cast yet.
    pub(super) fn viewshed(&self, eye: [i32; 2], z_m: f64, reach_m: f64) -> Viewshed {
        let reach = self.reach.min((reach_m / self.height_map.grid().cell_m).ceil() as i32);
        let corner = [(eye[0] - reach).div_euclid(64), eye[1] - reach];
        let words_per_row = (eye[0] + reach).div_euclid(64) - corner[0] + 1;
        let words = words_per_row * (2 * reach + 1);
        let hidden = vec![0; words as usize];
        Viewshed { eye, z_m, reach, cast: self.no_rays(), corner, words_per_row, hidden }
    }

    /// Casts those of `rays` that were not cast before.
    pub(super) fn cast(&mut self, viewshed: &mut Viewshed, rays: &Rays) {
        if !self.height_map.is_in_reach_of(viewshed.eye) {
            return;
        }
        self.set_height(viewshed.z_m);
        for (word, rays) in rays.iter().enumerate() {
            let mut rest = rays & !viewshed.cast[word];
            viewshed.cast[word] |= rest;
            while rest != 0 {
                self.cast_ray(viewshed, word * 64 + rest.trailing_zeros() as usize);
                rest &= rest - 1;
            }
        }
    }

    fn set_height(&mut self, z_m: f64) {
        if self.z_m == z_m {
            return;
        }
        self.z_m = z_m;
        for (stretch, storeys) in self.stretch.iter_mut().zip(0..) {
            let height = f64::from(storeys) * STOREY_M;
            // A building as high as the eye hides all ground behind it.
            let factor = if height < z_m { z_m / (z_m - height) } else { f64::INFINITY };
            *stretch = (factor * STRETCH as f64).min(FARTHEST as f64) as u64;
        }
        self.stretch[0] = 0;
    }

    /// The number of cells along its axis until the cells of a ray of a quadrant are out of range.
    fn cells_within(&self, reach: i32, ray: usize) -> i32 {
        let least = ((2 * ray as i32 + 1 - self.reach).abs() - 1).max(0);
        let least = f64::from(least) / f64::from(self.reach);
        (f64::from(reach) / (1.0 + least * least).sqrt()) as i32 + 1
    }

    /// Marks the hidden cells of a ray.
    fn cast_ray(&self, viewshed: &mut Viewshed, ray: usize) {
        let (quadrant, ray) = (ray / self.reach as usize, ray % self.reach as usize);
        let axes = [AXES[quadrant], AXES[(quadrant + 1) % 4]];
        let (eye, axis) = (viewshed.eye, quadrant % 2);
        let cells = self.cells_within(viewshed.reach, ray);
        let inside = inside(eye[axis], axes[0][axis], self.height_map.sides()[axis], cells);
        let steps = |ray: usize| &self.steps[ray * (self.reach as usize + 1)..];
        let (steps, next) = (steps(ray), steps(ray + 1));
        let at = self.height_map.layout().walk(eye, axes);
        let hidden_at = viewshed.layout().walk(eye, axes);
        // The end of the shadows, in units of half a cell / STRETCH.
        let mut end = 0;
        for cell in inside {
            let step = steps[cell as usize];
            let storeys = self.height_map.storeys_at(at.index(cell, step.passes));
            // Most cells have no building.
            if storeys > 0 {
                end = end.max((2 * cell as u64 + 1) * self.stretch[usize::from(storeys)]);
            }
            if 2 * cell as u64 * STRETCH < end {
                let cells = step.first..next[cell as usize].first;
                cells.for_each(|off| viewshed.hide(hidden_at.index(cell, off)));
            }
        }
    }
}

/// Which of the `cells` cells from `from` on, `step` by `step`, are among the first `length` of all.
fn inside(from: i32, step: i32, length: i32, cells: i32) -> Range<i32> {
    let (first, end) =
        if step > 0 { (-from, length - from) } else { (from - length + 1, from + 1) };
    let first = first.clamp(0, cells);
    first..end.clamp(first, cells)
}

#[cfg(test)]
#[path = "viewshed_tests.rs"]
mod tests;
