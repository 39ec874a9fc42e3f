//! Dilated outer approximations that are resolved together with the sets subtracted from them:
//! prediction and correction in one Boolean operation.

use csat_proto::region::{GridBox, GridPoint, MAX_COORDINATE_M, Region, Ring, Shape, to_units};

use super::boolean::shallow_groups;
use super::simplify::{Approximation, simplified_rings};
use super::sweep::dilated_path;
use super::{Inner, Outer, RULE, Reach, overlay};

/// A dilated outer set whose raw paths are not resolved yet: X_{k|k-1} (4.24)-(4.26).
///
/// Resolving them takes as long as subtracting parts, so [`Self::minus`] does both at once. The paths
/// are filled where their winding number is positive. Simplified rings need not be resolved before
/// they are dilated: an outer simplification only adds to winding numbers of 0 and 1, so none is
/// negative, a border of the filled set runs along an edge with 0 on its right, and the sweep of that
/// edge adds the missing 1. Where two borders cross, the filled set has a reflex corner, which needs
/// no fan.
///
/// Groups of shapes whose boxes do not meet are resolved one by one: many Boolean operations on small
/// sets take less time than one on all of them.
#[derive(Debug, Clone)]
pub struct Grown {
    groups: Vec<Group>,
    bounds: Region,
}

/// Paths of shapes that may meet once they have grown, and their box.
#[derive(Debug, Clone)]
struct Group {
    extent: GridBox,
    paths: Vec<Ring>,
}

impl Grown {
    /// `set` as it is, within `bounds`.
    pub fn still(set: &Outer, bounds: &Region) -> Self {
        let shapes = set.region().shapes().iter();
        Self { groups: groups(shapes.cloned()), bounds: bounds.clone() }
    }

    /// A superset of (`set` ⊕ `reach`) ∩ `bounds`, after a simplification by at most `tolerance_m`. A
    /// long reach is swept in stages, of which the last one is not resolved yet.
    pub fn new(set: &Outer, tolerance_m: f64, reach: &Reach, bounds: &Region) -> Self {
        let Some((set, last)) = set.before_last_stage(reach) else {
            return Self::still(&Outer::containing(bounds.clone()), bounds);
        };
        let tolerance_m =
            if reach.is_short() { tolerance_m } else { tolerance_m.max(last.tolerance_m) };
        let grown = |shape: &Shape| -> Shape {
            let rings: Vec<Ring> = match reach.is_short() {
                true => simplified_rings(shape, Approximation::Outer, tolerance_m),
                false => {
                    simplified_rings(last.swept_rings(shape), Approximation::Outer, tolerance_m)
                }
            };
            rings.iter().map(|ring| dilated_path(ring, &last.disc)).collect()
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
        let with_box = |shape: &'a Shape| Some((GridBox::around(&shape[0])?, shape));
        let layers: Vec<Vec<(GridBox, &'a Shape)>> =
            shallow_groups(parts.into_iter().map(Inner::region))
                .into_iter()
                .map(|layer| {
                    layer.into_iter().flat_map(Region::shapes).filter_map(with_box).collect()
                })
                .collect();
        let outside = outside(&self.bounds);
        let mut left: Vec<Shape> = Vec::new();
        for Group { extent, paths } in &self.groups {
            let near = |layer: &Vec<(GridBox, &'a Shape)>| -> Vec<&Ring> {
                layer
                    .iter()
                    .filter(|(b, _)| b.meets(extent))
                    .flat_map(|(_, shape)| *shape)
                    .collect()
            };
            let mut cuts = layers.iter().map(near).filter(|cut| !cut.is_empty());
            let beyond = if is_within(extent, &self.bounds) { &[][..] } else { &outside };
            let first = cuts.next().unwrap_or_default().into_iter().chain(beyond);
            let start = overlay(paths, first, RULE::Difference);
            let set = cuts.fold(start, |set, cut| overlay(set.rings(), cut, RULE::Difference));
            left.extend(set.into_shapes());
        }
        Outer::containing(Region::from_shapes(left))
    }
}

/// Gathers shapes whose boxes meet, directly or through others.
fn groups(shapes: impl Iterator<Item = Shape>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for paths in shapes {
        let Some(extent) = GridBox::around(paths.iter().flatten()) else { continue };
        let mut merged = Group { extent, paths };
        // A grown box may meet groups that were passed already.
        while let Some(index) = groups.iter().position(|group| group.extent.meets(&merged.extent)) {
            let group = groups.swap_remove(index);
            merged.extent = merged.extent.around_both(&group.extent);
            merged.paths.extend(group.paths);
        }
        groups.push(merged);
    }
    groups
}

/// Whether a box lies within a rectangle; false if `bounds` is no rectangle.
fn is_within(extent: &GridBox, bounds: &Region) -> bool {
    bounds.bounds().is_some_and(|b| {
        let is_corner = |p: &GridPoint| {
            (p.x == b.min.x || p.x == b.max.x) && (p.y == b.min.y || p.y == b.max.y)
        };
        let is_rectangle = bounds.vertex_count() == 4 && bounds.rings().flatten().all(is_corner);
        is_rectangle && b.contains(extent.min) && b.contains(extent.max)
    })
}

/// The rings of everything outside `bounds`.
fn outside(bounds: &Region) -> Vec<Ring> {
    let far = to_units(MAX_COORDINATE_M);
    let corners = [(-far, -far), (far, -far), (far, far), (-far, far)];
    let everything = corners.iter().map(|&(x, y)| GridPoint::new(x, y)).collect();
    let reversed = |ring: &Ring| ring.iter().rev().copied().collect();
    std::iter::once(everything).chain(bounds.rings().map(reversed)).collect()
}
