//! Buildings that no UAV has looked at from nearby yet, for `str4`.
//!
//! A UAV that looks at a building from nearby learns X° in and around it, from which X^Δ never grows
//! again. The prediction (5.27) does not model that: its X° is constant. So cells beside buildings
//! that have always been in X^Δ have a bonus when they are looked at for the first time. After two
//! looks that added nothing to X° the cell has no bonus any more.

use std::collections::BTreeMap;

use csat_proto::camera::{CameraModel, Pose, PoseError};
use csat_proto::raster::{Grid, Raster};

use super::height_map::{HeightMap, STOREY_M};
use super::rounded_views::{Aim, Bits, HeadingFootprint, RoundedPose, VisibleCells};
use crate::config::AgentConfig;

/// X° is the ground that is certainly within the obstacle distance. Depth errors above this share of
/// the obstacle distance leave little of it.
const DEPTH_ERROR: f64 = 0.5;
/// Heights of roofs are rounded up to multiples of this, storeys.
const ROOF_STOREYS: u8 = 5;
/// How far from the known part of a building an unknown part may be, metres.
const BESIDE_M: f64 = 12.0;

static NOTHING: VisibleCells = VisibleCells::nothing();

/// The cells that are to be looked at for the first time.
#[derive(Debug, Clone)]
pub(super) struct FirstLooks {
    /// The camera of guidance with the range within which a look adds to X°.
    camera: CameraModel,
    pose_error: PoseError,
    grid: Grid,
    /// The cells that were in X^Δ \ X° at every decision so far, without those that were looked at
    /// twice.
    unknown: Raster,
    /// The cells that were looked at once.
    once: Raster,
    /// `unknown` beside buildings, at this decision, by the height of their roofs, metres.
    roofs: Vec<(f64, Vec<Bits>)>,
    /// The footprints of a camera by its heading and its height above a roof.
    footprints: BTreeMap<Aim, HeadingFootprint>,
    /// The cells of `roofs` that are seen from a rounded pose.
    known: BTreeMap<RoundedPose, VisibleCells>,
}

impl FirstLooks {
    /// Before the first decision, on `grid`.
    pub(super) fn new(grid: Grid, config: &AgentConfig) -> Self {
        let mut unknown = Raster::empty(grid);
        (0..grid.rows).for_each(|row| unknown.set_run(row, 0..grid.columns));
        let [low, high] = config.camera.depth_noise.map(f64::abs);
        let reach_m = DEPTH_ERROR * config.targets.obstacle_distance_m / low.max(high);
        let camera = config.planning_camera();
        Self {
            camera: CameraModel { d_max_m: camera.d_max_m.min(reach_m), ..camera },
            pose_error: config.pose_error,
            grid,
            unknown,
            once: Raster::empty(grid),
            roofs: Vec::new(),
            footprints: BTreeMap::new(),
            known: BTreeMap::new(),
        }
    }

    /// See [`super::PlannerInput::pose_error`].
    pub(super) fn expect(&mut self, error: &PoseError) {
        if self.pose_error != *error {
            self.pose_error = *error;
            self.footprints.clear();
        }
    }

    /// Begins the next decision, at `pose`, with X^Δ in `wanted`, X° in `margin` and the buildings of
    /// `height_map`.
    pub(super) fn load(
        &mut self,
        wanted: &Raster,
        margin: &Raster,
        height_map: &HeightMap,
        pose: &Pose,
    ) {
        self.unknown.intersect_with(wanted);
        self.unknown.subtract(margin);
        self.roofs = self.roofs_of(height_map);
        self.known.clear();
        let mut seen = Raster::empty(self.grid);
        self.look(RoundedPose::of(pose, &self.grid)).add_to(&mut seen);
        let mut twice = seen.clone();
        twice.intersect_with(&self.once);
        self.unknown.subtract(&twice);
        self.once.union_with(&seen);
    }

    /// The unknown cells beside the buildings of `height_map`, the highest first.
    fn roofs_of(&self, height_map: &HeightMap) -> Vec<(f64, Vec<Bits>)> {
        let (mut roofs, mut rest) = (Vec::new(), self.unknown.clone());
        for step in (0..height_map.highest().div_ceil(ROOF_STOREYS)).rev() {
            let mut beside = height_map.near(step * ROOF_STOREYS + 1, BESIDE_M);
            beside.intersect_with(&rest);
            rest.subtract(&beside);
            let words = (0..self.grid.rows).flat_map(|row| {
                let words = (0..).zip(beside.row(row)).filter(|(_, bits)| **bits != 0);
                words.map(move |(word, bits)| (row as i32, word, *bits))
            });
            let storeys = f64::from(step + 1) * f64::from(ROOF_STOREYS);
            roofs.push((storeys * STOREY_M, words.collect()));
        }
        roofs
    }

    /// The cells whose roofs are in the image and nearby at `place`.
    pub(super) fn look(&mut self, place: RoundedPose) -> &VisibleCells {
        if self.roofs.is_empty() {
            return &NOTHING;
        }
        let Self { camera, pose_error, grid, roofs, footprints, known, .. } = self;
        known.entry(place).or_insert_with(|| {
            let mut words = Vec::new();
            for (height_m, cells) in roofs {
                let aim = place.aim_above(*height_m);
                let footprint = footprints
                    .entry(aim)
                    .or_insert_with(|| HeadingFootprint::of(camera, pose_error, aim, grid.cell_m));
                let eye = place.cell();
                let seen =
                    |&(row, word, bits): &Bits| (row, word, bits & footprint.word(eye, row, word));
                words.extend(cells.iter().map(seen));
            }
            VisibleCells::of(grid, words.into_iter())
        })
    }
}

#[cfg(test)]
#[path = "first_looks_tests.rs"]
mod tests;
