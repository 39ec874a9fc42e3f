//! What is drawn of an agent of the set-membership mission.

use std::borrow::Cow;

use csat_proto::model::Ground;
use csat_proto::region::Region;
use serde_json::{Value, json};

use super::report::{Report, percent_of};
use crate::rounding;
use csat_mission::documents::micro;
use csat_mission::picture::{self, Area, Content, Layer, Properties, Shapes, to_millimetre};
use csat_mission::style::{Colour, Fill, Form, Line, Style};

/// The colour of X̄ in the thesis's figures.
pub const UNEXPLORED: &str = "#F5DF4D";
/// The colour of the outline of X̄.
pub const UNEXPLORED_EDGE: &str = "#B79F00";
/// The colour of X_j.
pub const TARGET_SET: &str = "#009E73";
/// The colour of the outline of X_j.
pub const TARGET_EDGE: &str = "#00573F";
/// The colour of the OEM.
pub const OEM: &str = "#B2182B";
/// The colour of X^h.
pub const HIDDEN: &str = "#1F5FBF";

/// The title of the small map of X̄ and X^h.
const GROUND_PANEL: Option<Cow<'static, str>> =
    Some(Cow::Borrowed("Unexplored ground and its hidden part"));

/// The layers, from the bottom up.
pub const LAYERS: &[Style] = &[
    Style {
        key: Cow::Borrowed("unexplored"),
        title: Cow::Borrowed("X̄ unexplored: other cars can only be here"),
        kind: Form::Areas,
        colour: Colour::fixed(UNEXPLORED),
        fill: Fill::Plain { opacity: 0.85 },
        line: Some(Line::fixed(UNEXPLORED_EDGE, 0.6)),
        label: None,
        mark: None,
        unit: None,
        panel: GROUND_PANEL,
        is_ground: true,
        is_in_scene: true,
    },
    Style {
        key: Cow::Borrowed("hidden"),
        title: Cow::Borrowed("ground hidden and not seen since"),
        kind: Form::Cells,
        colour: Colour::fixed(HIDDEN),
        fill: Fill::Hatch { spacing_px: 5.0, width_px: 1.7, is_falling: false },
        line: None,
        label: None,
        mark: None,
        unit: None,
        panel: GROUND_PANEL,
        is_ground: true,
        is_in_scene: false,
    },
    Style {
        key: Cow::Borrowed("obstacles"),
        title: Cow::Borrowed("X° obstacle margin: no car can be here"),
        kind: Form::Areas,
        colour: Colour::fixed("#000000"),
        fill: Fill::Hatch { spacing_px: 3.0, width_px: 0.9, is_falling: true },
        line: Some(Line::fixed("#000000", 0.7)),
        label: None,
        mark: None,
        unit: None,
        panel: None,
        is_ground: false,
        is_in_scene: false,
    },
    Style {
        key: Cow::Borrowed("oem"),
        title: Cow::Borrowed("buildings as known (OEM)"),
        kind: Form::Heights,
        colour: Colour::fixed(OEM),
        fill: Fill::None,
        line: None,
        label: None,
        mark: None,
        unit: None,
        panel: Some(Cow::Borrowed("Occupancy-elevation map (OEM)")),
        is_ground: false,
        is_in_scene: false,
    },
    Style {
        key: Cow::Borrowed("targets"),
        title: Cow::Borrowed("Xⱼ: the identified car j is in it"),
        kind: Form::Areas,
        colour: Colour::fixed(TARGET_SET),
        fill: Fill::Plain { opacity: 0.6 },
        line: Some(Line::fixed(TARGET_EDGE, 1.0)),
        label: Some(Cow::Borrowed("target")),
        mark: Some(Cow::Borrowed("detected")),
        unit: None,
        panel: None,
        is_ground: false,
        is_in_scene: true,
    },
];

/// What there is to draw of a report: `hidden` and `oem` only where it has its maps.
pub(super) fn picture(ground: &Ground, report: &Report) -> Vec<Layer> {
    let mut layers = vec![
        Layer::new("unexplored", Content::Areas(vec![unexplored(ground, &report.unexplored)])),
        Layer::new("obstacles", Content::Areas(vec![obstacles(&report.obstacle_margin)])),
        Layer::new("targets", Content::Areas(targets(ground, report))),
    ];
    if let Some(maps) = &report.maps {
        let oem = picture::oem(&maps.oem_grid, &maps.oem_cells());
        layers.push(Layer::new("hidden", Content::Cells(picture::cells(&maps.hidden))));
        layers.push(Layer::new("oem", Content::Heights(oem)));
    }
    layers
}

fn unexplored(ground: &Ground, set: &Region) -> Area {
    let share_pct = micro(percent_of(ground, set.area_m2()));
    let properties = json!({ "kind": "unexplored", "share_pct": share_pct });
    area(rounding::outer(set, ground), set, properties)
}

fn obstacles(set: &Region) -> Area {
    area(rounding::inner(set), set, json!({ "kind": "obstacles" }))
}

fn targets(ground: &Ground, report: &Report) -> Vec<Area> {
    let target = |(target, set): &(_, Region)| {
        let detected = report.detected.contains(target);
        let properties = json!({ "kind": "target", "target": target, "detected": detected });
        area(rounding::outer(set, ground), set, properties)
    };
    report.targets.iter().map(target).collect()
}

/// An area with the members of a JSON object and with the size of the set that it shows.
fn area(shapes: Shapes, set: &Region, members: Value) -> Area {
    let Value::Object(mut properties) = members else { return Area::default() };
    properties.insert("area_m2".to_owned(), to_millimetre(set.area_m2()).into());
    Area { shapes, properties: Properties::from_iter(properties) }
}
