//! Makes outlines of real towns valid, with warnings.

use geo::bool_ops::FillRule;
use geo::orient::Direction;
use geo::{Area, BooleanOps, LineString, MultiPolygon, Orient, Polygon, Validation};

use super::report::{FeatureRef, MapWarning};
use crate::plane::Point;

/// Polygons of less area are left out, m². The smallest sheds are a hundred times larger.
pub(super) const MIN_AREA_M2: f64 = 0.01;

/// The polygon of an outer ring and its holes (positions as in the file, projected to metres), as
/// valid polygons: outer rings counter-clockwise, holes clockwise. Empty when nothing is left.
///
/// `part` names the polygon within its feature ("" or "part 2, ").
pub(super) fn polygon(
    rings: &[Vec<Point>],
    part: &str,
    feature: &FeatureRef,
    warnings: &mut Vec<MapWarning>,
) -> MultiPolygon<f64> {
    let Some((outer, holes)) = rings.split_first() else {
        let ring = format!("{part}outer ring");
        warnings.push(MapWarning::ShortRing { feature: feature.clone(), ring, got: 0 });
        return MultiPolygon(Vec::new());
    };
    let Some(mut shape) = ring(outer, format!("{part}outer ring"), feature, warnings) else {
        return MultiPolygon(Vec::new());
    };
    for (index, hole) in holes.iter().enumerate() {
        let name = format!("{part}hole {}", index + 1);
        let Some(hole) = ring(hole, name.clone(), feature, warnings) else { continue };
        let outside_m2 = hole.difference(&shape).unsigned_area();
        if outside_m2 > MIN_AREA_M2 {
            let feature = feature.clone();
            warnings.push(MapWarning::HoleOutside { feature, ring: name, outside_m2 });
        }
        shape = shape.difference(&hole);
    }
    oriented(&shape)
}

/// The parts of `shape` that are large enough, oriented.
pub(super) fn oriented(shape: &MultiPolygon<f64>) -> MultiPolygon<f64> {
    let mut shape = shape.orient(Direction::Default);
    shape.0.retain(|p| p.unsigned_area() > MIN_AREA_M2);
    shape
}

/// The area that one ring encloses, as valid polygons; `None` when there is none.
fn ring(
    positions: &[Point],
    name: String,
    feature: &FeatureRef,
    warnings: &mut Vec<MapWarning>,
) -> Option<MultiPolygon<f64>> {
    let mut points = positions.to_vec();
    let feature = feature.clone();
    if points.len() > 2 && points.first() != points.last() {
        points.push(points[0]);
        let (feature, ring) = (feature.clone(), name.clone());
        warnings.push(MapWarning::RingClosed { feature, ring });
    }
    if points.len() < 4 {
        warnings.push(MapWarning::ShortRing { feature, ring: name, got: positions.len() });
        return None;
    }
    points.dedup();
    let count = positions.len().max(points.len()) - points.len();
    if count > 0 {
        let (feature, ring) = (feature.clone(), name.clone());
        warnings.push(MapWarning::RepeatedPositions { feature, ring, count });
    }
    let polygon = Polygon::new(points.into_iter().collect(), Vec::new());
    let crosses = !polygon.is_valid();
    let shape = if crosses { rebuilt(polygon.exterior()) } else { MultiPolygon(vec![polygon]) };
    let got_m2 = shape.unsigned_area();
    if got_m2 <= MIN_AREA_M2 {
        warnings.push(MapWarning::ZeroArea { feature, ring: name, got_m2 });
        return None;
    }
    if crosses {
        let parts = shape.0.len();
        warnings.push(MapWarning::SelfCrossing { feature, ring: name, parts });
    }
    Some(shape)
}

/// All points that a ring winds around, as simple parts: a bow-tie becomes two triangles, a spike
/// vanishes, a loop is filled.
fn rebuilt(ring: &LineString<f64>) -> MultiPolygon<f64> {
    let polygon = Polygon::new(ring.clone(), Vec::new());
    let nothing = MultiPolygon(Vec::new());
    oriented(&polygon.union_with_fill_rule(&nothing, FillRule::NonZero))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn repair(rings: &[&[Point]]) -> (MultiPolygon<f64>, Vec<MapWarning>) {
        let feature = FeatureRef { index: 0, id: None, name: None };
        let rings: Vec<Vec<Point>> = rings.iter().map(|r| r.to_vec()).collect();
        let mut warnings = Vec::new();
        let shape = polygon(&rings, "", &feature, &mut warnings);
        (shape, warnings)
    }

    const SQUARE: [Point; 5] = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], [0.0, 0.0]];

    #[test]
    fn what_is_right_stays_as_it_is() {
        let hole = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0]];
        let (shape, warnings) = repair(&[&SQUARE]);
        assert!(warnings.is_empty());
        assert_eq!(shape.0[0].exterior().0.len(), 5);
        let (shape, warnings) = repair(&[&SQUARE, &hole]);
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!((shape.unsigned_area() - 80.0).abs() < 1e-5);
        assert_eq!(shape.0[0].interiors().len(), 1);
    }

    #[test]
    fn a_bow_tie_becomes_two_triangles() {
        let tie = [[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0], [0.0, 0.0]];
        let (shape, warnings) = repair(&[&tie]);
        assert!(matches!(warnings[..], [MapWarning::SelfCrossing { parts: 2, .. }]));
        assert!((shape.unsigned_area() - 8.0).abs() < 1e-5);
    }

    #[test]
    fn clockwise_rings_and_holes_out_of_place() {
        let clockwise: Vec<Point> = SQUARE.iter().rev().copied().collect();
        let (shape, warnings) = repair(&[&clockwise]);
        assert!(warnings.is_empty());
        assert!(shape.0[0].signed_area() > 0.0);
        let hole = [[8.0, 8.0], [10.0, 8.0], [10.0, 10.0], [8.0, 10.0], [8.0, 8.0]];
        let (shape, warnings) = repair(&[&SQUARE, &hole]);
        assert!(matches!(warnings[..], [MapWarning::HoleOutside { outside_m2, .. }]
            if (outside_m2 - 3.0).abs() < 1e-5));
        assert!((shape.unsigned_area() - 80.0).abs() < 1e-5);
    }

    proptest! {
        /// For every ring the result is valid, and empty only with a warning.
        #[test]
        fn any_ring_is_repaired_or_reported(
            points in prop::collection::vec([0..12i32, 0..12i32], 0..12),
        ) {
            let points: Vec<Point> = points.iter().map(|p| p.map(f64::from)).collect();
            let (shape, warnings) = repair(&[&points]);
            prop_assert!(!shape.0.is_empty() || !warnings.is_empty());
            for part in &shape.0 {
                prop_assert!(part.is_valid(), "{:?}", part.validation_errors());
                prop_assert!(part.signed_area() > 0.0);
            }
        }
    }
}
