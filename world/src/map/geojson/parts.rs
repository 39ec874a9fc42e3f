//! Buildings and their parts.
//!
//! Solids of a town stand on the ground (3.1), so a part that begins above it (`min_height`) is built
//! from the ground. Where other parts stand underneath, that is exact; where none does, there is a
//! warning.
//!
//! # References
//! OpenStreetMap wiki, *Simple 3D Buildings*: the outline of a building with parts is their union and
//! is not built itself.

use geo::{Area, BooleanOps, BoundingRect, Buffer, MultiPolygon, unary_union};

use super::super::count::{FeatureCount, LeftOut};
use super::super::merge::{BuildingOutline, meet};
use super::super::report::{FeatureRef, MapWarning};
use super::height::{DEFAULT_HEIGHT_M, Heights};

/// Half the width of a gap between parts that is taken for an error of drawing, metres.
const GAP_M: f64 = 0.25;
/// A part carries another one if it ends at most this much below its underside, metres.
const JOINT_M: f64 = 0.5;
/// A part may overhang by this area without a warning, m².
const LEDGE_M2: f64 = 1.0;

/// A building or a part as mapped, within the region.
pub(super) struct Solid {
    pub feature: FeatureRef,
    pub shape: MultiPolygon<f64>,
    pub is_part: bool,
    pub heights: Heights,
}

/// The solids to build: parts, buildings without parts, and what parts leave of the outline of a
/// building.
pub(super) fn outlines(
    mut solids: Vec<Solid>,
    count: &mut FeatureCount,
    warnings: &mut Vec<MapWarning>,
) -> Vec<BuildingOutline> {
    let owners: Vec<Option<usize>> = solids.iter().map(|solid| owner(solid, &solids)).collect();
    for (part, owner) in owners.iter().enumerate() {
        if let (None, Some(owner)) = (solids[part].heights.top_m, owner) {
            solids[part].heights.top_m = solids[*owner].heights.top_m;
        }
    }
    let mut built = Vec::new();
    for (index, solid) in solids.iter().enumerate() {
        let parts: Vec<&Solid> =
            (0..solids.len()).filter(|p| owners[*p] == Some(index)).map(|p| &solids[p]).collect();
        let mut outline = BuildingOutline {
            feature: solid.feature.clone(),
            building: owners[index]
                .map_or(solid.feature.index, |owner| solids[owner].feature.index),
            shape: solid.shape.clone(),
            height_m: top_m(solid),
        };
        if !parts.is_empty() {
            outline.shape = rest(&solid.shape, &parts);
            if outline.shape.0.is_empty() {
                count.leave_out(LeftOut::HasParts, &solid.feature);
                continue;
            }
            outline.height_m = height_of_rest_m(solid, &parts);
            warnings.push(MapWarning::PartsLeave {
                feature: solid.feature.clone(),
                parts: parts.len(),
                area_m2: outline.shape.unsigned_area(),
                used_m: outline.height_m,
            });
        }
        *(if solid.is_part { &mut count.parts } else { &mut count.buildings }) += 1;
        built.push((outline, solid.heights.base_m));
    }
    warn_of_floating(&built, warnings);
    built.into_iter().map(|(outline, _)| outline).collect()
}

fn top_m(solid: &Solid) -> f64 {
    solid.heights.top_m.unwrap_or(DEFAULT_HEIGHT_M)
}

/// The building that a part belongs to: the one with the greatest common area, which is at least half
/// the area of the part.
fn owner(part: &Solid, solids: &[Solid]) -> Option<usize> {
    if !part.is_part {
        return None;
    }
    let bounds = part.shape.bounding_rect();
    let buildings = solids.iter().enumerate().filter(|(_, s)| !s.is_part);
    let near = buildings.filter(|(_, s)| meet(&s.shape.bounding_rect(), &bounds));
    let shared = near.map(|(i, s)| (s.shape.intersection(&part.shape).unsigned_area(), i));
    let (most_m2, index) = shared.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (most_m2 >= part.shape.unsigned_area() / 2.0).then_some(index)
}

/// What parts leave of an outline, without gaps that are errors of drawing.
fn rest(outline: &MultiPolygon<f64>, parts: &[&Solid]) -> MultiPolygon<f64> {
    let mut rest = outline.difference(&unary_union(parts.iter().map(|p| &p.shape)));
    rest.0.retain(|piece| !piece.buffer(-GAP_M).0.is_empty());
    rest
}

/// The height of what parts leave of an outline. If the outline is lower than a part, its height is
/// that of the rest. Otherwise its height is that of the whole building, and the rest is as high as
/// the lowest part.
fn height_of_rest_m(outline: &Solid, parts: &[&Solid]) -> f64 {
    let tops = || parts.iter().map(|p| top_m(p));
    let highest_m = tops().fold(0.0, f64::max);
    match outline.heights.top_m {
        Some(top_m) if top_m < highest_m => top_m,
        _ => tops().fold(highest_m, f64::min),
    }
}

fn warn_of_floating(built: &[(BuildingOutline, f64)], warnings: &mut Vec<MapWarning>) {
    for (outline, base_m) in built.iter().filter(|(_, base_m)| *base_m > 0.0) {
        let carries = |(other, other_base_m): &&(BuildingOutline, f64)| {
            other_base_m < base_m
                && other.height_m >= base_m - JOINT_M
                && meet(&other.shape.bounding_rect(), &outline.shape.bounding_rect())
        };
        let beneath = unary_union(built.iter().filter(carries).map(|(other, _)| &other.shape));
        let area_m2 = outline.shape.difference(&beneath).unsigned_area();
        if area_m2 > LEDGE_M2 {
            let feature = outline.feature.clone();
            warnings.push(MapWarning::Floating { feature, base_m: *base_m, area_m2 });
        }
    }
}
