//! A generator of towns that csat does not have, as docs/extending.md explains it: one long street.

use csat_proto::model::Ground;
use csat_world::map::{FeatureCount, Map, MapConfig, MapRules};
use csat_world::obstacle::Obstacle;
use csat_world::world::{World, WorldConfig, WorldErrors};
use geo::{LineString, Polygon};

/// A street from west to east with a house every 60 m on either side.
pub fn street(config: &MapConfig, rules: &MapRules) -> Map {
    let [width_m, depth_m] = config.size_m;
    // Cars keep their distance to walls: the house fronts are this far from the middle.
    let front_m = rules.road_clearance_m + 3.0;
    let house = |x: f64, side: f64| {
        let (y0, y1) = (side * front_m, side * (front_m + 20.0));
        let ring = vec![[x, y0], [x + 15.0, y0], [x + 15.0, y1], [x, y1], [x, y0]];
        Obstacle {
            footprint: Polygon::new(LineString::from(ring), Vec::new()),
            height_m: 12.0f64.min(rules.height_limit_m()),
            name: format!("house at {x} m"),
        }
    };
    let houses = (0..(width_m / 60.0) as u32).map(|i| f64::from(i) * 60.0 + 20.0 - width_m / 2.0);
    Map {
        ground: Ground { size_m: [width_m, depth_m] },
        obstacles: houses.flat_map(|x| [house(x, -1.0), house(x, 1.0)]).collect(),
        roads: vec![vec![[-width_m / 2.0, 0.0], [width_m / 2.0, 0.0]]],
        road_widths_m: vec![8.0],
        centre_deg: None,
        attribution: None,
        count: FeatureCount::default(),
        warnings: Vec::new(),
    }
}

fn main() -> Result<(), WorldErrors> {
    let config = WorldConfig::default();
    let town = street(&config.map, &config.map_rules());
    println!("{} houses, {:.1} % built", town.obstacles.len(), 100.0 * town.built_share());
    let mut world = World::from_map(&config, town, 1)?;
    for _ in 0..20 {
        world.advance();
    }
    println!("{} cars after 10 s, the first at {:?}", world.targets().len(), world.targets()[0]);
    Ok(())
}
