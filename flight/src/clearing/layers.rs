//! What is drawn of an agent of road clearing.

use std::borrow::Cow;

use csat_clearing::agent::Role;
use csat_clearing::bitmap::Bitmap;
use csat_mission::picture::{Area, Cells, Content, Layer, Ring, properties, to_millimetre};
use csat_mission::style::{Colour, Fill, Form, Line, Style};
use csat_proto::camera::CameraModel;
use csat_world::contamination::Square;
use serde_json::json;

use super::report::Report;

/// Half the width of the mark of a UAV that is no cleaner, metres.
const MARK_M: f64 = 7.0;

const fn style(
    [key, title, colour]: [&'static str; 3],
    kind: Form,
    fill: Fill,
    line_px: Option<f64>,
) -> Style {
    Style {
        key: Cow::Borrowed(key),
        title: Cow::Borrowed(title),
        kind,
        colour: Colour::fixed(colour),
        fill,
        line: match line_px {
            Some(width_px) => Some(Line::fixed(colour, width_px)),
            None => None,
        },
        label: None,
        mark: None,
        unit: None,
        panel: None,
        is_ground: true,
        is_in_scene: true,
    }
}

const fn cells(names: [&'static str; 3], fill: Fill) -> Style {
    style(names, Form::Cells, fill, None)
}

const fn role(names: [&'static str; 3], opacity: f64) -> Style {
    style(names, Form::Areas, Fill::Plain { opacity }, Some(1.6))
}

const PLAIN: Fill = Fill::Plain { opacity: 0.85 };

/// The layers, from the bottom up.
pub const LAYERS: &[Style] = &[
    cells(["cleared", "road that it has cleared so far", "#1b7837"], PLAIN),
    cells(["foreign", "road that others have cleared", "#a6dba0"], PLAIN),
    cells(["unknown", "road that is not known to be cleared", "#b2182b"], PLAIN),
    cells(["frontier", "its frontier", "#ffd92f"], Fill::Plain { opacity: 1.0 }),
    role(["cleaner", "image of a cleaner", "#d7191c"], 0.06),
    role(["wing", "wing (diamond)", "#f28e2b"], 0.5),
    role(["tail", "tail (triangle)", "#2ca25f"], 0.5),
    role(["helper", "helper (octagon)", "#2b6cb0"], 0.5),
];

/// What there is to draw of a report: `foreign`, `unknown` and `frontier` only where it has its maps.
pub(super) fn picture(camera: &CameraModel, report: &Report) -> Vec<Layer> {
    let square = Square::of_image(camera, &report.pose);
    let mut layers = Vec::new();
    let mut masks = Vec::new();
    if let Some(maps) = &report.maps {
        layers.push(Layer::new("cleared", Content::Cells(maps.trail.clone())));
        masks = vec![
            ("foreign", &maps.foreign),
            ("unknown", &maps.unknown),
            ("frontier", &maps.frontier),
        ];
    }
    for (key, mask) in masks {
        layers.push(Layer::new(key, Content::Cells(on_ground(&square, mask))));
    }
    if let Some(key) = layer_of(report.role) {
        let area = Area {
            shapes: vec![vec![outline(report.role, &square)]],
            properties: properties(json!({
                "kind": report.role.name(), "agent": report.agent, "stalled": report.is_stalled,
                "lost": report.is_lost,
            })),
        };
        layers.push(Layer::new(key, Content::Areas(vec![area])));
    }
    layers
}

/// The layer of a role; a ground station has none.
fn layer_of(role: Role) -> Option<&'static str> {
    match role {
        Role::Cleaner => Some("cleaner"),
        Role::LeftWing | Role::RightWing => Some("wing"),
        Role::Tail => Some("tail"),
        Role::Helper => Some("helper"),
        Role::Station => None,
    }
}

/// The image of a cleaner, or a mark in the middle of that of another UAV.
fn outline(role: Role, square: &Square) -> Ring {
    let corners: &[[f64; 2]] = match role {
        Role::Cleaner => &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
        Role::LeftWing | Role::RightWing => &[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]],
        Role::Tail => &[[-1.0, -0.8], [1.0, -0.8], [0.0, 1.0]],
        Role::Helper | Role::Station => &[
            [0.4, -1.0],
            [1.0, -0.4],
            [1.0, 0.4],
            [0.4, 1.0],
            [-0.4, 1.0],
            [-1.0, 0.4],
            [-1.0, -0.4],
            [-0.4, -1.0],
        ],
    };
    let half_m = if role == Role::Cleaner { square.side_m / 2.0 } else { MARK_M };
    let at = |corner: &[f64; 2]| {
        [0, 1].map(|axis| to_millimetre(square.middle[axis] + half_m * corner[axis]))
    };
    corners.iter().map(at).collect()
}

/// The pixels of a mask, on the ground.
fn on_ground(square: &Square, mask: &Bitmap) -> Cells {
    let cell_m = square.side_m / f64::from(mask.columns());
    let origin_m = square.middle.map(|middle| to_millimetre(middle - square.side_m / 2.0));
    let place = |[row, column]: [u16; 2]| (column.into(), (mask.rows() - 1 - row).into());
    let mut cells = Cells::of(cell_m, origin_m, mask.pixels().map(place));
    cells.runs.sort_unstable();
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_row_of_a_mask_is_north() {
        let mut mask = Bitmap::new(4, 4);
        mask.set(0, 1);
        mask.set(0, 2);
        mask.set(3, 3);
        let cells = on_ground(&Square { middle: [10.0, 20.0], side_m: 8.0 }, &mask);
        assert_eq!((cells.cell_m, cells.origin_m), (2.0, [6.0, 16.0]));
        assert_eq!(cells.runs, [[0, 3, 4], [3, 1, 3]]);
    }
}
