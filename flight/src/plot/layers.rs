//! What maps show of an agent's knowledge: layers, as their styles say.

use svg::node::element::{Circle, Definitions, Group, Line as Stroke, Path, Pattern};

use super::canvas::{Panel, group, label, round};
use super::colours::{UAV_COLOURS, uav_colour};
use csat_mission::picture::{Cells, Content, Heat, Layer, Oem, Properties, Shapes};
use csat_mission::style::{Colour, Fill, Form, Line, Style};

/// Number of bands of height, or of other values.
pub const BANDS: u16 = 5;
/// Cells of an occupancy-elevation map that are known to be empty.
pub const EMPTY: &str = "#D7E8F3";

/// A layer; of an occupancy-elevation map the outlines of occupied cells.
pub fn layer(panel: &Panel, style: &Style, layer: &Layer) -> Group {
    let all = group(&style.key);
    match &layer.content {
        Content::Areas(areas) => areas.iter().fold(all, |all, area| {
            all.add(painted(style, &area.properties, panel.area(&area.shapes)))
        }),
        Content::Cells(cells) => all.add(painted(style, &Properties::new(), panel.cells(cells))),
        Content::Heights(oem) => height_outlines(panel, style, oem, all),
        Content::Heat(heat) => values(panel, style, &heat.bands(BANDS), all),
        Content::Points(marks) => marks.iter().fold(all, |all, mark| {
            all.add(point(style, &mark.properties, panel.pixel(mark.point)))
        }),
    }
}

/// A layer of heights or values as the small map of its own shows it: cells, filled by value.
pub fn filled(panel: &Panel, style: &Style, content: &Content) -> Group {
    let all = group(&format!("{}-filled", style.key));
    match content {
        Content::Heights(oem) => {
            let empty = panel.cells(&oem.empty).set("class", "empty").set("fill", EMPTY);
            values(panel, style, &oem.bands(BANDS, oem.highest_dm()), all.add(empty))
        }
        Content::Heat(heat) => values(panel, style, &heat.bands(BANDS), all),
        _ => all,
    }
}

/// What the style says to write beside areas and points.
pub fn labels(panel: &Panel, style: &Style, layer: &Layer) -> Group {
    let all = group(&format!("{}-labels", style.key));
    let Some(key) = &style.label else { return all };
    let places: Vec<Option<[f64; 2]>> = match &layer.content {
        Content::Areas(areas) => areas.iter().map(|area| highest(&area.shapes)).collect(),
        Content::Points(marks) => marks.iter().map(|mark| Some(mark.point)).collect(),
        _ => Vec::new(),
    };
    let named = places.into_iter().zip(layer.properties());
    named.fold(all, |all, (place, properties)| {
        let (Some(place), Some(value)) = (place, properties.get(&**key)) else { return all };
        let words = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let [x, y] = panel.pixel(place);
        let colour = style.line.as_ref().map_or(&style.colour, |line| &line.colour);
        all.add(label(x, y - 4.0, 13.0, colour_of(colour, properties), words))
    })
}

/// The northernmost point of shapes.
fn highest(shapes: &Shapes) -> Option<[f64; 2]> {
    shapes.iter().flatten().flatten().copied().max_by(|a, b| a[1].total_cmp(&b[1]))
}

/// A path in the fill and the outline of a style.
pub fn painted(style: &Style, properties: &Properties, path: Path) -> Path {
    let path = match style.fill {
        Fill::None => path.set("fill", "none"),
        Fill::Plain { opacity } => {
            path.set("fill", colour_of(&style.colour, properties)).set("fill-opacity", opacity)
        }
        Fill::Hatch { .. } => {
            path.set("fill", format!("url(#{})", hatch_id(style, index_of(style, properties))))
        }
    };
    match &style.line {
        Some(Line { colour, width_px }) => {
            path.set("stroke", colour_of(colour, properties)).set("stroke-width", *width_px)
        }
        None => path,
    }
}

/// A point at a pixel.
pub fn point(style: &Style, properties: &Properties, [x, y]: [f64; 2]) -> Circle {
    Circle::new()
        .set("cx", round(x))
        .set("cy", round(y))
        .set("r", 4)
        .set("fill", colour_of(&style.colour, properties))
        .set("stroke", "#ffffff")
        .set("stroke-width", 1.2)
}

/// The colour of an area or a point with these properties.
pub fn colour_of<'a>(colour: &'a Colour, properties: &Properties) -> &'a str {
    match colour {
        Colour::Fixed(colour) => colour,
        Colour::By(key) => uav_colour(index(key, properties)),
    }
}

