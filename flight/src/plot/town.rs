//! What maps show of the truth: the town, its cars and the fleet.

use svg::node::element::{Circle, Group, Path, Polygon, Rectangle};

use super::canvas::{Panel, group, label, round};
use super::colours::uav_colour;
use crate::view::{Building, View};
use csat_mission::picture::targets;

/// Buildings, in the legend.
pub const BUILDING: &str = "#8E8E8E";
/// The outlines of buildings.
pub const BUILDING_EDGE: &str = "#4A4A4A";
/// What footprints are clipped to.
pub const NEAR_REGION: &str = "near-region";
/// Roads.
pub const ROAD: &str = "#E3E3E0";
/// How dark the tracks of cars are.
pub const TRACK_OPACITY: f64 = 0.35;

/// Ground and roads, cut at the border of the region.
pub fn ground(panel: &Panel, view: &View) -> Group {
    let [x, y] = view.size_m.map(|s| s / 2.0);
    let region = vec![[-x, -y], [x, -y], [x, y], [-x, y]];
    let [west, north] = panel.north_west_m;
    let [east, south] = [west + panel.width / panel.scale, north - panel.height / panel.scale];
    let everything = vec![[west, south], [east, south], [east, north], [west, north]];
    let mut data = String::new();
    for road in &view.roads {
        data += &panel.line(road);
    }
    let roads = Path::new()
        .set("class", "roads")
        .set("d", data)
        .set("fill", "none")
        .set("stroke", ROAD)
        .set("stroke-width", round((6.0 * panel.scale).max(1.0)))
        .set("stroke-linejoin", "round");
    let outside = panel.area_of([&everything, &region]).set("fill", "#ffffff");
    let border = panel.area_of([&region]).set("fill", "none").set("stroke", "#333333");
    group("ground").add(roads).add(outside).add(border)
}

/// Buildings, darker when higher.
pub fn buildings(panel: &Panel, view: &View) -> Group {
    let highest = view.obstacles.iter().map(|b| b.height_m).fold(1.0, f64::max);
    view.obstacles.iter().fold(group("buildings"), |group, building| {
        let grey = 205.0 - 85.0 * (building.height_m / highest).clamp(0.0, 1.0);
        let area = panel
            .area_of(&building.rings)
            .set("fill", format!("#{0:02X}{0:02X}{0:02X}", grey as u8))
            .set("stroke", BUILDING_EDGE)
            .set("stroke-width", 0.6);
        group.add(area)
    })
}

/// The outlines of buildings.
pub fn outlines(panel: &Panel, view: &View) -> Group {
    let all = group("outlines").set("fill", "none").set("stroke", "#333333");
    let outline = |building: &Building| panel.area_of(&building.rings).set("stroke-width", 0.7);
    view.obstacles.iter().map(outline).fold(all, Group::add)
}

/// How the fleet flew and where it looks.
pub fn uavs(panel: &Panel, view: &View) -> Group {
    view.uavs.iter().enumerate().fold(group("uavs"), |all, (index, uav)| {
        let colour = uav_colour(index);
        let mut one = group("uav")
            .add(
                panel
                    .area_of([&uav.footprint])
                    .set("class", "footprint")
                    .set("clip-path", format!("url(#{NEAR_REGION})"))
                    .set("fill", colour)
                    .set("fill-opacity", 0.07)
                    .set("stroke", colour)
                    .set("stroke-width", 1.3)
                    .set("stroke-dasharray", "6 4"),
            )
            .add(
                Path::new()
                    .set("class", "path")
                    .set("d", panel.line(&uav.path))
                    .set("fill", "none")
                    .set("stroke", colour)
                    .set("stroke-width", 1.5)
                    .set("stroke-opacity", 0.85)
                    .set("stroke-linejoin", "round"),
            );
        if let (Some(first), Some(last)) = (uav.path.first(), uav.path.last()) {
            let [x, y] = panel.pixel(*first);
            let start = Circle::new().set("cx", round(x)).set("cy", round(y)).set("r", 3.5);
            let start = start.set("fill", "#ffffff").set("stroke", colour).set("stroke-width", 1.5);
            let [x, y] = panel.pixel(*last);
            let beside = label(x, y - 11.0, 13.0, colour, format!("U{index}"));
            one = one.add(start).add(arrow([x, y], uav.yaw_rad, colour)).add(beside);
        }
        all.add(one)
    })
}

/// Ground stations: masts with their names, as agents after the UAVs.
pub fn stations(panel: &Panel, view: &View) -> Group {
    (view.uavs.len()..).zip(&view.stations).fold(group("stations"), |all, (agent, station)| {
        let (colour, [x, y]) = (uav_colour(agent), panel.pixel([station.x_m, station.y_m]));
        let beside = label(x, y - 11.0, 13.0, colour, format!("S{agent}"));
        all.add(mast([x, y], colour)).add(beside)
    })
}

/// A mast at a pixel.
pub fn mast([x, y]: [f64; 2], colour: &str) -> Polygon {
    const SHAPE: [[f64; 2]; 3] = [[0.0, -9.0], [8.0, 6.0], [-8.0, 6.0]];
    let points = SHAPE.map(|[dx, dy]| format!("{:.1},{:.1}", x + dx, y + dy)).join(" ");
    Polygon::new()
        .set("class", "station")
        .set("points", points)
        .set("fill", colour)
        .set("stroke", "#ffffff")
        .set("stroke-width", 1.2)
}

/// An arrowhead at a pixel, pointing along a heading.
fn arrow([x, y]: [f64; 2], yaw_rad: f64, colour: &str) -> Polygon {
    const SHAPE: [[f64; 2]; 4] = [[11.0, 0.0], [-7.0, 6.0], [-3.5, 0.0], [-7.0, -6.0]];
    let (s, c) = yaw_rad.sin_cos();
    let points: Vec<String> = SHAPE
        .iter()
        // Pixels count downwards.
        .map(|[a, b]| format!("{:.1},{:.1}", x + a * c - b * s, y - a * s - b * c))
        .collect();
    Polygon::new()
        .set("points", points.join(" "))
        .set("fill", colour)
        .set("stroke", "#ffffff")
        .set("stroke-width", 1.2)
}

/// Where the cars are and have been; hollow when `agent` does not know of them.
pub fn cars(panel: &Panel, view: &View, agent: usize) -> Group {
    let named = targets(view.of_agent(agent));
    let known = |target: usize| named.contains(&(target as u64));
    view.targets.iter().enumerate().fold(group("cars"), |group, (target, path)| {
        let Some(last) = path.last() else { return group };
        let track = Path::new()
            .set("d", panel.line(path))
            .set("fill", "none")
            .set("stroke", "#000000")
            .set("stroke-opacity", TRACK_OPACITY)
            .set("stroke-width", 1);
        let [x, y] = panel.pixel(*last);
        let mark = Rectangle::new()
            .set("class", "car")
            .set("x", round(x - 3.5))
            .set("y", round(y - 3.5))
            .set("width", 7)
            .set("height", 7)
            .set("fill", if known(target) { "#000000" } else { "#ffffff" })
            .set("stroke", if known(target) { "#ffffff" } else { "#000000" })
            .set("stroke-width", 1.2);
        group.add(track).add(mark)
    })
}
