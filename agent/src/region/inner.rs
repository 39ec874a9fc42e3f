//! Inner approximations.

use std::collections::BTreeMap;

use csat_proto::region::{GridBox, Region, Ring, Shape};

use super::boolean::{shallow_groups, touched};
use super::simplify::{Approximation, simplify_region, simplify_shapes};
use super::sweep::eroded_path;
use super::{Disc, Memo, RULE, filled, overlay};
use crate::identity::Identity;

/// An inner approximation: a set that is contained in the set it approximates, up to rounding, which
/// the margins of its parts outweigh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Inner(Region);

impl Inner {
    /// Declares that `region` is contained in the set it approximates. This is where a guarantee
    /// enters: the caller has a proposition that says so, or a checked message that claims so.
    pub fn within(region: Region) -> Self {
        Self(region)
    }

    /// The union of rings, counter-clockwise ones adding and clockwise ones subtracting, in `bounds`.
    pub(crate) fn from_rings(rings: &[Ring], bounds: &Region) -> Self {
        Self(overlay(rings, bounds.rings(), RULE::Intersect))
    }

    /// The region.
    pub fn region(&self) -> &Region {
        &self.0
    }

    /// The region, by value.
    pub fn into_region(self) -> Region {
        self.0
    }

    /// Whether it is ∅.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The union of all `parts`.
    pub fn union<'a>(parts: impl IntoIterator<Item = &'a Inner>) -> Inner {
        let mut parts = parts.into_iter().filter(|part| !part.is_empty());
        let Some(first) = parts.next() else { return Inner::default() };
        let parts = parts.filter_map(|part| Some((part.0.bounds()?, &part.0)));
        shallow_groups(parts).into_iter().fold(first.clone(), |sum, group| {
            let clip = group.into_iter().flat_map(Region::rings);
            Inner(overlay(sum.0.rings(), clip, RULE::Union))
        })
    }

    /// self ∪ `parts`, simplified by at most `tolerance_m` where parts were added. A shape whose box meets
    /// no shape of a part stays as it is; one that was added to may reach over it by a unit.
    pub fn absorbing(self, parts: &[&Inner], tolerance_m: f64, memo: &Memo) -> Inner {
        let own = self.0.into_shapes().into_iter().map(|shape| (0, shape));
        let added = (1..).zip(parts).flat_map(|(source, part)| {
            part.0.shapes().iter().map(move |shape| (source, shape.clone()))
        });
        let with_box = |item: (usize, Shape)| Some((GridBox::around(&item.1[0])?, item));
        let mut own: Vec<_> = own.filter_map(with_box).collect();
        let clusters = touched(&mut own, added.filter_map(with_box).collect());
        let mut sum: Vec<Shape> = own.into_iter().map(|(_, (_, shape))| shape).collect();
        for cluster in clusters {
            let mut sets: BTreeMap<usize, Vec<Shape>> = BTreeMap::new();
            for (source, shape) in cluster {
                sets.entry(source).or_default().push(shape);
            }
            let sets: Vec<Inner> =
                sets.into_values().map(|shapes| Inner(Region::from_shapes(shapes))).collect();
            let rings = sets.iter().map(|set| set.0.rings().collect::<Vec<_>>());
            let key = Identity::of_operation([RULE::Union as u64, tolerance_m.to_bits()], rings);
            let united = || Inner::union(&sets).simplified(tolerance_m).into_region();
            sum.extend_from_slice(&memo.result(key, || united().into_shapes().into()));
        }
        Inner(Region::from_shapes(sum))
    }

    /// The same set in shapes that do not cross each other.
    pub fn resolved(&self) -> Inner {
        let rings: Vec<Ring> = self.0.rings().cloned().collect();
        Inner(filled(&rings))
    }

    /// self minus the union of counter-clockwise rings.
    pub(crate) fn without(&self, rings: &[Ring]) -> Inner {
        Inner(overlay(self.0.rings(), rings, RULE::Difference))
    }

    /// self ⊖ disc.
    pub fn eroded(&self, disc: &Disc) -> Inner {
        if !disc.fits(&self.0) {
            return Inner::default();
        }
        let paths: Vec<Ring> = self.0.rings().map(|ring| eroded_path(ring, disc)).collect();
        Inner(filled(&paths))
    }

    /// A subset with fewer vertices: each move shifts the border by at most
    /// `tolerance_m`.
    pub fn simplified(self, tolerance_m: f64) -> Inner {
        Inner(simplify_region(self.0, Approximation::Inner, tolerance_m))
    }

    /// A subset with fewer vertices, each shape by its own tolerance, metres.
    pub fn simplified_by(&self, tolerance_m: impl Fn(&Shape) -> f64) -> Inner {
        Inner(simplify_shapes(&self.0, Approximation::Inner, tolerance_m))
    }
}
