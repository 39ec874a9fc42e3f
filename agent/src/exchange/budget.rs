//! Simplifies messages until they fit a budget of bytes and the number of vertices that receivers
//! accept, without breaking the guarantee.
//!
//! Outer approximations grow and inner ones shrink until a message fits. Each level doubles the
//! tolerance, which increases with the distance of a shape from the nearest UAV. Rasters without a
//! guarantee are left out at higher levels. At the last level inner approximations are empty and
//! outer ones are boxes. If a message does not fit even then, it is not sent.

use csat_proto::message::{Digest, Fact, Known, Message, Snapshot};
use csat_proto::oem::OemPatch;
use csat_proto::raster::Raster;
use csat_proto::region::{GridBox, GridPoint, Region, Shape, metres};

use super::validate::check_vertices;
use crate::mutant::{Mutant, is_on};
use crate::region::{Inner, Outer};

/// Tolerance of the first level next to a UAV, metres.
const FINEST_M: f64 = 0.25;
/// The tolerance grows by its own size for every this many metres from the nearest UAV.
const DISTANCE_M: f64 = 50.0;
/// Levels of simplification; after the last one sets are empty or boxes.
pub const LEVELS: u32 = 8;
/// From this level on the views of cameras and the digest are left out, and sets are too coarse to
/// replace the facts that they were made of.
const COARSE_LEVEL: u32 = 4;
/// Runs of map cells at the first level; each further level has half as many.
const RUNS: usize = 512;

/// Of the messages that `said` makes at levels 0, 1, …, the finest one with at most `max_vertices`
/// whose encoded body has at most `room` bytes: its level and that body.
///
/// Messages get shorter with each level, so the search begins at `first`, the level of the last
/// message. With a small budget, making all finer messages would take more time than the rest of the
/// agent's step.
pub fn fit(
    room: f64,
    max_vertices: u32,
    first: u32,
    said: impl Fn(u32) -> Message,
) -> Option<(u32, Vec<u8>)> {
    let at = |level: u32| Some((level, fitting(room, max_vertices, &said(level))?));
    let first = first.min(LEVELS);
    match at(first) {
        Some(fitting) => Some((0..first).rev().map_while(at).last().unwrap_or(fitting)),
        None => (first + 1..=LEVELS).find_map(at),
    }
}

/// The encoded body of a message with at most `max_vertices`, if it has at most `room` bytes.
pub fn fitting(room: f64, max_vertices: u32, message: &Message) -> Option<Vec<u8>> {
    check_vertices(max_vertices, message).ok()?;
    let body = encode(message);
    (body.len() as f64 <= room).then_some(body)
}

/// The body of a message.
pub fn encode(message: &Message) -> Vec<u8> {
    postcard::to_stdvec(message).expect("a message always serialises")
}

/// Simplifies sets by their distance from the UAVs.
#[derive(Debug, Clone)]
pub struct Shortener {
    level: u32,
    /// Positions of UAVs, metres.
    uavs: Vec<[f64; 2]>,
    /// X_g.
    ground: Outer,
}

impl Shortener {
    /// A shortener for UAVs at `uavs` (`world`, metres) over X_g: sets near them keep more detail.
    /// Each level is coarser than the one before; level 0 changes nothing.
    pub fn new(level: u32, uavs: &[[f64; 2]], ground: &Region) -> Self {
        Self { level, uavs: uavs.to_vec(), ground: Outer::containing(ground.clone()) }
    }

    /// A shorter fact that claims less. At coarse levels it has no digest, which would be most of its
    /// bytes.
    pub fn fact(&self, fact: &Fact) -> Fact {
        if self.level == 0 {
            return fact.clone();
        }
        let is_coarse = self.level >= COARSE_LEVEL;
        let view = |raster: &Raster| match is_coarse {
            false => raster.clone(),
            true => Raster::empty(*raster.grid()),
        };
        let mut short = Fact {
            held: if is_coarse { Digest::default() } else { fact.held.clone() },
            clear_ground: self.inner(&fact.clear_ground),
            obstacle_margin: self.inner(&fact.obstacle_margin),
            hidden: view(&fact.hidden),
            seen: view(&fact.seen),
            oem: self.patch(&fact.oem),
            ..fact.clone()
        };
        for target in &mut short.targets {
            target.location = self.outer(&target.location);
            target.exclusion = self.inner(&target.exclusion);
        }
        short
    }

