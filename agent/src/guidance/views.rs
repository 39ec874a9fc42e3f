//! What `str4` sees from where, remembered: its search comes by the same places again and again, in
//! both passes and at the next decision, and casting shadows is most of what a look costs.
//!
//! Poses are rounded to [`SNAP_M`], a fraction of a footprint, so that near ones share a view.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use csat_proto::camera::Pose;
use csat_proto::raster::{Grid, Raster};

use super::criterion::Sight;
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;

/// Positions are rounded to multiples of this, metres.
const SNAP_M: f64 = 8.0;
/// Headings are told apart by this share of a radian.
const PER_RADIAN: f64 = 200.0;
/// More views than this are not kept from one decision to the next: some 16 MB.
const MOST: usize = 10_000;

/// A pose, rounded: multiples of [`SNAP_M`] east and north, heading, millimetres up.
pub(super) type Place = (i32, i32, i32, i32);

/// The place of a pose.
pub(super) fn place(pose: &Pose) -> Place {
    let [x, y, z] = pose.p_world;
    let snap = |v: f64| (v / SNAP_M).round() as i32;
    let heading = (pose.yaw_rad.rem_euclid(TAU) * PER_RADIAN).round() as i32;
    (snap(x), snap(y), heading, (z * 1e3).round() as i32)
}

/// The cells that are seen from a place, as (row, word of the row, bits).
#[derive(Debug, Clone)]
pub(super) struct View(Vec<(u32, usize, u64)>);

impl View {
    /// set ∪= view.
    pub(super) fn add_to(&self, set: &mut Raster) {
        for &(row, word, bits) in &self.0 {
            set.row_mut(row)[word] |= bits;
        }
    }

    /// set \= view.
    pub(super) fn take_from(&self, set: &mut Raster) {
        for &(row, word, bits) in &self.0 {
            set.row_mut(row)[word] &= !bits;
        }
    }
}

/// The views of one OEM. What is remembered changes the time a look takes and nothing else.
#[derive(Debug, Clone)]
pub(super) struct Views {
    sight: Sight,
    oem: Option<Oem>,
    known: BTreeMap<Place, View>,
}

impl Views {
    /// No view yet, on `grid`.
    pub(super) fn new(grid: Grid, config: &AgentConfig) -> Self {
        Self { sight: Sight::wide(grid, config), oem: None, known: BTreeMap::new() }
    }

    /// The next looks are in the world of `oem`.
    pub(super) fn load(&mut self, oem: &Oem) {
        let is_new = self.oem.as_ref() != Some(oem);
        if is_new {
            self.oem = Some(oem.clone());
            self.sight.load(oem);
        }
        if is_new || self.known.len() > MOST {
            self.known.clear();
        }
    }

    /// F \ H^OEM at the place of `pose`.
    pub(super) fn look(&mut self, pose: &Pose) -> &View {
        let place = place(pose);
        self.known.entry(place).or_insert_with(|| {
            let [x, y] = [place.0, place.1].map(|v| f64::from(v) * SNAP_M);
            let rounded = Pose::level([x, y, pose.p_world[2]], pose.yaw_rad);
            let footprint = self.sight.look(&rounded);
            let seen = |(row, word, bits)| (row, word, self.sight.seen(None, row, word, bits));
            View(footprint.words().map(seen).filter(|word| word.2 != 0).collect())
        })
    }
}
