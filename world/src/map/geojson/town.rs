//! From parsed features to a town: they are projected, repaired, clipped and made disjoint.

use ::geojson::{GeometryValue, Position};
use csat_proto::model::Ground;
use geo::{BooleanOps, BoundingRect, MultiPolygon, Rect, coord};

use super::super::count::{FeatureCount, LeftOut};
use super::super::merge::{BuildingOutline, disjoint};
use super::super::project::TangentPlane;
use super::super::report::MapWarning;
use super::super::{Map, MapRules, repair};
use super::height::heights;
use super::kind::road_width_m;
use super::parts::{self, Solid};
use super::{FeatureKind, Parsed};
use crate::plane::{Bounds, Point};

/// A town under construction.
pub(super) struct Town<'a> {
    pub plane: TangentPlane,
    pub ground: Ground,
    pub rules: &'a MapRules,
    pub count: FeatureCount,
    pub warnings: Vec<MapWarning>,
}

impl Town<'_> {
    pub fn build(mut self, parsed: &[Parsed], attribution: Option<String>) -> Map {
        let (mut solids, mut roads, mut road_widths_m) = (Vec::new(), Vec::new(), Vec::new());
        for feature in parsed {
            let built = match feature.kind {
                FeatureKind::Road => {
                    let built = self.road(feature, &mut roads);
                    road_widths_m.resize(roads.len(), road_width_m(&feature.properties));
                    built
                }
                _ => self.solid(feature).map(|solid| solids.push(solid)),
            };
            if let Err(reason) = built {
                self.count.leave_out(reason, &feature.reference);
            }
        }
        let mut outlines = parts::outlines(solids, &mut self.count, &mut self.warnings);
        outlines.iter_mut().for_each(|outline| self.lower(outline));
        let obstacles = disjoint(&outlines, &mut self.warnings);
        for (reason, features) in self.count.reasons.iter().filter(|(r, _)| r.is_suspicious()) {
            let (reason, features) = (reason.clone(), features.clone());
            self.warnings.push(MapWarning::LeftOut { reason, features });
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
            road_widths_m,
            centre_deg: Some(self.plane.centre_deg()),
            attribution,
            count: self.count,
            warnings: self.warnings,
        }
    }

    /// Positions in the plane; `None` when one of them is too far away.
    fn project(&self, positions: &[Position]) -> Option<Vec<Point>> {
        positions.iter().map(|p| self.plane.project([p[0], p[1]])).collect()
    }

    /// A building or part of one, within the region.
    fn solid(&mut self, feature: &Parsed) -> Result<Solid, LeftOut> {
        let reference = &feature.reference;
        let polygons = match &feature.geometry {
            GeometryValue::Polygon { coordinates } => std::slice::from_ref(coordinates),
            GeometryValue::MultiPolygon { coordinates } => coordinates.as_slice(),
            other => return Err(wrong(other, "Polygon or MultiPolygon")),
        };
        let mut shape = MultiPolygon(Vec::new());
        for (index, rings) in polygons.iter().enumerate() {
            let part =
                if polygons.len() > 1 { format!("part {}, ", index + 1) } else { String::new() };
            let rings: Option<Vec<_>> = rings.iter().map(|ring| self.project(ring)).collect();
            let rings = rings.ok_or(LeftOut::Outside)?;
            let polygon = repair::polygon(&rings, &part, reference, &mut self.warnings);
            shape = if shape.0.is_empty() { polygon } else { shape.union(&polygon) };
        }
        if shape.0.is_empty() {
            return Err(LeftOut::NoArea);
        }
        let shape = self.clip(shape);
        if shape.0.is_empty() {
            return Err(LeftOut::Outside);
        }
        let heights = heights(feature, &mut self.warnings);
        let is_part = feature.kind == FeatureKind::Part;
        Ok(Solid { feature: reference.clone(), shape, is_part, heights })
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

    /// Lowers an outline below the flights.
    fn lower(&mut self, outline: &mut BuildingOutline) {
        let (got_m, max_m) = (outline.height_m, self.rules.height_limit_m());
        if got_m > max_m {
            let feature = outline.feature.clone();
            self.warnings.push(MapWarning::HeightClamped { feature, got_m, max_m });
            outline.height_m = max_m;
        }
    }

    /// Adds a road that reaches the region.
    fn road(&mut self, feature: &Parsed, roads: &mut Vec<Vec<Point>>) -> Result<(), LeftOut> {
        let lines = match &feature.geometry {
            GeometryValue::LineString { coordinates } => std::slice::from_ref(coordinates),
            GeometryValue::MultiLineString { coordinates } => coordinates.as_slice(),
            other => return Err(wrong(other, "LineString or MultiLineString")),
        };
        let half = self.ground.size_m.map(|s| s / 2.0);
        let region = Bounds { min: half.map(|x| -x), max: half };
        let mut result = Err(LeftOut::ShortRoad);
        for line in lines {
            let line = self.project(line).map(|mut line| {
                line.dedup();
                line
            });
            match line {
                Some(line) if line.len() < 2 => {
                    let (feature, got) = (feature.reference.clone(), line.len());
                    self.warnings.push(MapWarning::ShortRoad { feature, got });
                }
                Some(line)
                    if Bounds::around(line.iter().copied()).is_some_and(|b| b.meets(&region)) =>
                {
                    roads.push(line);
                    result = Ok(());
                }
                _ => result = result.or(Err(LeftOut::Outside)),
            }
        }
        self.count.roads += usize::from(result.is_ok());
        result
    }
}

fn wrong(got: &GeometryValue, expected: &'static str) -> LeftOut {
    LeftOut::WrongGeometry { got: got.type_name(), expected }
}
