//! Outer approximations.

use csat_proto::region::{GridBox, Region, Ring, Shape};

use super::simplify::{Kind, simplify_region};
use super::sweep::dilated_path;
use super::{Disc, Inner, RULE, overlay};

/// A set that contains what it stands for; it may only grow by rounding.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Outer(Region);

impl Outer {
    /// Declares that `region` contains what it stands for. This is where a guarantee enters: the
    /// caller has a proposition that says so, or checked a message that claims so.
    pub fn containing(region: Region) -> Self {
        Self(region)
    }

    /// The union of convex rings (counter-clockwise, grid), each dilated by `disc`, within `bounds`.
    pub(crate) fn around(rings: &[Ring], disc: &Disc, bounds: &Region) -> Self {
        if !GridBox::around(rings.iter().flatten()).is_none_or(|b| disc.fits_about(&b)) {
            return Self(bounds.clone());
        }
        let paths: Vec<Ring> = rings.iter().map(|ring| dilated_path(ring, disc)).collect();
        Self(overlay(&paths, bounds.rings(), RULE::Intersect))
    }

    /// The region.
    pub fn region(&self) -> &Region {
        &self.0
    }

    /// The region, by value.
    pub fn into_region(self) -> Region {
        self.0
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// self ∩ other.
    pub fn intersection(&self, other: &Outer) -> Outer {
        let meets = match (self.0.bounds(), other.0.bounds()) {
            (Some(a), Some(b)) => a.meets(&b),
            _ => false,
        };
        if !meets {
            return Outer::default();
        }
        Outer(overlay(self.0.rings(), other.0.rings(), RULE::Intersect))
    }

    /// self minus the union of `parts`.
    pub fn minus<'a>(&self, parts: impl IntoIterator<Item = &'a Inner>) -> Outer {
        let Some(bounds) = self.0.bounds() else { return Outer::default() };
        let clip = shapes_meeting(parts.into_iter().map(Inner::region), &bounds);
        let Some(clip_bounds) = GridBox::around(clip.iter().flat_map(|s| &s[0])) else {
            return self.clone();
        };
        // Shapes that nothing touches need not pass through the overlay.
        let touched = |shape: &&Shape| {
            GridBox::around(&shape[0]).is_some_and(|shape_box| shape_box.meets(&clip_bounds))
        };
        let (subject, mut kept): (Vec<&Shape>, Vec<&Shape>) =
            self.0.shapes().iter().partition(touched);
        let cut =
            overlay(subject.into_iter().flatten(), clip.into_iter().flatten(), RULE::Difference);
        let mut shapes = cut.into_shapes();
        shapes.extend(kept.drain(..).cloned());
        Outer(Region::from_shapes(shapes))
    }

    /// (self ⊕ disc) ∩ bounds.
    pub fn dilated(&self, disc: &Disc, bounds: &Region) -> Outer {
        if !disc.fits(&self.0) {
            return Outer(bounds.clone());
        }
        let paths: Vec<Ring> = self.0.rings().map(|ring| dilated_path(ring, disc)).collect();
        Outer(overlay(&paths, bounds.rings(), RULE::Intersect))
    }

    /// A superset with fewer vertices: each move shifts the border by at most
    /// `tolerance_m`.
    pub fn simplified(self, tolerance_m: f64) -> Outer {
        Outer(simplify_region(self.0, Kind::Outer, tolerance_m))
    }
}

fn shapes_meeting<'a>(
    regions: impl Iterator<Item = &'a Region>,
    bounds: &GridBox,
) -> Vec<&'a Shape> {
    regions
        .flat_map(Region::shapes)
        .filter(|shape| GridBox::around(&shape[0]).is_some_and(|b| b.meets(bounds)))
        .collect()
}