fn index(key: &str, properties: &Properties) -> usize {
    properties.get(key).and_then(serde_json::Value::as_u64).unwrap_or_default() as usize
}

/// Which of the hatchings of a style an area with these properties has.
fn index_of(style: &Style, properties: &Properties) -> usize {
    match &style.colour {
        Colour::Fixed(_) => 0,
        Colour::By(key) => index(key, properties) % UAV_COLOURS.len(),
    }
}

fn hatch_id(style: &Style, index: usize) -> String {
    match &style.colour {
        Colour::Fixed(_) => format!("hatch-{}", style.key),
        Colour::By(_) => format!("hatch-{}-{index}", style.key),
    }
}

/// The hatchings of styles: `hatch-KEY`.
pub fn hatches(styles: &[Style]) -> Definitions {
    styles.iter().fold(Definitions::new(), |all, style| {
        let colours = match &style.colour {
            Colour::Fixed(colour) => vec![&**colour],
            Colour::By(_) => UAV_COLOURS.to_vec(),
        };
        let hatches = colours.into_iter().enumerate();
        hatches
            .filter_map(|(index, colour)| hatch(style, index, colour))
            .fold(all, Definitions::add)
    })
}

fn hatch(style: &Style, index: usize, colour: &str) -> Option<Pattern> {
    let Fill::Hatch { spacing_px, width_px, is_falling } = style.fill else { return None };
    let line = Stroke::new()
        .set("x1", 0)
        .set("y1", 0)
        .set("x2", 0)
        .set("y2", spacing_px)
        .set("stroke", colour)
        .set("stroke-width", width_px);
    let angle = if is_falling { -45 } else { 45 };
    let pattern = Pattern::new()
        .set("id", hatch_id(style, index))
        .set("width", spacing_px)
        .set("height", spacing_px)
        .set("patternUnits", "userSpaceOnUse")
        .set("patternTransform", format!("rotate({angle})"));
    Some(pattern.add(line))
}

/// The occupied cells, outlined; the higher, the stronger.
fn height_outlines(panel: &Panel, style: &Style, oem: &Oem, all: Group) -> Group {
    let bands = oem.bands(BANDS, oem.highest_dm());
    shares(&bands).fold(all, |all, (share, cells)| {
        let path = panel
            .cells(cells)
            .set("fill", "none")
            .set("stroke", colour_of(&style.colour, &Properties::new()))
            .set("stroke-width", round(0.5 + 0.8 * share))
            .set("stroke-opacity", round(0.35 + 0.65 * share));
        all.add(path)
    })
}

/// Bands of cells, filled; the higher, the stronger.
fn values(panel: &Panel, style: &Style, bands: &[Cells], all: Group) -> Group {
    shares(bands).fold(all, |all, (share, cells)| all.add(value(style, share, panel.cells(cells))))
}

/// A path in the colour of a value, 0 for that of the lowest band and 1 for that of the highest.
pub fn value(style: &Style, share: f64, path: Path) -> Path {
    let path = path
        .set("fill", colour_of(&style.colour, &Properties::new()))
        .set("fill-opacity", round(0.2 + 0.8 * share));
    match style.kind {
        // Cells of a field stand side by side: between them nothing is to be seen.
        Form::Heat => path.set("shape-rendering", "crispEdges"),
        _ => path.set("stroke", "#ffffff").set("stroke-width", 0.3),
    }
}

/// Bands that are not empty, with their places from 0 to 1.
fn shares(bands: &[Cells]) -> impl Iterator<Item = (f64, &Cells)> {
    let last = bands.len().max(2) - 1;
    let shares =
        bands.iter().enumerate().map(move |(band, cells)| (band as f64 / last as f64, cells));
    shares.filter(|(_, cells)| !cells.runs.is_empty())
}

/// The upper ends of the bands of a layer of heights, with their unit, or of values.
pub fn scale(content: &Content) -> Option<[String; BANDS as usize]> {
    let (highest, unit) = match content {
        Content::Heights(oem) => (f64::from(oem.highest_dm()) / 10.0, "m"),
        Content::Heat(Heat { maximum, .. }) => (*maximum, ""),
        _ => return None,
    };
    let digits = if highest < 2.0 { 2 } else { 0 };
    Some(std::array::from_fn(|band| {
        let upper = highest * (band + 1) as f64 / f64::from(BANDS);
        format!("≤{upper:.digits$} {unit}").trim_end().to_owned()
    }))
}
