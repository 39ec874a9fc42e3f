//! What is drawn in the panels of `map.svg`, from the ground up.

use svg::node::element::{Circle, Definitions, Group, Line, Path, Pattern, Polygon, Rectangle};

use super::canvas::{Panel, group, label, round};
use super::uav_colour;
use crate::view::View;
use csat_mission::picture::Knowledge;
use csat_mission::picture::Oem;

/// X̄ of the thesis's figures.
pub const UNEXPLORED: &str = "#F5DF4D";
/// X_j.
pub const TARGET_SET: &str = "#009E73";
/// OEM.
pub const OEM: &str = "#B2182B";
/// X^h.
pub const HIDDEN: &str = "#1F5FBF";
/// Buildings, in the legend.
pub const BUILDING: &str = "#8E8E8E";
/// What footprints are clipped to.
pub const NEAR_REGION: &str = "near-region";
/// Roads.
pub const ROAD: &str = "#E3E3E0";

/// The hatchings that [`hidden`] and [`margin`] refer to.
pub fn hatches() -> Definitions {
    let hatch = |id: &str, spacing: f64, colour: &str, width: f64, angle: i32| {
        Pattern::new()
            .set("id", id)
            .set("width", spacing)
            .set("height", spacing)
            .set("patternUnits", "userSpaceOnUse")
            .set("patternTransform", format!("rotate({angle})"))
            .add(
                Line::new()
                    .set("x1", 0)
                    .set("y1", 0)
                    .set("x2", 0)
                    .set("y2", spacing)
                    .set("stroke", colour)
                    .set("stroke-width", width),
            )
    };
    let hidden = hatch("hatch-hidden", 5.0, HIDDEN, 1.7, 45);
    let margin = hatch("hatch-margin", 3.0, "#000000", 0.9, -45);
    Definitions::new().add(hidden).add(margin)
}

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
            .set("stroke", "#4A4A4A")
            .set("stroke-width", 0.6);
        group.add(area)
    })
}

/// X̄.
pub fn unexplored(panel: &Panel, knowledge: &Knowledge) -> Path {
    panel
        .area(&knowledge.unexplored)
        .set("class", "unexplored")
        .set("fill", UNEXPLORED)
        .set("fill-opacity", 0.85)
        .set("stroke", "#B79F00")
        .set("stroke-width", 0.6)
}

/// X^h, hatched.
pub fn hidden(panel: &Panel, knowledge: &Knowledge) -> Path {
    panel.cells(&knowledge.hidden).set("class", "hidden").set("fill", "url(#hatch-hidden)")
}

/// X°, finely hatched.
pub fn margin(panel: &Panel, knowledge: &Knowledge) -> Path {
    panel
        .area(&knowledge.obstacle_margin)
        .set("class", "margin")
        .set("fill", "url(#hatch-margin)")
        .set("stroke", "#000000")
        .set("stroke-width", 0.7)
}

/// X_j with j.
pub fn target_sets(panel: &Panel, knowledge: &Knowledge) -> Group {
    knowledge.targets.iter().fold(group("targets"), |group, (_, shapes)| {
        let area = panel
            .area(shapes)
            .set("fill", TARGET_SET)
            .set("fill-opacity", 0.6)
            .set("stroke", "#00573F")
            .set("stroke-width", 1.0);
        group.add(area)
    })
}

/// The indexes of target sets, beside them.
pub fn target_labels(panel: &Panel, knowledge: &Knowledge) -> Group {
    knowledge.targets.iter().fold(group("target-labels"), |group, (target, shapes)| {
        let points: Vec<[f64; 2]> = shapes.iter().flatten().flatten().copied().collect();
        let Some(highest) = points.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1])) else {
            return group;
        };
        let [x, y] = panel.pixel(highest);
        group.add(label(x, y - 4.0, 13.0, "#00573F", target.to_string()))
    })
}

/// The cells of the OEM, outlined; the higher, the stronger.
pub fn oem_outlines(panel: &Panel, oem: &Oem) -> Group {
    oem_cells(panel, oem, group("oem"), |path, share| {
        path.set("fill", "none")
            .set("stroke", OEM)
            .set("stroke-width", round(0.5 + 0.8 * share))
            .set("stroke-opacity", round(0.35 + 0.65 * share))
    })
}

/// The cells of the OEM, filled by height, and those known to be empty.
pub fn oem_filled(panel: &Panel, oem: &Oem) -> Group {
    let empty = panel.cells(&oem.empty).set("class", "oem-empty").set("fill", "#D7E8F3");
    oem_cells(panel, oem, group("oem-filled").add(empty), |path, share| {
        path.set("fill", OEM)
            .set("fill-opacity", round(0.2 + 0.8 * share))
            .set("stroke", "#ffffff")
            .set("stroke-width", 0.3)
    })
}

/// One path per band of height.
fn oem_cells(panel: &Panel, oem: &Oem, into: Group, style: impl Fn(Path, f64) -> Path) -> Group {
    let bands = height_bands(oem);
    (0..BANDS).fold(into, |group, band| {
        let runs = oem
            .occupied
            .iter()
            .filter(|cell| bands.band(cell.2) == band)
            .map(|&(column, row, _)| [row, column, column + 1])
            .collect();
        let cells =
            csat_mission::picture::Cells { cell_m: oem.cell_m, origin_m: oem.origin_m, runs };
        let share = f64::from(band) / f64::from(BANDS - 1);
        if cells.runs.is_empty() { group } else { group.add(style(panel.cells(&cells), share)) }
    })
}

/// How dark the tracks of cars are.
pub const TRACK_OPACITY: f64 = 0.35;

/// Number of bands of height.
pub const BANDS: u16 = 5;

/// Bands of height of equal width up to the highest cell.
#[derive(Debug, Clone, Copy)]
pub struct HeightBands {
    highest_dm: u16,
}

/// The bands of an OEM.
pub fn height_bands(oem: &Oem) -> HeightBands {
    HeightBands { highest_dm: oem.occupied.iter().map(|c| c.2).max().unwrap_or(1).max(1) }
}

impl HeightBands {
    /// The band of a height.
    fn band(&self, height_dm: u16) -> u16 {
        (u32::from(height_dm) * u32::from(BANDS) / (u32::from(self.highest_dm) + 1)) as u16
    }

    /// The upper end of a band, metres.
    pub fn upper_m(&self, band: u16) -> f64 {
        f64::from(self.highest_dm) / 10.0 * f64::from(band + 1) / f64::from(BANDS)
    }
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
    let known = |target: usize| {
        let knowledge = view.agents.get(agent);
        knowledge.is_some_and(|a| a.targets.iter().any(|(j, _)| usize::from(*j) == target))
    };
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
