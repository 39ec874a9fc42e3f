//! Pictures of the ground: roads, cells, densities and paths.

use std::fmt::Write;

use csat_mission::picture::{Cells, Heat};

use crate::report::shapes::escaped;
use crate::report::sheet::class;

/// How many shades there are.
const BANDS: u16 = 12;
/// Side of a picture, pixels.
const SIDE_PX: f64 = 520.0;
/// Room around it, pixels.
const ROOM_PX: f64 = 44.0;

/// A picture of a square of ground.
pub struct Map {
    /// What it shows.
    pub title: String,
    /// Its south-west corner, `world`, metres.
    pub origin_m: [f64; 2],
    /// Its side, metres.
    pub side_m: f64,
    /// What is drawn, in order.
    pub marks: Vec<Mark>,
}

/// What is drawn on a map.
pub enum Mark {
    /// Values of cells, the highest darkest.
    Heat(Heat),
    /// The centre line of a road, and its width, metres.
    Road(Vec<[f64; 2]>, f64),
    /// Cells in the colour of a series.
    Cells(Cells, usize),
    /// Cells in a colour, `#rrggbb`.
    Painted(Cells, String),
    /// A line through places, in the colour of a series.
    Path(Vec<[f64; 2]>, usize, Stroke),
    /// What a series is, where no ring says it.
    Key(usize, String),
    /// A closed ring, in the colour of a series, and what it is.
    Ring(Vec<[f64; 2]>, usize, String),
    /// Small dots.
    Dots(Vec<[f64; 2]>),
    /// A cross, in the colour of a series.
    Cross([f64; 2], usize),
    /// The true place of the target: a star.
    Star([f64; 2]),
}

/// How a path is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// A thin line.
    Thin,
    /// A line that stands out.
    Bold,
    /// A dashed line.
    Dashed,
}

impl Stroke {
    /// Its class in the style of pages.
    fn class(self) -> &'static str {
        match self {
            Self::Thin => "seed",
            Self::Bold => "mean",
            Self::Dashed => "dashed",
        }
    }
}

