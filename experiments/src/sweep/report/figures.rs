//! From results to plots: the first varied key along the axis, the second as series, the rest as
//! plots of their own.

use crate::report::axis::XAxis;
use crate::report::chart::{Chart, Dot, Line, Mark};
use crate::stats::Stats;
use crate::sweep::metric::{self, Metric, metric};
use crate::sweep::results::Results;

/// The most groups of plots; beyond that, the tables say it.
pub const MAX_FACETS: usize = 12;

/// Plots that have all but the first two keys in common.
#[derive(Debug, Clone)]
pub struct Facet {
    /// What they have in common; empty when there are only two keys.
    pub name: String,
    /// The choices of the third key and those after it.
    rest: Vec<Option<usize>>,
}

/// The groups of plots; `None` when they are too many to be of use.
pub fn facets(results: &Results) -> Option<Vec<Facet>> {
    let axes = &results.manifest.vary;
    let mut facets: Vec<Facet> = Vec::new();
    for point in results.manifest.points.iter().filter(|p| !p.is_baseline) {
        let rest: Vec<Option<usize>> = point.choice.iter().skip(2).copied().collect();
        if facets.iter().all(|facet| facet.rest != rest) {
            let name =
                (2..axes.len()).map(|a| format!("{} = {}", axes[a].title(), point.shown(axes, a)));
            facets.push(Facet { name: name.collect::<Vec<_>>().join(", "), rest });
        }
    }
    (facets.len() <= MAX_FACETS).then_some(facets)
}

/// The horizontal axis of every plot.
pub fn x_axis(results: &Results) -> XAxis {
    let Some(axis) = results.manifest.vary.first() else { return XAxis::of_one() };
    let values: Vec<_> = axis.values.iter().map(|v| (v.number(), v.shown())).collect();
    XAxis::of(&axis.keys, &values)
}

/// The plot of a metric in a group.
pub fn chart<'a>(results: &Results, facet: &Facet, what: &Metric, x: &'a XAxis) -> Chart<'a> {
    let axes = &results.manifest.vary;
    let series = axes.get(1).map_or(1, |axis| axis.values.len());
    let lines = (0..series).map(|s| {
        let name = axes.get(1).map_or(String::new(), |axis| {
            format!("{} {}", last_key(&axis.keys), axis.values[s].shown())
        });
        let mut line = Line { name, ..Line::default() };
        for i in 0..x.at.len() {
            let choice = choice_at(results, facet, i, s);
            let point = results.manifest.combination(&choice);
            line.marks.push(point.map(|p| mark(results, p, what.key)).unwrap_or_default());
            // A reference makes sense where links vary or the user asked for it.
            let reference =
                results.manifest.perfect_like(&choice).filter(|_| results.manifest.baseline);
            line.references.push(reference.and_then(|p| mark(results, p, what.key).stats()));
        }
        line
    });
    let lines = lines.collect();
    Chart { title: what.plot.title.to_owned(), unit: what.plot.unit, x, top: what.plot.top, lines }
}

/// The choice at a value of the first key and one of the second, where there are so many.
fn choice_at(results: &Results, facet: &Facet, first: usize, second: usize) -> Vec<Option<usize>> {
    let mut choice: Vec<Option<usize>> = [Some(first), Some(second)].to_vec();
    choice.truncate(results.manifest.vary.len());
    choice.extend(&facet.rest);
    choice
}

/// The point there, if the sweep has it.
pub fn point_at(results: &Results, facet: &Facet, first: usize, second: usize) -> Option<usize> {
    results.manifest.combination(&choice_at(results, facet, first, second))
}

fn last_key(keys: &[String]) -> String {
    keys.iter().map(|k| k.rsplit('.').next().unwrap_or(k)).collect::<Vec<_>>().join(", ")
}

fn mark(results: &Results, point: usize, key: &str) -> Mark {
    let mut mark = Mark::default();
    for record in results.flown(point) {
        let is_open = metric::is_open(record, key);
        match metric(record, key) {
            Some(value) => mark.runs.push(Dot { seed: record.seed, value, is_open }),
            None => mark.without += 1,
        }
    }
    mark
}

/// Mean and confidence of a metric at a point, and how many of its runs count as open.
pub fn cell(results: &Results, point: usize, key: &str) -> Option<(Stats, usize)> {
    let mark = mark(results, point, key);
    let open = mark.runs.iter().filter(|dot| dot.is_open).count();
    Some((mark.stats()?, open))
}
