//! Dilations and erosions by lengths much larger than the details of a set.

use csat_proto::region::{GridBox, Region, Ring, Shape, UNITS_PER_M};

use super::sweep::{dilated_path, eroded_path};
use super::{Disc, Inner, Outer, RULE, filled, overlay};

/// The largest disc that sets are swept with at once, metres.
const FIRST_STAGE_M: f64 = 1.0;
/// Before each stage sets are simplified by this share of its disc's radius.
const STAGE_TOLERANCE: f64 = 1.0 / 32.0;
/// The same for sets that are swept in each period, where the effects of simplifications add up.
const STAGE_TOLERANCE_OF_PERIOD: f64 = 1.0 / 1024.0;

/// A disc of any size, in stages.
///
/// If a set is swept with a disc much larger than its details, the number of crossings of its raw
/// path is the number of pairs of its edges: for thousands of vertices and a minute of age,
/// gigabytes. So the disc is swept in stages, each as large as all stages before it together, with a
/// simplification before each stage: details are removed before they are swept far. The polygons of
/// the stages are homothetic, so their Minkowski sum is the polygon of the whole disc.
#[derive(Debug, Clone)]
pub struct Reach {
    whole: Disc,
    stages: Vec<Stage>,
}

/// One stage of a sweep.
#[derive(Debug, Clone)]
pub(super) struct Stage {
    pub(super) disc: Disc,
    radius_m: f64,
    /// The tolerance of the simplification before it; small compared with the radius.
    pub(super) tolerance_m: f64,
}

impl Reach {
    /// A disc of `radius_m`, by circumscribed polygons of `vertices` corners. Up to a metre it is one
    /// stage.
    pub fn new(radius_m: f64, vertices: u16) -> Self {
        Self::staged(radius_m, vertices, STAGE_TOLERANCE)
    }

    /// The same for sets that are swept in each period, with finer simplifications.
    pub fn of_period(radius_m: f64, vertices: u16) -> Self {
        Self::staged(radius_m, vertices, STAGE_TOLERANCE_OF_PERIOD)
    }

    fn staged(radius_m: f64, vertices: u16, tolerance: f64) -> Self {
        let mut stages = Vec::new();
        let mut done_m = 0.0;
        while done_m < radius_m && radius_m.is_finite() {
            let part_m = (radius_m - done_m).min(f64::max(done_m, FIRST_STAGE_M));
            let tolerance_m = part_m * tolerance;
            let disc = Disc::circumscribed(part_m, vertices);
            stages.push(Stage { disc, radius_m: part_m, tolerance_m });
            done_m += part_m;
        }
        let whole = Disc::circumscribed(radius_m, vertices);
        if stages.is_empty() { Self::at_once(whole) } else { Self { whole, stages } }
    }

    /// A disc that is swept in one stage, whatever its size.
    pub fn at_once(disc: Disc) -> Self {
        let stage = Stage { disc: disc.clone(), radius_m: 0.0, tolerance_m: 0.0 };
        Self { whole: disc, stages: vec![stage] }
    }
}

impl Reach {
    /// Whether all of it is one stage.
    pub(super) fn is_short(&self) -> bool {
        self.stages.len() == 1
    }
}

impl Outer {
    /// A superset of (self ⊕ reach) ∩ bounds. The stages after a simplification move corners that it
    /// pushed out farther, by up to three quarters of the reach.
    pub fn dilated_far(&self, reach: &Reach, bounds: &Region) -> Outer {
        let Some((set, last)) = self.before_last_stage(reach) else {
            return Outer::containing(bounds.clone());
        };
        let paths = last.paths(&set.simplified(last.tolerance_m));
        Outer::containing(overlay(&paths, bounds.rings(), RULE::Intersect))
    }

    /// self ⊕ all stages but the last one, and the last stage. `None` if the reach is too large for
    /// the grid.
    pub(super) fn before_last_stage<'r>(&self, reach: &'r Reach) -> Option<(Outer, &'r Stage)> {
        if !reach.whole.fits(self.region()) {
            return None;
        }
        let (last, stages) = reach.stages.split_last()?;
        let grown = stages.iter().fold(self.clone(), |set, stage| {
            let paths = stage.paths(&set.simplified(stage.tolerance_m));
            Outer::containing(filled(&paths))
        });
        Some((grown, last))
    }
}

impl Inner {
    /// A subset of self ⊖ reach that contains self ⊖ 1.25 reach.
    pub fn eroded_far(&self, reach: &Reach) -> Inner {
        if !reach.whole.fits(self.region()) {
            return Inner::default();
        }
        let mut left = self.clone();
        for stage in &reach.stages {
            left = left.simplified(stage.tolerance_m);
            let shapes = left.region().shapes().iter();
            let rings = shapes.filter(|shape| !stage.exceeds(&shape[0])).flatten();
            let paths: Vec<Ring> = rings.map(|ring| eroded_path(ring, &stage.disc)).collect();
            left = Inner::within(filled(&paths));
        }
        left
    }
}

impl Stage {
    /// The raw paths of `set` ⊕ disc.
    fn paths(&self, set: &Outer) -> Vec<Ring> {
        let rings = set.region().shapes().iter().flat_map(|shape| self.swept_rings(shape));
        rings.map(|ring| dilated_path(ring, &self.disc)).collect()
    }

    /// The rings of a shape without holes that the dilation fills.
    pub(super) fn swept_rings<'a>(&self, shape: &'a Shape) -> impl Iterator<Item = &'a Ring> {
        let holes: Vec<&Ring> = shape.iter().skip(1).filter(|ring| !self.exceeds(ring)).collect();
        shape.first().into_iter().chain(holes)
    }

    /// Whether the disc does not fit into the box of a ring, and so nowhere into the ring.
    fn exceeds(&self, ring: &Ring) -> bool {
        let side = |min: i32, max: i32| f64::from(max) - f64::from(min);
        GridBox::around(ring).is_none_or(|b| {
            let room = side(b.min.x, b.max.x).min(side(b.min.y, b.max.y));
            room < 2.0 * self.radius_m * UNITS_PER_M
        })
    }
}
