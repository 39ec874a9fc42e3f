//! What is drawn of an agent of the census.

use std::borrow::Cow;

use csat_mission::picture::{Content, Heat, Layer, Mark};
use csat_mission::style::{Colour, Fill, Form, Style};
use serde_json::{Map, json};

use crate::agent::{Count, Looks};

/// The layers, from the bottom up.
pub const LAYERS: &[Style] = &[
    Style {
        key: Cow::Borrowed("looks"),
        title: Cow::Borrowed("how often the UAV looked at the ground"),
        kind: Form::Heat,
        colour: Colour::fixed("#0072b2"),
        fill: Fill::Plain { opacity: 0.7 },
        line: None,
        label: None,
        mark: None,
        unit: Some(Cow::Borrowed("frames")),
        panel: None,
        is_ground: true,
        is_in_scene: false,
    },
    Style {
        key: Cow::Borrowed("cars"),
        title: Cow::Borrowed("cars where they were counted"),
        kind: Form::Points,
        colour: Colour::fixed("#d55e00"),
        fill: Fill::Plain { opacity: 0.9 },
        line: None,
        label: Some(Cow::Borrowed("target")),
        mark: None,
        unit: None,
        panel: None,
        is_ground: false,
        is_in_scene: true,
    },
];

/// What there is to draw of a report.
pub fn layers(report: &Count) -> Vec<Layer> {
    let cars = report.sightings.iter().map(|(target, sighting)| Mark {
        point: sighting.location,
        properties: Map::from_iter([
            ("kind".to_owned(), json!("car")),
            ("target".to_owned(), json!(target)),
            ("by".to_owned(), json!(sighting.by)),
        ]),
    });
    let cars = Layer::new("cars", Content::Points(cars.collect()));
    let looks = report.looks.iter().map(|looks| Layer::new("looks", Content::Heat(heat(looks))));
    looks.chain([cars]).collect()
}

fn heat(Looks { grid, frames }: &Looks) -> Heat {
    Heat {
        cell_m: grid.cell_m,
        origin_m: grid.origin(),
        columns: grid.columns,
        maximum: frames.iter().copied().max().map_or(0.0, f64::from),
        values: frames.iter().copied().map(f64::from).collect(),
    }
}
