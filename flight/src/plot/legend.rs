//! The legend of maps: the layers of the mission, then what is the same for all missions.

use svg::Node;
use svg::node::element::{Circle, Group, Line, Path, Rectangle};

use super::canvas::{group, round, text};
use super::colours::uav_colour;
use super::{layers, town};
use crate::view::View;
use csat_mission::picture::{Layer, Properties};
use csat_mission::style::{Form, Style};

const ROW_PX: f64 = 21.0;

/// A legend in the making.
struct Legend {
    all: Group,
    x: f64,
    /// Where the next row begins.
    y: f64,
}

/// Height of the legend, pixels; `agent` as for [`legend`].
pub fn height_px(view: &View, agent: Option<usize>) -> f64 {
    let scales = view.layers.iter().filter(|style| agent.is_some() && has_scale(style));
    let building = usize::from(!view.obstacles.is_empty());
    ROW_PX * (view.layers.len() + scales.count() + building + 3) as f64
}

/// The legend with its top left corner at (x, y): of a map of what one agent knows, or without the
/// scales of heights and values, which are each agent's own, of the maps of all.
pub fn legend(x: f64, y: f64, view: &View, agent: Option<usize>) -> Group {
    let mut legend = Legend { all: group("legend"), x, y };
    for style in &view.layers {
        legend.layer(style);
        let layers = agent.map(|agent| view.of_agent(agent));
        if let Some(layers) = layers.filter(|_| has_scale(style)) {
            legend.scale(style, Layer::of(layers, style));
        }
    }
    if !view.obstacles.is_empty() {
        legend.building();
    }
    if !view.targets.is_empty() {
        legend.cars(&agent.map_or_else(|| "the agent".to_owned(), |agent| view.name_of(agent)));
    }
    legend.fleet(view);
    legend.all
}

fn has_scale(style: &Style) -> bool {
    matches!(style.kind, Form::Heights | Form::Heat)
}

impl Legend {
    fn building(&mut self) {
        let sample = self.sample().set("fill", town::BUILDING).set("stroke", town::BUILDING_EDGE);
        self.row(sample, "building, darker when higher");
    }

    /// The outline of a sample in the next row.
    fn sample(&self) -> Path {
        let (x, y) = (round(self.x), round(self.y + 3.0));
        Path::new().set("d", format!("M{x} {y}h22v13h-22Z"))
    }

    fn line(&self) -> Line {
        let middle = self.middle();
        let (from, to) = (round(self.x), round(self.x + 22.0));
        Line::new().set("x1", from).set("x2", to).set("y1", middle).set("y2", middle)
    }

    fn middle(&self) -> f64 {
        round(self.y + 9.5)
    }

    fn add(&mut self, node: impl Into<Box<dyn Node>>) {
        self.all.append(node);
    }

    /// Adds a sample and its meaning, and goes on to the next row.
    fn row(&mut self, sample: impl Into<Box<dyn Node>>, words: &str) {
        self.add(sample);
        self.add(text(self.x + 32.0, self.y + 14.0, 13.0, words));
        self.y += ROW_PX;
    }

    fn layer(&mut self, style: &Style) {
        let none = Properties::new();
        let sample = self.sample();
        match style.kind {
            Form::Areas | Form::Cells => {
                self.row(layers::painted(style, &none, sample), &style.title)
            }
            Form::Heights => {
                let colour = layers::colour_of(&style.colour, &none);
                self.row(sample.set("fill", "none").set("stroke", colour), &style.title);
            }
            Form::Heat => {
                let unit = style.unit.as_ref().map(|unit| format!(", {unit}")).unwrap_or_default();
                self.row(layers::value(style, 1.0, sample), &format!("{}{unit}", style.title));
            }
            Form::Points => {
                let middle = [self.x + 11.0, self.middle()];
                self.row(layers::point(style, &none, middle), &style.title);
            }
        }
    }

    /// The colours of heights or values: of cells that were not seen and that are empty, then of bands.
    fn scale(&mut self, style: &Style, layer: Option<&Layer>) {
        let Some(ends) = layer.and_then(|layer| layers::scale(&layer.content)) else {
            self.y += ROW_PX;
            return;
        };
        let (x, y) = (self.x, self.y);
        let square =
            |at: f64| Path::new().set("d", format!("M{:.1} {:.1}h14v13h-14Z", x + at, y + 3.0));
        let say = |at: f64, words: &str| text(x + at + 17.0, y + 14.0, 9.0, words);
        let unseen = square(0.0).set("fill", "#ffffff").set("stroke", town::BUILDING_EDGE);
        let mut row = group("heights");
        let mut at = 0.0;
        if style.kind == Form::Heights {
            let empty = square(62.0).set("fill", layers::EMPTY);
            row = row.add(unseen).add(say(0.0, "not seen")).add(empty).add(say(62.0, "empty"));
            at = 112.0;
        }
        for (band, end) in ends.iter().enumerate() {
            let share = band as f64 / f64::from(layers::BANDS - 1);
            row = row.add(layers::value(style, share, square(at))).add(say(at, end));
            at += 44.0;
        }
        self.add(row);
        self.y += ROW_PX;
    }

    fn cars(&mut self, agent: &str) {
        let track = self.line().set("stroke", "#000000");
        self.add(track.set("stroke-opacity", town::TRACK_OPACITY));
        self.add(car(self.x + 4.0, self.middle(), "#000000", "#ffffff"));
        let unknown = car(self.x + 17.0, self.middle(), "#ffffff", "#000000");
        self.row(unknown, &format!("cars, known to {agent} and not; their tracks"));
    }

    fn fleet(&mut self, view: &View) {
        let colour = uav_colour(0);
        self.add(self.line().set("stroke", colour).set("stroke-width", 1.8));
        let start = Circle::new().set("cx", round(self.x)).set("cy", self.middle()).set("r", 3.5);
        let start = start.set("fill", "#ffffff").set("stroke", colour);
        self.row(start, "path of a UAV from its start");
        if !view.stations.is_empty() {
            let (x, middle) = (self.x, self.middle());
            self.add(town::mast([x + 167.0, middle], uav_colour(view.uavs.len())));
            self.add(text(x + 180.0, middle + 4.5, 13.0, "ground station"));
        }
        let line = self.line().set("stroke", colour).set("stroke-dasharray", "6 4");
        self.row(line.set("stroke-width", 1.3), "its footprint now");
    }
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
