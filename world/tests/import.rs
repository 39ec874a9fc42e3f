//! Everything that can be wrong with a GeoJSON map, each by the smallest file that shows it.

use csat_proto::model::Ground;
use csat_world::map::geojson::import;
use csat_world::map::{LeftOut, Map, MapError, MapRules, MapWarning, Untagged};
use proptest::prelude::*;
use serde_json::{Value, json};

const RULES: MapRules = MapRules { lowest_altitude_m: 52.0, road_clearance_m: 2.55 };

/// Degrees per metre about (0, 0), where the tests' maps lie.
const DEG: f64 = 1.0 / 111_319.490_793;
/// The same northwards.
const DEG_N: f64 = 1.0 / 110_574.275_8;

fn read(text: &str) -> Result<Map, Vec<MapError>> {
    read_with(text, None)
}

fn read_with(text: &str, untagged: Option<Untagged>) -> Result<Map, Vec<MapError>> {
    let map = import(text, Ground { size_m: [100.0, 100.0] }, &RULES, untagged);
    if let Ok(map) = &map {
        let count = &map.count;
        assert_eq!(count.features, count.used() + count.left_out(), "{count}");
    }
    map
}

/// How many features were left out, by reason.
fn left_out(map: &Map) -> Vec<(LeftOut, usize)> {
    map.count.reasons.iter().map(|(reason, which)| (reason.clone(), which.len())).collect()
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
    assert_eq!((map.count.features, map.count.buildings, map.count.roads), (2, 1, 1));
    assert_eq!(map.count.left_out(), 0);
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
    assert_eq!(left_out(&map), [(LeftOut::NoArea, 1)]);
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

/// What is empty is called empty, not outside the region.
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
            // A flag says that there is a road, not which.
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
        (json!({ "height": "60'" }), 18.288, 0),
        (json!({ "height": "40'6\"" }), 12.3444, 0),
        (json!({ "height": "" }), 9.0, 0),
        (json!({ "building:height": "11 m", "est_height": "5" }), 11.0, 0),
        (json!({ "est_height": "13", "building:levels": "2" }), 13.0, 0),
        (json!({ "height": "?", "est_height": "13" }), 13.0, 1),
        (json!({ "building:levels": "2;3" }), 9.0, 0),
        (json!({ "building:levels": "2", "roof:levels": "1" }), 9.0, 0),
        (json!({ "building:levels": "2", "roof:levels": "1", "roof:height": "5 m" }), 11.0, 0),
        (json!({ "building:levels": "0", "roof:levels": "2" }), 6.0, 0),
        (json!({ "building:levels": "2", "roof:height": "steep" }), 6.0, 1),
        (json!({ "height": "15", "roof:height": "5" }), 15.0, 0),
        (json!({ "height": "6", "min_height": "7" }), 6.0, 1),
        (json!({ "height": "6", "min_height": "low" }), 6.0, 1),
        (json!({ "min_height": "0", "building:min_level": "0" }), 9.0, 0),
        (json!({ "height": "0" }), 9.0, 1),
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
        assert!((map.obstacles[0].height_m - expected_m).abs() < 1e-9, "{tags}");
        assert_eq!(map.warnings.len(), warnings, "{tags}: {:?}", map.warnings);
        for warning in &map.warnings {
            if let MapWarning::BadHeight { key, got, .. } = warning {
                assert!(tags[*key].to_string().contains(got.trim_matches('"')), "{warning}");
            }
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
    for text in
        ["[]", "{}", r#"{"type": "Topology"}"#, r#"{"type": "FeatureCollection"}"#, "", "\u{feff} "]
    {
        assert!(matches!(&read(text).unwrap_err()[..], [MapError::NotCollection { .. }]), "{text}");
    }
    let town = collection(json!([building(&[&SQUARE])]));
    let broken = town.replacen("\"properties\":", "\"properties\"", 1);
    for text in [broken.clone(), format!("\u{feff}{broken}"), format!("\u{1e}{broken}")] {
        let at = text.trim_start_matches('\u{feff}').find("\"properties\"{").unwrap() + 13;
        assert!(
            matches!(&read(&text).unwrap_err()[..], [MapError::NotJson { line: 1, column, reason }]
                if *column == at && reason == "expected `:`"),
            "{:?}, not {at}",
            read(&text)
        );
    }
}

/// What editors, streams and exporters make of the same town.
#[test]
fn the_same_town_is_read_from_every_kind_of_file() {
    let [house, road] = [building(&[&SQUARE]), road(&ROAD)];
    let whole = collection(json!([house, road]));
    let expected = read(&whole).unwrap();
    assert_eq!(read(&format!("\u{feff}{whole}")).unwrap(), expected);
    for (name, text) in [
        ("lines", format!("{house}\n{road}\n")),
        ("lines of Windows", format!("{house}\r\n{road}\r\n")),
        ("a mark", format!("\u{feff}{house}\n{road}")),
        ("empty lines", format!("{house}\n\n{road}\n\n")),
        ("RFC 8142", format!("\u{1e}{house}\n\u{1e}{road}\n")),
        ("collections", format!("{}\n{}", collection(json!([house])), collection(json!([road])))),
    ] {
        let map = read(&text).unwrap();
        assert_eq!((map.obstacles.len(), map.roads.len()), (1, 1), "{name}");
        assert!((area_m2(&map) - 100.0).abs() < 0.01, "{name}");
        let is_collection = name == "collections";
        assert_eq!(map.warnings.is_empty(), is_collection, "{name}: {:?}", map.warnings);
        assert!(
            is_collection || matches!(map.warnings[..], [MapWarning::NoCenter { .. }]),
            "{name}"
        );
    }
    assert_eq!(read(&house.to_string()).unwrap().obstacles.len(), 1, "a single feature");
    let error = read(&format!("{house}\n{{}}")).unwrap_err();
    assert!(error[0].to_string().contains("an object without type as document 2"), "{}", error[0]);
    let errors = read(&format!("{house}\n{house}x")).unwrap_err();
    assert!(matches!(&errors[..], [MapError::NotJson { line: 2, .. }]), "{errors:?}");
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

    // Beside tagged buildings they are a warning.
    let map = with_road(vec![building(&[&SQUARE]), plain.clone()]);
    assert_eq!(map.obstacles[0].height_m, 9.0);
    let warning = map.warnings[0].to_string();
    assert!(
        warning
            .starts_with("1 feature(s) left out: polygons without a `building` tag (map.untagged")
    );
}

#[test]
fn projected_files_are_one_mistake_and_their_crs_is_named() {
    let town = |crs: Value, scale: f64| {
        let rings: Vec<Value> = (0..30)
            .map(|i| {
                let mut house = building(&[&SQUARE]);
                let corner = |x: f64, y: f64| json!([x * scale + f64::from(i), y * scale]);
                let ring = [corner(2.0, 8.0), corner(2.0, 9.0), corner(3.0, 9.0), corner(2.0, 8.0)];
                house["geometry"]["coordinates"] = json!([ring]);
                house
            })
            .collect();
        let mut text: Value = serde_json::from_str(&collection(json!(rings))).unwrap();
        text["crs"] = crs;
        text.to_string()
    };
    let named = |name: &str| json!({ "type": "name", "properties": { "name": name } });
    let errors = read(&town(Value::Null, 1e6)).unwrap_err();
    assert!(matches!(&errors[..], [MapError::BadPosition { count: 30, .. }]), "{errors:?}");
    assert!(
        errors[0].to_string().starts_with("30 feature(s) have positions that are no [longitude")
    );
    let errors = read(&town(named("EPSG:3857"), 1e6)).unwrap_err();
    assert!(
        matches!(&errors[..], [MapError::ForeignCrs { got, bad: 30, features: 30 }] if got == "EPSG:3857"),
        "{errors:?}"
    );
    // Numbers that could be degrees are refused all the same.
    let errors = read(&town(named("urn:ogc:def:crs:EPSG::2154"), 1.0)).unwrap_err();
    assert!(matches!(&errors[..], [MapError::ForeignCrs { bad: 0, .. }]), "{errors:?}");
    assert!(read(&town(named("urn:ogc:def:crs:OGC:1.3:CRS84"), 1.0)).is_ok());
}

fn tall(mut value: Value, tags: Value) -> Value {
    value["properties"] = tags;
    value
}

fn square(x: f64, y: f64, side: f64) -> [[f64; 2]; 5] {
    [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
}

/// Height over a place; 0 where nothing stands.
fn height_at(map: &Map, p: [f64; 2]) -> f64 {
    let walls = csat_world::obstacle::Walls::new(&map.obstacles);
    walls.nearest_within(p, 1e-3).map_or(0.0, |(index, _)| map.obstacles[index].height_m)
}

#[test]
fn parts_are_built_and_the_outline_is_not() {
    let outline =
        tall(building(&[&square(0.0, 0.0, 20.0)]), json!({ "building": "yes", "height": "40" }));
    let half = |x: f64| [[x, 0.0], [x + 10.0, 0.0], [x + 10.0, 20.0], [x, 20.0], [x, 0.0]];
    let low = tall(building(&[&half(0.0)]), json!({ "building:part": "yes", "height": "6" }));
    let high = tall(building(&[&half(10.0)]), json!({ "building:part": "yes", "height": "40" }));
    let map = with_road(vec![outline.clone(), low, high]);
    assert_eq!(map.warnings, []);
    assert_eq!(left_out(&map), [(LeftOut::HasParts, 1)]);
    assert_eq!((map.count.buildings, map.count.parts), (0, 2));
    assert_eq!((height_at(&map, [5.0, 10.0]), height_at(&map, [15.0, 10.0])), (6.0, 40.0));

    // A part of unknown height is as high as its building; `no` is none.
    let bare = tall(building(&[&half(0.0)]), json!({ "building:part": "yes" }));
    let none = tall(building(&[&half(10.0)]), json!({ "building:part": "no", "height": "9" }));
    let map = with_road(vec![outline, bare, none]);
    assert_eq!(height_at(&map, [5.0, 10.0]), 40.0);
    assert_eq!(left_out(&map), [(LeftOut::NotABuilding, 1)]);
}

#[test]
fn ground_that_no_part_covers_is_built_and_told() {
    let tower = tall(
        building(&[&square(5.0, 5.0, 9.0)]),
        json!({ "building:part": "yes", "height": "40" }),
    );
    for (height, rest_m) in [(json!("6"), 6.0), (Value::Null, 40.0), (json!("40"), 40.0)] {
        let tags = json!({ "building": "yes", "height": height });
        let map = with_road(vec![tall(building(&[&square(0.0, 0.0, 30.0)]), tags), tower.clone()]);
        assert_eq!(height_at(&map, [9.0, 9.0]), 40.0);
        assert_eq!(height_at(&map, [25.0, 25.0]), rest_m, "{height}");
        assert!(
            matches!(&map.warnings[..],
            [MapWarning::PartsLeave { parts: 1, area_m2, used_m, .. }]
                if (area_m2 - 819.0).abs() < 0.1 && *used_m == rest_m),
            "{:?}",
            map.warnings
        );
        assert_eq!((map.count.buildings, map.count.parts), (1, 1));
    }
    // The height of the whole tells nothing of the rest: it is like the lowest part.
    let low = tall(
        building(&[&square(15.0, 5.0, 9.0)]),
        json!({ "building:part": "yes", "height": "8" }),
    );
    let whole =
        tall(building(&[&square(0.0, 0.0, 30.0)]), json!({ "building": "yes", "height": "40" }));
    let map = with_road(vec![whole, tower, low]);
    assert_eq!((height_at(&map, [25.0, 25.0]), height_at(&map, [9.0, 9.0])), (8.0, 40.0));
    // A gap of drawing is none.
    let tags = json!({ "building": "yes" });
    let part = tall(
        building(&[&square(0.2, 0.2, 29.6)]),
        json!({ "building:part": "yes", "height": "7" }),
    );
    let map = with_road(vec![tall(building(&[&square(0.0, 0.0, 30.0)]), tags), part.clone()]);
    assert_eq!((map.obstacles.len(), &map.warnings[..]), (1, &[][..]));
    // Without a building around it, a part is one.
    let map = with_road(vec![part]);
    assert_eq!((height_at(&map, [9.0, 9.0]), map.count.parts), (7.0, 1));
}

#[test]
fn what_begins_above_the_ground_is_built_from_the_ground() {
    let podium = tall(
        building(&[&square(0.0, 0.0, 20.0)]),
        json!({ "building:part": "yes", "height": "6" }),
    );
    let on = |side: f64, tags: Value| tall(building(&[&square(5.0, 5.0, side)]), tags);
    let upper = json!({ "building:part": "yes", "height": "30", "min_height": "6" });
    let map = with_road(vec![podium.clone(), on(10.0, upper.clone())]);
    let outlined = tall(building(&[&square(0.0, 0.0, 20.0)]), json!({ "building": "yes" }));
    assert_eq!((height_at(&map, [10.0, 10.0]), height_at(&map, [2.0, 2.0])), (30.0, 6.0));
    assert!(
        !map.warnings.iter().any(|w| matches!(w, MapWarning::Floating { .. })),
        "{:?}",
        map.warnings
    );
    // Within one building they stand on each other without a word.
    let map = with_road(vec![outlined, podium.clone(), on(10.0, upper)]);
    assert_eq!(map.warnings, []);
    // The upper one reaches 5 m x 20 m and 15 m x 5 m beyond the podium.
    let levels =
        json!({ "building:part": "yes", "building:levels": "9", "building:min_level": "2" });
    let map = with_road(vec![podium, on(20.0, levels)]);
    assert_eq!(height_at(&map, [22.0, 22.0]), 27.0);
    let floating = |w: &&MapWarning| matches!(w, MapWarning::Floating { base_m: 6.0, area_m2, .. } if (area_m2 - 175.0).abs() < 0.1);
    assert_eq!(map.warnings.iter().filter(floating).count(), 1, "{:?}", map.warnings);
    // A roof on columns is a building down to the ground.
    let canopy =
        tall(building(&[&SQUARE]), json!({ "building": "roof", "height": "5", "min_height": "4" }));
    let map = with_road(vec![canopy]);
    assert_eq!(height_at(&map, [5.0, 5.0]), 5.0);
    assert!(matches!(&map.warnings[..], [MapWarning::Floating { base_m: 4.0, .. }]));
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

/// A fault that a whole file has is one line.
#[test]
fn warnings_of_one_cause_are_one_line() {
    let houses = (0..9).map(|i| {
        let at = square(f64::from(i) * 5.0 - 40.0, 0.0, 4.0);
        let height = if i == 5 { "high" } else { "-1" };
        tall(building(&[&at]), json!({ "building": "yes", "height": height }))
    });
    let map = with_road(houses.collect());
    assert_eq!(map.warnings.len(), 9);
    let lines = csat_world::map::report::by_cause(&map.warnings);
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
    let (last, broken) = errors.split_last().unwrap();
    for (index, error) in (1..).zip(broken) {
        let text = error.to_string();
        assert!(text.starts_with(&format!("feature {index}")), "{text}");
        assert!(text.contains("way/7") || index == 5, "{text}");
        assert!(matches!(error, MapError::BadFeature { .. }), "{error}");
    }
    assert!(
        broken[1].to_string().contains("a position of fewer than two numbers"),
        "{}",
        broken[1]
    );
    assert!(
        matches!(last, MapError::BadPosition { feature, got, count: 1 }
            if feature.name.as_deref() == Some("Hall") && got[0] == 385_000.0),
        "{last}"
    );
    // Thousands of them are no thousand lines.
    let errors = read(&collection(json!(vec![5; 3000]))).unwrap_err();
    assert_eq!(errors.len(), 9);
    assert_eq!(errors[8], MapError::MoreBadFeatures { count: 2992 });
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
