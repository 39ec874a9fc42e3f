//! One plot: means with their confidence, and every run as a dot. Plain SVG whose colours are those
//! of the page's style, so that it can be read on light and dark ground.

use std::fmt::Write;

use super::axis::{LEAN_DEG, XAxis, YAxis, short};
use super::shapes::{
    AREA, Frame, INSET, LEFT, RIGHT, WIDTH, band, escaped, line, means, rounded, run_dot, symbol,
    text, whisker,
};
use crate::sweep::stats::{Stats, stats};

/// How many colours and marks the style distinguishes.
const STYLES: usize = 8;

/// A plot.
#[derive(Debug, Clone)]
pub struct Chart<'a> {
    /// What it shows.
    pub title: String,
    /// Unit of the vertical axis.
    pub unit: &'a str,
    /// The horizontal axis.
    pub x: &'a XAxis,
    /// The most a value can be.
    pub top: f64,
    /// What is drawn.
    pub lines: Vec<Line>,
}

/// One series.
#[derive(Debug, Clone, Default)]
pub struct Line {
    /// Its name; empty when there is only one.
    pub name: String,
    /// Per value of the horizontal axis.
    pub marks: Vec<Mark>,
    /// Per value of the horizontal axis, what perfect links give there.
    pub references: Vec<Option<Stats>>,
}

/// What is at one place of a series.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mark {
    /// The runs that have a value.
    pub runs: Vec<Dot>,
    /// How many flown runs have none.
    pub without: usize,
}

/// A run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Its seed.
    pub seed: u64,
    /// Its value.
    pub value: f64,
    /// Whether the true value is this or more.
    pub is_open: bool,
}

impl Mark {
    /// Mean and confidence.
    pub fn stats(&self) -> Option<Stats> {
        stats(&self.runs.iter().map(|dot| dot.value).collect::<Vec<_>>())
    }
}

