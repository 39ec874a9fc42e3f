//! `map-agents.svg`: what each agent knows at the end, side by side.

use svg::Document;
use svg::node::element::{ClipPath, Definitions, Group, Rectangle, Title, Use};

use super::canvas::{Panel, group, round, text};
use super::map::{drawn, labelled, margin_m, title};
use super::{layers, legend, town};
use crate::view::View;
use csat_mission::picture::{Layer, targets};

const WIDTH_PX: f64 = 1240.0;
const GAP_PX: f64 = 20.0;
const HEADER_PX: f64 = 64.0;
const TITLE_PX: f64 = 22.0;
/// No map is drawn for less width.
const DRAWN_PX: f64 = 400.0;
/// No map is wider, however few there are.
const WIDEST_PX: f64 = 600.0;

/// Draws what every agent knows, in a grid of small maps.
pub fn agents_svg(view: &View) -> String {
    let count = view.agents.len().max(1);
    let columns = (1..=count).find(|n| n * n >= count).unwrap_or(1);
    let rows = count.div_ceil(columns);
    let room = (WIDTH_PX - GAP_PX) / columns as f64 - GAP_PX;
    let width = room.min(WIDEST_PX);
    let panel = Panel::new(0.0, 0.0, width.max(DRAWN_PX), view.size_m, margin_m(view));
    // Many maps are drawn larger than they are shown, so that marks and numbers shrink with them.
    let shrunk = width / panel.width;
    let row_px = panel.height * shrunk + TITLE_PX + GAP_PX;
    let legend_y = HEADER_PX + rows as f64 * row_px;
    let height = legend_y + legend::height_px(view, None) + 2.0 * GAP_PX;
    let mut document = Document::new()
        .set("viewBox", (0, 0, round(WIDTH_PX), round(height)))
        .set("width", round(WIDTH_PX))
        .set("height", round(height))
        .set("font-family", super::map::FONT)
        .add(Title::new(title(view)))
        .add(definitions(&panel, view))
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "#ffffff"))
        .add(text(GAP_PX, 34.0, 22.0, title(view)).set("font-weight", "bold"))
        .add(text(GAP_PX, 54.0, 14.0, "what each agent knows"));
    for (agent, known) in view.agents.iter().enumerate() {
        let (row, column) = (agent / columns, agent % columns);
        let x = GAP_PX + column as f64 * (width + GAP_PX);
        let y = HEADER_PX + row as f64 * row_px + TITLE_PX;
        document = document.add(
            group("agent")
                .set("transform", format!("translate({} {})", round(x), round(y)))
                .add(heading(agent, known, view, width))
                .add(
                    map(&panel, view, agent, known).set("transform", format!("scale({shrunk:.4})")),
                ),
        );
    }
    let line = view.attribution.clone().unwrap_or_default();
    let footer = text(WIDTH_PX - GAP_PX, height - 12.0, 11.0, line).set("text-anchor", "end");
    document = document.add(legend::legend(GAP_PX, legend_y, view, None)).add(footer);
    document.to_string() + "\n"
}

/// In numbers what its map shows; less of it where there is less room.
fn heading(agent: usize, known: &[Layer], view: &View, width: f64) -> Group {
    let name = view.name_of(agent);
    let cars = format!("{name}: {} of {} cars", targets(known).len(), view.targets.len());
    let words = match shares(known) {
        _ if view.targets.is_empty() => name,
        shares if width > 260.0 => format!("{cars}{shares}"),
        _ => cars,
    };
    let size = if width > 200.0 { 13.0 } else { 10.0 };
    group("heading").add(text(0.0, -7.0, size, words).set("font-weight", "bold"))
}

/// The shares of the region that layers of one area say: `, 16.8 % unexplored`.
fn shares(known: &[Layer]) -> String {
    let share = |layer: &Layer| {
        let share_pct = layer.properties().next()?.get("share_pct")?.as_f64()?;
        Some(format!(", {share_pct:.1} % {}", layer.key))
    };
    known.iter().filter_map(share).collect()
}

fn map(panel: &Panel, view: &View, agent: usize, known: &[Layer]) -> Group {
    let shared = |id: &str| Use::new().set("href", format!("#{id}"));
    let (ground, above): (Vec<_>, Vec<_>) = view.layers.iter().partition(|style| style.is_ground);
    let all = Group::new().set("clip-path", "url(#panel)").add(shared("ground"));
    let all = drawn(panel, ground, known, all).add(shared("buildings"));
    let all = drawn(panel, above, known, all)
        .add(town::cars(panel, view, agent))
        .add(shared("uavs"))
        .add(shared("stations"));
    labelled(panel, view, known, all)
}

/// What is the same on every map is written once.
fn definitions(panel: &Panel, view: &View) -> Definitions {
    let area = Rectangle::new().set("width", round(panel.width)).set("height", round(panel.height));
    layers::hatches(&view.layers)
        .add(ClipPath::new().set("id", "panel").add(area))
        .add(super::map::near_region(panel, view.size_m))
        .add(town::ground(panel, view).set("id", "ground"))
        .add(town::buildings(panel, view).set("id", "buildings"))
        .add(town::uavs(panel, view).set("id", "uavs"))
        .add(town::stations(panel, view).set("id", "stations"))
}
