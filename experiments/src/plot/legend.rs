//! The legend of `map.svg`.

use svg::node::element::{Circle, Group, Line, Path, Rectangle};

use super::canvas::{group, round, text};
use super::{layers, uav_colour};
use crate::view::View;

/// Height of the legend, pixels.
pub const HEIGHT_PX: f64 = ROW_PX * 10.0;
const ROW_PX: f64 = 21.0;

/// The legend with its top left corner at (x, y): of a map of what one agent knows, or without the
/// scale of heights, which is each agent's own, of the maps of all.
pub fn legend(x: f64, y: f64, view: &View, agent: Option<usize>) -> Group {
    let box_at = |row: f64| {
        Rectangle::new()
            .set("x", round(x))
            .set("y", round(y + row * ROW_PX + 3.0))
            .set("width", 22)
            .set("height", 13)
    };
    let say = |row: f64, words: &str| text(x + 32.0, y + row * ROW_PX + 14.0, 13.0, words);
    let line = |row: f64| {
        let middle = round(y + row * ROW_PX + 9.5);
        Line::new()
            .set("x1", round(x))
            .set("x2", round(x + 22.0))
            .set("y1", middle)
            .set("y2", middle)
    };
    let filled = [
        ("X̄ unexplored: other cars can only be here", layers::UNEXPLORED, "#B79F00"),
        ("Xⱼ: the identified car j is in it", layers::TARGET_SET, "#00573F"),
        ("ground hidden and not seen since", "url(#hatch-hidden)", "none"),
        ("X° obstacle margin: no car can be here", "url(#hatch-margin)", "#000000"),
        ("building, darker when higher", layers::BUILDING, "#4A4A4A"),
    ];
    let mut legend = group("legend");
    for (row, (words, fill, stroke)) in filled.into_iter().enumerate() {
        let sample = box_at(row as f64).set("fill", fill).set("stroke", stroke);
        legend = legend.add(sample).add(say(row as f64, words));
    }
    let colour = uav_colour(0);
    let start = Circle::new()
        .set("cx", round(x))
        .set("cy", round(y + 6.0 * ROW_PX + 9.5))
        .set("r", 3.5)
        .set("fill", "#ffffff")
        .set("stroke", colour);
    let track = line(5.0).set("stroke", "#000000").set("stroke-opacity", layers::TRACK_OPACITY);
    let of = agent.map_or_else(|| "the agent".to_owned(), |agent| view.name_of(agent));
    let cars = format!("cars, known to {of} and not; their tracks");
    let unseen = box_at(9.0).set("fill", "#ffffff").set("stroke", "#4A4A4A");
    if !view.stations.is_empty() {
        let middle = y + 7.0 * ROW_PX + 9.5;
        legend = legend
            .add(layers::mast([x + 167.0, middle], uav_colour(view.uavs.len())))
            .add(text(x + 180.0, middle + 4.5, 13.0, "ground station"));
    }
    legend = legend
        .add(track)
        .add(car(x + 4.0, y + 5.0 * ROW_PX + 9.5, "#000000", "#ffffff"))
        .add(car(x + 17.0, y + 5.0 * ROW_PX + 9.5, "#ffffff", "#000000"))
        .add(say(5.0, &cars))
        .add(line(6.0).set("stroke", colour).set("stroke-width", 1.8))
        .add(start)
        .add(say(6.0, "path of a UAV from its start"))
        .add(
            line(7.0).set("stroke", colour).set("stroke-dasharray", "6 4").set("stroke-width", 1.3),
        )
        .add(say(7.0, "its footprint now"));
    let Some(agent) = agent else {
        let outline = box_at(8.0).set("fill", "none").set("stroke", layers::OEM);
        return legend.add(outline).add(say(8.0, "building as known (OEM)"));
    };
    legend
        .add(heights(x, y + 8.0 * ROW_PX, view, agent))
        .add(unseen)
        .add(say(9.0, "white in the OEM: not seen yet"))
}

fn car(x: f64, y: f64, fill: &str, stroke: &str) -> Rectangle {
    Rectangle::new()
        .set("x", round(x - 3.5))
        .set("y", round(y - 3.5))
        .set("width", 7)
        .set("height", 7)
        .set("fill", fill)
        .set("stroke", stroke)
}

/// The colours of the OEM: empty, then bands of height.
fn heights(x: f64, y: f64, view: &View, agent: usize) -> Group {
    let oem = view.agents.get(agent).map(|a| &a.oem);
    let Some(bands) = oem.map(layers::height_bands) else { return group("heights") };
    let square =
        |at: f64| Path::new().set("d", format!("M{:.1} {:.1}h14v13h-14Z", x + at, y + 3.0));
    let mut row = group("heights").add(square(0.0).set("fill", "#D7E8F3")).add(text(
        x + 18.0,
        y + 14.0,
        11.0,
        "OEM: empty",
    ));
    for band in 0..layers::BANDS {
        let share = f64::from(band) / f64::from(layers::BANDS - 1);
        let at = 88.0 + 50.0 * f64::from(band);
        let sample =
            square(at).set("fill", layers::OEM).set("fill-opacity", round(0.2 + 0.8 * share));
        let words = format!("≤{:.0} m", bands.upper_m(band));
        row = row.add(sample).add(text(x + at + 17.0, y + 14.0, 9.0, words));
    }
    row
}