impl Map {
    /// The picture as SVG.
    pub fn svg(&self) -> String {
        let names: Vec<(usize, &String)> = self.marks.iter().filter_map(named).collect();
        let height = SIDE_PX + 2.0 * ROOM_PX + 16.0 * names.len() as f64;
        let width = SIDE_PX + 2.0 * ROOM_PX;
        let title = escaped(&self.title);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" role=\"img\">\n<title>{title}</title>\n\
             <text class=\"name\" x=\"{ROOM_PX}\" y=\"20\">{title}</text>\n"
        );
        self.marks.iter().for_each(|mark| self.mark(&mut svg, mark));
        let (low, high) = (ROOM_PX, ROOM_PX + SIDE_PX);
        let _ = writeln!(
            svg,
            "<g class=\"grid\"><path d=\"M{low} {low}H{high}V{high}H{low}Z\" fill=\"none\"/></g>"
        );
        self.ticks(&mut svg);
        for (index, (series, name)) in names.into_iter().enumerate() {
            let y = high + ROOM_PX + 16.0 * index as f64;
            let _ = writeln!(
                svg,
                "<g class=\"{}\"><path class=\"mean\" d=\"M{low} {y}h18\"/></g>\
                 <text x=\"{}\" y=\"{}\">{}</text>",
                class(series),
                low + 25.0,
                y + 4.0,
                escaped(name)
            );
        }
        svg + "</svg>\n"
    }

    fn at(&self, p: [f64; 2]) -> [f64; 2] {
        let scale = SIDE_PX / self.side_m;
        let x = ROOM_PX + (p[0] - self.origin_m[0]) * scale;
        [x, ROOM_PX + SIDE_PX - (p[1] - self.origin_m[1]) * scale]
    }

    fn ticks(&self, svg: &mut String) {
        let bottom = ROOM_PX + SIDE_PX + 14.0;
        for (share, anchor) in [(0.0, "start"), (0.5, "middle"), (1.0, "end")] {
            let x = ROOM_PX + share * SIDE_PX;
            let metres = self.origin_m[0] + share * self.side_m;
            let unit = if share == 1.0 { " m" } else { "" };
            let _ = writeln!(
                svg,
                "<text class=\"few\" x=\"{x}\" y=\"{bottom}\" text-anchor=\"{anchor}\">{metres:.0}{unit}</text>"
            );
            let y = ROOM_PX + (1.0 - share) * SIDE_PX + 4.0;
            let metres = self.origin_m[1] + share * self.side_m;
            let _ = writeln!(
                svg,
                "<text class=\"few\" x=\"{}\" y=\"{y}\" text-anchor=\"end\">{metres:.0}</text>",
                ROOM_PX - 3.0
            );
        }
    }

    fn mark(&self, svg: &mut String, mark: &Mark) {
        match mark {
            Mark::Heat(heat) => self.heat(svg, heat),
            Mark::Road(places, width_m) => {
                let width = width_m * SIDE_PX / self.side_m;
                let _ = writeln!(
                    svg,
                    "<path d=\"{}\" fill=\"none\" stroke=\"#888888\" stroke-opacity=\".3\" \
                     stroke-width=\"{width:.1}\" stroke-linejoin=\"round\"/>",
                    self.line(places)
                );
            }
            Mark::Cells(cells, series) => {
                let data = self.cells(cells);
                let class = class(*series);
                let _ =
                    writeln!(svg, "<g class=\"{class}\"><path class=\"run\" d=\"{data}\"/></g>");
            }
            Mark::Painted(cells, colour) => {
                let data = self.cells(cells);
                let _ = writeln!(svg, "<path d=\"{data}\" fill=\"{colour}\" stroke=\"none\"/>");
            }
            Mark::Path(places, series, stroke) => self.stroke(svg, places, *series, *stroke),
            Mark::Ring(places, series, _) => {
                let closed: Vec<[f64; 2]> = places.iter().chain(places.first()).copied().collect();
                self.stroke(svg, &closed, *series, Stroke::Bold);
            }
            Mark::Key(..) => {}
            Mark::Dots(places) => {
                for [x, y] in places.iter().filter(|p| self.holds(p)).map(|p| self.at(*p)) {
                    let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"0.8\"/>");
                }
            }
            Mark::Cross(place, series) => {
                let [x, y] = self.at(*place);
                let _ = writeln!(
                    svg,
                    "<g class=\"{}\"><path class=\"mean\" d=\"M{:.1} {y:.1}h10M{x:.1} {:.1}v10\"/></g>",
                    class(*series),
                    x - 5.0,
                    y - 5.0
                );
            }
            Mark::Star(place) => {
                let [x, y] = self.at(*place);
                let _ = writeln!(
                    svg,
                    "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" style=\"fill:#d7191c\">★</text>",
                    y + 5.0
                );
            }
        }
    }

    fn holds(&self, p: &[f64; 2]) -> bool {
        (0..2).all(|axis| (0.0..=self.side_m).contains(&(p[axis] - self.origin_m[axis])))
    }

    fn stroke(&self, svg: &mut String, places: &[[f64; 2]], series: usize, stroke: Stroke) {
        let (class, stroke, data) = (class(series), stroke.class(), self.line(places));
        let _ = writeln!(svg, "<g class=\"{class}\"><path class=\"{stroke}\" d=\"{data}\"/></g>");
    }

    /// The parts of a line that are on the map.
    fn line(&self, places: &[[f64; 2]]) -> String {
        let mut data = String::new();
        let mut end = None;
        for ends in places.windows(2) {
            let Some([from, to]) = self.clipped([ends[0], ends[1]]) else { continue };
            let [[x0, y0], [x1, y1]] = [from, to].map(|place| self.at(place));
            if end != Some(from) {
                let _ = write!(data, "M{x0:.1} {y0:.1}");
            }
            let _ = write!(data, "L{x1:.1} {y1:.1}");
            end = Some(to);
        }
        data
    }

    /// The part of a segment that is on the map.
    fn clipped(&self, [a, b]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
        let (mut first, mut last) = (0.0f64, 1.0f64);
        for axis in 0..2 {
            let (start, way) = (a[axis] - self.origin_m[axis], b[axis] - a[axis]);
            if way == 0.0 {
                if !(0.0..=self.side_m).contains(&start) {
                    return None;
                }
                continue;
            }
            let (low, high) = (-start / way, (self.side_m - start) / way);
            (first, last) = (first.max(low.min(high)), last.min(low.max(high)));
        }
        let at = |t: f64| match t {
            0.0 => a,
            1.0 => b,
            _ => [0, 1].map(|axis| a[axis] + t * (b[axis] - a[axis])),
        };
        (first <= last).then(|| [at(first), at(last)])
    }

    /// The outlines of the cells that are on the map.
    fn cells(&self, cells: &Cells) -> String {
        let mut data = String::new();
        for ring in cells.rings() {
            let ([x0, y1], [x1, y0]) = (self.at(ring[0]), self.at(ring[2]));
            let (low, high) = (ROOM_PX, ROOM_PX + SIDE_PX);
            let [x0, x1, y0, y1] = [x0, x1, y0, y1].map(|value| value.clamp(low, high));
            if x1 > x0 && y1 > y0 {
                let _ = write!(data, "M{x0:.1} {y0:.1}H{x1:.1}V{y1:.1}H{x0:.1}Z");
            }
        }
        data
    }

    fn heat(&self, svg: &mut String, heat: &Heat) {
        for (band, cells) in (1..).zip(heat.bands(BANDS)) {
            let data = self.cells(&cells);
            let opacity = f64::from(band) / f64::from(BANDS);
            let _ = writeln!(
                svg,
                "<path d=\"{data}\" fill=\"#5e3c99\" fill-opacity=\"{opacity:.2}\" stroke=\"none\"/>"
            );
        }
    }
}

fn named(mark: &Mark) -> Option<(usize, &String)> {
    match mark {
        Mark::Ring(_, series, name) | Mark::Key(series, name) => Some((*series, name)),
        _ => None,
    }
}
