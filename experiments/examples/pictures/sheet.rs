//! A white sheet with windows onto the world, and a line of explanations.

use csat_experiments::plot::canvas::{Panel, group, round, text};
use csat_experiments::plot::layers;
use csat_experiments::set_membership::layers as known;
use svg::Document;
use svg::node::Node;
use svg::node::element::{ClipPath, Group, Path, Rectangle};

/// Room around everything, pixels.
pub const GAP_PX: f64 = 20.0;
const TITLE_PX: f64 = 26.0;
const KEY_PX: f64 = 24.0;

/// How an area is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// Colour, `none` or `url(#…)`.
    pub fill: &'static str,
    /// 0 to 1.
    pub opacity: f64,
    /// Colour or `none`.
    pub stroke: &'static str,
    /// Pixels.
    pub width: f64,
    /// As SVG's `stroke-dasharray`.
    pub dashes: &'static str,
}

impl Style {
    /// An area without an outline.
    pub const fn fill(fill: &'static str, opacity: f64) -> Self {
        Self { fill, opacity, stroke: "none", width: 0.0, dashes: "none" }
    }

    /// An outline.
    pub const fn line(stroke: &'static str, width: f64) -> Self {
        Self { fill: "none", opacity: 1.0, stroke, width, dashes: "none" }
    }

    /// The same with an outline.
    pub const fn outlined(self, stroke: &'static str, width: f64) -> Self {
        Self { stroke, width, ..self }
    }

    /// The same, dashed.
    pub const fn dashed(self, dashes: &'static str) -> Self {
        Self { dashes, ..self }
    }

    /// A path in this style.
    pub fn on(&self, path: Path) -> Path {
        path.set("fill", self.fill)
            .set("fill-opacity", self.opacity)
            .set("stroke", self.stroke)
            .set("stroke-width", self.width)
            .set("stroke-dasharray", self.dashes)
            .set("stroke-linejoin", "round")
    }
}

/// A picture that grows.
pub struct Sheet {
    width: f64,
    height: f64,
    body: Group,
    clips: Vec<Panel>,
}

impl Sheet {
    /// An empty sheet, `width` pixels wide.
    pub fn new(width: f64) -> Self {
        Self { width, height: 0.0, body: group("sheet"), clips: Vec::new() }
    }

    /// The width that each of `count` windows side by side has, pixels.
    pub fn share(&self, count: usize) -> f64 {
        (self.width - GAP_PX) / count as f64 - GAP_PX
    }

    /// Adds anything that ends at `bottom`, pixels.
    pub fn add(&mut self, node: impl Into<Box<dyn Node>>, bottom: f64) {
        self.body.append(node);
        self.height = self.height.max(bottom);
    }

    /// Adds a window at column `column` of columns `width_px` wide.
    pub fn window(
        &mut self,
        (column, width_px): (usize, f64),
        title: &str,
        place: ([f64; 2], [f64; 2]),
        draw: impl FnOnce(&Panel) -> Group,
    ) {
        let x = GAP_PX + column as f64 * (width_px + GAP_PX);
        self.window_at(x, width_px, title, place, draw);
    }

    /// Adds a window from `x` on, `width_px` wide, with what `draw` puts into it. It shows `size_m` of
    /// the world around `centre`.
    pub fn window_at(
        &mut self,
        x: f64,
        width_px: f64,
        title: &str,
        (centre, size_m): ([f64; 2], [f64; 2]),
        draw: impl FnOnce(&Panel) -> Group,
    ) {
        let scale = width_px / size_m[0];
        let panel = Panel {
            x,
            y: TITLE_PX + GAP_PX / 2.0,
            width: width_px,
            height: size_m[1] * scale,
            scale,
            north_west_m: [centre[0] - size_m[0] / 2.0, centre[1] + size_m[1] / 2.0],
        };
        let clip = format!("url(#window-{})", self.clips.len());
        let border = frame_of(&panel).set("fill", "none").set("stroke", "#333333");
        self.body.append(text(x, TITLE_PX - 2.0, 14.0, title).set("font-weight", "bold"));
        self.body.append(draw(&panel).set("clip-path", clip));
        self.body.append(border);
        self.body.append(scale_bar(&panel));
        self.height = self.height.max(panel.y + panel.height);
        self.clips.push(panel);
    }

    /// Adds the explanations, as many in a row as fit.
    pub fn key(&mut self, entries: &[(Style, &str)]) {
        let (mut x, mut y) = (GAP_PX, self.height + KEY_PX);
        for (style, words) in entries {
            let needed = 34.0 + 6.6 * words.chars().count() as f64;
            if x + needed > self.width && x > GAP_PX {
                (x, y) = (GAP_PX, y + KEY_PX);
            }
            let swatch = Path::new().set("d", format!("M{x} {}h20v-12h-20Z", round(y + 1.0)));
            self.body.append(style.on(swatch));
            self.body.append(text(x + 26.0, y, 12.5, *words));
            x = round(x + needed + 14.0);
        }
        self.height = y;
    }

    /// The SVG.
    pub fn finish(self) -> String {
        let (width, height) = (round(self.width), round(self.height + GAP_PX / 1.5));
        let mut definitions = layers::hatches(known::LAYERS);
        for (index, panel) in self.clips.iter().enumerate() {
            let id = format!("window-{index}");
            definitions.append(ClipPath::new().set("id", id).add(frame_of(panel)));
        }
        let background =
            Rectangle::new().set("width", width).set("height", height).set("fill", "#ffffff");
        let document = Document::new()
            .set("viewBox", (0, 0, width, height))
            .set("width", width)
            .set("height", height)
            .set("font-family", "Helvetica, Arial, 'DejaVu Sans', sans-serif")
            .add(definitions)
            .add(background)
            .add(self.body);
        document.to_string() + "\n"
    }
}

fn frame_of(panel: &Panel) -> Rectangle {
    Rectangle::new()
        .set("x", round(panel.x))
        .set("y", round(panel.y))
        .set("width", round(panel.width))
        .set("height", round(panel.height))
}

/// About a quarter of a window, in 1, 2 or 5 times a power of ten, inside its lower left corner.
fn scale_bar(panel: &Panel) -> Group {
    let wanted = panel.width / panel.scale / 4.0;
    let power = 10f64.powf(wanted.log10().floor());
    let length_m =
        [5.0, 2.0, 1.0].iter().map(|f| f * power).find(|l| *l <= wanted).unwrap_or(power);
    let (x, y) = (panel.x + 8.0, panel.y + panel.height - 8.0);
    let length = round(length_m * panel.scale);
    let back = Rectangle::new()
        .set("x", round(panel.x + 3.0))
        .set("y", round(y - 9.0))
        .set("width", round(length + 52.0))
        .set("height", 14)
        .set("fill", "#ffffff")
        .set("fill-opacity", 0.85);
    let bar = Path::new()
        .set("d", format!("M{} {}h{length}v-4h-{length}Z", round(x), round(y)))
        .set("fill", "#222222");
    group("scale").add(back).add(bar).add(text(
        x + length + 5.0,
        y + 1.0,
        11.0,
        format!("{length_m} m"),
    ))
}
