//! Makes outlines that overlap disjoint, so that solids of different obstacles never overlap.
//!
//! Outlines of equal height that meet become one obstacle. Where heights differ, the higher building
//! keeps its whole outline, which is cut out of the lower ones. The union of the solids stays the
//! same, and each solid stays Z-convex (3.1).

use geo::{Area, BooleanOps, BoundingRect, MultiPolygon, Rect, unary_union};

use super::repair::{MIN_AREA_M2, oriented};
use super::report::{FeatureRef, MapWarning};
use crate::obstacle::Obstacle;

/// A building as mapped: valid, oriented outlines.
#[derive(Debug, Clone)]
pub(super) struct BuildingOutline {
    pub feature: FeatureRef,
    /// The index of the building that it is or that it is a part of.
    pub building: usize,
    pub shape: MultiPolygon<f64>,
    pub height_m: f64,
}

/// Disjoint obstacles (up to a few µm of rounding) that cover what the outlines cover, in the order
/// of the first feature of each.
pub(super) fn disjoint(
    outlines: &[BuildingOutline],
    warnings: &mut Vec<MapWarning>,
) -> Vec<Obstacle> {
    let mut named: Vec<(usize, Obstacle)> = Vec::new();
    for cluster in clusters(outlines) {
        let members: Vec<&BuildingOutline> = cluster.iter().map(|&i| &outlines[i]).collect();
        report_overlaps(&members, warnings);
        resolve(&members, &mut named);
    }
    // Stable: parts of one feature keep the order in which they were made.
    named.sort_by_key(|(first, _)| *first);
    named.into_iter().map(|(_, obstacle)| obstacle).collect()
}

/// Groups of outlines linked by bounding boxes that meet, each in feature order.
fn clusters(outlines: &[BuildingOutline]) -> Vec<Vec<usize>> {
    let boxes: Vec<Option<Rect<f64>>> = outlines.iter().map(|o| o.shape.bounding_rect()).collect();
    let mut cluster_of: Vec<usize> = (0..outlines.len()).collect();
    for i in 0..outlines.len() {
        for j in 0..i {
            let (a, b) = (cluster_of[i], cluster_of[j]);
            if a != b && meet(&boxes[i], &boxes[j]) {
                let (keep, drop) = (a.min(b), a.max(b));
                cluster_of.iter_mut().filter(|c| **c == drop).for_each(|c| *c = keep);
            }
        }
    }
    let mut clusters = vec![Vec::new(); outlines.len()];
    for (index, &cluster) in cluster_of.iter().enumerate() {
        clusters[cluster].push(index);
    }
    clusters.retain(|c| !c.is_empty());
    clusters
}

/// Whether two bounding boxes touch.
pub(super) fn meet(a: &Option<Rect<f64>>, b: &Option<Rect<f64>>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return false };
    a.min().x <= b.max().x
        && b.min().x <= a.max().x
        && a.min().y <= b.max().y
        && b.min().y <= a.max().y
}

fn report_overlaps(members: &[&BuildingOutline], warnings: &mut Vec<MapWarning>) {
    for (j, b) in members.iter().enumerate() {
        for a in &members[..j] {
            // Parts of one building may overlap.
            if a.building == b.building || !meet(&a.shape.bounding_rect(), &b.shape.bounding_rect())
            {
                continue;
            }
            let area_m2 = a.shape.intersection(&b.shape).unsigned_area();
            if area_m2 > MIN_AREA_M2 {
                warnings.push(MapWarning::Overlap {
                    feature: a.feature.clone(),
                    other: b.feature.clone(),
                    area_m2,
                    what: if a.height_m == b.height_m {
                        "merged them"
                    } else {
                        "cut the lower one"
                    },
                });
            }
        }
    }
}

/// The obstacles of one cluster, from the highest down.
fn resolve(members: &[&BuildingOutline], named: &mut Vec<(usize, Obstacle)>) {
    if let [single] = members {
        let parts = single.shape.0.iter().map(|p| MultiPolygon(vec![p.clone()]));
        return parts.for_each(|part| push_parts(&part, &[*single], single.height_m, named));
    }
    let mut heights: Vec<f64> = members.iter().map(|m| m.height_m).collect();
    heights.sort_by(|a, b| b.total_cmp(a));
    heights.dedup();
    let mut higher = MultiPolygon(Vec::new());
    for height_m in heights {
        let level: Vec<&BuildingOutline> =
            members.iter().copied().filter(|m| m.height_m == height_m).collect();
        let union = unary_union(level.iter().map(|m| &m.shape));
        let free = if higher.0.is_empty() { union.clone() } else { union.difference(&higher) };
        push_parts(&free, &level, height_m, named);
        higher = higher.union(&union);
    }
}

/// One obstacle per part, named after the features that it comes from.
fn push_parts(
    shape: &MultiPolygon<f64>,
    sources: &[&BuildingOutline],
    height_m: f64,
    named: &mut Vec<(usize, Obstacle)>,
) {
    for footprint in oriented(shape).0 {
        let mut from: Vec<&FeatureRef> = sources
            .iter()
            .filter(|s| sources.len() == 1 || covers(s, &footprint))
            .map(|s| &s.feature)
            .collect();
        from.sort();
        let first = from.first().map_or(usize::MAX, |f| f.index);
        let names: Vec<String> = from.iter().map(|f| label(f)).collect();
        named.push((first, Obstacle { footprint, height_m, name: names.join(" + ") }));
    }
}

