//! From parsed features to a town: projected, repaired, clipped, disjoint.

use ::geojson::{GeometryValue, Position};
use csat_proto::model::Ground;
use geo::{BooleanOps, BoundingRect, MultiPolygon, Rect, coord};
use serde_json::Value;

use super::super::merge::{Outline, disjoint};
use super::super::project::TangentPlane;
use super::super::report::{FeatureRef, MapWarning};
use super::super::{Map, MapRules, repair};
use super::{Kind, Parsed};
use crate::plane::{Bounds, Point};

/// Height of a storey, metres.
const STOREY_M: f64 = 3.0;
/// Height of a building of which nothing is known, metres.
const DEFAULT_HEIGHT_M: f64 = 9.0;

/// A town being put together.
pub(super) struct Town<'a> {
    pub plane: TangentPlane,
    pub ground: Ground,
    pub rules: &'a MapRules,
    pub warnings: Vec<MapWarning>,
}

impl Town<'_> {
    pub fn build(mut self, parsed: &[Parsed], attribution: Option<String>) -> Map {
        let (mut outlines, mut roads, mut outside) = (Vec::new(), Vec::new(), Vec::new());
        for feature in parsed {
            let reference = &feature.reference;
            let Some(geometry) = &feature.geometry else {
                self.warnings.push(MapWarning::NoGeometry { feature: reference.clone() });
                continue;
            };
            let inside = match feature.kind {
                Kind::Building => self.building(feature, geometry, &mut outlines),
                Kind::Road => self.road(reference, geometry, &mut roads),
            };
            if !inside {
                outside.push(reference.clone());
            }
        }
        let obstacles = disjoint(&outlines, &mut self.warnings);
        if !outside.is_empty() {
            self.warnings.push(MapWarning::Outside { features: outside });
        }
        if obstacles.is_empty() {
            self.warnings.push(MapWarning::NoBuildings);
        }
        if roads.is_empty() {
            self.warnings.push(MapWarning::NoRoads);
        }
        Map {
            ground: self.ground,
            obstacles,
            roads,
            centre_deg: Some(self.plane.centre_deg()),
            attribution,
            warnings: self.warnings,
        }
    }

    /// Positions in the plane; `None` when one is too far away to be there.
    fn project(&self, positions: &[Position]) -> Option<Vec<Point>> {
        positions.iter().map(|p| self.plane.project([p[0], p[1]])).collect()
    }

    /// Adds a building; false when it does not reach the region.
    fn building(
        &mut self,
        feature: &Parsed,
        geometry: &GeometryValue,
        outlines: &mut Vec<Outline>,
    ) -> bool {
        let reference = &feature.reference;
        let polygons = match geometry {
            GeometryValue::Polygon { coordinates } => std::slice::from_ref(coordinates),
            GeometryValue::MultiPolygon { coordinates } => coordinates.as_slice(),
            other => {
                self.wrong(reference, other.type_name(), "Polygon or MultiPolygon");
                return true;
            }
        };
        let mut shape = MultiPolygon(Vec::new());
        for (index, rings) in polygons.iter().enumerate() {
            let part =
                if polygons.len() > 1 { format!("part {}, ", index + 1) } else { String::new() };
            let rings: Option<Vec<_>> = rings.iter().map(|ring| self.project(ring)).collect();
            let Some(rings) = rings else { return false };
            let polygon = repair::polygon(&rings, &part, reference, &mut self.warnings);
            shape = if shape.0.is_empty() { polygon } else { shape.union(&polygon) };
        }
        if shape.0.is_empty() {
            return true; // `repair` has said why.
        }
        let shape = self.clip(shape);
        if shape.0.is_empty() {
            return false;
        }
        let height_m = self.height_m(feature);
        outlines.push(Outline { feature: reference.clone(), shape, height_m });
        true
    }

    /// The part inside the region.
    fn clip(&self, shape: MultiPolygon<f64>) -> MultiPolygon<f64> {
        let [x, y] = self.ground.size_m.map(|s| s / 2.0);
        let contained =
            |b: Rect<f64>| b.min().x >= -x && b.min().y >= -y && b.max().x <= x && b.max().y <= y;
        if shape.bounding_rect().is_some_and(contained) {
            return shape;
        }
        let window = Rect::new(coord! { x: -x, y: -y }, coord! { x: x, y: y }).to_polygon();
        repair::oriented(&shape.intersection(&window))
    }

    fn wrong(&mut self, feature: &FeatureRef, got: &'static str, expected: &'static str) {
        let feature = feature.clone();
        self.warnings.push(MapWarning::WrongGeometry { feature, got, expected });
    }

    /// `height`, else 3 m × `building:levels`, else 9 m; below the flights.
    fn height_m(&mut self, feature: &Parsed) -> f64 {
        let got_m = match number(feature, "height", 'm') {
            Ok(Some(height_m)) => height_m,
            unknown => {
                let used_m = self.levels_height_m(feature);
                if let Err(got) = unknown {
                    self.bad_height(feature, "height", got, " of metres", used_m);
                }
                used_m
            }
        };
        let max_m = self.rules.height_limit_m();
        if got_m <= max_m {
            return got_m;
        }
        let feature = feature.reference.clone();
        self.warnings.push(MapWarning::HeightClamped { feature, got_m, max_m });
        max_m
    }

    fn levels_height_m(&mut self, feature: &Parsed) -> f64 {
        match number(feature, "building:levels", ' ') {
            Ok(levels) => levels.map_or(DEFAULT_HEIGHT_M, |levels| levels * STOREY_M),
            Err(got) => {
                self.bad_height(feature, "building:levels", got, "", DEFAULT_HEIGHT_M);
                DEFAULT_HEIGHT_M
            }
        }
    }

    fn bad_height(
        &mut self,
        feature: &Parsed,
        key: &'static str,
        got: String,
        unit: &'static str,
        used_m: f64,
    ) {
        let feature = feature.reference.clone();
        self.warnings.push(MapWarning::BadHeight { feature, key, got, unit, used_m });
    }

    /// Adds a road; false when it does not reach the region.
    fn road(
        &mut self,
        feature: &FeatureRef,
        geometry: &GeometryValue,
        roads: &mut Vec<Vec<Point>>,
    ) -> bool {
        let lines = match geometry {
            GeometryValue::LineString { coordinates } => std::slice::from_ref(coordinates),
            GeometryValue::MultiLineString { coordinates } => coordinates.as_slice(),
            other => {
                self.wrong(feature, other.type_name(), "LineString or MultiLineString");
                return true;
            }
        };
        let half = self.ground.size_m.map(|s| s / 2.0);
        let region = Bounds { min: half.map(|x| -x), max: half };
        let mut inside = false;
        for line in lines {
            let Some(mut line) = self.project(line) else { continue };
            line.dedup();
            if line.len() < 2 {
                let (feature, got) = (feature.clone(), line.len());
                self.warnings.push(MapWarning::ShortRoad { feature, got });
                inside = true;
            } else if Bounds::around(line.iter().copied()).is_some_and(|b| b.meets(&region)) {
                roads.push(line);
                inside = true;
            }
        }
        inside
    }
}

/// A positive number that may carry a unit; `None` without the key, the raw value when it is
/// something else.
fn number(feature: &Parsed, key: &str, unit: char) -> Result<Option<f64>, String> {
    let Some(value) = feature.properties.get(key).filter(|v| !v.is_null()) else {
        return Ok(None);
    };
    let number = match value {
        Value::String(text) => text.trim().trim_end_matches(unit).trim_end().parse().ok(),
        other => other.as_f64(),
    };
    match number.filter(|x: &f64| x.is_finite() && *x > 0.0) {
        Some(number) => Ok(Some(number)),
        None => Err(value.to_string()),
    }
}
