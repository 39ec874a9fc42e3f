//! Real towns from RFC 7946 GeoJSON in longitude and latitude, as OpenStreetMap exports them.
//!
//! Buildings are features with a `building` tag, roads features with a drivable `highway` tag; all
//! else is not ours and left alone. Positions are projected to the local tangent plane about the
//! foreign member `center` ([longitude, latitude]) or else the middle of the data.
//!
//! What is not GeoJSON is an error; what is GeoJSON but no usable town (open or crossing rings,
//! overlaps, odd heights) is repaired or left out with a warning. Both name the feature.

use ::geojson::{Feature, GeometryValue, Position, feature};
use csat_proto::model::Ground;
use serde_json::{Map as JsonObject, Value};

use super::project::TangentPlane;
use super::report::{FeatureRef, MapError, MapWarning};
use super::{Map, MapRules};
use crate::plane::Bounds;

mod town;

/// Values of `highway` that cars use; links (`primary_link`) included.
const DRIVABLE: [&str; 11] = [
    "motorway",
    "trunk",
    "primary",
    "secondary",
    "tertiary",
    "unclassified",
    "residential",
    "living_street",
    "service",
    "road",
    "busway",
];

/// Reads a town from GeoJSON text: the part of it inside `ground`, tops below the flights.
///
/// # Errors
/// Every mistake at once: not JSON, not a feature collection, features that are none, positions
/// that are no longitude and latitude.
pub fn import(text: &str, ground: Ground, rules: &MapRules) -> Result<Map, Vec<MapError>> {
    let document: Value = serde_json::from_str(text)
        .map_err(|e| vec![MapError::NotJson { reason: e.to_string() }])?;
    let (collection, features) = features_of(&document).map_err(|e| vec![e])?;
    let mut errors = Vec::new();
    let parsed = parse(features, &mut errors);
    let centre = match collection.get("center").map(|v| (v, position_of(v))) {
        None => None,
        Some((_, Some(centre))) => Some(centre),
        Some((value, None)) => {
            errors.push(MapError::BadCenter { got: value.to_string() });
            None
        }
    };
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut warnings = Vec::new();
    let centre = centre.unwrap_or_else(|| {
        let got = middle(&parsed);
        warnings.push(MapWarning::NoCenter { got });
        got
    });
    let plane = TangentPlane::new(centre);
    let attribution = collection.get("attribution").and_then(Value::as_str).map(str::to_owned);
    Ok(town::Town { plane, ground, rules, warnings }.build(&parsed, attribution))
}

/// The members of a feature collection and its features.
fn features_of(document: &Value) -> Result<(&JsonObject<String, Value>, &[Value]), MapError> {
    let got = |got: String| Err(MapError::NotCollection { got });
    let Some(collection) = document.as_object() else {
        return got("a document that is not an object".into());
    };
    match collection.get("type").and_then(Value::as_str) {
        Some("FeatureCollection") => {}
        Some(other) => return got(format!("a {other}")),
        None => return got("an object without type".into()),
    }
    match collection.get("features").and_then(Value::as_array) {
        Some(features) => Ok((collection, features)),
        None => got("a FeatureCollection without features".into()),
    }
}

/// A feature that matters to a town.
struct Parsed {
    reference: FeatureRef,
    kind: Kind,
    properties: JsonObject<String, Value>,
    geometry: Option<GeometryValue>,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Building,
    Road,
}

/// The buildings and roads among `features`.
fn parse(features: &[Value], errors: &mut Vec<MapError>) -> Vec<Parsed> {
    let mut parsed = Vec::new();
    for (index, value) in features.iter().enumerate() {
        let reference = reference_to(index, value);
        let result = serde_json::from_value::<Feature>(value.clone());
        let feature = match result {
            Ok(feature) => feature,
            Err(e) => {
                let reason = e.to_string();
                errors.push(MapError::BadFeature { feature: reference, reason });
                continue;
            }
        };
        let properties = feature.properties.unwrap_or_default();
        let Some(kind) = kind_of(&properties) else { continue };
        let geometry = feature.geometry.map(|g| g.value);
        let bad = geometry.iter().flat_map(positions).find(|p| !is_lon_lat(p.as_slice()));
        if let Some(bad) = bad {
            let got = bad.as_slice().to_vec();
            errors.push(MapError::BadPosition { feature: reference, got });
            continue;
        }
        parsed.push(Parsed { reference, kind, properties, geometry });
    }
    parsed
}

fn reference_to(index: usize, feature: &Value) -> FeatureRef {
    let id = match feature.get("id").and_then(|id| serde_json::from_value(id.clone()).ok()) {
        Some(feature::Id::String(id)) => Some(id),
        Some(feature::Id::Number(id)) => Some(id.to_string()),
        None => None,
    };
    let name = feature.get("properties").and_then(|p| p.get("name")).and_then(Value::as_str);
    FeatureRef { index, id, name: name.map(str::to_owned) }
}

fn kind_of(properties: &JsonObject<String, Value>) -> Option<Kind> {
    let tag = |key| properties.get(key).and_then(Value::as_str);
    // Exporters write `"building": true` as well as `"building": "yes"`.
    let flag = properties.get("building").and_then(Value::as_bool);
    if flag == Some(true) || tag("building").is_some_and(|v| v != "no") {
        return Some(Kind::Building);
    }
    let highway = tag("highway")?;
    let underground = tag("tunnel").is_some_and(|v| v != "no");
    let drivable = DRIVABLE.contains(&highway.trim_end_matches("_link"));
    (drivable && !underground).then_some(Kind::Road)
}

fn is_lon_lat(p: &[f64]) -> bool {
    p.len() >= 2 && (-180.0..=180.0).contains(&p[0]) && (-90.0..=90.0).contains(&p[1])
}

fn position_of(value: &Value) -> Option<[f64; 2]> {
    let numbers: Vec<f64> = value.as_array()?.iter().map_while(Value::as_f64).collect();
    is_lon_lat(&numbers).then(|| [numbers[0], numbers[1]])
}

/// Every position of a geometry.
fn positions(geometry: &GeometryValue) -> Vec<&Position> {
    match geometry {
        GeometryValue::Point { coordinates } => vec![coordinates],
        GeometryValue::MultiPoint { coordinates } | GeometryValue::LineString { coordinates } => {
            coordinates.iter().collect()
        }
        GeometryValue::MultiLineString { coordinates } | GeometryValue::Polygon { coordinates } => {
            coordinates.iter().flatten().collect()
        }
        GeometryValue::MultiPolygon { coordinates } => {
            coordinates.iter().flatten().flatten().collect()
        }
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().flat_map(|g| positions(&g.value)).collect()
        }
    }
}

/// The middle of the data, [longitude, latitude] in degrees.
fn middle(parsed: &[Parsed]) -> [f64; 2] {
    let all = parsed.iter().filter_map(|p| p.geometry.as_ref()).flat_map(positions);
    Bounds::around(all.map(|p| [p[0], p[1]]))
        .map_or([0.0; 2], |b| [(b.min[0] + b.max[0]) / 2.0, (b.min[1] + b.max[1]) / 2.0])
}
