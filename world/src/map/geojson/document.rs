//! From text to features: one GeoJSON document, or many one after the other.
//!
//! # References
//! RFC 7946 (GeoJSON), RFC 8142 (GeoJSON text sequences, with or without record separators).

use std::borrow::Cow;

use serde_json::{Deserializer, Value, json};

use super::super::report::MapError;

/// Types of geometries.
pub(super) const GEOMETRIES: [&str; 7] = [
    "Point",
    "MultiPoint",
    "LineString",
    "MultiLineString",
    "Polygon",
    "MultiPolygon",
    "GeometryCollection",
];

/// What a file holds.
#[derive(Default)]
pub(super) struct Document {
    /// Its first feature collection without the features, for members such as `center`.
    pub members: Value,
    /// All features in order.
    pub features: Vec<Value>,
}

/// The text without a byte order mark.
pub fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Reads the documents of a file, which is one or, line by line, a sequence.
pub(super) fn read(text: &str) -> Result<Document, MapError> {
    let text = without_mark(text);
    // Record separators occur between documents only: within strings JSON escapes them. Each is
    // replaced by a space, which keeps lines and columns.
    let text: Cow<'_, str> =
        if text.contains('\u{1e}') { text.replace('\u{1e}', " ").into() } else { text.into() };
    let mut document = Document::default();
    let mut count = 0;
    for value in Deserializer::from_str(&text).into_iter::<Value>() {
        let value = value.map_err(|error| {
            let (line, column) = (error.line(), error.column());
            let reason = error.to_string();
            let reason = reason.split(" at line ").next().unwrap_or_default().to_owned();
            MapError::NotJson { reason, line, column }
        })?;
        count += 1;
        document.add(value).map_err(|got| {
            let got = if count > 1 { format!("{got} as document {count}") } else { got };
            MapError::NotCollection { got }
        })?;
    }
    if count == 0 {
        return Err(MapError::NotCollection { got: "an empty file".into() });
    }
    Ok(document)
}

impl Document {
    /// Adds a GeoJSON value, or returns what the value is instead.
    fn add(&mut self, mut value: Value) -> Result<(), String> {
        let Some(object) = value.as_object_mut() else {
            return Err("a document that is not an object".into());
        };
        match object.get("type").and_then(Value::as_str) {
            Some("FeatureCollection") => {
                let Some(Value::Array(features)) = object.get_mut("features").map(Value::take)
                else {
                    return Err("a FeatureCollection without features".into());
                };
                self.features.extend(features);
                if self.members.is_null() {
                    self.members = value;
                }
            }
            Some("Feature") => self.features.push(value),
            Some(kind) if GEOMETRIES.contains(&kind) => {
                let feature = json!({ "type": "Feature", "properties": null, "geometry": value });
                self.features.push(feature);
            }
            Some(other) => return Err(format!("a {other}")),
            None => return Err("an object without type".into()),
        }
        Ok(())
    }
}
