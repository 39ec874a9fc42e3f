//! What the buildings of a map hide from a cell, for `str4`: as [`super::shadow`] has it, but on cells
//! and rays alone. It asks for so many views that what each costs must not depend on how many buildings
//! there are.
//!
//! Rays leave the middle of the eye's cell; they and the cells they pass are the same for every eye. On
//! its way out a ray carries how far the highest shadow reaches that it has met: a building of height h
//! that ends at distance d hides from height z what is nearer than d·z/(z-h). Cells take the ray that is
//! next to them.

use std::ops::Range;

use csat_proto::raster::Grid;

use super::height_map::{HeightMap, Layout, STOREY_M};
use crate::estimate::oem::Oem;

/// Parts of 1 that stretches are told in.
const STRETCH: u64 = 1 << 10;
/// A stretch beyond all reach.
const FARTHEST: u64 = 1 << 32;
/// The axes of the quadrants: east, north, west, south. To the left of each lies the next.
const AXES: [[i32; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// A ray of a quadrant, so many cells along its axis; in cells to the left of the axis.
#[derive(Debug, Clone, Copy)]
struct RayStep {
    /// The cell it passes.
    passes: i16,
    /// The first cell that takes this ray: the last one comes before the first of the next ray.
    first: i16,
}

/// Rays by number, a bit each.
pub(super) type Rays = Vec<u64>;

/// The cells of a map that are hidden from the middle of one of its cells, or of one outside it.
#[derive(Debug, Clone)]
pub(super) struct Viewshed {
    /// (column, row).
    eye: [i32; 2],
    z_m: f64,
    /// How far it goes, cells.
    reach: i32,
    /// The rays that were cast: nothing is known of the cells of others.
    cast: Rays,
    /// The south-west corner of `hidden`: its row, and its word of a row of the map.
    corner: [i32; 2],
    words_per_row: i32,
    /// The hidden cells.
    hidden: Vec<u64>,
}

impl Viewshed {
    /// Those of `bits`, cells of one word of one row within reach, whose rays were cast, that are not
    /// hidden.
    pub(super) fn seen(&self, row: i32, word: i32, bits: u64) -> u64 {
        let index = (row - self.corner[1]) * self.words_per_row + word - self.corner[0];
        bits & !self.hidden[index as usize]
    }

    /// Where the bits of `hidden` are.
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
    /// How far rays go, cells along their quadrant's axis; there are as many rays in a quadrant.
    reach: i32,
    /// By ray of a quadrant, with one past the last, and cell along its axis.
    steps: Vec<RayStep>,
    /// By storeys: what the distance of their far side is multiplied by to give their shadow's end, seen
    /// from `z_m`; in shares of [`STRETCH`].
    stretch: [u64; 256],
    z_m: f64,
}

impl RayCaster {
    /// Of an empty map on `grid`, for looks no farther than `reach_m` on the ground.
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

    /// What it casts rays in.
    pub(super) fn height_map(&self) -> &HeightMap {
        &self.height_map
    }

    /// The next rays are cast in `oem`; false if it looks as before.
    pub(super) fn load(&mut self, oem: &Oem) -> bool {
        let height_map = HeightMap::of(oem, self.height_map.grid(), self.reach);
        let is_new = height_map != self.height_map;
        self.height_map = height_map;
        is_new
    }

    /// The ray that a cell takes which is so far east and north of the eye; none for the eye's own.
    pub(super) fn ray_of(&self, cell: [i32; 2]) -> Option<usize> {
        let dot = |axis: [i32; 2]| axis[0] * cell[0] + axis[1] * cell[1];
        (0..4).find_map(|quadrant| {
            let (along, across) = (dot(AXES[quadrant]), dot(AXES[(quadrant + 1) % 4]));
            let ray = || (across + along) * self.reach / (2 * along);
            let is_inside = along > 0 && (-along..along).contains(&across);
            is_inside.then(|| quadrant * self.reach as usize + ray() as usize)
        })
    }

    /// Those rays.
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

    /// What is hidden from `z_m` above the middle of a cell, (column, row), within `reach_m` on the ground:
    /// nothing, until rays are cast.
    pub(super) fn viewshed(&self, eye: [i32; 2], z_m: f64, reach_m: f64) -> Viewshed {
        let reach = self.reach.min((reach_m / self.height_map.grid().cell_m).ceil() as i32);
        let corner = [(eye[0] - reach).div_euclid(64), eye[1] - reach];
        let words_per_row = (eye[0] + reach).div_euclid(64) - corner[0] + 1;
        let words = words_per_row * (2 * reach + 1);
        let hidden = vec![0; words as usize];
        Viewshed { eye, z_m, reach, cast: self.no_rays(), corner, words_per_row, hidden }
    }

    /// Casts those of `rays` that were not.
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
            // What is as high as the eye hides all that lies behind.
            let factor = if height < z_m { z_m / (z_m - height) } else { f64::INFINITY };
            *stretch = (factor * STRETCH as f64).min(FARTHEST as f64) as u64;
        }
        self.stretch[0] = 0;
    }

    /// How many cells along its axis a ray of a quadrant takes until those that take it are out of reach.
    fn cells_within(&self, reach: i32, ray: usize) -> i32 {
        let least = ((2 * ray as i32 + 1 - self.reach).abs() - 1).max(0);
        let least = f64::from(least) / f64::from(self.reach);
        (f64::from(reach) / (1.0 + least * least).sqrt()) as i32 + 1
    }

    /// Finds which cells that take a ray are hidden.
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
        // In halves of a cell and shares of STRETCH.
        let mut end = 0;
        for cell in inside {
            let step = steps[cell as usize];
            let storeys = self.height_map.storeys_at(at.index(cell, step.passes));
            // Mostly there is nothing.
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
