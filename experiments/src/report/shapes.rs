//! The pieces of a plot: where values are, and small pieces of SVG.

use std::fmt::Write;

use super::axis::{LABEL_PX, YAxis};
use crate::stats::Stats;

/// Width of a plot, pixels.
pub const WIDTH: f64 = 620.0;
/// Height of the area with the values, pixels.
pub const AREA: f64 = 250.0;
/// Room on the left, pixels.
pub const LEFT: f64 = 68.0;
/// Room on the right, pixels.
pub const RIGHT: f64 = 20.0;
/// Room between the frame and the first and last value, pixels.
pub const INSET: f64 = 26.0;

/// Where everything is.
pub struct Frame {
    /// The vertical axis.
    pub y: YAxis,
    /// Its top, pixels.
    pub top: f64,
}

impl Frame {
    /// Pixels of a place from 0 to 1.
    pub fn x(&self, at: f64) -> f64 {
        LEFT + INSET + at * (WIDTH - LEFT - RIGHT - 2.0 * INSET)
    }
    /// Pixels of a value; what is outside of the frame is at its edge.
    pub fn y(&self, value: f64) -> f64 {
        let share = (value - self.y.low) / (self.y.high - self.y.low);
        self.top + AREA * (1.0 - share.clamp(0.0, 1.0))
    }
    /// The bottom of the area, pixels.
    pub fn bottom(&self) -> f64 {
        self.top + AREA
    }
}

/// With four digits that mean something.
pub fn rounded(value: f64) -> f64 {
    let scale = 10f64.powf(3.0 - value.abs().max(1e-9).log10().floor());
    (value * scale).round() / scale
}

/// The path along (pixels, value).
pub fn path(frame: &Frame, places: &[(f64, f64)]) -> String {
    let mut data = String::new();
    for (i, (x, value)) in places.iter().enumerate() {
        let _ = write!(data, "{}{x:.1} {:.1}", if i == 0 { 'M' } else { 'L' }, frame.y(*value));
    }
    data
}

/// The ends of the confidence intervals, for [`band`].
pub fn confidence(places: &[(f64, Stats)]) -> Vec<(f64, [f64; 2])> {
    let ends = |s: &Stats| {
        let reach = s.drawn_half_width().unwrap_or(0.0);
        [s.mean - reach, s.mean + reach]
    };
    places.iter().map(|(x, s)| (*x, ends(s))).collect()
}

/// The area between (pixels, values).
pub fn band(frame: &Frame, places: &[(f64, [f64; 2])], class: &str) -> String {
    let above = places.iter().map(|(x, [_, high])| (*x, *high));
    let below = places.iter().rev().map(|(x, [low, _])| (*x, *low));
    let data = path(frame, &above.chain(below).collect::<Vec<_>>());
    format!("<path class=\"{class}\" d=\"{data}Z\"/>\n")
}

/// The interval at one place, if it is worth drawing.
pub fn whisker(x: f64, frame: &Frame, s: &Stats) -> String {
    let Some(reach) = s.drawn_half_width() else { return String::new() };
    let (y0, y1) = (frame.y(s.mean + reach), frame.y(s.mean - reach));
    format!(
        "<path class=\"whisker\" d=\"M{:.1} {y0:.1}H{:.1}M{x:.1} {y0:.1}V{y1:.1}M{:.1} {y1:.1}H{:.1}\"/>\n",
        x - 4.0,
        x + 4.0,
        x - 4.0,
        x + 4.0
    )
}

/// A mark that can be told from the others without its colour.
pub fn symbol(style: usize, x: f64, y: f64, r: f64) -> String {
    let polygon = |corners: &[[f64; 2]]| {
        let mut data = String::new();
        for (i, [dx, dy]) in corners.iter().enumerate() {
            let command = if i == 0 { 'M' } else { 'L' };
            let _ = write!(data, "{command}{:.1} {:.1}", x + dx * r, y + dy * r);
        }
        data + "Z"
    };
    match style {
        0 => format!("M{:.1} {y:.1}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z", x - r, d = 2.0 * r),
        1 => polygon(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
        2 => polygon(&[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]]),
        3 => polygon(&[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]]),
        4 => polygon(&[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]]),
        5 => polygon(&[[-1.2, 0.0], [0.8, -1.1], [0.8, 1.1]]),
        6 => polygon(&[[1.2, 0.0], [-0.8, -1.1], [-0.8, 1.1]]),
        _ => polygon(&[[-1.2, -0.45], [1.2, -0.45], [1.2, 0.45], [-1.2, 0.45]]),
    }
}

/// A stroke.
pub fn line(svg: &mut String, from: [f64; 2], to: [f64; 2]) {
    let ([x0, y0], [x1, y1]) = (from, to);
    let _ = writeln!(svg, "<path d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\"/>");
}

/// A label.
pub fn text(svg: &mut String, at: [f64; 2], anchor: &str, words: &str) {
    let [x, y] = at;
    let words = escaped(words);
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{LABEL_PX}\" text-anchor=\"{anchor}\">{words}</text>"
    );
}

/// Text that is no markup.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
