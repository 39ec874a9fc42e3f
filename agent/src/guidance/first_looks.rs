//! Buildings that nobody has looked at from nearby, for `str4`.
//!
//! Whoever has a building before the camera, from near enough, learns X° in and around it, and X^Δ never
//! again grows out of there. The prediction (5.27) knows nothing of that: X° stays what it is. So cells
//! beside buildings that have been X^Δ ever since count for more when they are looked at for the first
//! time. Where two looks taught nothing there is nothing to be learnt.

use std::collections::BTreeMap;

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::raster::{Grid, Raster};

use super::height_map::{HeightMap, STOREY_M};
use super::rounded_views::{Aim, Bits, HeadingFootprint, RoundedPose, VisibleCells};
use crate::config::AgentConfig;

/// X° is what is sure to be nearer than the obstacle distance. Depth errors of so much of it leave little.
const DEPTH_ERROR: f64 = 0.5;
/// Roofs are taken to be as high as the next multiple of this, storeys.
const ROOF_STOREYS: u8 = 5;
/// How far from a building that is known more of it may stand, metres.
const BESIDE_M: f64 = 12.0;

static NOTHING: VisibleCells = VisibleCells::nothing();

/// What is left to be looked at for the first time.
#[derive(Debug, Clone)]
pub(super) struct FirstLooks {
    /// One that sees as far as anything is learnt.
    camera: CameraModel,
    grid: Grid,
    /// X^Δ \ X° at every decision so far, but for what was looked at twice.
    unknown: Raster,
    /// What was looked at once.
    once: Raster,
    /// `unknown` beside buildings, at this decision, by the height of their roofs, metres.
    roofs: Vec<(f64, Vec<Bits>)>,
    /// Of a camera so high above a roof.
    footprints: BTreeMap<Aim, HeadingFootprint>,
    /// What is seen of `roofs`.
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
            grid,
            unknown,
            once: Raster::empty(grid),
            roofs: Vec::new(),
            footprints: BTreeMap::new(),
            known: BTreeMap::new(),
        }
    }

    /// The next decision, at `pose`: X^Δ is `wanted`, X° is `margin`, and `height_map` is what stands there.
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

    /// Those cells whose roofs are in the image, and near, at `place`.
    pub(super) fn look(&mut self, place: RoundedPose) -> &VisibleCells {
        if self.roofs.is_empty() {
            return &NOTHING;
        }
        let Self { camera, grid, roofs, footprints, known, .. } = self;
        known.entry(place).or_insert_with(|| {
            let mut words = Vec::new();
            for (height_m, cells) in roofs {
                let aim = place.aim_above(*height_m);
                let footprint = footprints
                    .entry(aim)
                    .or_insert_with(|| HeadingFootprint::of(camera, aim, grid.cell_m));
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
