//! Pictures of densities on the ground.

use std::fmt::Write;

use csat_mission::picture::Heat;

use crate::report::shapes::escaped;

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
    /// A line through places, in the colour of a series.
    Path(Vec<[f64; 2]>, usize),
    /// A closed ring, in the colour of a series, and what it is.
    Ring(Vec<[f64; 2]>, usize, String),
    /// Small dots.
    Dots(Vec<[f64; 2]>),
    /// A cross, in the colour of a series.
    Cross([f64; 2], usize),
    /// The true place of the target: a star.
    Star([f64; 2]),
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
                "<g class=\"s{series}\"><path class=\"mean\" d=\"M{low} {y}h18\"/></g>\
                 <text x=\"{}\" y=\"{}\">{}</text>",
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
            Mark::Path(places, series) => {
                let _ = writeln!(
                    svg,
                    "<g class=\"s{series}\"><path class=\"seed\" d=\"{}\"/></g>",
                    self.line(places)
                );
            }
            Mark::Ring(places, series, _) => {
                let _ = writeln!(
                    svg,
                    "<g class=\"s{series}\"><path class=\"mean\" d=\"{}Z\"/></g>",
                    self.line(places)
                );
            }
            Mark::Dots(places) => {
                for [x, y] in places.iter().filter(|p| self.holds(p)).map(|p| self.at(*p)) {
                    let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"0.8\"/>");
                }
            }
            Mark::Cross(place, series) => {
                let [x, y] = self.at(*place);
                let _ = writeln!(
                    svg,
                    "<g class=\"s{series}\"><path class=\"mean\" d=\"M{:.1} {y:.1}h10M{x:.1} {:.1}v10\"/></g>",
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

    /// The parts of a line that are on the map.
    fn line(&self, places: &[[f64; 2]]) -> String {
        let mut data = String::new();
        let mut is_on = false;
        for place in places {
            let was_on = std::mem::replace(&mut is_on, self.holds(place));
            if is_on {
                let [x, y] = self.at(*place);
                let _ = write!(data, "{}{x:.1} {y:.1}", if was_on { 'L' } else { 'M' });
            }
        }
        data
    }

    fn heat(&self, svg: &mut String, heat: &Heat) {
        for (band, cells) in (1..).zip(heat.bands(BANDS)) {
            let mut data = String::new();
            for ring in cells.rings() {
                let ([x0, y1], [x1, y0]) = (self.at(ring[0]), self.at(ring[2]));
                let (low, high) = (ROOM_PX, ROOM_PX + SIDE_PX);
                let [x0, x1, y0, y1] = [x0, x1, y0, y1].map(|value| value.clamp(low, high));
                if x1 > x0 && y1 > y0 {
                    let _ = write!(data, "M{x0:.1} {y0:.1}H{x1:.1}V{y1:.1}H{x0:.1}Z");
                }
            }
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
        Mark::Ring(_, series, name) => Some((*series, name)),
        _ => None,
    }
}
