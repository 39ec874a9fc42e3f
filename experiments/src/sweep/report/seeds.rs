//! A plot of differences within a seed: a line for each seed, their mean, and its confidence.

use std::fmt::Write;

use super::super::pairs::Paired;
use crate::report::axis::{XAxis, YAxis, short};
use crate::report::chart::undrawn;
use crate::report::shapes::{Frame, LEFT, RIGHT, WIDTH, escaped, path, rounded, whisker};
use crate::report::sheet::{Entry, Sheet, class, mark};

/// The most seeds with a line each; the mean is over all.
pub const MAX_LINES: usize = 100;

/// A plot.
#[derive(Debug, Clone)]
pub struct SeedLines<'a> {
    /// What it shows.
    pub title: &'a str,
    /// What values are the differences from.
    pub reference: &'a str,
    /// Unit of the vertical axis.
    pub unit: &'a str,
    /// The horizontal axis.
    pub x: &'a XAxis,
    /// Per value of the horizontal axis, the differences there.
    pub places: Vec<Option<Paired>>,
    /// The value of the horizontal axis that all are compared with: there is no difference there.
    pub origin: Option<usize>,
}

impl SeedLines<'_> {
    /// Whether there is anything to show: something differs.
    pub fn is_empty(&self) -> bool {
        self.pairs().all(|paired| paired.lower + paired.higher == 0)
    }

    /// The plot as SVG.
    pub fn svg(&self) -> String {
        let Self { title, unit, x, .. } = self;
        let unit = format!("difference, {unit}");
        let reference = format!("{} (dashed)", self.reference);
        let legend = vec![
            Entry::series(0, "mean"),
            Entry::thin(0, "a seed each"),
            Entry::dashed("perfect", &reference),
        ];
        let sheet = Sheet { title, unit: &unit, x, y: self.y_axis(), legend };
        sheet.svg(|frame| {
            let mut svg = String::new();
            let zero = [LEFT, WIDTH - RIGHT].map(|x| (x, 0.0));
            let _ = writeln!(
                svg,
                "<g class=\"perfect\"><path class=\"dashed\" d=\"{}\"/></g>",
                path(frame, &zero)
            );
            let _ = writeln!(svg, "<g class=\"{}\">", class(0));
            self.seeds().iter().for_each(|seed| svg += &self.seed(frame, *seed));
            svg + &self.mean(frame) + "</g>\n"
        })
    }

    /// What there is to say of seeds and intervals that are not drawn; empty when all are.
    pub fn note(&self) -> String {
        let all = self.pairs().flat_map(|paired| &paired.differences).map(|(seed, _)| seed);
        let count = all.collect::<std::collections::BTreeSet<_>>().len();
        let lines = match count {
            0..=MAX_LINES => String::new(),
            _ => format!(" Lines of the first {MAX_LINES} of {count} seeds."),
        };
        lines + &undrawn(self.pairs().map(|paired| &paired.stats))
    }

    fn pairs(&self) -> impl Iterator<Item = &Paired> {
        self.places.iter().flatten()
    }

    fn seeds(&self) -> Vec<u64> {
        let seeds = self.pairs().flat_map(|paired| &paired.differences).map(|(seed, _)| *seed);
        let mut seeds: Vec<u64> = seeds.collect();
        seeds.sort_unstable();
        seeds.dedup();
        seeds.truncate(MAX_LINES);
        seeds
    }

    fn y_axis(&self) -> YAxis {
        let ends = self.pairs().flat_map(|Paired { stats: s, .. }| {
            let reach = s.drawn_half_width().unwrap_or(0.0);
            [s.min, s.max, s.mean - reach, s.mean + reach]
        });
        YAxis::across(ends)
    }

    /// Places from left to right, in pixels, with what `value` gives there.
    fn along(&self, frame: &Frame, value: impl Fn(&Paired) -> Option<f64>) -> Vec<(f64, f64)> {
        let at = |(index, x): (usize, &f64)| {
            let is_origin = self.origin == Some(index);
            let there = self.places.get(index).and_then(Option::as_ref).and_then(&value);
            Some((frame.x(*x), there.or(is_origin.then_some(0.0))?))
        };
        let mut places: Vec<(f64, f64)> = self.x.at.iter().enumerate().filter_map(at).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places
    }

    fn seed(&self, frame: &Frame, seed: u64) -> String {
        let of = |paired: &Paired| {
            let found = paired.differences.iter().find(|(other, _)| *other == seed);
            found.map(|(_, difference)| *difference)
        };
        let places = self.along(frame, of);
        let values: Vec<String> = places.iter().map(|(_, v)| short(rounded(*v))).collect();
        let mut svg = format!(
            "<g><title>seed {seed}: {}</title><path class=\"seed\" d=\"{}\"/>",
            escaped(&values.join(", ")),
            path(frame, &places)
        );
        for (x, value) in places {
            let y = frame.y(value);
            let _ = write!(svg, "<circle class=\"run\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.2\"/>");
        }
        svg + "</g>\n"
    }

    fn mean(&self, frame: &Frame) -> String {
        let places = self.along(frame, |paired| Some(paired.stats.mean));
        let mut svg = format!("<path class=\"mean\" d=\"{}\"/>\n", path(frame, &places));
        for (x, paired) in self.x.at.iter().zip(&self.places) {
            let Some(Paired { stats: s, lower, higher, .. }) = paired else { continue };
            let x = frame.x(*x);
            svg += &whisker(x, frame, s);
            let reach = s.half_width.map_or(String::new(), |h| format!(" ± {}", short(rounded(h))));
            let mean = short(rounded(s.mean));
            let _ = writeln!(
                svg,
                "<path class=\"mark\" d=\"{}\"><title>mean {mean}{reach}, {} seeds: {lower} lower, \
                 {higher} higher</title></path>",
                mark(0, x, frame.y(s.mean)),
                s.n
            );
        }
        svg
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn lines(x: &XAxis, seeds: u64) -> SeedLines<'_> {
        let values = |slope: f64| (1..=seeds).map(|s| (s, slope * s as f64)).collect();
        let reference: BTreeMap<u64, f64> = values(1.0);
        let at = |slope: f64| Paired::new(&values(slope), &reference);
        let places = vec![None, at(0.5), at(3.0)];
        SeedLines { title: "a < b", reference: "a=1", unit: "m", x, places, origin: Some(0) }
    }

    #[test]
    fn every_seed_has_its_line_from_no_difference_on() {
        let x = XAxis::between("a", [1.0, 3.0], &[1.0, 2.0, 3.0]);
        let few = lines(&x, 4);
        let svg = few.svg();
        // One in the legend.
        assert_eq!(svg.matches("class=\"seed\"").count(), 5, "{svg}");
        assert!(svg.contains("<title>seed 3: 0, -1.5, 6</title>") && svg.contains("a &lt; b"));
        assert!(svg.contains("a=1 (dashed)"));
        assert_eq!(svg.matches("class=\"whisker\"").count(), 2);
        assert_eq!((few.note().as_str(), few.is_empty()), ("", false));
        let many = lines(&x, 150);
        assert_eq!(many.svg().matches("class=\"seed\"").count(), MAX_LINES + 1);
        assert_eq!(many.note(), " Lines of the first 100 of 150 seeds.");
    }

    #[test]
    fn intervals_of_two_seeds_are_not_drawn_and_that_is_said() {
        let x = XAxis::between("a", [1.0, 3.0], &[1.0, 2.0, 3.0]);
        let two = lines(&x, 2);
        assert_eq!(two.svg().matches("class=\"whisker\"").count(), 0);
        assert!(two.note().contains("n = 2"), "{}", two.note());
    }
}
