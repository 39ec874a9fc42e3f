//! From metres to pixels, and small pieces of SVG.

use std::fmt::Write;

use svg::node::element::{Group, Path, Text};

use csat_mission::picture::Cells;
use csat_mission::picture::Ring;
use csat_mission::picture::Shapes;

/// A rectangle of the picture that shows a rectangle of the world, north up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Panel {
    /// Left edge, pixels.
    pub x: f64,
    /// Top edge, pixels.
    pub y: f64,
    /// Width, pixels.
    pub width: f64,
    /// Height, pixels.
    pub height: f64,
    /// Pixels per metre.
    pub scale: f64,
    /// World coordinates of the left and top edge, metres.
    pub north_west_m: [f64; 2],
}

impl Panel {
    /// A panel at (x, y), `width` pixels wide, that shows a region of `size_m` and a margin.
    pub fn new(x: f64, y: f64, width: f64, size_m: [f64; 2], margin_m: f64) -> Self {
        let [east, north] = size_m.map(|s| s + 2.0 * margin_m);
        let scale = width / east;
        Self { x, y, width, height: north * scale, scale, north_west_m: [-east / 2.0, north / 2.0] }
    }

    /// Pixels of a point of the world.
    pub fn pixel(&self, p: [f64; 2]) -> [f64; 2] {
        [
            self.x + (p[0] - self.north_west_m[0]) * self.scale,
            self.y + (self.north_west_m[1] - p[1]) * self.scale,
        ]
    }

    /// The path data of rings.
    pub fn rings<'a>(&self, rings: impl IntoIterator<Item = &'a Ring>) -> String {
        let mut data = String::new();
        for ring in rings {
            self.line_to(&mut data, ring);
            data.push('Z');
        }
        data
    }

    /// The path data of an open line.
    pub fn line(&self, points: &[[f64; 2]]) -> String {
        let mut data = String::new();
        self.line_to(&mut data, points);
        data
    }

    fn line_to(&self, data: &mut String, points: &[[f64; 2]]) {
        for (i, p) in points.iter().enumerate() {
            let [x, y] = self.pixel(*p);
            let command = if i == 0 { 'M' } else { 'L' };
            write!(data, "{command}{x:.1} {y:.1}").expect("text grows");
        }
    }

    /// A filled area.
    pub fn area(&self, shapes: &Shapes) -> Path {
        self.area_of(shapes.iter().flatten())
    }

    /// A filled area of rings.
    pub fn area_of<'a>(&self, rings: impl IntoIterator<Item = &'a Ring>) -> Path {
        Path::new().set("d", self.rings(rings)).set("fill-rule", "evenodd")
    }

    /// The cells of a raster, as one area of runs.
    pub fn cells(&self, cells: &Cells) -> Path {
        let mut data = String::new();
        for &[row, from, to] in &cells.runs {
            let corner = |column: u32, row: u32| {
                self.pixel([
                    cells.origin_m[0] + f64::from(column) * cells.cell_m,
                    cells.origin_m[1] + f64::from(row) * cells.cell_m,
                ])
            };
            let ([x0, y0], [x1, y1]) = (corner(from, row), corner(to, row.saturating_add(1)));
            write!(data, "M{x0:.1} {y0:.1}H{x1:.1}V{y1:.1}H{x0:.1}Z").expect("text grows");
        }
        Path::new().set("d", data)
    }
}

/// A group with a class that tests and people can find.
pub fn group(class: &str) -> Group {
    Group::new().set("class", class)
}

/// Text whose baseline starts at (x, y).
pub fn text(x: f64, y: f64, size: f64, content: impl Into<String>) -> Text {
    Text::new(content)
        .set("x", round(x))
        .set("y", round(y))
        .set("font-size", size)
        .set("fill", "#222222")
}

/// Text on a white halo, centred on x.
pub fn label(x: f64, y: f64, size: f64, colour: &str, content: impl Into<String>) -> Text {
    text(x, y, size, content)
        .set("text-anchor", "middle")
        .set("font-weight", "bold")
        .set("fill", colour)
        .set("stroke", "#ffffff")
        .set("stroke-width", 3)
        .set("stroke-linejoin", "round")
        .set("paint-order", "stroke")
}

/// A tenth of a pixel is enough.
pub fn round(pixels: f64) -> f64 {
    (pixels * 10.0).round() / 10.0
}
