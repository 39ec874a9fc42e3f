//! The counts of what became of each feature.

use csat_world::map::{LeftOut, MapError, MapWarning, Untagged};
use serde_json::{Value, json};

use super::{
    ROAD, SQUARE, area_m2, building, collection, feature, left_out, positions, read, read_with,
    road, square, tall, with_road,
};

#[test]
fn geometry_of_no_or_the_wrong_kind_is_left_out() {
    let point = json!({ "type": "Point", "coordinates": [0.0, 0.0] });
    let line = json!({ "type": "LineString", "coordinates": positions(&ROAD) });
    for (properties, geometry, expected) in [
        (json!({ "building": "yes" }), line, "Polygon or MultiPolygon"),
        (json!({ "highway": "service" }), point, "LineString or MultiLineString"),
    ] {
        let map = with_road(vec![building(&[&SQUARE]), feature(properties, geometry)]);
        assert!(matches!(&left_out(&map)[..],
            [(LeftOut::WrongGeometry { expected: e, .. }, 1)] if *e == expected));
        assert!(matches!(&map.warnings[..], [MapWarning::LeftOut { .. }]));
    }
    let none = feature(json!({ "building": "yes" }), Value::Null);
    let map = with_road(vec![building(&[&SQUARE]), none]);
    assert_eq!(
        map.warnings[0].to_string(),
        "1 feature(s) left out: no geometry; the first: feature 1 (way/7)"
    );
}

/// An empty geometry is reported as empty, not as outside the region.
#[test]
fn empty_geometry_is_left_out_as_what_it_is() {
    for (tag, kind, coordinates) in [
        ("building", "MultiPolygon", json!([])),
        ("building", "MultiPolygon", json!([[]])),
        ("building", "Polygon", json!([])),
        ("building", "Polygon", json!([[]])),
        ("highway", "MultiLineString", json!([])),
        ("highway", "MultiLineString", json!([[]])),
        ("highway", "LineString", json!([])),
        ("building", "Point", json!([])),
    ] {
        let geometry = json!({ "type": kind, "coordinates": coordinates });
        let odd = feature(json!({ tag: "service" }), geometry.clone());
        let map = with_road(vec![building(&[&SQUARE]), odd]);
        assert_eq!(
            left_out(&map),
            [(LeftOut::EmptyGeometry { got: kind.into() }, 1)],
            "{geometry}"
        );
        assert!(matches!(&map.warnings[..], [MapWarning::LeftOut { .. }]), "{geometry}");
    }
}

#[test]
fn tags_that_are_neither_text_nor_true_are_named() {
    let polygon = building(&[&SQUARE])["geometry"].clone();
    for (tags, key, got) in [
        (json!({ "building": 1 }), "building", "1"),
        (json!({ "building": ["yes"] }), "building", "[\"yes\"]"),
        (json!({ "building:part": 2.5 }), "building:part", "2.5"),
        (json!({ "highway": true, "x": 1 }), "highway", "true"),
    ] {
        let odd = feature(tags, polygon.clone());
        let map = with_road(vec![building(&[&SQUARE]), odd]);
        if key == "highway" {
            // `true` does not say which kind of road it is.
            assert_eq!(left_out(&map), [(LeftOut::OtherKind, 1)]);
            continue;
        }
        assert_eq!(left_out(&map), [(LeftOut::OddTag { key, got: got.into() }, 1)]);
        let warning = map.warnings[0].to_string();
        assert!(warning.contains(&format!("`{key}` is {got}, expected text or true")), "{warning}");
    }
}