impl Chart<'_> {
    /// Whether there is anything to show.
    pub fn is_empty(&self) -> bool {
        self.lines.iter().all(|line| line.marks.iter().all(|mark| mark.runs.is_empty()))
    }

    /// The plot as SVG.
    pub fn svg(&self) -> String {
        let (legend, legend_height) = self.legend();
        let frame = Frame { y: self.y_axis(), top: 40.0 + legend_height };
        let leans = self.x.leans(WIDTH - LEFT - RIGHT - 2.0 * INSET);
        let height = frame.bottom() + if leans { self.x.leaning_px() + 34.0 } else { 52.0 };
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
             width=\"{WIDTH}\" height=\"{height:.0}\" role=\"img\">\n<title>{0}</title>\n\
             <text class=\"name\" x=\"12\" y=\"20\">{0}</text>\n{legend}",
            escaped(&self.title)
        );
        svg += &self.grid(&frame, leans, height);
        for (index, line) in self.lines.iter().enumerate() {
            svg += &self.references(&frame, index, line);
        }
        for (index, line) in self.lines.iter().enumerate() {
            svg += &self.series(&frame, index, line);
        }
        svg + &self.without(&frame) + "</svg>\n"
    }

    fn y_axis(&self) -> YAxis {
        let mut values = Vec::new();
        for line in &self.lines {
            let marks = line.marks.iter().filter_map(Mark::stats);
            for s in marks.chain(line.references.iter().flatten().copied()) {
                // A wide band must not hide how the runs differ: it may be cut.
                let reach = s.half_width.unwrap_or(0.0).min(1.5 * (s.max - s.min));
                values.extend([s.min, s.max, (s.mean - reach).max(0.0), s.mean + reach]);
            }
        }
        let most = self.top;
        YAxis::around(values.into_iter().map(|v| v.min(most)), most)
    }

    /// Frame, ticks and titles.
    fn grid(&self, frame: &Frame, leans: bool, height: f64) -> String {
        let (left, right, bottom) = (LEFT, WIDTH - RIGHT, frame.bottom());
        let mut svg = String::from("<g class=\"grid\">\n");
        for tick in &frame.y.ticks {
            let y = frame.y(*tick);
            let label = short((*tick * 1e9).round() / 1e9);
            line(&mut svg, [left, y], [right, y]);
            text(&mut svg, [left - 8.0, y + 4.0], "end", &label);
        }
        let readable = self.x.readable(WIDTH - LEFT - RIGHT - 2.0 * INSET);
        for (i, at) in self.x.at.iter().enumerate() {
            let x = frame.x(*at);
            line(&mut svg, [x, bottom], [x, bottom + 5.0]);
            let label = &self.x.labels[i];
            if leans {
                let _ = writeln!(
                    svg,
                    "<text transform=\"translate({x:.1} {:.1}) rotate(-{LEAN_DEG})\" \
                     text-anchor=\"end\">{}</text>",
                    bottom + 16.0,
                    escaped(label)
                );
            } else if readable.contains(&i) {
                text(&mut svg, [x, bottom + 19.0], "middle", label);
            }
        }
        if self.x.is_broken && self.x.at.len() > 1 {
            // Two strokes through the axis: what follows is not to scale.
            let x = frame.x(0.92);
            for shift in [-3.0, 3.0] {
                line(&mut svg, [x + shift - 3.0, bottom + 6.0], [x + shift + 3.0, bottom - 6.0]);
            }
        }
        line(&mut svg, [left, bottom], [right, bottom]);
        line(&mut svg, [left, frame.top], [left, bottom]);
        text(&mut svg, [(left + right) / 2.0, height - 12.0], "middle", &self.x.title);
        let _ = writeln!(
            svg,
            "<text transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            frame.top + AREA / 2.0,
            escaped(self.unit)
        );
        svg + "</g>\n"
    }

    /// What perfect links give, as a dashed line with its band.
    fn references(&self, frame: &Frame, index: usize, line: &Line) -> String {
        let mut places: Vec<(f64, Stats)> = self
            .x
            .at
            .iter()
            .zip(&line.references)
            .filter_map(|(at, s)| Some((frame.x(*at), (*s)?)))
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (Some(first), Some(last)) = (places.first().copied(), places.last().copied()) else {
            return String::new();
        };
        // Alike for several series: drawn once.
        if index > 0 && line.references == self.lines[0].references {
            return String::new();
        }
        places.insert(0, (LEFT, first.1));
        places.push((WIDTH - RIGHT, last.1));
        let shared = self.lines.iter().all(|l| l.references == self.lines[0].references);
        let class = if shared { "perfect".to_owned() } else { format!("s{}", index % STYLES) };
        let mut svg = format!("<g class=\"{class}\">\n");
        if places.iter().all(|(_, s)| s.half_width.is_some()) {
            svg += &band(frame, &places, "soft band");
        }
        let _ = writeln!(svg, "<path class=\"dashed\" d=\"{}\"/>", means(frame, &places));
        svg + "</g>\n"
    }

    fn series(&self, frame: &Frame, index: usize, line: &Line) -> String {
        let style = index % STYLES;
        // Series stand a little beside one another so that no dot hides another.
        let middle = (self.lines.len() - 1) as f64 / 2.0;
        // Between words there is more room than between numbers.
        let step = if self.x.is_numeric { 7.0 } else { 22.0 };
        let room = if self.x.is_numeric { 24.0 } else { 0.6 * WIDTH / self.x.at.len() as f64 };
        let shift = (index as f64 - middle) * (room / self.lines.len() as f64).min(step);
        let mut places: Vec<(f64, &Mark, Stats)> = self
            .x
            .at
            .iter()
            .zip(&line.marks)
            .filter_map(|(at, mark)| Some((frame.x(*at) + shift, mark, mark.stats()?)))
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut svg = format!("<g class=\"s{style}\">\n");
        let curve: Vec<(f64, Stats)> = places.iter().map(|(x, _, s)| (*x, *s)).collect();
        if self.x.is_numeric && curve.len() > 1 {
            // A stretch without confidence (a single run at one end) has no band.
            for part in curve.chunk_by(|a, b| a.1.half_width.is_some() == b.1.half_width.is_some())
            {
                if part[0].1.half_width.is_some() {
                    svg += &band(frame, part, "band");
                }
            }
            let _ = writeln!(svg, "<path class=\"mean\" d=\"{}\"/>", means(frame, &curve));
        }
        for (x, mark, s) in &places {
            // Beside one another, so that equal values and the whisker hide none.
            let spread = if self.lines.len() == 1 { 16.0 } else { 7.0 };
            for (k, dot) in mark.runs.iter().enumerate() {
                let shift = (k as f64 + 0.5) / mark.runs.len() as f64 - 0.5;
                svg += &run_dot(*x + spread * shift, frame, dot, self.unit);
            }
            svg += &whisker(*x, frame, s);
            let tip = format!(
                "mean {} {}, 95 % ± {}, {} runs",
                short(rounded(s.mean)),
                self.unit,
                s.half_width.map_or("?".to_owned(), |h| short(rounded(h))),
                s.n
            );
            let path = symbol(style, *x, frame.y(s.mean), 5.0);
            let _ = writeln!(
                svg,
                "<path class=\"mark\" d=\"{path}\"><title>{}</title></path>",
                escaped(&tip)
            );
        }
        svg + "</g>\n"
    }

    /// How many runs have no value, above the places where that is so.
    fn without(&self, frame: &Frame) -> String {
        let mut svg = String::new();
        for (i, at) in self.x.at.iter().enumerate() {
            let marks = self.lines.iter().filter_map(|line| line.marks.get(i));
            let (without, with) = marks.fold((0, 0), |(a, b), m| (a + m.without, b + m.runs.len()));
            if without > 0 {
                let _ = writeln!(
                    svg,
                    "<text class=\"few\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{with} of {}\
                     <title>{without} runs have no value</title></text>",
                    frame.x(*at),
                    frame.top - 5.0,
                    with + without
                );
            }
        }
        svg
    }

    /// The legend and its height; none for a single nameless series.
    fn legend(&self) -> (String, f64) {
        let mut entries: Vec<(String, String, String)> = Vec::new();
        for (index, line) in self.lines.iter().enumerate().filter(|(_, l)| !l.name.is_empty()) {
            let style = index % STYLES;
            entries.push((format!("s{style}"), symbol(style, 9.0, -4.0, 5.0), line.name.clone()));
        }
        if self.lines.iter().any(|line| line.references.iter().any(Option::is_some)) {
            let name = "perfect links (dashed)".to_owned();
            entries.push(("perfect".to_owned(), String::new(), name));
        }
        if entries.is_empty() {
            return (String::new(), 6.0);
        }
        let (mut x, mut y) = (12.0, 40.0);
        let mut svg = String::from("<g class=\"legend\">\n");
        for (class, mark, name) in entries {
            let width = 38.0 + 7.2 * name.chars().count() as f64;
            if x > 12.0 && x + width > WIDTH - 8.0 {
                (x, y) = (12.0, y + 18.0);
            }
            let sample = if mark.is_empty() {
                "<path class=\"dashed\" d=\"M0 -4H20\"/>".to_owned()
            } else {
                format!("<path class=\"mean\" d=\"M0 -4H18\"/><path class=\"mark\" d=\"{mark}\"/>")
            };
            let _ = writeln!(
                svg,
                "<g transform=\"translate({x:.1} {y:.1})\"><g class=\"{class}\">{sample}</g>\
                 <text x=\"25\" y=\"0\">{}</text></g>",
                escaped(&name)
            );
            x += width;
        }
        (svg + "</g>\n", y - 14.0)
    }
}
