//! What a feature is, by its tags.

use ::geojson::GeometryValue;
use serde_json::{Map as JsonObject, Value};

use super::super::Untagged;
use super::super::count::LeftOut;

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

/// Keys of areas that are not buildings (OpenStreetMap wiki, *Map features*).
const OTHER_AREAS: [&str; 28] = [
    "aerialway",
    "aeroway",
    "amenity",
    "area:highway",
    "barrier",
    "boundary",
    "craft",
    "emergency",
    "geological",
    "healthcare",
    "highway",
    "historic",
    "indoor",
    "landuse",
    "leisure",
    "man_made",
    "military",
    "natural",
    "office",
    "place",
    "power",
    "public_transport",
    "railway",
    "shop",
    "sport",
    "tourism",
    "water",
    "waterway",
];

/// A feature that becomes part of a town.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FeatureKind {
    /// A whole building.
    Building,
    /// A part of a building with a height of its own.
    Part,
    /// A road for cars.
    Road,
}

/// What a feature is, or why it is left out.
pub(super) fn kind_of(
    properties: &JsonObject<String, Value>,
    geometry: Option<&GeometryValue>,
    untagged: Option<Untagged>,
) -> Result<FeatureKind, LeftOut> {
    let text = |key| properties.get(key).and_then(Value::as_str);
    let building = Tag::of(properties, "building");
    let part = Tag::of(properties, "building:part");
    if building == Tag::Yes || part == Tag::Yes {
        let kind = if building == Tag::Yes { FeatureKind::Building } else { FeatureKind::Part };
        return if text("location") == Some("underground") {
            Err(LeftOut::Underground)
        } else {
            Ok(kind)
        };
    }
    if let Some(highway) = text("highway") {
        let drivable = DRIVABLE.contains(&highway.trim_end_matches("_link"));
        return match text("tunnel") {
            _ if !drivable => Err(LeftOut::NotDrivable),
            Some(tunnel) if tunnel != "no" => Err(LeftOut::Tunnel),
            _ => Ok(FeatureKind::Road),
        };
    }
    for (key, tag) in [("building", &building), ("building:part", &part)] {
        if let Tag::Odd(got) = tag {
            return Err(LeftOut::OddTag { key, got: got.clone() });
        }
    }
    if building == Tag::No || part == Tag::No {
        return Err(LeftOut::NotABuilding);
    }
    let is_area = matches!(
        geometry,
        Some(GeometryValue::Polygon { .. } | GeometryValue::MultiPolygon { .. })
    );
    let is_said = |key: &&str| Tag::of(properties, key) != Tag::None;
    match untagged {
        _ if !is_area || OTHER_AREAS.iter().any(is_said) => Err(LeftOut::OtherKind),
        Some(Untagged::Buildings) => Ok(FeatureKind::Building),
        _ => Err(LeftOut::Untagged),
    }
}

#[derive(PartialEq)]
enum Tag {
    None,
    Yes,
    No,
    Odd(String),
}

impl Tag {
    /// Exporters write `"building": true` as well as `"building": "yes"`, and empty text or null for
    /// a tag that a feature does not have.
    fn of(properties: &JsonObject<String, Value>, key: &str) -> Self {
        match properties.get(key) {
            None | Some(Value::Null) => Self::None,
            Some(Value::Bool(flag)) => {
                if *flag {
                    Self::Yes
                } else {
                    Self::No
                }
            }
            Some(Value::String(text)) => match text.as_str() {
                "" => Self::None,
                "no" | "false" => Self::No,
                _ => Self::Yes,
            },
            Some(other) => Self::Odd(other.to_string()),
        }
    }
}
