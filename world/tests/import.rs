//! Everything that can be wrong with a GeoJSON map, each by the smallest file that shows it.

use csat_proto::model::Ground;
use csat_world::map::geojson::import;
use csat_world::map::{Map, MapError, MapRules, MapWarning};
use proptest::prelude::*;
use serde_json::{Value, json};

const RULES: MapRules = MapRules { lowest_altitude_m: 52.0, road_clearance_m: 2.55 };

/// Degrees per metre about (0, 0), where the tests' maps lie.
const DEG: f64 = 1.0 / 111_319.490_793;
/// The same northwards.
const DEG_N: f64 = 1.0 / 110_574.275_8;

fn read(text: &str) -> Result<Map, Vec<MapError>> {
    import(text, Ground { size_m: [100.0, 100.0] }, &RULES)
}

fn collection(features: Value) -> String {
    json!({ "type": "FeatureCollection", "center": [0.0, 0.0], "features": features }).to_string()
}

fn position(p: &[f64; 2]) -> Value {
    json!([p[0] * DEG, p[1] * DEG_N])
}

fn positions(points: &[[f64; 2]]) -> Value {
    points.iter().map(position).collect()
}

fn feature(properties: Value, geometry: Value) -> Value {
    json!({ "type": "Feature", "id": "way/7", "properties": properties, "geometry": geometry })
}

fn building(rings: &[&[[f64; 2]]]) -> Value {
    let rings: Vec<Value> = rings.iter().map(|r| positions(r)).collect();
    feature(json!({ "building": "yes" }), json!({ "type": "Polygon", "coordinates": rings }))
}

fn road(points: &[[f64; 2]]) -> Value {
    let line = json!({ "type": "LineString", "coordinates": positions(points) });
    feature(json!({ "highway": "residential" }), line)
}

const SQUARE: [[f64; 2]; 5] = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]];
const ROAD: [[f64; 2]; 2] = [[-60.0, -20.0], [60.0, -20.0]];

/// The map of one building and a road, and the warnings.
fn with_road(buildings: Vec<Value>) -> Map {
    let mut features = buildings;
    features.push(road(&ROAD));
    read(&collection(json!(features))).unwrap()
}

fn area_m2(map: &Map) -> f64 {
    map.obstacles.iter().map(|o| o.area_m2()).sum()
}

#[test]
fn a_clean_map_has_no_warnings() {
    let map = with_road(vec![building(&[&SQUARE])]);
    assert_eq!(map.warnings, []);
    assert!((area_m2(&map) - 100.0).abs() < 0.01, "{}", area_m2(&map));
    assert_eq!(map.obstacles[0].name, "way/7");
    assert_eq!(map.roads.len(), 1);
}

#[test]
fn open_rings_are_closed_and_repeats_dropped() {
    let map = with_road(vec![building(&[&SQUARE[..4]])]);
    assert!(
        matches!(&map.warnings[..], [MapWarning::RingClosed { ring, .. }] if ring == "outer ring")
    );
    assert!((area_m2(&map) - 100.0).abs() < 0.01);
    let mut repeated = SQUARE.to_vec();
    repeated.splice(1..1, [SQUARE[0], SQUARE[0]]);
    let map = with_road(vec![building(&[&repeated])]);
    assert!(matches!(map.warnings[..], [MapWarning::RepeatedPositions { count: 2, .. }]));
    assert!((area_m2(&map) - 100.0).abs() < 0.01);
}

#[test]
fn crossing_rings_are_rebuilt() {
    let tie = [[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0], [0.0, 0.0]];
    let map = with_road(vec![building(&[&tie])]);
    assert!(matches!(map.warnings[..], [MapWarning::SelfCrossing { parts: 2, .. }]));
    assert!((area_m2(&map) - 50.0).abs() < 0.01);
    assert_eq!(map.obstacles.len(), 2);
}

