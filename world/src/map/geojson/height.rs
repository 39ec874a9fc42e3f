//! The height of a building by its tags.
//!
//! # References
//! OpenStreetMap wiki: *Simple 3D Buildings*, *Key:height*, *Key:min_height*, *Key:building:levels*,
//! *Key:roof:levels*.

use serde_json::Value;

use super::super::report::MapWarning;
use super::Parsed;
use super::length::{LENGTHS, STOREYS, metres, storeys};

/// Height of a storey, metres.
const STOREY_M: f64 = 3.0;
/// Height of a building without a tag for it, metres.
pub(super) const DEFAULT_HEIGHT_M: f64 = 9.0;

/// The heights of a building by its tags.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Heights {
    /// Height of the top, metres; `None` without a tag for it.
    pub top_m: Option<f64>,
    /// Height of the underside, metres; 0 for a building that stands on the ground.
    pub base_m: f64,
}

/// A value that cannot be read.
struct Bad {
    key: &'static str,
    got: String,
    expected: &'static str,
}

/// The tags of one feature, and those of them that cannot be read.
struct Tags<'a> {
    feature: &'a Parsed,
    bad: Vec<Bad>,
}

/// The heights of a building or part. For each value that cannot be read there is a warning with the
/// height that is used instead.
pub(super) fn heights(feature: &Parsed, warnings: &mut Vec<MapWarning>) -> Heights {
    let mut tags = Tags { feature, bad: Vec::new() };
    let top_m = tags.top_m();
    // A part without a height is as high as its building; a part with a misspelt height is not.
    let top_m = top_m.or((!tags.bad.is_empty()).then_some(DEFAULT_HEIGHT_M));
    let above = tags.bad.len();
    let mut base_m = tags.base_m();
    if base_m > 0.0 && base_m >= top_m.unwrap_or(DEFAULT_HEIGHT_M) {
        let key =
            if tags.raw("min_height").is_some() { "min_height" } else { "building:min_level" };
        let got = tags.raw(key).map(Value::to_string).unwrap_or_default();
        tags.bad.push(Bad { key, got, expected: "less than the height of the top" });
        base_m = 0.0;
    }
    for (index, Bad { key, got, expected }) in tags.bad.into_iter().enumerate() {
        let used_m = if index < above { top_m.unwrap_or(DEFAULT_HEIGHT_M) } else { base_m };
        let feature = feature.reference.clone();
        warnings.push(MapWarning::BadHeight { feature, key, got, expected, used_m });
    }
    Heights { top_m, base_m }
}

impl Tags<'_> {
    /// The value of the first key for heights that can be read, else the height of storeys and roof.
    fn top_m(&mut self) -> Option<f64> {
        for key in ["height", "building:height", "est_height"] {
            if let Some(top_m) = self.read(key, metres, LENGTHS, f64::MIN_POSITIVE) {
                return Some(top_m);
            }
        }
        let levels = self.read("building:levels", storeys, STOREYS, 0.0)?;
        let top_m = levels * STOREY_M + self.roof_m();
        if top_m > 0.0 {
            return Some(top_m);
        }
        let (key, got) = ("building:levels", "0".to_owned());
        self.bad.push(Bad { key, got, expected: "storeys, or a roof with `roof:levels`" });
        None
    }

    /// The height of the storeys under the roof, which `building:levels` does not include.
    fn roof_m(&mut self) -> f64 {
        let height_m = self.read("roof:height", metres, LENGTHS, 0.0);
        let levels = || Some(self.read("roof:levels", storeys, STOREYS, 0.0)? * STOREY_M);
        height_m.or_else(levels).unwrap_or(0.0)
    }

    fn base_m(&mut self) -> f64 {
        let base_m = self.read("min_height", metres, LENGTHS, 0.0);
        let levels = || Some(self.read("building:min_level", storeys, STOREYS, 0.0)? * STOREY_M);
        base_m.or_else(levels).unwrap_or(0.0)
    }

    fn raw(&self, key: &str) -> Option<&Value> {
        self.feature.properties.get(key).filter(|v| !v.is_null() && v.as_str() != Some(""))
    }

    fn read(
        &mut self,
        key: &'static str,
        read: fn(&Value) -> Option<f64>,
        expected: &'static str,
        at_least: f64,
    ) -> Option<f64> {
        let value = self.raw(key)?;
        let number = read(value).filter(|x| *x >= at_least);
        if number.is_none() {
            self.bad.push(Bad { key, got: value.to_string(), expected });
        }
        number
    }
}