#[test]
fn roads_need_two_positions_and_cars() {
    let stub = [[5.0, -5.0], [5.0, -5.0]];
    let map = with_road(vec![building(&[&SQUARE]), road(&stub)]);
    assert!(matches!(map.warnings[..], [MapWarning::ShortRoad { got: 1, .. }]));
    assert_eq!(left_out(&map), [(LeftOut::ShortRoad, 1)]);
    let line = json!({ "type": "MultiLineString", "coordinates": [positions(&ROAD)] });
    for (tags, expected) in [
        (json!({ "highway": "footway" }), 1),
        (json!({ "highway": "steps" }), 1),
        (json!({ "highway": "primary", "tunnel": "yes" }), 1),
        (json!({ "highway": "primary_link", "tunnel": "no" }), 2),
        (json!({ "highway": "living_street" }), 2),
    ] {
        let map = with_road(vec![building(&[&SQUARE]), feature(tags.clone(), line.clone())]);
        assert_eq!(map.roads.len(), expected, "{tags}");
        assert_eq!(map.warnings, [], "{tags}");
    }
    let map = read(&collection(json!([building(&[&SQUARE])]))).unwrap();
    assert_eq!(map.warnings, [MapWarning::NoRoads]);
}

#[test]
fn every_line_of_a_road_has_the_width_of_the_road() {
    let lines = json!([positions(&ROAD), positions(&[[0.0, -40.0], [0.0, 40.0]])]);
    let lines = json!({ "type": "MultiLineString", "coordinates": lines });
    let wide = feature(json!({ "highway": "motorway" }), lines);
    let mut tagged = road(&ROAD);
    tagged["properties"]["width"] = json!("3.5 m");
    let map = read(&collection(json!([building(&[&SQUARE]), wide, road(&ROAD), tagged]))).unwrap();
    assert_eq!(map.road_widths_m, [15.0, 15.0, 6.0, 3.5]);
    assert_eq!(map.road_width_m(3), 3.5);
}

#[test]
fn the_window_cuts_and_what_is_outside_is_counted() {
    let at = |x: f64| SQUARE.iter().map(|p| [p[0] + x, p[1]]).collect::<Vec<_>>();
    let map = with_road(vec![building(&[&at(45.0)]), building(&[&at(60.0)])]);
    assert!((area_m2(&map) - 50.0).abs() < 0.01);
    assert_eq!(left_out(&map), [(LeftOut::Outside, 1)]);
    assert!(matches!(&map.warnings[..], [MapWarning::LeftOut { .. }]));
    // On the other side of the world the plane must not fold back.
    let mut antipode = road(&ROAD);
    antipode["geometry"]["coordinates"] = json!([[180.0, 0.0], [179.9, 0.0]]);
    let map = with_road(vec![building(&[&SQUARE]), antipode]);
    assert_eq!(left_out(&map), [(LeftOut::Outside, 1)]);
    assert_eq!(map.roads.len(), 1);
}

#[test]
fn polygons_without_tags_are_told_of_and_may_be_buildings() {
    let polygon = building(&[&SQUARE])["geometry"].clone();
    let plain = feature(json!({ "height": 12.3, "confidence": -1 }), polygon.clone());
    let bare = json!({ "type": "Feature", "properties": null, "geometry": polygon });
    let park = feature(json!({ "leisure": "park" }), polygon.clone());
    let all = || collection(json!([road(&ROAD), plain, bare, park]));
    let errors = read(&all()).unwrap_err();
    assert!(matches!(&errors[..], [MapError::Untagged { count: 2, .. }]), "{errors:?}");
    let text = errors[0].to_string();
    assert!(text.contains("2 polygon(s) without a `building` tag, the first: feature 1"), "{text}");
    assert!(text.contains("map.untagged = \"buildings\""), "{text}");

    let map = read_with(&all(), Some(Untagged::Ignore)).unwrap();
    assert_eq!(left_out(&map), [(LeftOut::Untagged, 2), (LeftOut::OtherKind, 1)]);
    assert_eq!(map.obstacles.len(), 0);
    let map = read_with(&all(), Some(Untagged::Buildings)).unwrap();
    assert_eq!(left_out(&map), [(LeftOut::OtherKind, 1)]);
    assert_eq!(map.obstacles[0].height_m, 12.3);

    // Beside tagged buildings, untagged polygons are a warning.
    let map = with_road(vec![building(&[&SQUARE]), plain.clone()]);
    assert_eq!(map.obstacles[0].height_m, 9.0);
    let warning = map.warnings[0].to_string();
    assert!(
        warning
            .starts_with("1 feature(s) left out: polygons without a `building` tag (map.untagged")
    );
}