#[test]
fn rings_of_nothing_are_left_out() {
    let map = with_road(vec![building(&[&SQUARE[..2]])]);
    assert!(matches!(
        map.warnings[..],
        [MapWarning::ShortRing { got: 2, .. }, MapWarning::NoBuildings]
    ));
    let map = with_road(vec![building(&[])]);
    assert!(matches!(map.warnings[0], MapWarning::ShortRing { got: 0, .. }));
    let line = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [0.0, 0.0]];
    let map = with_road(vec![building(&[&line])]);
    assert!(matches!(map.warnings[..], [MapWarning::ZeroArea { .. }, MapWarning::NoBuildings]));
    // A hole that is none leaves the building whole.
    let map = with_road(vec![building(&[&SQUARE, &line])]);
    assert!(matches!(&map.warnings[..], [MapWarning::ZeroArea { ring, .. }] if ring == "hole 1"));
    assert!((area_m2(&map) - 100.0).abs() < 0.01);
}

#[test]
fn holes_are_courtyards_and_stray_ones_are_trimmed() {
    let hole = |x: f64| [[x, 4.0], [x, 6.0], [x + 2.0, 6.0], [x + 2.0, 4.0], [x, 4.0]];
    let map = with_road(vec![building(&[&SQUARE, &hole(4.0)])]);
    assert_eq!(map.warnings, []);
    assert_eq!(map.obstacles[0].footprint.interiors().len(), 1);
    let map = with_road(vec![building(&[&SQUARE, &hole(9.0)])]);
    assert!(matches!(map.warnings[..], [MapWarning::HoleOutside { .. }]));
    assert!((area_m2(&map) - 98.0).abs() < 0.01);
}

#[test]
fn sheds_are_kept() {
    let shed = [[0.0, 0.0], [1.5, 0.0], [1.5, 1.5], [0.0, 1.5], [0.0, 0.0]];
    let map = with_road(vec![building(&[&shed])]);
    assert!((area_m2(&map) - 2.25).abs() < 1e-3);
    assert_eq!(map.warnings, []);
}

#[test]
fn multipolygons_are_one_feature() {
    let far: Vec<[f64; 2]> = SQUARE.iter().map(|p| [p[0] + 20.0, p[1]]).collect();
    let near: Vec<[f64; 2]> = SQUARE.iter().map(|p| [p[0] + 5.0, p[1]]).collect();
    let rings = [&SQUARE[..], &far, &near].map(|ring| json!([positions(ring)]));
    let geometry = json!({ "type": "MultiPolygon", "coordinates": rings });
    let map = with_road(vec![feature(json!({ "building": true }), geometry)]);
    assert_eq!(map.obstacles.len(), 2);
    assert!((area_m2(&map) - 250.0).abs() < 0.03);
}

#[test]
fn geometry_of_no_or_the_wrong_kind_is_left_out() {
    let point = json!({ "type": "Point", "coordinates": [0.0, 0.0] });
    let line = json!({ "type": "LineString", "coordinates": positions(&ROAD) });
    for (properties, geometry, expected) in [
        (json!({ "building": "yes" }), line, "Polygon or MultiPolygon"),
        (json!({ "highway": "service" }), point, "LineString or MultiLineString"),
    ] {
        let map = with_road(vec![building(&[&SQUARE]), feature(properties, geometry)]);
        assert!(matches!(&map.warnings[..],
            [MapWarning::WrongGeometry { expected: e, .. }] if *e == expected));
    }
    let map = with_road(vec![building(&[&SQUARE]), feature(json!({ "building": 1 }), Value::Null)]);
    assert_eq!(map.warnings, [], "not tagged as a building");
    let none = feature(json!({ "building": "yes" }), Value::Null);
    let map = with_road(vec![building(&[&SQUARE]), none]);
    assert!(matches!(&map.warnings[..],
        [MapWarning::NoGeometry { feature }] if feature.to_string() == "feature 1 (way/7)"));
}

