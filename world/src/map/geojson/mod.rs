//! Real towns from RFC 7946 GeoJSON in longitude and latitude, as OpenStreetMap exports them.
//!
//! Buildings are features with a `building` tag, parts of them with heights of their own have
//! `building:part`, and roads have a drivable `highway`; all other features are counted and left out.
//! Positions are projected to the local tangent plane about the foreign member `center` ([longitude,
//! latitude]) or else the middle of the data.
//!
//! A text that is not GeoJSON is an error. Features that do not make a usable town (open or crossing
//! rings, overlaps, odd heights) are repaired or left out with a warning. Errors and warnings name
//! the feature, and [`Map::count`] counts what became of all features.
//!
//! | module | what it does |
//! |---|---|
//! | `document` | text to features |
//! | `crs` | the coordinate reference system that a file names |
//! | `kind` | what a feature is |
//! | `length`, `height` | the height of a building |
//! | `parts` | buildings and their parts |
//! | `town` | features projected, repaired, clipped, disjoint |

use ::geojson::{Feature, GeometryValue, Position, feature};
use csat_proto::model::Ground;
use serde_json::{Map as JsonObject, Value};

use super::count::{FeatureCount, LeftOut};
use super::project::TangentPlane;
use super::report::{FeatureRef, MapError, MapWarning};
use super::{Map, MapRules, Untagged};
use crate::plane::Bounds;
use kind::{FeatureKind, kind_of};

mod crs;
mod document;
mod height;
mod kind;
mod length;
mod parts;
mod town;

pub use document::without_mark;

/// The most invalid features that are named one by one.
const NAMED: usize = 8;

/// Reads a town from GeoJSON text (one document, or a sequence of them): the part of it inside
/// `ground`, tops below the flights. `untagged` says what polygons without tags are.
///
/// # Errors
/// All mistakes together: a text that is not JSON or not GeoJSON, invalid features, positions that
/// are not longitude and latitude, and polygons of which none is tagged as a building, if `untagged`
/// is `None`.
pub fn import(
    text: &str,
    ground: Ground,
    rules: &MapRules,
    untagged: Option<Untagged>,
) -> Result<Map, Vec<MapError>> {
    let document = document::read(text).map_err(|e| vec![e])?;
    let members = &document.members;
    let mut errors = Vec::new();
    let mut count = FeatureCount { features: document.features.len(), ..FeatureCount::default() };
    let parsed = parse(&document, untagged, &mut count, &mut errors);
    let centre = match members.get("center").map(|v| (v, position_of(v))) {
        None => None,
        Some((_, Some(centre))) => Some(centre),
        Some((value, None)) => {
            errors.push(MapError::BadCenter { got: value.to_string() });
            None
        }
    };
    let is_building = |p: &Parsed| p.kind != FeatureKind::Road;
    if let (None, Some(polygons)) = (untagged, count.reasons.get(&LeftOut::Untagged))
        && !parsed.iter().any(is_building)
    {
        errors.push(MapError::Untagged { feature: polygons[0].clone(), count: polygons.len() });
    }
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
    let attribution = members.get("attribution").and_then(Value::as_str).map(str::to_owned);
    Ok(town::Town { plane, ground, rules, count, warnings }.build(&parsed, attribution))
}

/// A feature that becomes part of a town.
struct Parsed {
    reference: FeatureRef,
    kind: FeatureKind,
    properties: JsonObject<String, Value>,
    geometry: GeometryValue,
}

/// The buildings and roads of a document; the others are counted.
fn parse(
    document: &document::Document,
    untagged: Option<Untagged>,
    count: &mut FeatureCount,
    errors: &mut Vec<MapError>,
) -> Vec<Parsed> {
    let mut parsed = Vec::new();
    let (mut broken, mut misplaced) = (0, Vec::new());
    for (index, value) in document.features.iter().enumerate() {
        let reference = reference_to(index, value);
        let feature = match feature_of(value) {
            Ok(feature) => feature,
            Err(reason) => {
                broken += 1;
                if broken <= NAMED {
                    errors.push(MapError::BadFeature { feature: reference, reason });
                }
                continue;
            }
        };
        let properties = feature.properties.unwrap_or_default();
        let geometry = feature.geometry.map(|g| g.value);
        let kind = kind_of(&properties, geometry.as_ref(), untagged);
        if matches!(kind, Ok(_) | Err(LeftOut::Untagged)) {
            let mut all = geometry.iter().flat_map(positions);
            if let Some(bad) = all.find(|p| !is_lon_lat(p.as_slice())) {
                misplaced.push((reference, bad.as_slice().to_vec()));
                continue;
            }
        }
        let usable = kind.and_then(|kind| Ok((kind, extent(geometry, value)?)));
        match usable {
            Ok((kind, geometry)) => parsed.push(Parsed { reference, kind, properties, geometry }),
            Err(reason) => count.leave_out(reason, &reference),
        }
    }
    if broken > NAMED {
        errors.push(MapError::MoreBadFeatures { count: broken - NAMED });
    }
    let (bad, features) = (misplaced.len(), document.features.len());
    let objects = std::iter::once(&document.members).chain(&document.features);
    if let Some(got) = objects.filter_map(crs::foreign).next() {
        errors.push(MapError::ForeignCrs { got, features, bad });
    } else if let Some((feature, got)) = misplaced.into_iter().next() {
        errors.push(MapError::BadPosition { feature, got, count: bad });
    }
    parsed
}

/// The feature. A geometry without positions is left out, because the parser cannot read it.
fn feature_of(value: &Value) -> Result<Feature, String> {
    let mut value = value.clone();
    let is_known = |kind: &str| document::GEOMETRIES.contains(&kind);
    if value.pointer("/geometry/type").and_then(Value::as_str).is_some_and(is_known)
        && value.pointer("/geometry/coordinates").is_some_and(is_hollow)
    {
        value["geometry"] = Value::Null;
    }
    if !value.is_object() {
        return Err(format!("expected an object, got `{value}`"));
    }
    let feature = serde_json::from_value::<Feature>(value).map_err(|e| e.to_string())?;
    if feature.geometry.iter().flat_map(|g| positions(&g.value)).any(|p| p.len() < 2) {
        return Err("a position of fewer than two numbers".into());
    }
    Ok(feature)
}

/// Whether a list is empty or contains only such lists.
fn is_hollow(coordinates: &Value) -> bool {
    coordinates.as_array().is_some_and(|list| list.iter().all(is_hollow))
}

/// A geometry with positions; `feature` is the feature that it was read from.
fn extent(geometry: Option<GeometryValue>, feature: &Value) -> Result<GeometryValue, LeftOut> {
    match (geometry, feature.pointer("/geometry/type").and_then(Value::as_str)) {
        (Some(geometry), _) if !positions(&geometry).is_empty() => Ok(geometry),
        (_, Some(got)) => Err(LeftOut::EmptyGeometry { got: got.to_owned() }),
        (_, None) => Err(LeftOut::NoGeometry),
    }
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
    let all = parsed.iter().flat_map(|p| positions(&p.geometry));
    Bounds::around(all.map(|p| [p[0], p[1]]))
        .map_or([0.0; 2], |b| [(b.min[0] + b.max[0]) / 2.0, (b.min[1] + b.max[1]) / 2.0])
}