fn covers(source: &BuildingOutline, footprint: &geo::Polygon<f64>) -> bool {
    meet(&source.shape.bounding_rect(), &footprint.bounding_rect())
        && source.shape.intersection(footprint).unsigned_area() > MIN_AREA_M2 / 2.0
}

fn label(feature: &FeatureRef) -> String {
    feature.id.clone().unwrap_or_else(|| format!("feature {}", feature.index))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::{Contains, Distance, Euclidean, Point, Validation, polygon};
    use proptest::prelude::*;

    fn square(index: usize, x: f64, y: f64, side: f64, height_m: f64) -> BuildingOutline {
        let shape = MultiPolygon(vec![polygon![
            (x: x, y: y), (x: x + side, y: y), (x: x + side, y: y + side), (x: x, y: y + side)
        ]]);
        let feature = FeatureRef { index, id: Some(format!("way/{index}")), name: None };
        BuildingOutline { feature, building: index, shape, height_m }
    }

    #[test]
    fn equal_heights_become_one_obstacle() {
        let mut warnings = Vec::new();
        let outlines = [square(0, 0.0, 0.0, 4.0, 9.0), square(1, 3.0, 3.0, 4.0, 9.0)];
        let obstacles = disjoint(&outlines, &mut warnings);
        assert_eq!(obstacles.len(), 1);
        assert_eq!(obstacles[0].name, "way/0 + way/1");
        assert!((obstacles[0].area_m2() - 31.0).abs() < 1e-4);
        assert!(matches!(warnings[..], [MapWarning::Overlap { what: "merged them", area_m2, .. }]
            if (area_m2 - 1.0).abs() < 1e-4));
    }

    #[test]
    fn the_higher_keeps_its_outline_and_the_lower_is_cut() {
        let mut warnings = Vec::new();
        let outlines = [square(0, 0.0, 0.0, 10.0, 6.0), square(1, 4.0, 4.0, 2.0, 20.0)];
        let obstacles = disjoint(&outlines, &mut warnings);
        assert_eq!(obstacles.len(), 2);
        assert_eq!((obstacles[0].height_m, obstacles[1].height_m), (6.0, 20.0));
        assert!((obstacles[0].area_m2() - 96.0).abs() < 1e-4);
        assert_eq!(obstacles[0].footprint.interiors().len(), 1);
        assert!((obstacles[1].area_m2() - 4.0).abs() < 1e-4);
        assert!(matches!(warnings[..], [MapWarning::Overlap { what: "cut the lower one", .. }]));
    }

    #[test]
    fn neighbours_that_only_touch_are_no_overlap() {
        let mut warnings = Vec::new();
        let outlines = [square(0, 0.0, 0.0, 4.0, 6.0), square(1, 4.0, 0.0, 4.0, 9.0)];
        assert_eq!(disjoint(&outlines, &mut warnings).len(), 2);
        assert!(warnings.is_empty());
    }

    #[test]
    fn a_building_wholly_under_a_higher_one_vanishes() {
        let outlines = [square(0, 1.0, 1.0, 2.0, 6.0), square(1, 0.0, 0.0, 4.0, 9.0)];
        let mut warnings = Vec::new();
        let obstacles = disjoint(&outlines, &mut warnings);
        assert_eq!(obstacles.len(), 1);
        assert_eq!(obstacles[0].name, "way/1");
        assert_eq!(warnings.len(), 1);
    }

    proptest! {
        /// For all overlaps, the solids are disjoint and their union stays the same.
        #[test]
        fn the_union_of_the_solids_stays(
            squares in prop::collection::vec(
                (0.0..20.0f64, 0.0..20.0f64, 1.0..8.0f64, 1..4u8), 1..10,
            ),
            probes in prop::collection::vec([0.0..28.0f64, 0.0..28.0f64], 50),
        ) {
            let outlines: Vec<BuildingOutline> = squares
                .iter()
                .enumerate()
                .map(|(i, &(x, y, side, levels))| square(i, x, y, side, 3.0 * f64::from(levels)))
                .collect();
            let obstacles = disjoint(&outlines, &mut Vec::new());
            for (i, a) in obstacles.iter().enumerate() {
                prop_assert!(a.footprint.is_valid());
                for b in &obstacles[..i] {
                    let shared = a.footprint.intersection(&b.footprint).unsigned_area();
                    prop_assert!(shared < 1e-3, "{} m²", shared);
                }
            }
            for p in probes {
                let p = Point::new(p[0], p[1]);
                let near_edge = |o: &BuildingOutline| Euclidean.distance(&p, o.shape.0[0].exterior()) < 0.1;
                if outlines.iter().any(near_edge) {
                    continue;
                }
                let highest = outlines.iter().filter(|o| o.shape.contains(&p)).map(|o| o.height_m);
                let got = obstacles.iter().filter(|o| o.footprint.contains(&p)).map(|o| o.height_m);
                prop_assert_eq!(got.collect::<Vec<_>>(), highest.reduce(f64::max).into_iter().collect::<Vec<_>>());
            }
        }
    }
}
