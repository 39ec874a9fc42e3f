//! One plot of a few places: means with their confidence, and every run as a dot.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::axis::{XAxis, YAxis, short};
use super::shapes::{Frame, LEFT, RIGHT, WIDTH, band, confidence, escaped, path, rounded, whisker};
use super::sheet::{self, Entry, Sheet, class};
use crate::stats::{FEWEST_DRAWN, Stats, stats};

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
        let Self { title, unit, x, .. } = self;
        let sheet = Sheet { title, unit, x, y: self.y_axis(), legend: self.legend() };
        sheet.svg(|frame| {
            let lines = || self.lines.iter().enumerate();
            let references = lines().map(|(index, line)| self.references(frame, index, line));
            let series = lines().map(|(index, line)| self.series(frame, index, line));
            references.chain(series).collect::<String>() + &self.without(frame)
        })
    }

    fn y_axis(&self) -> YAxis {
        let mut values = Vec::new();
        for line in &self.lines {
            let marks = line.marks.iter().filter_map(Mark::stats);
            for s in marks.chain(line.references.iter().flatten().copied()) {
                let reach = s.drawn_half_width().unwrap_or(0.0);
                values.extend([s.min, s.max, (s.mean - reach).max(0.0), s.mean + reach]);
            }
        }
        let most = self.top;
        YAxis::around(values.into_iter().map(|v| v.min(most)), most)
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
        let class = if shared { "perfect".to_owned() } else { class(index) };
        let mut svg = format!("<g class=\"{class}\">\n");
        if places.iter().all(|(_, s)| s.drawn_half_width().is_some()) {
            svg += &band(frame, &confidence(&places), "soft band");
        }
        let _ = writeln!(svg, "<path class=\"dashed\" d=\"{}\"/>", path(frame, &means(&places)));
        svg + "</g>\n"
    }

    fn series(&self, frame: &Frame, index: usize, line: &Line) -> String {
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
        let mut svg = format!("<g class=\"{}\">\n", class(index));
        let curve: Vec<(f64, Stats)> = places.iter().map(|(x, _, s)| (*x, *s)).collect();
        if self.x.is_numeric && curve.len() > 1 {
            // A stretch without confidence (one or two runs at one end) has no band.
            let has_band = |s: &Stats| s.drawn_half_width().is_some();
            for part in curve.chunk_by(|a, b| has_band(&a.1) == has_band(&b.1)) {
                if has_band(&part[0].1) {
                    svg += &band(frame, &confidence(part), "band");
                }
            }
            let _ = writeln!(svg, "<path class=\"mean\" d=\"{}\"/>", path(frame, &means(&curve)));
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
            let shape = sheet::mark(index, *x, frame.y(s.mean));
            let _ = writeln!(
                svg,
                "<path class=\"mark\" d=\"{shape}\"><title>{}</title></path>",
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

    /// What there is to say of intervals that are not drawn; empty when all are.
    pub fn note(&self) -> String {
        let marks = self.lines.iter().flat_map(|line| &line.marks).filter_map(Mark::stats);
        let references = self.lines.iter().flat_map(|line| line.references.iter().flatten());
        undrawn(marks.collect::<Vec<_>>().iter().chain(references))
    }

    /// None for a single nameless series.
    fn legend(&self) -> Vec<Entry> {
        let named = self.lines.iter().enumerate().filter(|(_, line)| !line.name.is_empty());
        let mut entries: Vec<Entry> = named.map(|(i, line)| Entry::series(i, &line.name)).collect();
        if self.lines.iter().any(|line| line.references.iter().any(Option::is_some)) {
            entries.push(Entry::dashed("perfect", "perfect links (dashed)"));
        }
        entries
    }
}

/// Why some intervals are not drawn; empty when all are.
pub fn undrawn<'a>(all: impl Iterator<Item = &'a Stats>) -> String {
    let few: BTreeSet<usize> = all.map(|s| s.n).filter(|n| *n < FEWEST_DRAWN).collect();
    let why = |n: &usize| match n {
        1 => " Where n = 1 there is no interval.",
        _ => {
            " Where n = 2 the interval is too wide to draw (Student\u{2019}s t is 12.7): see the table."
        }
    };
    few.iter().map(why).collect()
}

/// Where the means are.
fn means(places: &[(f64, Stats)]) -> Vec<(f64, f64)> {
    places.iter().map(|(x, s)| (*x, s.mean)).collect()
}

/// A run: a dot, or a hollow triangle when its value is a lower bound.
fn run_dot(x: f64, frame: &Frame, dot: &Dot, unit: &str) -> String {
    let y = frame.y(dot.value);
    let more = if dot.is_open { " or more" } else { "" };
    let tip = format!("seed {}: {} {unit}{more}", dot.seed, short(rounded(dot.value)));
    let tip = escaped(&tip);
    if dot.is_open {
        let (x0, x1, y0, y1) = (x - 4.0, x + 4.0, y + 3.0, y - 4.0);
        return format!(
            "<path class=\"open\" d=\"M{x0:.1} {y0:.1}H{x1:.1}L{x:.1} {y1:.1}Z\"><title>{tip}</title></path>\n"
        );
    }
    format!(
        "<circle class=\"run\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\"><title>{tip}</title></circle>\n"
    )
}