#[test]
fn roads_need_two_positions_and_cars() {
    let stub = [[5.0, -5.0], [5.0, -5.0]];
    let map = with_road(vec![building(&[&SQUARE]), road(&stub)]);
    assert!(matches!(map.warnings[..], [MapWarning::ShortRoad { got: 1, .. }]));
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
fn heights_are_read_in_every_spelling() {
    for (tags, expected_m, warnings) in [
        (json!({}), 9.0, 0),
        (json!({ "height": "18" }), 18.0, 0),
        (json!({ "height": "18 m", "building:levels": "2" }), 18.0, 0),
        (json!({ "height": "12.5m" }), 12.5, 0),
        (json!({ "height": 7 }), 7.0, 0),
        (json!({ "height": null, "building:levels": "3.5" }), 10.5, 0),
        (json!({ "building:levels": 4 }), 12.0, 0),
        (json!({ "height": "tall", "building:levels": "4" }), 12.0, 1),
        (json!({ "height": "60'" }), 9.0, 1),
        (json!({ "height": "-3" }), 9.0, 1),
        (json!({ "height": "NaN", "building:levels": "0" }), 9.0, 2),
        (json!({ "height": "18", "building:levels": "?" }), 18.0, 0),
        (json!({ "height": "50" }), 50.0, 0),
        (json!({ "height": "80" }), 50.0, 1),
    ] {
        let mut value = building(&[&SQUARE]);
        let properties = value["properties"].as_object_mut().unwrap();
        properties.extend(tags.as_object().unwrap().clone());
        let map = with_road(vec![value]);
        assert_eq!(map.obstacles[0].height_m, expected_m, "{tags}");
        assert_eq!(map.warnings.len(), warnings, "{tags}: {:?}", map.warnings);
        for warning in &map.warnings {
            let clamped =
                matches!(warning, MapWarning::HeightClamped { got_m: 80.0, max_m: 50.0, .. });
            assert!(clamped || matches!(warning, MapWarning::BadHeight { .. }), "{warning}");
        }
    }
}

#[test]
fn overlaps_are_resolved_and_named() {
    let shifted: Vec<[f64; 2]> = SQUARE.iter().map(|p| [p[0] + 5.0, p[1] + 5.0]).collect();
    let map = with_road(vec![building(&[&SQUARE]), building(&[&shifted])]);
    assert!(matches!(map.warnings[..], [MapWarning::Overlap { what: "merged them", .. }]));
    assert_eq!(map.obstacles.len(), 1);
    let mut high = building(&[&shifted]);
    high["properties"]["height"] = json!("20");
    let map = with_road(vec![building(&[&SQUARE]), high]);
    assert!(matches!(map.warnings[..], [MapWarning::Overlap { what: "cut the lower one", .. }]));
    assert_eq!(map.obstacles.len(), 2);
    assert!((area_m2(&map) - 175.0).abs() < 0.02);
}

#[test]
fn the_window_cuts_and_what_is_outside_is_counted() {
    let at = |x: f64| SQUARE.iter().map(|p| [p[0] + x, p[1]]).collect::<Vec<_>>();
    let map = with_road(vec![building(&[&at(45.0)]), building(&[&at(60.0)])]);
    assert!((area_m2(&map) - 50.0).abs() < 0.01);
    assert!(matches!(&map.warnings[..], [MapWarning::Outside { features }] if features.len() == 1));
    // On the other side of the world the plane must not fold back.
    let mut antipode = road(&ROAD);
    antipode["geometry"]["coordinates"] = json!([[180.0, 0.0], [179.9, 0.0]]);
    let map = with_road(vec![building(&[&SQUARE]), antipode]);
    assert!(matches!(&map.warnings[..], [MapWarning::Outside { .. }]));
    assert_eq!(map.roads.len(), 1);
}

#[test]
fn the_centre_may_be_missing_but_not_wrong() {
    let document = |center: Value| {
        let mut value: Value =
            serde_json::from_str(&collection(json!([building(&[&SQUARE]), road(&ROAD)]))).unwrap();
        match center {
            Value::Null => value.as_object_mut().unwrap().remove("center"),
            center => value.as_object_mut().unwrap().insert("center".into(), center),
        };
        value.to_string()
    };
    let map = read(&document(Value::Null)).unwrap();
    // The data spans x from −60 to 60 and y from −20 to 10.
    assert!(matches!(map.warnings[..], [MapWarning::NoCenter { got }]
        if got[0].abs() < 1e-9 && (got[1] / DEG_N + 5.0).abs() < 1e-6));
    for bad in [json!("here"), json!([1.0]), json!([500.0, 0.0]), json!([null, 0.0])] {
        let errors = read(&document(bad.clone())).unwrap_err();
        assert_eq!(errors, [MapError::BadCenter { got: bad.to_string() }]);
    }
}

#[test]
fn what_is_not_geojson_is_an_error() {
    assert!(matches!(&read("{").unwrap_err()[..], [MapError::NotJson { .. }]));
    assert!(matches!(&read("[1e999]").unwrap_err()[..], [MapError::NotJson { .. }]));
    for text in ["[]", "{}", r#"{"type": "Feature"}"#, r#"{"type": "FeatureCollection"}"#] {
        assert!(matches!(&read(text).unwrap_err()[..], [MapError::NotCollection { .. }]), "{text}");
    }
}

#[test]
fn every_broken_feature_is_named_at_once() {
    let mut projected = building(&[&SQUARE]);
    projected["geometry"]["coordinates"][0][2] = json!([385_000.0, 6_672_000.0]);
    projected["properties"]["name"] = json!("Hall");
    let mut not_a_number = building(&[&SQUARE]);
    not_a_number["geometry"]["coordinates"][0][1] = json!([null, 0.0]);
    let mut short = building(&[&SQUARE]);
    short["geometry"]["coordinates"][0][1] = json!([0.0]);
    let mut flat = building(&[&SQUARE]);
    flat["geometry"]["coordinates"] = json!([0.0, 0.0]);
    let mut unknown = building(&[&SQUARE]);
    unknown["geometry"]["type"] = json!("Blob");
    let features = json!([projected, not_a_number, short, flat, unknown, 5]);
    let errors = read(&collection(features)).unwrap_err();
    assert_eq!(errors.len(), 6, "{errors:?}");
    for (index, error) in errors.iter().enumerate() {
        let text = error.to_string();
        assert!(text.starts_with(&format!("feature {index}")), "{text}");
        assert!(text.contains("way/7") || index == 5, "{text}");
        match error {
            MapError::BadPosition { feature, got } if index == 0 => {
                assert_eq!(feature.name.as_deref(), Some("Hall"));
                assert_eq!(got[0], 385_000.0);
            }
            MapError::BadPosition { got, .. } => assert_eq!((index, &got[..]), (2, &[0.0][..])),
            other => assert!(matches!(other, MapError::BadFeature { .. }) && index > 0, "{other}"),
        }
    }
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

proptest! {
    #![proptest_config(ProptestConfig::with_failure_persistence(
        proptest::test_runner::FileFailurePersistence::WithSource("regressions"),
    ))]
    /// Arbitrary JSON in place of coordinates: an error or a map, never a panic.
    #[test]
    fn hostile_coordinates_do_not_panic(
        points in prop::collection::vec(
            prop_oneof![
                (-0.001..0.001f64, -0.001..0.001f64).prop_map(|(x, y)| json!([x, y])),
                (-1e6..1e6f64).prop_map(|x| json!([x, x])),
                any::<bool>().prop_map(Value::from),
                Just(json!([])),
                Just(json!([0.0, 0.0, 1.0, 2.0])),
            ],
            0..8,
        ),
        kind in prop_oneof![Just("Polygon"), Just("MultiPolygon"), Just("LineString")],
    ) {
        for coordinates in [json!(points), json!([points]), json!([[points]])] {
            let geometry = json!({ "type": kind, "coordinates": coordinates });
            for tag in ["building", "highway"] {
                let value = feature(json!({ tag: "service" }), geometry.clone());
                let _ = read(&collection(json!([value])));
            }
        }
    }
}
