//! All mistakes of a GeoJSON map, each with the smallest file that has it.

use csat_proto::model::Ground;
use csat_world::map::geojson::import;
use csat_world::map::{LeftOut, Map, MapError, MapRules, Untagged};
use serde_json::{Value, json};

mod buildings;
mod features;
mod files;
mod rings;

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

fn tall(mut value: Value, tags: Value) -> Value {
    value["properties"] = tags;
    value
}

fn square(x: f64, y: f64, side: f64) -> [[f64; 2]; 5] {
    [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
}