/// Every reason once: all are counted, and the sum is the number of features.
#[test]
fn every_feature_is_accounted_for() {
    let polygon = building(&[&SQUARE])["geometry"].clone();
    let line = road(&ROAD)["geometry"].clone();
    let of = |tags: Value, geometry: &Value| feature(tags, geometry.clone());
    let far = [[70.0, 0.0], [80.0, 0.0], [80.0, 10.0], [70.0, 0.0]];
    let features = json!([
        road(&ROAD),
        building(&[&SQUARE]),
        of(json!({ "building": "no" }), &polygon),
        of(json!({ "building": "yes", "location": "underground" }), &polygon),
        of(json!({ "building": 1 }), &polygon),
        of(json!({ "building": "yes" }), &Value::Null),
        of(json!({ "building": "yes" }), &json!({ "type": "MultiPolygon", "coordinates": [] })),
        of(json!({ "building": "yes" }), &line),
        building(&[&SQUARE[..2]]),
        building(&[&far]),
        road(&[[5.0, -5.0], [5.0, -5.0]]),
        of(json!({ "highway": "steps" }), &line),
        of(json!({ "highway": "primary", "tunnel": "yes" }), &line),
        of(json!({ "landuse": "grass" }), &polygon),
        of(json!({}), &polygon),
        tall(building(&[&square(20.0, 0.0, 5.0)]), json!({ "building": "yes" })),
        tall(building(&[&square(20.0, 0.0, 5.0)]), json!({ "building:part": "yes" })),
    ]);
    let map = read(&collection(features)).unwrap();
    assert_eq!(map.count.reasons.len(), 14, "{}", map.count);
    assert!(left_out(&map).iter().all(|(_, count)| *count == 1), "{}", map.count);
    let text = map.count.to_string();
    let first = "features: 17 = 1 building + 1 building part + 1 road + 14 left out";
    assert_eq!(text.lines().next(), Some(first));
    assert_eq!(text.lines().count(), 15);
}

/// A mistake in all features of a file is reported in one line.
#[test]
fn warnings_of_one_cause_are_one_line() {
    let houses = (0..9).map(|i| {
        let at = square(f64::from(i) * 5.0 - 40.0, 0.0, 4.0);
        let height = if i == 5 { "high" } else { "-1" };
        tall(building(&[&at]), json!({ "building": "yes", "height": height }))
    });
    let map = with_road(houses.collect());
    assert_eq!(map.warnings.len(), 9);
    let lines = csat_world::map::by_cause(&map.warnings);
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(
        lines[0].contains("feature 0 (way/7): height = \"-1\", expected a length"),
        "{}",
        lines[0]
    );
    assert!(lines[0].ends_with(
        "took 9 m (and 7 more like it: feature 1 (way/7), feature 2 (way/7), feature 3 (way/7), …)"
    ), "{}", lines[0]);
    assert!(lines[1].contains("feature 5 (way/7): height = \"high\""), "{}", lines[1]);
}

#[test]
fn features_of_other_kinds_are_left_alone() {
    let tree =
        feature(json!({ "natural": "tree" }), json!({ "type": "Point", "coordinates": [0, 0] }));
    let no = {
        let mut value = building(&[&SQUARE]);
        value["properties"]["building"] = json!("no");
        value
    };
    let map = with_road(vec![tree, no, building(&[&SQUARE])]);
    assert_eq!((map.obstacles.len(), map.warnings.len()), (1, 0));
}
