//! What all plots have in common: title, legend, grid and axes. Plain SVG whose colours are those of
//! the page's style, so that it can be read on light and dark ground.

use std::fmt::Write;

use super::axis::{LEAN_DEG, XAxis, YAxis, short};
use super::shapes::{AREA, Frame, INSET, LEFT, RIGHT, WIDTH, escaped, line, symbol, text};

/// How many colours and marks the style distinguishes.
const STYLES: usize = 8;

/// The class of a series: its colour.
pub fn class(series: usize) -> String {
    format!("s{}", series % STYLES)
}

/// The mark of a series, told from the others without its colour.
pub fn mark(series: usize, x: f64, y: f64) -> String {
    symbol(series % STYLES, x, y, 5.0)
}

/// A line of the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    class: String,
    sample: String,
    name: String,
}

impl Entry {
    /// A series by its number, with its mark.
    pub fn series(series: usize, name: &str) -> Self {
        let mark = mark(series, 9.0, -4.0);
        let sample =
            format!("<path class=\"mean\" d=\"M0 -4H18\"/><path class=\"mark\" d=\"{mark}\"/>");
        Self { class: class(series), sample, name: name.to_owned() }
    }

    /// What is drawn as thin lines of a series' colour.
    pub fn thin(series: usize, name: &str) -> Self {
        let sample = "<path class=\"seed\" d=\"M0 -4H20\"/>".to_owned();
        Self { class: class(series), sample, name: name.to_owned() }
    }

    /// Something drawn as a dashed line.
    pub fn dashed(class: &str, name: &str) -> Self {
        let sample = "<path class=\"dashed\" d=\"M0 -4H20\"/>".to_owned();
        Self { class: class.to_owned(), sample, name: name.to_owned() }
    }
}

/// An empty plot.
#[derive(Debug, Clone)]
pub struct Sheet<'a> {
    /// What it shows.
    pub title: &'a str,
    /// Unit of the vertical axis.
    pub unit: &'a str,
    /// The horizontal axis.
    pub x: &'a XAxis,
    /// The vertical axis.
    pub y: YAxis,
    /// The legend.
    pub legend: Vec<Entry>,
}

impl Sheet<'_> {
    /// The plot with what `draw` puts on it.
    pub fn svg(self, draw: impl FnOnce(&Frame) -> String) -> String {
        let (legend, legend_height) = legend(&self.legend);
        let leans = self.x.leans(WIDTH - LEFT - RIGHT - 2.0 * INSET);
        let frame = Frame { y: self.y, top: 40.0 + legend_height };
        let height = frame.bottom() + if leans { self.x.leaning_px() + 34.0 } else { 52.0 };
        let title = escaped(self.title);
        let grid = grid(&frame, self.x, self.unit, height);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
             width=\"{WIDTH}\" height=\"{height:.0}\" role=\"img\">\n<title>{title}</title>\n\
             <text class=\"name\" x=\"12\" y=\"20\">{title}</text>\n{legend}{grid}{}</svg>\n",
            draw(&frame)
        )
    }
}

/// Frame, ticks and titles.
fn grid(frame: &Frame, x_axis: &XAxis, unit: &str, height: f64) -> String {
    let (left, right, bottom) = (LEFT, WIDTH - RIGHT, frame.bottom());
    let mut svg = String::from("<g class=\"grid\">\n");
    for tick in &frame.y.ticks {
        let y = frame.y(*tick);
        let label = short((*tick * 1e9).round() / 1e9);
        line(&mut svg, [left, y], [right, y]);
        text(&mut svg, [left - 8.0, y + 4.0], "end", &label);
    }
    ticks(&mut svg, frame, x_axis);
    line(&mut svg, [left, bottom], [right, bottom]);
    line(&mut svg, [left, frame.top], [left, bottom]);
    text(&mut svg, [(left + right) / 2.0, height - 12.0], "middle", &x_axis.title);
    let _ = writeln!(
        svg,
        "<text transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        frame.top + AREA / 2.0,
        escaped(unit)
    );
    svg + "</g>\n"
}

/// The places of the horizontal axis.
fn ticks(svg: &mut String, frame: &Frame, x_axis: &XAxis) {
    let (bottom, width) = (frame.bottom(), WIDTH - LEFT - RIGHT - 2.0 * INSET);
    let (leans, readable) = (x_axis.leans(width), x_axis.readable(width));
    for (i, at) in x_axis.at.iter().enumerate() {
        let x = frame.x(*at);
        line(svg, [x, bottom], [x, bottom + 5.0]);
        let label = &x_axis.labels[i];
        if leans {
            let _ = writeln!(
                svg,
                "<text transform=\"translate({x:.1} {:.1}) rotate(-{LEAN_DEG})\" \
                 text-anchor=\"end\">{}</text>",
                bottom + 16.0,
                escaped(label)
            );
        } else if readable.contains(&i) {
            text(svg, [x, bottom + 19.0], "middle", label);
        }
    }
    if x_axis.is_broken && x_axis.at.len() > 1 {
        // Two strokes through the axis: what follows is not to scale.
        let x = frame.x(0.92);
        for shift in [-3.0, 3.0] {
            line(svg, [x + shift - 3.0, bottom + 6.0], [x + shift + 3.0, bottom - 6.0]);
        }
    }
}

/// The legend and its height; none without entries.
fn legend(entries: &[Entry]) -> (String, f64) {
    if entries.is_empty() {
        return (String::new(), 6.0);
    }
    let (mut x, mut y) = (12.0, 40.0);
    let mut svg = String::from("<g class=\"legend\">\n");
    for Entry { class, sample, name } in entries {
        let width = 38.0 + 7.2 * name.chars().count() as f64;
        if x > 12.0 && x + width > WIDTH - 8.0 {
            (x, y) = (12.0, y + 18.0);
        }
        let _ = writeln!(
            svg,
            "<g transform=\"translate({x:.1} {y:.1})\"><g class=\"{class}\">{sample}</g>\
             <text x=\"25\" y=\"0\">{}</text></g>",
            escaped(name)
        );
        x += width;
    }
    (svg + "</g>\n", y - 14.0)
}
