//! A mission on a map of the Earth, for the map panels of Foxglove and Lichtblick.
//!
//! A town that was imported is where it is; a generated one is about (0, 0), in the Gulf of Guinea.

use csat_world::map::TangentPlane;
use csat_world::world::World;
use foxglove::messages::{GeoJson, LocationFix};
use geojson::Feature;
use serde_json::{Value, json};

use super::recording::Seen;
use super::scene::{FRAME, timestamp};
use super::shape;
use crate::plot::uav_colour;
use crate::rounding::polygons;
use crate::view::Ring;
use crate::words::named;

/// A degree has this many of the parts that angles are rounded to, 11 cm on the ground: the map is for
/// looking at.
const PER_DEGREE: f64 = 1e6;

/// The town: its buildings and its roads.
pub fn town(world: &World) -> GeoJson {
    let plane = world.map().plane();
    let buildings = world.obstacles().iter().map(|obstacle| {
        let rings: Vec<Ring> = obstacle.rings().map(|ring| placed(&plane, &ring)).collect();
        let outlines = polygons(&[rings], PER_DEGREE);
        let name = format!("{}, {:.0} m", obstacle.name, obstacle.height_m);
        let style = json!({ "color": "#555555", "weight": 1, "fillOpacity": 0.5 });
        shape::feature(shape::multi_polygon(&outlines), json!({ "name": name, "style": style }))
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
            features.extend(sets(&plane, seen, world.config().fleet.count, colour));
        }
        if seen.footprint.is_empty() {
            continue;
        }
        let footprint = polygons(&[vec![placed(&plane, &seen.footprint)]], PER_DEGREE);
        let style = json!({ "color": colour, "weight": 2, "fillOpacity": 0.05 });
        let name = format!("footprint of UAV {}", seen.agent);
        let footprint = shape::multi_polygon(&footprint);
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

/// Where an agent knows the targets to be, those it identified and the others.
fn sets(plane: &TangentPlane, seen: &Seen, uavs: u16, colour: &str) -> Vec<Feature> {
    let set = |shapes: &[Vec<Ring>], properties: Value| {
        let shapes: Vec<Vec<Ring>> =
            shapes.iter().map(|s| s.iter().map(|ring| placed(plane, ring)).collect()).collect();
        shape::feature(shape::multi_polygon(&polygons(&shapes, PER_DEGREE)), properties)
    };
    let (known, agent) = (&seen.known, named([seen.agent.0], uavs));
    let faint = json!({ "color": colour, "weight": 1, "fillOpacity": 0.1 });
    let strong = json!({ "color": colour, "weight": 2, "fillOpacity": 0.4 });
    let name = format!("unexplored by {agent}");
    let mut features = vec![set(&known.unexplored, json!({ "name": name, "style": faint }))];
    features.extend(known.targets.iter().map(|(target, shapes)| {
        let name = format!("target {target} of {agent}");
        set(shapes, json!({ "name": name, "style": strong }))
    }));
    features
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
