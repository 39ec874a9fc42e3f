//! What `str4` sees from where, remembered: its search comes by the same places again and again, in
//! both passes and at the next decision, and casting shadows is most of what a look costs.
//!
//! Poses are rounded to [`SNAP_M`], a fraction of a footprint, so that near ones share a view, and
//! heights to [`STOREY_DM`], so that a map that only grows more exact changes little. Where buildings grew
//! since, a view loses what they hide; only where one vanished is it found anew.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::TAU;

use csat_proto::camera::Pose;
use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::{Grid, Raster};

use super::criterion::Sight;
use super::shadow::{Fan, Tower};
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;

/// Positions are rounded to multiples of this, metres.
const SNAP_M: f64 = 8.0;
/// Heights are rounded to multiples of this, decimetres, none of them to 0.
const STOREY_DM: u16 = 10;
/// Headings are told apart by this share of a radian.
const PER_RADIAN: f64 = 200.0;
/// From this many views on, those that nobody looked at of late are forgotten: some 16 MB.
const MOST: usize = 16_000;

/// A pose, rounded: multiples of [`SNAP_M`] east and north, heading, millimetres up.
pub(super) type Place = (i32, i32, i32, i32);

/// The place of a pose.
pub(super) fn place(pose: &Pose) -> Place {
    let [x, y, z] = pose.p_world;
    let snap = |v: f64| (v / SNAP_M).round() as i32;
    let heading = (pose.yaw_rad.rem_euclid(TAU) * PER_RADIAN).round() as i32;
    (snap(x), snap(y), heading, (z * 1e3).round() as i32)
}

/// What is seen from a place.
#[derive(Debug, Clone)]
pub(super) struct View {
    /// The cells, as (row, word of the row, bits).
    words: Vec<(u16, u16, u64)>,
    /// Where it is seen from, `world`, metres.
    eye: [f64; 3],
    /// Where buildings may be in the way; `None` for anywhere.
    fan: Option<Fan>,
    /// How many changes of the map were there when it was last known to hold.
    changes: usize,
    /// The last load of a map after which it was looked at.
    looked: u64,
}

impl View {
    /// set ∪= view.
    pub(super) fn add_to(&self, set: &mut Raster) {
        for &(row, word, bits) in &self.words {
            set.row_mut(row.into())[usize::from(word)] |= bits;
        }
    }

    /// |set ∩ view|, cells.
    pub(super) fn count_in(&self, set: &Raster) -> u32 {
        let common = |&(row, word, bits): &(u16, u16, u64)| {
            (set.row(row.into())[usize::from(word)] & bits).count_ones()
        };
        self.words.iter().map(common).sum()
    }

    /// set \ view.
    pub(super) fn take_from(&self, set: &mut Raster) {
        for &(row, word, bits) in &self.words {
            set.row_mut(row.into())[usize::from(word)] &= !bits;
        }
    }

    /// Takes away what has grown in the way; false if something in the way vanished.
    fn follow(&mut self, changes: &[Change], sight: &mut Sight) -> bool {
        let foot = [self.eye[0], self.eye[1]];
        let may_hide = |tower: &Tower| self.fan.as_ref().is_none_or(|fan| tower.is_in(fan, foot));
        let mut grown = Vec::new();
        for change in changes {
            match change {
                Change::Grown(tower) if may_hide(tower) => grown.push(*tower),
                Change::Vanished(tower) if may_hide(tower) => return false,
                _ => {}
            }
        }
        if !grown.is_empty() {
            sight.look_at(&grown, self.eye);
            self.words.retain_mut(|(row, word, bits)| {
                *bits = sight.seen(None, (*row).into(), (*word).into(), *bits);
                *bits != 0
            });
        }
        true
    }
}

/// What happened to the building of a cell.
#[derive(Debug, Clone)]
enum Change {
    /// It is new or higher, and stands like this.
    Grown(Tower),
    /// It stood like this, and does not stand there or is lower.
    Vanished(Tower),
}

