//! The page around the plots.

use std::fmt::Write;

use super::{figures, pairs};
use crate::report::axis::significant;
use crate::report::page;
use crate::report::shapes::escaped;
use crate::sweep::manifest::Manifest;
use crate::sweep::results::{Counts, Results};

/// The most failed or missing runs that are listed one by one.
const MAX_LISTED: usize = 200;

/// The report: a function of the results alone.
pub fn html(results: &Results) -> String {
    let manifest = &results.manifest;
    let body = head(results, &manifest.command())
        + &alarms(results)
        + &plots(results)
        + &table(results)
        + &pairs::section(results)
        + &scenario(manifest);
    page::document(&format!("Sweep of {}", manifest.scenario), &body)
}

/// The scenario in full.
pub fn scenario(manifest: &Manifest) -> String {
    format!(
        "<h2>The scenario</h2>\n<details><summary>In full, at the first point</summary>\n\
         <pre>{}</pre></details>\n",
        escaped(&manifest.scenario_toml)
    )
}

/// What was flown and with what, and the command that flies it again.
pub fn head(results: &Results, again: &str) -> String {
    let manifest = &results.manifest;
    let Counts { runs, flown, failed, missing, violated } = results.counts();
    let builds = results.builds();
    let build = match builds.len() {
        0 => escaped(&manifest.build.to_string()),
        1 => builds.keys().map(|build| escaped(&build.to_string())).collect(),
        _ => {
            let lines =
                builds.iter().map(|(b, n)| format!("{}: {n} runs", escaped(&b.to_string())));
            format!("<strong>mixed</strong><br/>{}", lines.collect::<Vec<_>>().join("<br/>"))
        }
    };
    let varied = manifest.vary.iter().map(|axis| {
        let values: Vec<String> = axis.values.iter().map(|v| v.shown()).collect();
        format!("<code>{}</code>: {}", escaped(&axis.title()), escaped(&values.join("; ")))
    });
    let varied: Vec<String> = varied.collect();
    let of_flown = match violated {
        0 => format!("no violation in {} checks of what is guaranteed", results.checks()),
        n => format!("<strong>{n} with violations of what is guaranteed</strong>"),
    };
    let rows = [
        ("varied", if varied.is_empty() { "nothing".to_owned() } else { varied.join("<br/>") }),
        ("seeds", escaped(&manifest.seeds)),
        ("runs", format!("{runs}: {flown} flown ({of_flown}), {failed} failed, {missing} missing")),
        ("csat", build),
        ("again", format!("<code>{}</code>", escaped(again))),
    ];
    page::definitions(&rows)
}

/// Runs that are not what they should be, each with the command that flies it again.
pub fn alarms(results: &Results) -> String {
    let manifest = &results.manifest;
    let (mut failed, mut violated, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    for (run, record) in &results.runs {
        let name = escaped(&manifest.points[run.point].describe(&manifest.vary));
        let what = format!("{name}, seed {}", run.seed);
        let replay = format!("<br/><code>{}</code>", escaped(&manifest.replay(run)));
        match record {
            None => missing.push(what + &replay),
            Some(record) => match (&record.failed, record.violations()) {
                (Some(why), _) => failed.push(format!("{what}: {}{replay}", escaped(why))),
                (None, 0) => {}
                (None, n) => violated.push(format!("{what}: {n}{replay}")),
            },
        }
    }
    let list = |title: &str, items: &[String]| {
        if items.is_empty() {
            return String::new();
        }
        let mut text = format!(
            "<div class=\"alarm\">\n<p><strong>{} {title}</strong></p>\n<ul>\n",
            items.len()
        );
        items.iter().take(MAX_LISTED).for_each(|item| text += &format!("<li>{item}</li>\n"));
        if let Some(more @ 1..) = items.len().checked_sub(MAX_LISTED) {
            text += &format!("<li>and {more} more: see sweep.csv</li>\n");
        }
        text + "</ul>\n</div>\n"
    };
    list("run(s) violated what is guaranteed", &violated)
        + &list("run(s) failed", &failed)
        + &list("run(s) missing: means are over the others", &missing)
}

fn plots(results: &Results) -> String {
    let Some(facets) = figures::facets(results) else {
        return "<p>Too many combinations for plots: see the table and sweep_means.csv.</p>\n"
            .to_owned();
    };
    let x = figures::x_axis(results);
    let mut page = String::from(
        "<h2>Plots</h2>\n<p>Large marks: means, with 95 % confidence intervals of the mean by \
         Student's t (cut where the quantity ends, at 0 or 100 %). Small dots: runs, whose seeds show under the pointer. \
         \u{201c}k of n\u{201d} above a plot: only k of n runs have a value there.</p>\n",
    );
    for facet in &facets {
        if !facet.name.is_empty() {
            let _ = writeln!(page, "<h3>{}</h3>", escaped(&facet.name));
        }
        page += &page::figures(results.metrics().iter().filter_map(|metric| {
            let chart = figures::chart(results, facet, metric, &x);
            let note = format!("{}{}", metric.plot.note, chart.note());
            (!chart.is_empty()).then(|| page::figure(&chart.svg(), &note))
        }));
    }
    page
}

/// A row per point.
fn table(results: &Results) -> String {
    let manifest = &results.manifest;
    let mut page = String::from(
        "<h2>Points</h2>\n<p>Mean ± half of the 95 % confidence interval over the flown runs; all \
         numbers are in sweep.csv (runs) and sweep_means.csv (points).</p>\n\
         <div class=\"wide\"><table>\n<thead><tr>",
    );
    for axis in &manifest.vary {
        let _ = write!(page, "<th class=\"left\">{}</th>", escaped(&axis.title()));
    }
    if manifest.vary.is_empty() || manifest.points.iter().any(|p| p.is_baseline) {
        page += "<th class=\"left\">links</th>";
    }
    page += "<th>runs</th>";
    let metrics = results.metrics();
    metrics.iter().for_each(|m| page += &format!("<th>{}</th>", escaped(m.plot.short)));
    page += "</tr></thead>\n<tbody>\n";
    for (index, point) in manifest.points.iter().enumerate() {
        page += "<tr>";
        for axis in 0..manifest.vary.len() {
            let shown = point.shown(&manifest.vary, axis);
            let _ = write!(page, "<td class=\"left\">{}</td>", escaped(&shown));
        }
        if manifest.vary.is_empty() || manifest.points.iter().any(|p| p.is_baseline) {
            page += if point.perfect {
                "<td class=\"left\">perfect</td>"
            } else {
                "<td class=\"left\">as set</td>"
            };
        }
        let all = results.of(index).len();
        let flown = results.flown(index).count();
        let runs = if flown == all { all.to_string() } else { format!("{flown} of {all}") };
        let _ = write!(page, "<td>{runs}</td>");
        for metric in &metrics {
            let _ = write!(page, "<td>{}</td>", cell(results, index, metric.key, flown));
        }
        page += "</tr>\n";
    }
    page + "</tbody>\n</table></div>\n"
}

fn cell(results: &Results, point: usize, key: &str, flown: usize) -> String {
    let Some((s, open)) = figures::cell(results, point, key) else { return "–".to_owned() };
    let mean = significant(s.mean);
    let bound = if open > 0 { "≥ " } else { "" };
    let reach = s.half_width.map(|h| format!(" ± {}", significant(h))).unwrap_or_default();
    let of = match (open, flown - s.n) {
        (0, 0) => String::new(),
        (0, _) => format!(" ({} of {flown})", s.n),
        (open, _) => format!(" ({} of {flown} found all)", s.n - open),
    };
    format!("{bound}{mean}{reach}{of}")
}
