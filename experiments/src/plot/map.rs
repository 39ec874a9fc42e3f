//! `map.svg`: the town, the fleet and what one agent knows of them at the end.

use svg::Document;
use svg::node::element::{ClipPath, Definitions, Group, Polygon, Rectangle};

use super::canvas::{Panel, group, round, text};
use super::{axes, layers, legend};
use crate::view::View;
use csat_mission::picture::Knowledge;
use csat_mission::words::counted;

const MAIN_PX: f64 = 880.0;
const SIDE_PX: f64 = 330.0;
const GAP_PX: f64 = 24.0;
const MAIN_X_PX: f64 = 8.0 + axes::LEFT_PX;
const SCALE_BAR_PX: f64 = 20.0;
const HEADER_PX: f64 = 74.0;
const FOOTER_PX: f64 = 34.0;

/// The fonts of maps.
pub(super) const FONT: &str = "Helvetica, Arial, 'DejaVu Sans', sans-serif";

/// Draws the end of a mission, as `agent` knows it.
pub fn map_svg(view: &View, agent: usize) -> String {
    let margin = margin_m(view);
    let main = Panel::new(MAIN_X_PX, HEADER_PX, MAIN_PX, view.size_m, margin);
    let side_x = MAIN_X_PX + MAIN_PX + GAP_PX;
    let title_px = 24.0;
    let hidden = Panel::new(side_x, HEADER_PX, SIDE_PX, view.size_m, margin);
    let oem_y = hidden.y + hidden.height + GAP_PX + title_px;
    let oem = Panel::new(side_x, oem_y, SIDE_PX, view.size_m, margin);
    let legend_y = oem.y + oem.height + GAP_PX;
    let legend = legend::legend(side_x, legend_y, view, Some(agent));
    let bottom =
        (main.y + main.height + axes::BELOW_PX + SCALE_BAR_PX).max(legend_y + legend::HEIGHT_PX);
    let (width, height) = (side_x + SIDE_PX + GAP_PX, bottom + FOOTER_PX);
    let nobody = Knowledge::default();
    let knowledge = view.agents.get(agent).unwrap_or(&nobody);

    let background = Rectangle::new()
        .set("width", round(width))
        .set("height", round(height))
        .set("fill", "#ffffff");
    let document = Document::new()
        .set("viewBox", (0, 0, round(width), round(height)))
        .set("width", round(width))
        .set("height", round(height))
        .set("font-family", FONT)
        .add(svg::node::element::Title::new(title(view)))
        .add(definitions(&[&main, &hidden, &oem]).add(near_region(&main, view.size_m)))
        .add(background)
        .add(header(view, agent, &hidden, &oem))
        .add(clipped(0, main_layers(&main, view, agent, knowledge)))
        .add(axes::axes(&main, view.size_m))
        .add(decorations(&main, view.size_m))
        .add(clipped(1, hidden_layers(&hidden, view, knowledge)))
        .add(clipped(2, oem_layers(&oem, view, knowledge)))
        .add(legend)
        .add(footer(view, height));
    document.to_string() + "\n"
}

/// Room around the region for the fleet's start and its turns outside.
pub(super) fn margin_m(view: &View) -> f64 {
    let beyond = view
        .uavs
        .iter()
        .flat_map(|u| u.path.iter().copied())
        .chain(view.stations.iter().map(|station| [station.x_m, station.y_m]))
        .map(|p| (p[0].abs() - view.size_m[0] / 2.0).max(p[1].abs() - view.size_m[1] / 2.0));
    let size = view.size_m[0].max(view.size_m[1]);
    let most = 0.15 * size;
    beyond
        .fold(0.02 * size, |a, b| if b.is_finite() { a.max(b + 0.02 * size) } else { a })
        .min(most)
}

pub(super) fn title(view: &View) -> String {
    format!("{}, seed {}, t = {} s", view.scenario, view.seed, view.time_s)
}

fn header(view: &View, agent: usize, hidden: &Panel, oem: &Panel) -> Group {
    let known = view.agents.get(agent).map_or(0, |a| a.targets.len());
    let stations = match view.stations.len() {
        0 => String::new(),
        count => format!(", {}", counted(count, "station")),
    };
    let subtitle = format!(
        "what {} knows: {known} of {} cars identified; {} UAVs{stations}; {} m x {} m",
        view.name_of(agent),
        view.targets.len(),
        view.uavs.len(),
        view.size_m[0],
        view.size_m[1]
    );
    group("header")
        .add(text(MAIN_X_PX, 34.0, 22.0, title(view)).set("font-weight", "bold"))
        .add(text(MAIN_X_PX, 58.0, 14.0, subtitle))
        .add(text(hidden.x, hidden.y - 10.0, 14.0, "Unexplored ground and its hidden part"))
        .add(text(oem.x, oem.y - 10.0, 14.0, "Occupancy-elevation map (OEM)"))
}

