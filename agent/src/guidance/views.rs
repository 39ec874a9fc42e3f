//! What `str4` sees from where, remembered: its search comes by the same places again and again, at the
//! next decision too while the map stays as it is.
//!
//! Places are every third cell, a fraction of a footprint, so that near poses share a view.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::raster::{Grid, Raster};

use super::footprint::Footprint;
use super::viewshed::Viewshed;
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;

/// Cells from place to place.
const SNAP_CELLS: f64 = 3.0;
/// Headings are told apart by this share of a radian.
const PER_RADIAN: f64 = 200.0;
/// From this many views on, all are forgotten: some 16 MB.
const MOST: usize = 16_000;

/// A pose, rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    /// (column, row), also outside the grid.
    cell: [i32; 2],
    /// In shares of 1 / [`PER_RADIAN`].
    heading: i32,
    altitude_mm: i32,
}

impl Place {
    /// The place of `pose` on `grid`.
    pub(super) fn of(pose: &Pose, grid: &Grid) -> Self {
        let (p, origin) = (pose.p_world, grid.origin());
        let cell = [0, 1].map(|axis| {
            let cells = (p[axis] - origin[axis]) / grid.cell_m - 0.5;
            ((cells / SNAP_CELLS).round() * SNAP_CELLS) as i32
        });
        let heading = (pose.yaw_rad.rem_euclid(TAU) * PER_RADIAN).round() as i32;
        Self { cell, heading, altitude_mm: (p[2] * 1e3).round() as i32 }
    }
}

/// What is seen from a place: cells, as (row, word of the row, bits).
#[derive(Debug, Clone, Default)]
pub(super) struct View(Vec<(u16, u16, u64)>);

impl View {
    /// set ∪= view.
    pub(super) fn add_to(&self, set: &mut Raster) {
        for &(row, word, bits) in &self.0 {
            set.row_mut(row.into())[usize::from(word)] |= bits;
        }
    }

    /// |set ∩ view|, cells.
    pub(super) fn count_in(&self, set: &Raster) -> u32 {
        let common = |&(row, word, bits): &(u16, u16, u64)| {
            (set.row(row.into())[usize::from(word)] & bits).count_ones()
        };
        self.0.iter().map(common).sum()
    }

    /// set \ view.
    pub(super) fn take_from(&self, set: &mut Raster) {
        for &(row, word, bits) in &self.0 {
            set.row_mut(row.into())[usize::from(word)] &= !bits;
        }
    }
}

/// The views of one map. What is remembered changes the time a look takes and nothing else.
#[derive(Debug, Clone)]
pub(super) struct Views {
    camera: CameraModel,
    grid: Grid,
    viewshed: Viewshed,
    known: BTreeMap<Place, View>,
}

impl Views {
    /// No view yet, on `grid`.
    pub(super) fn new(grid: Grid, config: &AgentConfig) -> Self {
        Self {
            camera: config.camera,
            grid,
            viewshed: Viewshed::new(grid, config.camera.d_max_m),
            known: BTreeMap::new(),
        }
    }

    /// The next looks are in the world of `oem`.
    pub(super) fn load(&mut self, oem: &Oem) {
        if self.viewshed.load(oem) || self.known.len() > MOST {
            self.known.clear();
        }
    }

    /// F \ H^OEM at the place of `pose`.
    pub(super) fn look(&mut self, pose: &Pose) -> &View {
        let place = Place::of(pose, &self.grid);
        self.known.entry(place).or_insert_with(|| {
            let [x, y] = [0, 1].map(|axis| {
                self.grid.origin()[axis] + (f64::from(place.cell[axis]) + 0.5) * self.grid.cell_m
            });
            let z = pose.p_world[2];
            let camera = self.camera.at(&Pose::level([x, y, z], pose.yaw_rad));
            self.viewshed.look_from(place.cell, z);
            let words = Footprint::of(&camera, &self.grid);
            let seen = words.words().map(|(row, word, bits)| {
                (row as u16, word as u16, self.viewshed.seen(row, word, bits))
            });
            View(seen.filter(|(.., bits)| *bits != 0).collect())
        })
    }
}
