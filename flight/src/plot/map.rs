//! `map.svg`: the town, the fleet and what one agent knows of them at the end.

use svg::Document;
use svg::node::element::{ClipPath, Definitions, Group, Polygon, Rectangle};

use super::canvas::{Panel, group, round, text};
use super::{axes, layers, legend, town};
use crate::view::View;
use csat_mission::picture::{Layer, targets};
use csat_mission::style::{Form, Style};
use csat_mission::words::counted;

const MAIN_PX: f64 = 880.0;
const SIDE_PX: f64 = 330.0;
const GAP_PX: f64 = 24.0;
const MAIN_X_PX: f64 = 8.0 + axes::LEFT_PX;
const SCALE_BAR_PX: f64 = 20.0;
const HEADER_PX: f64 = 74.0;
/// Room for the title of a small map.
const TITLE_PX: f64 = 24.0;
const FOOTER_PX: f64 = 34.0;

/// The fonts of maps.
pub(super) const FONT: &str = "Helvetica, Arial, 'DejaVu Sans', sans-serif";

/// A small map beside the large one: the layers whose styles name its title.
struct Side<'a> {
    title: &'a str,
    styles: Vec<&'a Style>,
    panel: Panel,
}

/// Draws the end of a mission, as `agent` knows it.
pub fn map_svg(view: &View, agent: usize) -> String {
    let main = Panel::new(MAIN_X_PX, HEADER_PX, MAIN_PX, view.size_m, margin_m(view));
    let side_x = MAIN_X_PX + MAIN_PX + GAP_PX;
    let sides = sides(view, side_x);
    let legend_y = sides.last().map_or(HEADER_PX, |s| s.panel.y + s.panel.height + GAP_PX);
    let legend_bottom = legend_y + legend::height_px(view, Some(agent));
    let bottom = (main.y + main.height + axes::BELOW_PX + SCALE_BAR_PX).max(legend_bottom);
    let (width, height) = (side_x + SIDE_PX + GAP_PX, bottom + FOOTER_PX);
    let panels: Vec<&Panel> = [&main].into_iter().chain(sides.iter().map(|s| &s.panel)).collect();

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
        .add(definitions(&panels, view).add(near_region(&main, view.size_m)))
        .add(background)
        .add(header(view, agent))
        .add(clipped(0, main_layers(&main, view, agent)))
        .add(axes::axes(&main, view.size_m))
        .add(decorations(&main, view.size_m));
    let sides = sides.iter().enumerate();
    let document = sides.fold(document, |document, (index, side)| {
        let title = text(side.panel.x, side.panel.y - 10.0, 14.0, side.title);
        document.add(title).add(clipped(index + 1, side_layers(side, view, view.of_agent(agent))))
    });
    let document = document.add(legend::legend(side_x, legend_y, view, Some(agent)));
    document.add(footer(view, height)).to_string() + "\n"
}

/// The small maps, one below the other.
fn sides(view: &View, x: f64) -> Vec<Side<'_>> {
    let mut sides: Vec<Side<'_>> = Vec::new();
    for style in &view.layers {
        let Some(title) = style.panel.as_deref() else { continue };
        if let Some(side) = sides.iter_mut().find(|side| side.title == title) {
            side.styles.push(style);
            continue;
        }
        let above = sides.last().map(|side| side.panel.y + side.panel.height);
        let y = above.map_or(HEADER_PX, |above| above + GAP_PX + TITLE_PX);
        let panel = Panel::new(x, y, SIDE_PX, view.size_m, margin_m(view));
        sides.push(Side { title, styles: vec![style], panel });
    }
    sides
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

fn header(view: &View, agent: usize) -> Group {
    let known = targets(view.of_agent(agent)).len();
    let stations = match view.stations.len() {
        0 => String::new(),
        count => format!(", {}", counted(count, "station")),
    };
    let cars = match view.targets.len() {
        0 => String::new(),
        count => format!(": {known} of {count} cars"),
    };
    let subtitle = format!(
        "what {} knows{cars}; {} UAVs{stations}; {} m x {} m",
        view.name_of(agent),
        view.uavs.len(),
        view.size_m[0],
        view.size_m[1]
    );
    group("header")
        .add(text(MAIN_X_PX, 34.0, 22.0, title(view)).set("font-weight", "bold"))
        .add(text(MAIN_X_PX, 58.0, 14.0, subtitle))
}

fn main_layers(panel: &Panel, view: &View, agent: usize) -> Group {
    let known = view.of_agent(agent);
    let (ground, above): (Vec<_>, Vec<_>) = view.layers.iter().partition(|style| style.is_ground);
    let town = group("main").add(town::ground(panel, view));
    let town = drawn(panel, ground, known, town)
        .add(axes::grid(panel, view.size_m))
        .add(town::buildings(panel, view));
    let all = drawn(panel, above, known, town)
        .add(town::cars(panel, view, agent))
        .add(town::uavs(panel, view))
        .add(town::stations(panel, view));
    labelled(panel, view, known, all)
}

fn side_layers(side: &Side<'_>, view: &View, known: &[Layer]) -> Group {
    let Side { panel, styles, .. } = side;
    if styles.iter().any(|style| matches!(style.kind, Form::Heights | Form::Heat)) {
        return value_layers(side, view, known);
    }
    let (ground, above): (Vec<_>, Vec<_>) = styles.iter().partition(|style| style.is_ground);
    let town = group("side").add(town::ground(panel, view));
    let town = drawn(panel, ground, known, town).add(town::buildings(panel, view));
    drawn(panel, above, known, town)
}

/// Heights or values, among the outlines of buildings.
fn value_layers(side: &Side<'_>, view: &View, known: &[Layer]) -> Group {
    let frame = View { size_m: view.size_m, ..View::default() };
    let ground = group("side").add(town::ground(&side.panel, &frame));
    let filled = side.styles.iter().filter_map(|style| {
        Some(layers::filled(&side.panel, style, &Layer::of(known, style)?.content))
    });
    filled.fold(ground, Group::add).add(town::outlines(&side.panel, view))
}

/// Adds the layers of some styles.
pub(super) fn drawn<'a>(
    panel: &Panel,
    styles: impl IntoIterator<Item = &'a Style>,
    known: &[Layer],
    into: Group,
) -> Group {
    let styles = styles.into_iter();
    let layers =
        styles.filter_map(|style| Some(layers::layer(panel, style, Layer::of(known, style)?)));
    layers.fold(into, Group::add)
}

/// Adds what is written beside areas and points.
pub(super) fn labelled(panel: &Panel, view: &View, known: &[Layer], into: Group) -> Group {
    let styles = view.layers.iter().filter(|style| style.label.is_some());
    let labels =
        styles.filter_map(|style| Some(layers::labels(panel, style, Layer::of(known, style)?)));
    labels.fold(into, Group::add)
}

fn clipped(panel: usize, layers: Group) -> Group {
    Group::new().set("clip-path", format!("url(#panel-{panel})")).add(layers)
}

fn definitions(panels: &[&Panel], view: &View) -> Definitions {
    panels.iter().enumerate().fold(layers::hatches(&view.layers), |definitions, (index, panel)| {
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
    ClipPath::new().set("id", town::NEAR_REGION).add(area)
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
