//! A mission on a map of the Earth, for the map panels of Foxglove and Lichtblick.
//!
//! A town that was imported is where it is; a generated one is about (0, 0), in the Gulf of Guinea.

use csat_world::map::TangentPlane;
use csat_world::world::World;
use foxglove::messages::{GeoJson, LocationFix};
use geojson::{Feature, GeometryValue};
use serde_json::json;

use super::drawn::Drawn;
use super::scene::{FRAME, timestamp};
use super::seen::Seen;
use crate::plot::uav_colour;
use crate::rounding::polygons;
use csat_mission::picture::{Content, Ring};
use csat_mission::shape;
use csat_mission::words::named;

/// A degree has this many of the parts that angles are rounded to, 11 cm on the ground: the map is for
/// looking at.
const PER_DEGREE: f64 = 1e6;

/// The town: its buildings and its roads.
pub fn town(world: &World) -> GeoJson {
    let plane = world.map().plane();
    let buildings = world.obstacles().iter().map(|obstacle| {
        let outlines = set(&plane, &[obstacle.rings().collect()]);
        let name = format!("{}, {:.0} m", obstacle.name, obstacle.height_m);
        let style = json!({ "color": "#555555", "weight": 1, "fillOpacity": 0.5 });
        shape::feature(outlines, json!({ "name": name, "style": style }))
    });
    let roads = world.roads().edges().iter().map(|edge| {
        let line = shape::line_string(&placed(&plane, &edge.line));
        shape::feature(line, json!({ "style": { "color": "#999999", "weight": 2 } }))
    });
    geojson(buildings.chain(roads).collect())
}

/// What moves, at one step. Agents that know the same share their sets.
pub fn step(world: &World, seen: &[Seen]) -> GeoJson {
    let plane = world.map().plane();
    let mut features = Vec::new();
    for seen in seen {
        let colour = uav_colour(usize::from(seen.agent.0));
        if !seen.is_repeated {
            features.extend(layers(&plane, seen, world.config().fleet.count, colour));
        }
        if seen.footprint.is_empty() {
            continue;
        }
        let footprint = set(&plane, &[vec![seen.footprint.clone()]]);
        let style = json!({ "color": colour, "weight": 2, "fillOpacity": 0.05 });
        let name = format!("footprint of UAV {}", seen.agent);
        features.push(shape::feature(footprint, json!({ "name": name, "style": style })));
    }
    for (index, target) in world.targets().iter().enumerate() {
        let car = shape::point(place(&plane, target.location));
        features.push(shape::feature(car, json!({ "name": format!("car {index}") })));
    }
    geojson(features)
}

/// Where an agent is: map panels begin with a look at it, and draw its way.
pub fn fix(time_ns: u64, world: &World, index: usize) -> Option<LocationFix> {
    let pose = *world.poses().get(index)?;
    let [east, north, altitude] = pose.p_world;
    let [longitude, latitude] = place(&world.map().plane(), [east, north]);
    Some(LocationFix {
        timestamp: Some(timestamp(time_ns)),
        frame_id: FRAME.to_owned(),
        latitude,
        longitude,
        altitude,
        position_covariance: vec![0.0; 9],
        ..LocationFix::default()
    })
}

/// What an agent knows, in its colour; faint where buildings cover it.
fn layers(plane: &TangentPlane, seen: &Seen, uavs: u16, colour: &str) -> Vec<Feature> {
    let agent = named([seen.agent.0], uavs);
    seen.layers.iter().flat_map(|drawn| layer(plane, drawn, &agent, colour)).collect()
}

fn layer(plane: &TangentPlane, drawn: &Drawn, agent: &str, colour: &str) -> Vec<Feature> {
    let (weight, opacity) = if drawn.style.is_ground { (1, 0.1) } else { (2, 0.4) };
    let named = |name: &str, opacity: f64| {
        let style = json!({ "color": colour, "weight": weight, "fillOpacity": opacity });
        json!({ "name": format!("{name} of {agent}"), "style": style })
    };
    let names = drawn.names();
    match &drawn.content {
        Content::Areas(areas) => {
            let sets = areas.iter().map(|area| set(plane, &area.shapes));
            sets.zip(names).map(|(s, name)| shape::feature(s, named(&name, opacity))).collect()
        }
        Content::Points(marks) => {
            let places = marks.iter().map(|mark| shape::point(place(plane, mark.point)));
            places.zip(names).map(|(p, name)| shape::feature(p, named(&name, opacity))).collect()
        }
        Content::Cells(_) | Content::Heights(_) | Content::Heat(_) => {
            let bands = drawn.bands().into_iter().map(|(share, cells)| {
                let shapes: Vec<Vec<Ring>> = cells.rings().map(|ring| vec![ring]).collect();
                shape::feature(set(plane, &shapes), named(&drawn.style.key, opacity * share))
            });
            bands.collect()
        }
    }
}

/// Shapes at their place on Earth.
fn set(plane: &TangentPlane, shapes: &[Vec<Ring>]) -> GeometryValue {
    let placed = |shape: &Vec<Ring>| shape.iter().map(|ring| placed(plane, ring)).collect();
    let shapes: Vec<Vec<Ring>> = shapes.iter().map(placed).collect();
    shape::multi_polygon(&polygons(&shapes, PER_DEGREE))
}

fn placed(plane: &TangentPlane, line: &[[f64; 2]]) -> Ring {
    line.iter().map(|p| place(plane, *p)).collect()
}

fn place(plane: &TangentPlane, p_world: [f64; 2]) -> [f64; 2] {
    plane.unproject(p_world).map(|degrees| (degrees * PER_DEGREE).round() / PER_DEGREE)
}

fn geojson(features: Vec<Feature>) -> GeoJson {
    GeoJson { geojson: shape::collection(features, &json!({})) }
}
