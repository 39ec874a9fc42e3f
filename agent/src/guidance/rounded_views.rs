//! A cache of the views of `str4` by rounded pose: the search passes the same poses many times, and
//! again at the next decision while the map is the same.
//!
//! Positions are rounded to every third cell, a fraction of a footprint, so that near poses share a
//! view. The viewshed of a position is computed once for all headings, and the footprint of a heading
//! once for all positions.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

use csat_proto::camera::{CameraModel, Pose, PoseError};
use csat_proto::model::Ground;
use csat_proto::raster::{Grid, Raster};

use super::footprint::Footprint;
use super::height_map::HeightMap;
use super::viewshed::{RayCaster, Rays, Viewshed};
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;
use crate::sense::pose_box::PoseBox;

/// Positions are rounded to multiples of this, cells.
const SNAP_CELLS: f64 = 3.0;
/// Number of rounded headings.
const HEADINGS: i32 = 1440;
/// Beyond this number of views the cache is cleared; they take about 30 MB.
const MOST: usize = 16_000;

/// The rounded position of a camera: (column, row), also outside the grid, and altitude, millimetres.
type Eye = ([i32; 2], i32);
/// The heading of a camera and its height above the plane that it looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Aim {
    /// In units of a turn / [`HEADINGS`].
    heading: i32,
    /// Above the plane that is looked at.
    altitude_mm: i32,
}

impl Aim {
    /// The pose with this aim above the origin.
    fn pose(self) -> Pose {
        let yaw_rad = f64::from(self.heading) * TAU / f64::from(HEADINGS);
        Pose::level([0.0, 0.0, f64::from(self.altitude_mm) / 1e3], yaw_rad)
    }
}

/// A pose, rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RoundedPose {
    cell: [i32; 2],
    heading: i32,
    altitude_mm: i32,
}

impl RoundedPose {
    /// `pose` rounded on `grid`.
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

    /// All fields as one number.
    fn key(&self) -> u128 {
        let Self { cell: [column, row], heading, altitude_mm } = *self;
        let parts = [column, row, heading, altitude_mm].map(|part| u128::from(part as u32));
        parts.iter().fold(0, |key, part| key << 32 | part)
    }

    /// Its cell, (column, row).
    pub(super) fn cell(&self) -> [i32; 2] {
        self.cell
    }

    /// The aim from there at a horizontal plane at this height, metres.
    pub(super) fn aim_above(&self, height_m: f64) -> Aim {
        let altitude_mm = self.altitude_mm - (height_m * 1e3).round() as i32;
        Aim { heading: self.heading, altitude_mm }
    }
}

impl Ord for RoundedPose {
    /// A single comparison, because lookups of poses dominate the search.
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

impl PartialOrd for RoundedPose {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Cells of a raster: row, word of the row, bits of the word.
pub(super) type Bits = (i32, i32, u64);

/// F for one heading.
#[derive(Debug, Clone)]
pub(super) struct HeadingFootprint {
    /// Rows, and the columns in each, relative to the camera.
    runs: Vec<(i32, Range<i32>)>,
    /// Upper bound of the distances on the ground, for all headings, metres.
    reach_m: f64,
}

impl HeadingFootprint {
    /// What `camera` sees, without obstacles, of a plane of cells of `cell_m` from above the middle
    /// of a cell.
    pub(super) fn of(camera: &CameraModel, error: &PoseError, aim: Aim, cell_m: f64) -> Self {
        // The origin is the middle of the middle cell.
        let reach = (camera.d_max_m / cell_m).ceil();
        let ground = Ground { size_m: [(2.0 * reach + 1.0) * cell_m; 2] };
        let window = Grid::covering(&ground, cell_m);
        let view = camera.at(&aim.pose());
        let poses = PoseBox::new(&view, &aim.pose(), error);
        let footprint = Footprint::of(&view, &poses, &window);
        let from_eye = |cell: u32| cell as i32 - reach as i32;
        let run =
            |(row, run): (u32, Range<u32>)| (from_eye(row), from_eye(run.start)..from_eye(run.end));
        let corners = footprint.corners().iter().map(|corner| corner[0].hypot(corner[1]));
        let reach_m = corners.fold(0.0, f64::max).min(camera.d_max_m);
        Self { runs: footprint.rows().map(run).collect(), reach_m }
    }

    /// Its cells (column, row), relative to the camera.
    fn cells(&self) -> impl Iterator<Item = [i32; 2]> + '_ {
        self.runs.iter().flat_map(|(row, run)| run.clone().map(|column| [column, *row]))
    }

    /// Its cells on `grid` for a camera above the cell (x, y).
    fn words(&self, [x, y]: [i32; 2], grid: &Grid) -> impl Iterator<Item = Bits> + '_ {
        let (columns, rows) = (grid.columns as i32, 0..grid.rows as i32);
        let inside = self.runs.iter().filter(move |(row, _)| rows.contains(&(y + row)));
        inside.flat_map(move |(row, run)| {
            let [start, end] = [run.start, run.end].map(|column| (x + column).clamp(0, columns));
            let words = if start < end { start / 64..(end - 1) / 64 + 1 } else { 0..0 };
            words.map(move |word| (y + row, word, bits_between(start, end, word)))
        })
    }

