//! Outer sets about to grow: what prediction and correction do to a set, in one Boolean operation.

use csat_proto::region::{GridBox, GridPoint, MAX_COORDINATE_M, Region, Ring, Shape, to_units};

use super::boolean::groups_apart;
use super::outer::{difference, shapes_meeting};
use super::simplify::{Kind, simplified_rings};
use super::sweep::dilated_path;
use super::{Disc, Inner, Outer, RULE, overlay};

/// A dilated outer set whose raw paths are not resolved yet: X_{k|k-1} (4.24)-(4.26).
///
/// Resolving them costs as much as taking parts out, so [`Self::minus`] does both at once (with
/// the first group of parts that are apart from each other). The paths
/// are filled where their winding number is positive. Simplified rings need not be resolved before
/// they are dilated: an outer simplification only adds to winding numbers of 0 and 1, so none is
/// negative, a border of the filled set runs along an edge with 0 on its right, and the sweep of
/// that edge adds the 1 that it takes. Where two borders cross, the filled set has a reflex corner,
/// which needs no fan.
///
/// Groups of shapes whose boxes do not meet are resolved one by one: a Boolean operation on many
/// small sets takes less than one on all of them.
#[derive(Debug, Clone)]
pub struct Grown {
    groups: Vec<Group>,
    bounds: Region,
}

/// Paths of shapes that may meet once they have grown, and their box.
#[derive(Debug, Clone)]
struct Group {
    reach: GridBox,
    paths: Vec<Ring>,
}

impl Grown {
    /// `set` as it is, within `bounds`.
    pub fn still(set: &Outer, bounds: &Region) -> Self {
        let shapes = set.region().shapes().iter();
        Self { groups: groups(shapes.cloned()), bounds: bounds.clone() }
    }

    /// (`set` ⊕ `disc`) ∩ `bounds`, after a simplification by at most `tolerance_m`.
    pub fn new(set: &Outer, tolerance_m: f64, disc: &Disc, bounds: &Region) -> Self {
        if !disc.fits(set.region()) {
            return Self::still(&Outer::containing(bounds.clone()), bounds);
        }
        let grown = |shape: &Shape| -> Shape {
            let rings = simplified_rings(shape, Kind::Outer, tolerance_m);
            rings.iter().map(|ring| dilated_path(ring, disc)).collect()
        };
        let shapes = set.region().shapes().iter();
        Self { groups: groups(shapes.map(grown)), bounds: bounds.clone() }
    }

    /// The set itself.
    pub fn resolved(&self) -> Outer {
        self.minus([])
    }

    /// The set minus the union of `parts`.
    pub fn minus<'a>(&self, parts: impl IntoIterator<Item = &'a Inner>) -> Outer {
        let parts: Vec<(GridBox, &Shape)> = parts
            .into_iter()
            .flat_map(|part| part.region().shapes())
            .filter_map(|shape| Some((GridBox::around(&shape[0])?, shape)))
            .collect();
        let outside = outside(&self.bounds);
        let mut left: Vec<Shape> = Vec::new();
        for Group { reach, paths } in &self.groups {
            let near = parts.iter().filter(|(part_box, _)| part_box.meets(reach));
            let beyond = if is_within(reach, &self.bounds) { &[][..] } else { &outside };
            let clip = near.flat_map(|(_, shape)| shape.iter()).chain(beyond);
            left.extend(overlay(paths, clip, RULE::Difference).into_shapes());
        }
        Outer::containing(Region::from_shapes(left))
    }
}

/// Gathers shapes whose boxes meet, directly or through others.
fn groups(shapes: impl Iterator<Item = Shape>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for paths in shapes {
        let Some(reach) = GridBox::around(paths.iter().flatten()) else { continue };
        let mut merged = Group { reach, paths };
        // A grown box may meet groups that were passed already.
        while let Some(index) = groups.iter().position(|group| group.reach.meets(&merged.reach)) {
            let group = groups.swap_remove(index);
            merged.reach = merged.reach.around_both(&group.reach);
            merged.paths.extend(group.paths);
        }
        groups.push(merged);
    }
    groups
}

/// Whether a box lies within a rectangle; false if `bounds` is no rectangle.
fn is_within(reach: &GridBox, bounds: &Region) -> bool {
    bounds.vertex_count() == 4
        && bounds.bounds().is_some_and(|b| b.contains(reach.min) && b.contains(reach.max))
}

/// The rings of everything outside `bounds`.
fn outside(bounds: &Region) -> Vec<Ring> {
    let far = to_units(MAX_COORDINATE_M);
    let corners = [(-far, -far), (far, -far), (far, far), (-far, far)];
    let everything = corners.iter().map(|&(x, y)| GridPoint::new(x, y)).collect();
    let reversed = |ring: &Ring| ring.iter().rev().copied().collect();
    std::iter::once(everything).chain(bounds.rings().map(reversed)).collect()
}
