//! A plot of many moments: for each line the mean and a band of one standard deviation.

use std::fmt::Write;

use super::axis::{XAxis, YAxis};
use super::shapes::{Frame, band, path};
use super::sheet::{Entry, Sheet, class, mark};
use crate::stats::stats;

/// Lines of no more points than this have a mark at each.
const MARKED: usize = 20;

/// A plot.
#[derive(Debug, Clone)]
pub struct Curves<'a> {
    /// What it shows.
    pub title: &'a str,
    /// Unit of the vertical axis.
    pub unit: &'a str,
    /// The horizontal axis.
    pub x: &'a XAxis,
    /// What is at its ends.
    pub span: [f64; 2],
    /// The most a value can be.
    pub top: f64,
    /// What is drawn.
    pub lines: Vec<Curve>,
}

/// One line.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    /// Its name; empty when there is only one.
    pub name: String,
    /// Its points, from left to right.
    pub points: Vec<Moment>,
    /// What was published for it.
    pub published: Option<Published>,
}

/// A point of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Where it is.
    pub x: f64,
    /// The mean.
    pub mean: f64,
    /// The standard deviation; 0 for a single value.
    pub sd: f64,
}

/// A published mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// What it is the mean over.
    pub span: [f64; 2],
    /// The mean.
    pub mean: f64,
}

impl Moment {
    /// The mean and deviation of values; `None` for none.
    pub fn of(x: f64, values: &[f64]) -> Option<Self> {
        stats(values).map(|s| Self { x, mean: s.mean, sd: s.sd.unwrap_or(0.0) })
    }

    fn ends(&self) -> [f64; 2] {
        [(self.mean - self.sd).max(0.0), self.mean + self.sd]
    }
}

impl Curves<'_> {
    /// Whether there is anything to show.
    pub fn is_empty(&self) -> bool {
        self.lines.iter().all(|line| line.points.is_empty())
    }

    /// The plot as SVG.
    pub fn svg(&self) -> String {
        let Self { title, unit, x, .. } = *self;
        let sheet = Sheet { title, unit, x, y: self.y_axis(), legend: self.legend() };
        sheet.svg(|frame| {
            let lines = self.lines.iter().enumerate();
            lines.map(|(index, line)| self.line(frame, index, line)).collect()
        })
    }

    fn y_axis(&self) -> YAxis {
        let moments = self.lines.iter().flat_map(|line| &line.points).flat_map(Moment::ends);
        let published = self.lines.iter().filter_map(|line| line.published).map(|p| p.mean);
        YAxis::around(moments.chain(published).map(|v| v.min(self.top)), self.top)
    }

    fn legend(&self) -> Vec<Entry> {
        let named = self.lines.iter().enumerate().filter(|(_, line)| !line.name.is_empty());
        let mut entries: Vec<Entry> = named.map(|(i, line)| Entry::series(i, &line.name)).collect();
        if self.lines.iter().any(|line| line.published.is_some()) {
            entries.push(Entry::dashed("perfect", "published mean (dashed)"));
        }
        entries
    }

    fn line(&self, frame: &Frame, index: usize, line: &Curve) -> String {
        let at = |x: f64| frame.x((x - self.span[0]) / (self.span[1] - self.span[0]));
        let mut svg = format!("<g class=\"{}\">\n", class(index));
        if line.points.iter().any(|p| p.sd > 0.0) {
            let ends: Vec<_> = line.points.iter().map(|p| (at(p.x), p.ends())).collect();
            svg += &band(frame, &ends, "soft band");
        }
        let means: Vec<_> = line.points.iter().map(|p| (at(p.x), p.mean)).collect();
        let _ = writeln!(svg, "<path class=\"mean\" d=\"{}\"/>", path(frame, &means));
        if means.len() <= MARKED {
            for (x, mean) in &means {
                let shape = mark(index, *x, frame.y(*mean));
                let _ = writeln!(svg, "<path class=\"mark\" d=\"{shape}\"/>");
            }
        }
        if let Some(Published { span, mean }) = line.published {
            let ends = span.map(|x| (at(x.min(self.span[1])), mean));
            let _ = writeln!(svg, "<path class=\"dashed\" d=\"{}\"/>", path(frame, &ends));
        }
        svg + "</g>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_bands_marks_and_what_was_published() {
        let x = XAxis::between("time [s]", [0.0, 300.0], &[0.0, 100.0, 200.0, 300.0]);
        let points = [(0.0, [1.0, 3.0]), (300.0, [2.0, 2.0])];
        let points = points.iter().filter_map(|(x, values)| Moment::of(*x, values)).collect();
        let published = Some(Published { span: [150.0, 300.0], mean: 4.0 });
        let lines = vec![Curve { name: "one".to_owned(), points, published }];
        let curves =
            Curves { title: "a < b", unit: "m", x: &x, span: [0.0, 300.0], top: 100.0, lines };
        assert!(!curves.is_empty());
        let svg = curves.svg();
        assert!(svg.contains("a &lt; b") && svg.contains("soft band"), "{svg}");
        // One in the legend, two on the line.
        assert_eq!(svg.matches("class=\"mark\"").count(), 3);
        assert_eq!(svg.matches("class=\"dashed\"").count(), 2);
        assert_eq!(Moment::of(0.0, &[]), None);
    }
}
