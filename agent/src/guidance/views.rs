//! What `str4` sees from where, remembered: its search comes by the same places again and again, at the
//! next decision too while the map stays as it is.
//!
//! Places are every third cell, a fraction of a footprint, so that near poses share a view. What is
//! hidden from a place is found once for all headings, and where a heading looks once for all places.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::model::Ground;
use csat_proto::raster::{Grid, Raster};

use super::footprint::Footprint;
use super::viewshed::{RayCaster, Rays, Viewshed};
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;

/// Cells from place to place.
const SNAP_CELLS: f64 = 3.0;
/// Headings that are told apart.
const HEADINGS: i32 = 1440;
/// From this many views on, all are forgotten: some 30 MB.
const MOST: usize = 16_000;

/// Where a camera is, rounded: (column, row), also outside the grid, and altitude, millimetres.
type Eye = ([i32; 2], i32);
/// How it looks: heading, shares of a turn, and altitude, millimetres.
type Aim = (i32, i32);

/// A pose, rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    cell: [i32; 2],
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
        let heading = (pose.yaw_rad / TAU * f64::from(HEADINGS)).round() as i32;
        let heading = heading.rem_euclid(HEADINGS);
        Self { cell, heading, altitude_mm: (p[2] * 1e3).round() as i32 }
    }

    /// In its middle.
    pub(super) fn pose(&self, grid: &Grid) -> Pose {
        let [x, y] = [0, 1]
            .map(|axis| grid.origin()[axis] + (f64::from(self.cell[axis]) + 0.5) * grid.cell_m);
        let yaw_rad = f64::from(self.heading) * TAU / f64::from(HEADINGS);
        Pose::level([x, y, f64::from(self.altitude_mm) / 1e3], yaw_rad)
    }
}

/// F for one heading.
#[derive(Debug, Clone)]
struct Outlook {
    /// Rows, and the columns in each, from the eye on.
    runs: Vec<(i32, Range<i32>)>,
    /// Those that these cells take.
    rays: Rays,
}

impl Outlook {
    /// What `camera` sees from `pose`, the middle of a cell of `cell_m`, where nothing hides it.
    fn of(camera: &CameraModel, pose: &Pose, cell_m: f64, caster: &RayCaster) -> Self {
        let reach = caster.reach();
        // The middle of its middle cell is the origin.
        let size_m = f64::from(2 * reach + 1) * cell_m;
        let window = Grid::covering(&Ground { size_m: [size_m; 2] }, cell_m);
        let above = Pose { p_world: [0.0, 0.0, pose.p_world[2]], ..*pose };
        let footprint = Footprint::of(&camera.at(&above), &window);
        let from_eye = |cell: u32| cell as i32 - reach;
        let runs: Vec<(i32, Range<i32>)> = footprint
            .rows()
            .map(|(row, run)| (from_eye(row), from_eye(run.start)..from_eye(run.end)))
            .collect();
        let cells = runs.iter().flat_map(|(y, run)| run.clone().map(|x| [x, *y]));
        let rays = caster.rays_of(cells);
        Self { runs, rays }
    }
}

/// What is seen from a place: cells, as (word of a raster, bits).
#[derive(Debug, Clone, Default)]
pub(super) struct View(Vec<(u32, u64)>);

impl View {
    /// F \ H^OEM on `grid`.
    fn of(outlook: &Outlook, viewshed: &Viewshed, grid: &Grid) -> Self {
        let ([x, y], columns) = (viewshed.eye(), grid.columns as i32);
        let words_per_row = grid.columns.div_ceil(64);
        let mut words = Vec::new();
        for (row, run) in &outlook.runs {
            let row = y + row;
            let [start, end] = [run.start, run.end].map(|column| (x + column).clamp(0, columns));
            if start >= end || !(0..grid.rows as i32).contains(&row) {
                continue;
            }
            for word in start / 64..=(end - 1) / 64 {
                let (low, high) = ((start - word * 64).max(0), (end - word * 64).min(64));
                let run = (u64::MAX << low) & (u64::MAX >> (64 - high));
                let bits = viewshed.seen(row, word, run);
                if bits != 0 {
                    words.push((row as u32 * words_per_row + word as u32, bits));
                }
            }
        }
        Self(words)
    }

    /// set ∪= view.
    pub(super) fn add_to(&self, set: &mut Raster) {
        let words = set.words_mut();
        self.0.iter().for_each(|&(word, bits)| words[word as usize] |= bits);
    }

    /// |set ∩ view|, cells.
    pub(super) fn count_in(&self, set: &Raster) -> u32 {
        let words = set.words();
        self.0.iter().map(|&(word, bits)| (words[word as usize] & bits).count_ones()).sum()
    }

    /// set \ view.
    pub(super) fn take_from(&self, set: &mut Raster) {
        let words = set.words_mut();
        self.0.iter().for_each(|&(word, bits)| words[word as usize] &= !bits);
    }
}

/// The views of one map. What is remembered changes the time a look takes and nothing else.
#[derive(Debug, Clone)]
pub(super) struct Views {
    camera: CameraModel,
    grid: Grid,
    caster: RayCaster,
    outlooks: BTreeMap<Aim, Outlook>,
    viewsheds: BTreeMap<Eye, Viewshed>,
    known: BTreeMap<Place, View>,
}

impl Views {
    /// No view yet, on `grid`.
    pub(super) fn new(grid: Grid, config: &AgentConfig) -> Self {
        Self {
            camera: config.camera,
            grid,
            caster: RayCaster::new(grid, config.camera.d_max_m),
            outlooks: BTreeMap::new(),
            viewsheds: BTreeMap::new(),
            known: BTreeMap::new(),
        }
    }

    /// The next looks are in the world of `oem`.
    pub(super) fn load(&mut self, oem: &Oem) {
        if self.caster.load(oem) || self.known.len() > MOST {
            self.known.clear();
            self.viewsheds.clear();
            self.outlooks.clear();
        }
    }

    /// F \ H^OEM at the place of `pose`.
    pub(super) fn look(&mut self, pose: &Pose) -> &View {
        let place = Place::of(pose, &self.grid);
        let Self { camera, grid, caster, outlooks, viewsheds, known } = self;
        known.entry(place).or_insert_with(|| {
            let pose = place.pose(grid);
            let outlook = outlooks
                .entry((place.heading, place.altitude_mm))
                .or_insert_with(|| Outlook::of(camera, &pose, grid.cell_m, caster));
            let viewshed = viewsheds
                .entry((place.cell, place.altitude_mm))
                .or_insert_with(|| caster.viewshed(place.cell, pose.p_world[2]));
            caster.cast(viewshed, &outlook.rays);
            View::of(outlook, viewshed, grid)
        })
    }
}
