//! What is drawn of an agent of the Bayesian search.

use std::borrow::Cow;

use csat_bayes::belief::region::CellSet;
use csat_bayes::search_map::{Gaussian, SearchMap};
use csat_mission::documents::micro;
use csat_mission::picture::{
    Area, Cells, Content, Heat, Layer, Mark, Ring, properties, to_millimetre,
};
use csat_mission::style::{Colour, Fill, Form, Line, Style};
use csat_proto::model::Ground;
use serde_json::json;

use super::report::{Maps, Report};

/// The square of the radius of the ellipse that holds 95 % of a normal density in two dimensions.
const ELLIPSE: f64 = 5.991;
/// Corners of an ellipse.
const CORNERS: u32 = 48;
/// An ellipse with a greater deviation says nothing, metres.
const MAX_SIGMA_M: f64 = 120.0;
/// A region with a greater share of the ground is not drawn.
const MAX_REGION_SHARE: f64 = 0.05;
/// The most particles that are drawn.
const MAX_PARTICLES: usize = 800;

/// What differs from layer to layer.
struct Kind {
    key: &'static str,
    title: &'static str,
    form: Form,
    colour: &'static str,
    fill: Fill,
    line_px: f64,
    unit: &'static str,
    is_in_scene: bool,
}

const fn style(kind: Kind) -> Style {
    let Kind { key, title, form, colour, fill, line_px, unit, is_in_scene } = kind;
    Style {
        key: Cow::Borrowed(key),
        title: Cow::Borrowed(title),
        kind: form,
        colour: Colour::fixed(colour),
        fill,
        line: if line_px > 0.0 { Some(Line::fixed(colour, line_px)) } else { None },
        label: None,
        mark: None,
        unit: if unit.is_empty() { None } else { Some(Cow::Borrowed(unit)) },
        panel: None,
        is_ground: true,
        is_in_scene,
    }
}

/// The layers, from the bottom up.
pub const LAYERS: &[Style] = &[
    style(Kind {
        key: "belief",
        title: "where the target may be: probability of a cell",
        form: Form::Heat,
        colour: "#5e3c99",
        fill: Fill::Plain { opacity: 0.75 },
        line_px: 0.0,
        unit: "%",
        is_in_scene: true,
    }),
    style(Kind {
        key: "particles",
        title: "particles",
        form: Form::Points,
        colour: "#b35806",
        fill: Fill::Plain { opacity: 0.6 },
        line_px: 0.0,
        unit: "",
        is_in_scene: false,
    }),
    style(Kind {
        key: "region",
        title: "densest cells with 95 % of the probability",
        form: Form::Cells,
        colour: "#e66101",
        fill: Fill::Hatch { spacing_px: 4.0, width_px: 1.2, is_falling: false },
        line_px: 0.0,
        unit: "",
        is_in_scene: false,
    }),
    style(Kind {
        key: "ellipse",
        title: "95 % ellipse of mean and covariance",
        form: Form::Areas,
        colour: "#e66101",
        fill: Fill::None,
        line_px: 1.6,
        unit: "",
        is_in_scene: true,
    }),
    style(Kind {
        key: "detections",
        title: "detections, false alarms included",
        form: Form::Points,
        colour: "#1b7837",
        fill: Fill::Plain { opacity: 0.8 },
        line_px: 0.0,
        unit: "",
        is_in_scene: true,
    }),
];

/// What there is to draw of a report: `belief`, `particles` and `detections` only where it has its maps.
pub(super) fn picture(ground: &Ground, report: &Report) -> Vec<Layer> {
    let mut layers = Vec::new();
    if let Some(maps) = &report.maps {
        layers.push(Layer::new("belief", Content::Heat(heat(&maps.belief))));
        if !maps.particles.is_empty() {
            layers.push(Layer::new("particles", Content::Points(particles(maps))));
        }
    }
    if report.region.area_m2() <= MAX_REGION_SHARE * ground.area_m2() {
        layers.push(Layer::new("region", Content::Cells(cells(&report.region))));
    }
    let ellipse = (report.estimate.sigma_m() < MAX_SIGMA_M).then(|| ellipse(&report.estimate));
    layers.push(Layer::new("ellipse", Content::Areas(ellipse.into_iter().collect())));
    if let Some(maps) = &report.maps {
        layers.push(Layer::new("detections", Content::Points(detections(maps))));
    }
    layers
}

/// Per cent of the whole probability in each cell.
fn heat(SearchMap { grid, mass }: &SearchMap) -> Heat {
    let percent = |mass: &f64| micro(100.0 * mass);
    Heat {
        cell_m: grid.cell_m,
        origin_m: grid.origin(),
        columns: grid.columns,
        maximum: percent(&mass.iter().copied().fold(0.0, f64::max)),
        values: mass.iter().map(percent).collect(),
    }
}

fn particles(maps: &Maps) -> Vec<Mark> {
    let every = maps.particles.len().div_ceil(MAX_PARTICLES).max(1);
    let mark = |p: &[f64; 2]| Mark {
        point: p.map(to_millimetre),
        properties: properties(json!({ "kind": "particle" })),
    };
    maps.particles.iter().step_by(every).map(mark).collect()
}

fn detections(maps: &Maps) -> Vec<Mark> {
    let mark = |(id, step, location): &(csat_bayes::factor::FactorId, _, [f64; 2])| Mark {
        point: location.map(to_millimetre),
        properties: properties(json!({ "kind": "detection", "by": id.source, "seen_in": step })),
    };
    maps.sightings.iter().map(mark).collect()
}

fn cells(region: &CellSet) -> Cells {
    let runs = region.rects.iter().flat_map(|&[column, row, columns, rows]| {
        (row..row + rows).map(move |row| [row, column, column + columns])
    });
    let mut runs: Vec<[u32; 3]> = runs.collect();
    runs.sort_unstable();
    let mut joined: Vec<[u32; 3]> = Vec::new();
    for [row, from, to] in runs {
        match joined.last_mut() {
            Some([last_row, _, end]) if *last_row == row && *end == from => *end = to,
            _ => joined.push([row, from, to]),
        }
    }
    Cells { cell_m: region.cell_m, origin_m: region.origin_m, runs: joined }
}

/// The points at which the normal density has fallen so far that 95 % is inside.
fn ellipse(estimate: &Gaussian) -> Area {
    let ring = estimate.ellipse(ELLIPSE.sqrt(), CORNERS);
    let ring: Ring = ring.into_iter().map(|p| p.map(to_millimetre)).collect();
    let [x, y] = estimate.mean.map(to_millimetre);
    Area {
        shapes: vec![vec![ring]],
        properties: properties(json!({
            "kind": "estimate", "target": 0, "mean": [x, y], "sigma_m": micro(estimate.sigma_m()),
        })),
    }
}