    /// A shorter snapshot that claims less. At coarse levels it does not list the facts that it
    /// contains, so that receivers which are missing them do not take them for held.
    pub fn snapshot(&self, fact: &Fact, known: &Known) -> Snapshot {
        Snapshot { fact: self.fact(fact), known: self.known(known) }
    }

    /// Shorter knowledge that claims less.
    fn known(&self, known: &Known) -> Known {
        if self.level == 0 {
            return known.clone();
        }
        Known {
            step: known.step,
            targets: known.targets.iter().map(|(j, set)| (*j, self.outer(set))).collect(),
            unexplored: self.outer(&known.unexplored),
            obstacle_margin: self.inner(&known.obstacle_margin),
        }
    }

    fn patch(&self, patch: &OemPatch) -> OemPatch {
        if self.level >= LEVELS {
            OemPatch::default()
        } else {
            patch.first_runs(RUNS >> self.level)
        }
    }

    fn inner(&self, region: &Region) -> Region {
        if self.level >= LEVELS {
            return Region::EMPTY;
        }
        if is_on(Mutant::InnerGrownForBudget) {
            return boxed(region);
        }
        let set = Inner::within(region.clone());
        set.simplified_by(|shape| self.tolerance_m(shape)).into_region()
    }

    fn outer(&self, region: &Region) -> Region {
        if self.level >= LEVELS {
            return boxed(region);
        }
        if is_on(Mutant::OuterShrunkForBudget) {
            let set = Inner::within(region.clone());
            return set.simplified_by(|shape| self.tolerance_m(shape)).into_region();
        }
        let set = Outer::containing(region.clone());
        let simplified = set.simplified_by(|shape| self.tolerance_m(shape));
        simplified.intersection(&self.ground).into_region()
    }

    fn tolerance_m(&self, shape: &Shape) -> f64 {
        let finest_m = FINEST_M * f64::from(1u32 << (self.level - 1));
        let distance_m = GridBox::around(&shape[0]).map_or(0.0, |b| {
            let nearest = |p: &[f64; 2]| {
                let (min, max) = (metres(b.min), metres(b.max));
                (p[0] - p[0].clamp(min[0], max[0])).hypot(p[1] - p[1].clamp(min[1], max[1]))
            };
            self.uavs.iter().map(nearest).fold(f64::INFINITY, f64::min)
        });
        let distance_m = if distance_m.is_finite() { distance_m } else { 0.0 };
        finest_m * (1.0 + distance_m / DISTANCE_M)
    }
}

/// The box around a region.
fn boxed(region: &Region) -> Region {
    let Some(GridBox { min, max }) = region.bounds() else { return Region::EMPTY };
    let corners = [min, GridPoint::new(max.x, min.y), max, GridPoint::new(min.x, max.y)];
    Region::from_shapes(vec![vec![corners.to_vec()]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::grid_pose::GridPose;
    use csat_proto::message::Plan;
    use csat_proto::time::Step;

    /// A message that is shorter at higher levels.
    fn said(level: u32) -> Message {
        let poses = vec![GridPose::default(); (2 * (LEVELS - level) + 1) as usize];
        Message::Plan(Plan { step: Step(1), pass: 0, poses })
    }

    #[test]
    fn wherever_the_search_begins_it_ends_with_the_finest_that_fits() {
        let bytes = |level: u32| encode(&said(level)).len() as f64;
        for first in 0..LEVELS + 3 {
            for level in 0..=LEVELS {
                let found = fit(bytes(level), u32::MAX, first, said);
                assert_eq!(found, Some((level, encode(&said(level)))), "from {first}");
            }
            assert_eq!(fit(bytes(LEVELS) - 1.0, u32::MAX, first, said), None);
        }
    }
}