    /// Its cells in one word of a row of the grid, for a camera above the cell (x, y).
    pub(super) fn word(&self, [x, y]: [i32; 2], row: i32, word: i32) -> u64 {
        let first = self.runs.first().map_or(0, |(row, _)| *row);
        let run = usize::try_from(row - y - first).ok().and_then(|index| self.runs.get(index));
        run.map_or(0, |(_, run)| bits_between(x + run.start, x + run.end, word))
    }
}

/// The bits of a word of a row that are in a run of columns.
fn bits_between(start: i32, end: i32, word: i32) -> u64 {
    let [low, high] = [start, end].map(|column| (column - word * 64).clamp(0, 64));
    if low < high { (u64::MAX << low) & (u64::MAX >> (64 - high)) } else { 0 }
}

/// The cells that are seen from a pose, as (word of a raster, bits).
#[derive(Debug, Clone, Default)]
pub(super) struct VisibleCells(Vec<(u32, u64)>);

impl VisibleCells {
    pub(super) const fn nothing() -> Self {
        Self(Vec::new())
    }

    /// The cells of `bits`.
    pub(super) fn of(grid: &Grid, bits: impl Iterator<Item = Bits>) -> Self {
        let words_per_row = grid.columns.div_ceil(64);
        let index = |row: i32, word: i32| row as u32 * words_per_row + word as u32;
        let some = bits.filter(|&(.., bits)| bits != 0);
        // Enough for most views.
        let mut words = Vec::with_capacity(128);
        words.extend(some.map(|(row, word, bits)| (index(row, word), bits)));
        words.shrink_to_fit();
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

    /// |a ∩ b ∩ view|, cells.
    pub(super) fn count_in_both(&self, a: &Raster, b: &Raster) -> u32 {
        let (a, b) = (a.words(), b.words());
        let common = |&(word, bits): &(u32, u64)| a[word as usize] & b[word as usize] & bits;
        self.0.iter().map(|word| common(word).count_ones()).sum()
    }

    /// set \ view.
    pub(super) fn take_from(&self, set: &mut Raster) {
        let words = set.words_mut();
        self.0.iter().for_each(|&(word, bits)| words[word as usize] &= !bits);
    }
}

/// The cached views of one map. The cache changes the time of a look and no result.
#[derive(Debug, Clone)]
pub(super) struct RoundedViews {
    camera: CameraModel,
    pose_error: PoseError,
    grid: Grid,
    caster: RayCaster,
    /// Footprints with the rays of their cells.
    footprints: BTreeMap<Aim, (HeadingFootprint, Rays)>,
    viewsheds: BTreeMap<Eye, Viewshed>,
    known: BTreeMap<RoundedPose, VisibleCells>,
}

impl RoundedViews {
    /// An empty cache on `grid`.
    pub(super) fn new(grid: Grid, config: &AgentConfig) -> Self {
        Self {
            camera: config.planning_camera(),
            pose_error: config.pose_error,
            grid,
            caster: RayCaster::new(grid, config.planning_camera().d_max_m),
            footprints: BTreeMap::new(),
            viewsheds: BTreeMap::new(),
            known: BTreeMap::new(),
        }
    }

    /// See [`super::PlannerInput::pose_error`].
    pub(super) fn expect(&mut self, error: &PoseError) {
        if self.pose_error != *error {
            self.pose_error = *error;
            self.forget();
        }
    }

    fn forget(&mut self) {
        self.known.clear();
        self.viewsheds.clear();
        self.footprints.clear();
    }

    /// Loads `oem` for the next looks.
    pub(super) fn load(&mut self, oem: &Oem) {
        if self.caster.load(oem) || self.known.len() > MOST {
            self.forget();
        }
    }

    /// The heights of the loaded map.
    pub(super) fn height_map(&self) -> &HeightMap {
        self.caster.height_map()
    }

    /// F \ H^OEM at `place`.
    pub(super) fn look(&mut self, place: RoundedPose) -> &VisibleCells {
        let Self { camera, pose_error, grid, caster, footprints, viewsheds, known } = self;
        known.entry(place).or_insert_with(|| {
            let aim = place.aim_above(0.0);
            let (footprint, rays) = footprints.entry(aim).or_insert_with(|| {
                let footprint = HeadingFootprint::of(camera, pose_error, aim, grid.cell_m);
                let rays = caster.rays_of(footprint.cells());
                (footprint, rays)
            });
            let viewshed = viewsheds.entry((place.cell, place.altitude_mm)).or_insert_with(|| {
                let z_m = aim.pose().p_world[2];
                caster.viewshed(place.cell, z_m, footprint.reach_m)
            });
            caster.cast(viewshed, rays);
            let seen = |(row, word, bits)| (row, word, viewshed.seen(row, word, bits));
            VisibleCells::of(grid, footprint.words(place.cell, grid).map(seen))
        })
    }
}
