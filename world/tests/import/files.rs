//! Valid and invalid files.

use csat_world::map::{MapError, MapWarning};
use proptest::prelude::*;
use serde_json::{Value, json};

use super::{DEG_N, ROAD, SQUARE, area_m2, building, collection, feature, read, road};

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

/// The same town as editors, streams and exporters write it.
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
    // Numbers that could be degrees are refused as well.
    let errors = read(&town(named("urn:ogc:def:crs:EPSG::2154"), 1.0)).unwrap_err();
    assert!(matches!(&errors[..], [MapError::ForeignCrs { bad: 0, .. }]), "{errors:?}");
    assert!(read(&town(named("urn:ogc:def:crs:OGC:1.3:CRS84"), 1.0)).is_ok());
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
    // Thousands of mistakes are not reported one by one.
    let errors = read(&collection(json!(vec![5; 3000]))).unwrap_err();
    assert_eq!(errors.len(), 9);
    assert_eq!(errors[8], MapError::MoreBadFeatures { count: 2992 });
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
