//! Outer approximations.

use csat_proto::region::{GridBox, MAX_COORDINATE_M, Region, Ring, Shape, to_units};

use super::cells::{self, paths};
use super::simplify::{Approximation, simplify_region, simplify_shapes};
use super::sweep::dilated_path;
use super::{Disc, Inner, Memo, RULE, overlay};

/// An outer approximation: a set that contains the set it approximates; rounding may only make it
/// larger.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Outer(Region);

impl Outer {
    /// Declares that `region` contains the set it approximates. This is where a guarantee enters: the
    /// caller has a proposition that says so, or a checked message that claims so.
    pub fn containing(region: Region) -> Self {
        Self(region)
    }

    /// The union of convex rings (counter-clockwise, on the grid; points and segments are allowed),
    /// each dilated by `disc`, within `bounds`.
    pub(crate) fn around(rings: &[Ring], disc: &Disc, bounds: &Region) -> Self {
        // A point at the end of the grid may be the rounded image of a point beyond it.
        let end = to_units(MAX_COORDINATE_M);
        let is_inside =
            |b: &GridBox| [b.min.x, b.min.y, -b.max.x, -b.max.y].iter().all(|&x| x > -end);
        if GridBox::around(rings.iter().flatten())
            .is_some_and(|b| !is_inside(&b) || !disc.fits_about(&b))
        {
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

    /// Whether it is ∅.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// self ∩ other.
    pub fn intersection(&self, other: &Outer) -> Outer {
        Outer(cells::intersection(&self.0, &other.0, None))
    }

    /// self ∩ other, looked up in `memo` where it was computed before.
    pub fn intersection_by(&self, other: &Outer, memo: &Memo) -> Outer {
        Outer(cells::intersection(&self.0, &other.0, Some(memo)))
    }

    /// self minus the union of `parts`; self, bit for bit, if no part is near.
    pub fn minus<'a>(&self, parts: impl IntoIterator<Item = &'a Inner>) -> Outer {
        let Some(bounds) = self.0.bounds() else { return Outer::default() };
        let near = |part: &'a Inner| shapes_meeting(std::iter::once(part.region()), &bounds);
        let parts: Vec<_> = parts.into_iter().map(near).filter(|part| !part.is_empty()).collect();
        if parts.is_empty() {
            return self.clone();
        }
        let parts = parts.into_iter().map(|part| paths(part.into_iter().flatten())).collect();
        Outer(cells::difference(paths(self.0.rings()), parts, None))
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
        Outer(simplify_region(self.0, Approximation::Outer, tolerance_m))
    }

    /// A superset with fewer vertices, each shape by its own tolerance, metres.
    pub fn simplified_by(&self, tolerance_m: impl Fn(&Shape) -> f64) -> Outer {
        Outer(simplify_shapes(&self.0, Approximation::Outer, tolerance_m))
    }
}

/// The shapes whose boxes meet `bounds`.
pub(super) fn shapes_meeting<'a>(
    regions: impl Iterator<Item = &'a Region>,
    bounds: &GridBox,
) -> Vec<&'a Shape> {
    regions.flat_map(Region::shapes).filter(|shape| meets(shape, bounds)).collect()
}

fn meets(shape: &Shape, bounds: &GridBox) -> bool {
    GridBox::around(&shape[0]).is_some_and(|shape_box| shape_box.meets(bounds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::region::grid_point;

    /// A hull of few points may be a segment, a point, or repeat points.
    #[test]
    fn degenerate_rings_are_dilated_too() {
        let disc = Disc::circumscribed(1.0, 16);
        let bounds = Region::rectangle([100.0, 100.0]);
        let (a, b, c) = (grid_point([3.0, 4.0]), grid_point([8.0, 6.0]), grid_point([2.0, 9.0]));
        let area = |ring: Ring| Outer::around(&[ring], &disc, &bounds).region().area_m2();
        let disc_m2 = area(vec![a]);
        assert!((3.1..3.2).contains(&disc_m2));
        assert_eq!(area(vec![a, a, a]), disc_m2);
        let segment_m2 = area(vec![a, b]);
        assert!((segment_m2 - disc_m2 - 2.0 * 29f64.sqrt()).abs() < 0.1);
        assert!((area(vec![a, b, b, a]) - segment_m2).abs() < 1e-3);
        let triangle_m2 = area(vec![a, b, c]);
        assert!((area(vec![a, a, b, c, c, c, a]) - triangle_m2).abs() < 1e-3);
        assert_eq!(area(vec![]), 0.0);
    }

    #[test]
    fn what_reaches_past_the_grid_fills_the_bounds() {
        let bounds = Region::rectangle([100.0, 100.0]);
        for (far, radius_m) in [([4095.0, 0.0], 1.5), ([0.0, -5000.0], 0.3), ([4094.0, 0.0], 3.0)] {
            // A segment whose other end is within the bounds.
            let segment = vec![grid_point(far), grid_point([0.0, 0.0])];
            let disc = Disc::circumscribed(radius_m, 16);
            assert_eq!(Outer::around(&[segment], &disc, &bounds).into_region(), bounds);
        }
    }
}
