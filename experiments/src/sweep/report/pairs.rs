//! What the report tells of differences within a seed.

use std::fmt::Write;

use super::seeds::SeedLines;
use super::{figures, figures::Facet};
use crate::report::axis::{XAxis, significant};
use crate::report::page;
use crate::report::shapes::escaped;
use crate::sweep::metric::{Metric, metric};
use crate::sweep::pairs::{Paired, Reference};
use crate::sweep::results::Results;

/// The section; empty when there is nothing to compare.
pub fn section(results: &Results) -> String {
    let Ok(Some(reference)) = Reference::new(&results.manifest) else { return String::new() };
    let metrics = results.metrics();
    let shown: Vec<&Metric> = metrics.iter().filter(|m| differs(results, &reference, m)).collect();
    let head = format!(
        "<h2>Differences within a seed</h2>\n<p>Each mission less the one with the same seed at {}: what \
         differs between seeds falls out. Mean ± half of the 95 % confidence interval of the mean \
         difference by Student's t over the seeds that both have; bold where 0 is outside of it (one in \
         twenty is without any effect). All numbers are in sweep_pairs.csv; --against chooses what to \
         compare with.</p>\n",
        escaped(&reference.name)
    );
    if shown.is_empty() {
        return head + "<p>Nothing differs.</p>\n";
    }
    head + &table(results, &reference, &shown) + &plots(results, &reference, &shown)
}

fn paired(results: &Results, reference: &Reference, point: usize, what: &Metric) -> Option<Paired> {
    let of = reference.of[point]?;
    Paired::at(results, [point, of], |record| metric(record, what.key))
}

fn differs(results: &Results, reference: &Reference, what: &Metric) -> bool {
    let mut all = (0..reference.of.len()).filter_map(|p| paired(results, reference, p, what));
    all.any(|paired| paired.lower + paired.higher > 0)
}

fn table(results: &Results, reference: &Reference, shown: &[&Metric]) -> String {
    let manifest = &results.manifest;
    let mut page = String::from("<div class=\"wide\"><table>\n<thead><tr>");
    for axis in &manifest.vary {
        let _ = write!(page, "<th class=\"left\">{}</th>", escaped(&axis.title()));
    }
    page += "<th>seeds</th>";
    shown.iter().for_each(|metric| page += &format!("<th>{}</th>", escaped(metric.plot.short)));
    page += "</tr></thead>\n<tbody>\n";
    for (index, point) in manifest.points.iter().enumerate() {
        let Some(of) = reference.of[index] else { continue };
        page += "<tr>";
        for axis in 0..manifest.vary.len() {
            let _ = write!(
                page,
                "<td class=\"left\">{}</td>",
                escaped(&point.shown(&manifest.vary, axis))
            );
        }
        let both = Paired::at(results, [index, of], |_| Some(0.0));
        let _ = write!(page, "<td>{}</td>", both.map_or(0, |paired| paired.stats.n));
        for metric in shown {
            let cell = paired(results, reference, index, metric);
            let cell = cell.map_or("–".to_owned(), |paired| cell_text(&paired, metric));
            let _ = write!(page, "<td>{cell}</td>");
        }
        page += "</tr>\n";
    }
    page + "</tbody>\n</table></div>\n"
}

fn cell_text(paired: &Paired, metric: &Metric) -> String {
    let Paired { stats: s, lower, higher, .. } = paired;
    let sign = if s.mean > 0.0 { "+" } else { "" };
    let reach = s.half_width.map(|h| format!(" ± {}", significant(h))).unwrap_or_default();
    let mut text = format!("{sign}{}{reach}", significant(s.mean));
    if paired.is_clear() == Some(true) {
        text = format!("<strong>{text}</strong>");
    }
    let (better, worse) =
        if metric.plot.less_is_better { (lower, higher) } else { (higher, lower) };
    format!("{text}<br/><small>{better} better, {worse} worse</small>")
}

/// Plots with the first key along the axis, one group for each value of the others.
fn plots(results: &Results, reference: &Reference, shown: &[&Metric]) -> String {
    let too_many = "<p>Too many combinations for plots: see the table.</p>\n";
    let Some(facets) = figures::facets(results) else { return too_many.to_owned() };
    let axes = &results.manifest.vary;
    let series = axes.get(1).map_or(1, |axis| axis.values.len());
    if axes.is_empty() {
        return String::new();
    }
    if facets.len() * series > figures::MAX_FACETS {
        return too_many.to_owned();
    }
    let x = figures::x_axis(results);
    let mut page = String::new();
    for facet in &facets {
        for s in 0..series {
            let plots: Vec<String> = shown
                .iter()
                .filter_map(|metric| plot(results, reference, facet, s, metric, &x))
                .collect();
            if plots.is_empty() {
                continue;
            }
            let second =
                axes.get(1).map(|axis| format!("{} = {}", axis.title(), axis.values[s].shown()));
            let name: Vec<&str> =
                second.as_deref().into_iter().chain([facet.name.as_str()]).collect();
            let name = name.into_iter().filter(|n| !n.is_empty()).collect::<Vec<_>>().join(", ");
            if !name.is_empty() {
                let _ = writeln!(page, "<h3>{}</h3>", escaped(&name));
            }
            page += &page::figures(plots.into_iter());
        }
    }
    page
}

fn plot(
    results: &Results,
    reference: &Reference,
    facet: &Facet,
    series: usize,
    metric: &Metric,
    x: &XAxis,
) -> Option<String> {
    let at = |value| figures::point_at(results, facet, value, series);
    let places: Vec<Option<Paired>> =
        (0..x.at.len()).map(|v| paired(results, reference, at(v)?, metric)).collect();
    // Where the first key is what is compared, its reference has no difference.
    let is_origin = |value: &usize| at(*value).is_some_and(|p| reference.of.contains(&Some(p)));
    let origin = (0..x.at.len()).find(is_origin).filter(|_| reference.axis == Some(0));
    let (title, unit) = (metric.plot.title, metric.plot.unit);
    let lines = SeedLines { title, reference: &reference.name, unit, x, places, origin };
    let note = format!("{}{}", metric.plot.note, lines.note());
    (!lines.is_empty()).then(|| page::figure(&lines.svg(), &note))
}