fn main_layers(panel: &Panel, view: &View, agent: usize, knowledge: &Knowledge) -> Group {
    group("main")
        .add(layers::ground(panel, view))
        .add(layers::unexplored(panel, knowledge))
        .add(layers::hidden(panel, knowledge))
        .add(axes::grid(panel, view.size_m))
        .add(layers::buildings(panel, view))
        .add(layers::margin(panel, knowledge))
        .add(layers::oem_outlines(panel, &knowledge.oem))
        .add(layers::target_sets(panel, knowledge))
        .add(layers::cars(panel, view, agent))
        .add(layers::uavs(panel, view))
        .add(layers::stations(panel, view))
        .add(layers::target_labels(panel, knowledge))
}

fn hidden_layers(panel: &Panel, view: &View, knowledge: &Knowledge) -> Group {
    group("hidden-panel")
        .add(layers::ground(panel, view))
        .add(layers::unexplored(panel, knowledge))
        .add(layers::hidden(panel, knowledge))
        .add(layers::buildings(panel, view))
}

fn oem_layers(panel: &Panel, view: &View, knowledge: &Knowledge) -> Group {
    let outlines =
        view.obstacles.iter().fold(
            group("outlines").set("fill", "none").set("stroke", "#333333"),
            |group, building| group.add(panel.area_of(&building.rings).set("stroke-width", 0.7)),
        );
    group("oem-panel")
        .add(layers::ground(panel, &View { roads: Vec::new(), ..view_frame(view) }))
        .add(layers::oem_filled(panel, &knowledge.oem))
        .add(outlines)
}

/// A view with nothing in it but its size.
fn view_frame(view: &View) -> View {
    View { size_m: view.size_m, ..View::default() }
}

fn clipped(panel: usize, layers: Group) -> Group {
    Group::new().set("clip-path", format!("url(#panel-{panel})")).add(layers)
}

fn definitions(panels: &[&Panel]) -> Definitions {
    panels.iter().enumerate().fold(layers::hatches(), |definitions, (index, panel)| {
        let area = Rectangle::new()
            .set("x", round(panel.x))
            .set("y", round(panel.y))
            .set("width", round(panel.width))
            .set("height", round(panel.height));
        definitions.add(ClipPath::new().set("id", format!("panel-{index}")).add(area))
    })
}

/// Footprints reach far beyond the region; this much of them tells enough.
pub(super) fn near_region(panel: &Panel, size_m: [f64; 2]) -> ClipPath {
    let margin_m = 0.02 * size_m[0].max(size_m[1]);
    let half = size_m.map(|s| s / 2.0 + margin_m);
    let ([left, top], [right, bottom]) =
        (panel.pixel([-half[0], half[1]]), panel.pixel([half[0], -half[1]]));
    let area = Rectangle::new()
        .set("x", round(left))
        .set("y", round(top))
        .set("width", round(right - left))
        .set("height", round(bottom - top));
    ClipPath::new().set("id", layers::NEAR_REGION).add(area)
}

/// Scale bar and north.
fn decorations(panel: &Panel, size_m: [f64; 2]) -> Group {
    // About a fifth of the panel, in 1, 2 or 5 times a power of ten.
    let wanted = panel.width / panel.scale / 5.0;
    let power = 10f64.powf(wanted.log10().floor());
    let length_m =
        [5.0, 2.0, 1.0].iter().map(|f| f * power).find(|l| *l <= wanted).unwrap_or(power);
    let length = length_m * panel.scale;
    // Below the panel and its axis, where nothing else is drawn.
    let [left, _] = panel.pixel([-size_m[0] / 2.0, 0.0]);
    let bottom = panel.y + panel.height + axes::BELOW_PX + 14.0;
    let bar = Rectangle::new()
        .set("class", "scale-bar")
        .set("x", round(left))
        .set("y", round(bottom - 6.0))
        .set("width", round(length))
        .set("height", 6)
        .set("fill", "#222222");
    let [east, _] = panel.pixel([size_m[0] / 2.0, 0.0]);
    let (x, y) = (east - 9.0, panel.y - 32.0);
    let points =
        format!("{x},{y} {},{} {x},{} {},{}", x - 8.0, y + 24.0, y + 18.0, x + 8.0, y + 24.0);
    group("decorations")
        .add(bar)
        .add(text(left + length + 8.0, bottom, 13.0, format!("{length_m} m")))
        .add(Polygon::new().set("class", "north").set("points", points).set("fill", "#222222"))
        .add(text(x - 27.0, y + 22.0, 15.0, "N"))
}

fn footer(view: &View, height: f64) -> Group {
    let line = view.attribution.clone().unwrap_or_default();
    group("footer")
        .add(text(MAIN_X_PX + MAIN_PX, height - 16.0, 11.0, line).set("text-anchor", "end"))
}
