//! Sets and lines as GeoJSON that is valid: rings closed, outer ones counter-clockwise and holes
//! clockwise (RFC 7946 §3.1.6), whatever the lengths or angles are that the coordinates stand for.

use geojson::{Feature, FeatureCollection, Geometry, GeometryValue, JsonObject, Position};
use serde::Serialize;
use serde_json::Value;

use crate::picture::Ring;

/// Polygons, each an outer ring and its holes.
pub fn multi_polygon(shapes: &[Vec<Ring>]) -> GeometryValue {
    GeometryValue::MultiPolygon { coordinates: shapes.iter().filter_map(|s| rings(s)).collect() }
}

/// One polygon: an outer ring and its holes; without coordinates when the outer ring has no area.
pub fn polygon(shape: &[Ring]) -> GeometryValue {
    GeometryValue::Polygon { coordinates: rings(shape).unwrap_or_default() }
}

/// A line.
pub fn line_string(line: &[[f64; 2]]) -> GeometryValue {
    GeometryValue::new_line_string(line.iter().copied())
}

/// A point.
pub fn point(p: [f64; 2]) -> GeometryValue {
    GeometryValue::new_point(p)
}

/// A feature with the members of `properties`, a JSON object.
pub fn feature(geometry: GeometryValue, properties: Value) -> Feature {
    Feature {
        geometry: Some(Geometry::new(geometry)),
        properties: Some(members(properties)),
        ..Feature::default()
    }
}

/// A feature collection as text, with the members of `head` beside `features`.
pub fn collection(features: Vec<Feature>, head: &impl Serialize) -> String {
    let head = serde_json::to_value(head).expect("names and numbers are JSON");
    let foreign_members = Some(members(head));
    FeatureCollection { bbox: None, features, foreign_members }.to_string()
}

/// The members of a JSON object.
fn members(object: Value) -> JsonObject {
    match object {
        Value::Object(members) => members,
        _ => JsonObject::new(),
    }
}

/// The rings of a polygon, closed and turned the right way; `None` when nothing is left of the
/// outer one. Rounding may have closed up what was narrower than a millimetre.
fn rings(shape: &[Ring]) -> Option<Vec<Vec<Position>>> {
    let (outer, holes) = shape.split_first()?;
    let mut rings = vec![closed(outer, true)?];
    rings.extend(holes.iter().filter_map(|hole| closed(hole, false)));
    Some(rings)
}

fn closed(ring: &Ring, is_outer: bool) -> Option<Vec<Position>> {
    let mut ring = ring.clone();
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    let twice_area = twice_signed_area(&ring);
    if ring.len() < 3 || twice_area == 0.0 {
        return None;
    }
    if (twice_area > 0.0) != is_outer {
        ring.reverse();
    }
    ring.push(ring[0]);
    Some(ring.into_iter().map(Position::from).collect())
}

/// A ring without the corners that it hardly turns at: what is left out is within `tolerance_m` of
/// what is left. For pictures only, which are neither inner nor outer; it may touch itself.
pub fn thinned(ring: &[[f64; 2]], tolerance_m: f64) -> Ring {
    let (Some(&first), true) = (ring.first(), ring.len() > 4) else { return ring.to_vec() };
    let mut kept = vec![first];
    let mut last = 0;
    for index in 1..ring.len() {
        let next = ring[(index + 1) % ring.len()];
        let passed = &ring[last + 1..=index];
        let is_straight = passed.len() <= LONGEST_SKIP
            && passed.iter().all(|p| distance_m(*p, [ring[last], next]) <= tolerance_m);
        if !is_straight {
            kept.push(ring[index]);
            last = index;
        }
    }
    if kept.len() < 3 { ring.to_vec() } else { kept }
}

/// How many corners in a row may be left out, so that a long ring takes no long time.
const LONGEST_SKIP: usize = 24;

/// From a point to a segment.
fn distance_m(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (along, to_p) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share =
        ((to_p[0] * along[0] + to_p[1] * along[1]) / square.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (to_p[0] - share * along[0]).hypot(to_p[1] - share * along[1])
}

/// Twice the area inside of a ring, negative when it goes clockwise.
fn twice_signed_area(ring: &[[f64; 2]]) -> f64 {
    let Some(&[x, y]) = ring.first() else { return 0.0 };
    // About a corner: far from the origin, products of coordinates would swallow small rings.
    let corners = ring.iter().map(|p| [p[0] - x, p[1] - y]);
    let next = corners.clone().cycle().skip(1);
    corners.zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_are_closed_and_turned() {
        let outer = vec![[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]];
        let hole = vec![[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [2.0, 2.0]];
        let GeometryValue::MultiPolygon { coordinates } = multi_polygon(&[vec![outer, hole]])
        else {
            panic!("a MultiPolygon")
        };
        let plain: Vec<Vec<[f64; 2]>> =
            coordinates[0].iter().map(|ring| ring.iter().map(|p| [p[0], p[1]]).collect()).collect();
        assert_eq!(plain[0], [[4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [4.0, 0.0]]);
        assert_eq!(plain[1], [[2.0, 2.0], [2.0, 1.0], [1.0, 1.0], [2.0, 2.0]]);
    }

    #[test]
    fn what_rounding_closed_up_is_left_out() {
        let needle = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
        let flat = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        let GeometryValue::MultiPolygon { coordinates } =
            multi_polygon(&[vec![needle.clone()], vec![flat], vec![vec![]], vec![]])
        else {
            panic!("a MultiPolygon")
        };
        assert!(coordinates.is_empty());
        assert_eq!(polygon(&[needle]), GeometryValue::Polygon { coordinates: vec![] });
    }

    #[test]
    fn circles_need_few_corners_in_a_picture() {
        let at = |i: u32| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 400.0).sin_cos();
            [20.0 * cos, 20.0 * sin]
        };
        let circle: Ring = (0..400).map(at).collect();
        let few = thinned(&circle, 0.1);
        assert!((12..80).contains(&few.len()), "{}", few.len());
        assert!(few.iter().all(|p| circle.contains(p)));
        let area_m2 = twice_signed_area(&few) / 2.0;
        assert!((area_m2 - 400.0 * std::f64::consts::PI).abs() < 0.1 * 40.0 * std::f64::consts::PI);
        // Corners stay.
        let square = [[0.0, 0.0], [5.0, 0.0], [10.0, 0.0], [10.0, 10.0], [5.0, 10.05], [0.0, 10.0]];
        assert_eq!(thinned(&square, 0.1), [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]);
    }

    #[test]
    fn collections_carry_their_head() {
        let text = collection(
            vec![feature(point([1.0, 2.0]), serde_json::json!({"kind": "x"}))],
            &serde_json::json!({"step": 3}),
        );
        let parsed: FeatureCollection = text.parse().unwrap();
        assert_eq!(parsed.foreign_members.unwrap()["step"], 3);
        assert_eq!(parsed.features[0].properties.as_ref().unwrap()["kind"], "x");
    }
}