/// The views of one map. What is remembered changes the time a look takes and nothing else.
#[derive(Debug, Clone)]
pub(super) struct Views {
    sight: Sight,
    buildings: Option<Oem>,
    /// The buildings of cells that changed, one after the other.
    changes: Vec<Change>,
    /// Maps loaded so far.
    loads: u64,
    known: BTreeMap<Place, View>,
}

impl Views {
    /// No view yet, on `grid`.
    pub(super) fn new(grid: Grid, config: &AgentConfig) -> Self {
        Self {
            sight: Sight::wide(grid, config),
            buildings: None,
            changes: Vec::new(),
            loads: 0,
            known: BTreeMap::new(),
        }
    }

    /// The next looks are in the world of `oem`.
    pub(super) fn load(&mut self, oem: &Oem) {
        self.loads += 1;
        if self.known.len() > MOST {
            self.known.retain(|_, view| view.looked + 1 >= self.loads);
        }
        let buildings = buildings(oem);
        match &self.buildings {
            Some(before) if *before == buildings => return,
            Some(before) if before.grid() == buildings.grid() => {
                self.changes.extend(changed(before, &buildings));
            }
            _ => self.known.clear(),
        }
        self.sight.load(&buildings);
        self.buildings = Some(buildings);
    }

    /// F \ H^OEM at the place of `pose`.
    pub(super) fn look(&mut self, pose: &Pose) -> &View {
        let place = place(pose);
        let view = match self.known.entry(place) {
            Entry::Vacant(unknown) => unknown.insert(looked(&mut self.sight, place, pose)),
            Entry::Occupied(known) => {
                let view = known.into_mut();
                if !view.follow(&self.changes[view.changes..], &mut self.sight) {
                    *view = looked(&mut self.sight, place, pose);
                }
                view
            }
        };
        (view.changes, view.looked) = (self.changes.len(), self.loads);
        view
    }
}

/// Looks from a place, at the altitude and heading of `pose`.
fn looked(sight: &mut Sight, place: Place, pose: &Pose) -> View {
    let [x, y] = [place.0, place.1].map(|v| f64::from(v) * SNAP_M);
    let eye = [x, y, pose.p_world[2]];
    let footprint = sight.look(&Pose::level(eye, pose.yaw_rad));
    let seen = |(row, word, bits)| (row as u16, word as u16, sight.seen(None, row, word, bits));
    View {
        words: footprint.words().map(seen).filter(|(.., bits)| *bits != 0).collect(),
        eye,
        fan: Fan::around([x, y], footprint.corners()),
        changes: 0,
        looked: 0,
    }
}

/// What stands in a map, its heights rounded.
fn buildings(oem: &Oem) -> Oem {
    let mut buildings = Oem::unexplored(*oem.grid());
    for OemDelta { cell, state } in oem.known() {
        if let OemCell::Occupied { height_dm } = state {
            let storeys = height_dm.saturating_add(STOREY_DM / 2) / STOREY_DM;
            let height_dm = storeys.max(1).saturating_mul(STOREY_DM);
            buildings.join(OemDelta { cell, state: OemCell::Occupied { height_dm } });
        }
    }
    buildings
}

/// How two maps of one grid differ.
fn changed<'a>(before: &'a Oem, after: &'a Oem) -> impl Iterator<Item = Change> + 'a {
    let (columns, pairs) = (after.grid().columns, before.cells().iter().zip(after.cells()));
    let changed = pairs.zip(0..).filter(|((before, after), _)| before != after);
    changed.filter_map(move |(_, cell)| {
        let [stood, stands] =
            [before, after].map(|oem| Tower::wide(oem, cell % columns, cell / columns));
        match (stood, stands) {
            (Some(stood), None) => Some(Change::Vanished(stood)),
            (Some(stood), Some(stands)) if stands.height < stood.height => {
                Some(Change::Vanished(stood))
            }
            (_, stands) => stands.map(Change::Grown),
        }
    })
}
