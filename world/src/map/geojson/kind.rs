//! What a feature is, by its tags.

use ::geojson::GeometryValue;
use serde_json::{Map as JsonObject, Value};

use super::super::count::LeftOut;
use super::super::{ROAD_WIDTH_M, Untagged};
use super::length::metres;

/// Values of `highway` that cars use, and the widths of such roads, metres; links (`primary_link`) are at most
/// [`LINK_M`] wide.
const DRIVABLE: [(&str, f64); 11] = [
    ("motorway", 15.0),
    ("trunk", 12.0),
    ("primary", 10.0),
    ("secondary", 8.0),
    ("tertiary", 7.0),
    ("unclassified", 6.0),
    ("residential", 6.0),
    ("living_street", 5.0),
    ("service", 4.0),
    ("road", ROAD_WIDTH_M),
    ("busway", 6.0),
];
/// The width of a link between roads, a lane and its shoulders, metres.
const LINK_M: f64 = 6.0;
/// What a `width` may be, metres.
const WIDTHS_M: std::ops::RangeInclusive<f64> = 1.0..=100.0;

/// The width of a road, metres: its `width` if it can be read and is possible, else the usual one of its class.
pub(super) fn road_width_m(properties: &JsonObject<String, Value>) -> f64 {
    let tagged = properties.get("width").and_then(metres).filter(|m| WIDTHS_M.contains(m));
    let highway = properties.get("highway").and_then(Value::as_str).unwrap_or_default();
    tagged.or_else(|| class_width_m(highway)).unwrap_or(ROAD_WIDTH_M)
}

/// The usual width of roads with this `highway`, metres; `None` where cars do not drive.
fn class_width_m(highway: &str) -> Option<f64> {
    let class = highway.trim_end_matches("_link");
    let width_m = DRIVABLE.iter().find(|(name, _)| *name == class)?.1;
    Some(if class == highway { width_m } else { width_m.min(LINK_M) })
}

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
        let drivable = class_width_m(highway).is_some();
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn roads_are_as_wide_as_tagged_or_else_as_their_class() {
        for (tags, expected_m) in [
            (json!({ "highway": "motorway" }), 15.0),
            (json!({ "highway": "residential" }), 6.0),
            (json!({ "highway": "service" }), 4.0),
            (json!({ "highway": "motorway_link" }), 6.0),
            (json!({ "highway": "service", "width": "7.5 m" }), 7.5),
            (json!({ "highway": "service", "width": 3 }), 3.0),
            (json!({ "highway": "service", "width": "wide" }), 4.0),
            (json!({ "highway": "service", "width": "500" }), 4.0),
            (json!({ "highway": "service", "width": 0 }), 4.0),
        ] {
            assert_eq!(road_width_m(tags.as_object().unwrap()), expected_m, "{tags}");
        }
        assert_eq!(class_width_m("footway"), None);
    }

    #[test]
    fn the_documentation_has_the_width_of_every_class() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/maps.md");
        let text = std::fs::read_to_string(path).unwrap();
        let lines = text.lines().skip_while(|line| *line != "## Widths of roads");
        let rows = lines.skip_while(|line| !line.starts_with('|')).skip(2);
        let rows = rows.take_while(|line| line.starts_with('|'));
        let mut documented = 0;
        for row in rows {
            let (classes, width_m) = row.trim_matches('|').split_once('|').unwrap();
            for class in classes.split(',').map(str::trim) {
                assert_eq!(class_width_m(class), width_m.trim().parse().ok(), "{class}");
                documented += 1;
            }
        }
        assert_eq!(documented, DRIVABLE.len());
    }
}
