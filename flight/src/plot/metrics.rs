//! `metrics.svg`: the curves of thesis figures 5.9-5.13.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::error::PlotError;
use csat_mission::measures::{Curve, Panel};
use csat_mission::mission::Kind;

use super::colours::{GREY, STATIONS, TEXT, colour};
use crate::published::{Published, SPAN_S};
use crate::series::{Curves, Series};
use crate::summary::Summary;
use csat_mission::words::counted;

const WIDTH_PX: u32 = 1240;
const HEADER_PX: i32 = 62;
/// Height of a row of panels.
const ROW_PX: u32 = 324;

/// Draws a mission's metrics over time; with the thesis's means for `str3`, κ = 1 dashed, if the mission
/// is one of those that it flew.
///
/// # Errors
/// When the plotting library refuses.
pub fn metrics_svg(kind: &Kind, summary: &Summary, curves: &Curves) -> Result<String, PlotError> {
    let mut svg = String::new();
    draw(kind, summary, curves, &mut svg).map_err(|e| PlotError::Draw(e.to_string()))?;
    Ok(svg)
}

type Error = Box<dyn std::error::Error>;

fn draw(kind: &Kind, summary: &Summary, curves: &Curves, svg: &mut String) -> Result<(), Error> {
    let rows = kind.panels.len().div_ceil(2);
    let size_px = (WIDTH_PX, HEADER_PX as u32 + ROW_PX * rows as u32);
    let root = SVGBackend::with_string(svg, size_px).into_drawing_area();
    root.fill(&WHITE)?;
    let (header, body) = root.split_vertically(HEADER_PX);
    let series = &curves.fleet;
    let stations = match curves.stations.len() {
        0 => String::new(),
        count => format!("{}, ", counted(count, "station")),
    };
    let title = format!(
        "{}, seed {}: {} UAVs, {stations}{} targets, {} s",
        summary.scenario, summary.seed, summary.agents, summary.targets, summary.sim_s
    );
    header.draw_text(&title, &("sans-serif", 24).into_font().color(&TEXT), (20, 14))?;
    let end_s = series.end_s();
    let beside = Beside(summary.thesis_setting && summary.sim_s >= SPAN_S[1]);
    let thesis = if beside.0 {
        "; dashed: thesis, str3, kappa = 1, mean of 10 runs over 150-300 s, shaded: its deviation"
    } else {
        ""
    };
    let half = format!("{}-{} s", tick(end_s / 2.0, end_s), tick(end_s, end_s));
    let note = format!(
        "solid: this run, mean of the UAVs; numbers: its mean over {half}, the second half{thesis}"
    );
    header.draw_text(&note, &("sans-serif", 14).into_font().color(&GREY), (20, 42))?;
    for (area, panel) in body.split_evenly((rows, 2)).iter().zip(kind.panels) {
        draw_panel(area, panel, beside, summary, curves)?;
    }
    root.present()?;
    Ok(())
}

fn draw_panel(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    panel: &Panel,
    beside: Beside,
    summary: &Summary,
    curves: &Curves,
) -> Result<(), Error> {
    let series = &curves.fleet;
    let end_s = series.end_s().max(1e-3);
    let (top, legend) = axis(panel, beside, summary, curves);
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .caption(panel.title, ("sans-serif", 17).into_font().color(&TEXT))
        .x_label_area_size(36)
        .y_label_area_size(52)
        .build_cartesian_2d(0.0..end_s, 0.0..top)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .axis_style(BLACK.mix(0.5))
        .x_desc("time, s")
        .y_desc(panel.unit)
        .x_labels(7)
        .y_labels(6)
        .x_label_formatter(&|x| tick(*x, end_s))
        .y_label_formatter(&|y| match panel.unit {
            // The axis goes on above for the legend, the share does not.
            "%" if *y > 100.0 => String::new(),
            _ => tick(*y, top),
        })
        .label_style(("sans-serif", 13).into_font().color(&TEXT))
        .axis_desc_style(("sans-serif", 14).into_font().color(&TEXT))
        .draw()?;
    draw_thesis(&mut chart, panel, beside, summary, end_s, top)?;
    draw_curves(&mut chart, panel, beside, series, top)?;
    draw_stations(&mut chart, panel, curves, top)?;
    chart
        .configure_series_labels()
        .position(legend)
        .margin(8)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.25))
        .label_font(("sans-serif", 13).into_font().color(&TEXT))
        .draw()?;
    Ok(())
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// The thesis's means with their deviations, and the number of targets there are.
fn draw_thesis(
    chart: &mut Chart<'_, '_>,
    panel: &Panel,
    beside: Beside,
    summary: &Summary,
    end_s: f64,
    top: f64,
) -> Result<(), Error> {
    let span = [SPAN_S[0].min(end_s), SPAN_S[1].min(end_s)];
    for curve in panel.curves {
        if let Some([mean, deviation]) = beside.published(curve) {
            let corners = [(span[0], mean - deviation), (span[1], (mean + deviation).min(top))];
            chart
                .draw_series([Rectangle::new(corners, colour(curve.colour).mix(0.10).filled())])?;
            let ends = span.map(|t| (t, mean)).into_iter();
            let style = colour(curve.colour).stroke_width(2);
            chart.draw_series(DashedLineSeries::new(ends, 7, 5, style))?;
        }
    }
    if panel.unit == "targets" && summary.targets > 0 {
        let all = f64::from(summary.targets);
        let ends = [(0.0, all), (end_s, all)].into_iter();
        chart.draw_series(DashedLineSeries::new(ends, 2, 4, GREY.stroke_width(1)))?;
    }
    Ok(())
}

/// The curves and their names.
fn draw_curves(
    chart: &mut Chart<'_, '_>,
    panel: &Panel,
    beside: Beside,
    series: &Series,
    top: f64,
) -> Result<(), Error> {
    for curve in panel.curves {
        let style = colour(curve.colour).stroke_width(if curve.is_wide { 5 } else { 2 });
        for run in unbroken(series, curve.column, top) {
            chart.draw_series(LineSeries::new(run, style))?;
        }
        let name = legend_text(curve, beside, panel.unit, series);
        let colour = colour(curve.colour);
        // An empty series carries the legend once, however many pieces the curve has.
        chart
            .draw_series(LineSeries::new(std::iter::empty(), style))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(3)));
    }
    Ok(())
}

/// What each station knows, dashed. The legend has room for a few.
fn draw_stations(
    chart: &mut Chart<'_, '_>,
    panel: &Panel,
    curves: &Curves,
    top: f64,
) -> Result<(), Error> {
    let Some(column) = panel.of_stations else { return Ok(()) };
    for (index, (agent, series)) in curves.stations.iter().enumerate() {
        let style = STATIONS[index % STATIONS.len()].stroke_width(2);
        for run in unbroken(series, column, top) {
            chart.draw_series(DashedLineSeries::new(run, 5, 3, style))?;
        }
        if index < STATIONS.len() {
            let mean = series.half_mean(column).map_or("-".to_owned(), |mean| format!("{mean:.2}"));
            chart
                .draw_series(LineSeries::new(std::iter::empty(), style))?
                .label(format!("station {agent}, dashed: {mean}"))
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
    }
    Ok(())
}

/// A number beside an axis that ends at `end`: short axes have ticks closer than 1.
fn tick(value: f64, end: f64) -> String {
    let decimals = if end < 3.0 { 1 } else { 0 };
    format!("{value:.decimals$}")
}

/// Name, mean over the second half, and the thesis's.
fn legend_text(curve: &Curve, beside: Beside, unit: &str, series: &Series) -> String {
    let values: Vec<f64> = series.half(curve.column).flatten().collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let name = if curve.name.is_empty() { "mean" } else { curve.name };
    let ours = if values.is_empty() { "-".to_owned() } else { format!("{mean:.2}") };
    match beside.published(curve) {
        Some([published, deviation]) => {
            format!("{name}: {ours} {unit} (thesis {published} ± {deviation})")
        }
        None => format!("{name}: {ours}"),
    }
}

/// The top of the axis and the corner that the legend goes to: where the second half leaves room, or
/// above it, on an axis made higher.
fn axis(
    panel: &Panel,
    beside: Beside,
    summary: &Summary,
    curves: &Curves,
) -> (f64, SeriesLabelPosition) {
    let series = &curves.fleet;
    let of_stations = curves.stations.values().zip(std::iter::repeat(panel.of_stations));
    let of_stations = of_stations.filter_map(|(series, column)| Some((series, column?)));
    let half_s = series.end_s() / 2.0;
    let (mut top, mut low, mut high) = (panel.axis[0], f64::INFINITY, 0.0f64);
    let of_fleet = panel.curves.iter().map(|curve| (series, curve.column));
    for (series, column) in of_fleet.chain(of_stations) {
        for (time_s, value) in series.of(column) {
            let Some(value) = value.filter(|v| v.is_finite()) else { continue };
            top = top.max(value);
            if time_s >= half_s {
                (low, high) = (low.min(value), high.max(value));
            }
        }
    }
    for curve in panel.curves {
        if let Some([mean, deviation]) = beside.published(curve) {
            top = top.max(mean + deviation);
            (low, high) = (low.min(mean - deviation), high.max(mean + deviation));
        }
    }
    if panel.unit == "targets" {
        top = top.max(f64::from(summary.targets));
    }
    top = (top * 1.05).min(panel.axis[1]);
    if high < 0.72 * top {
        (top, SeriesLabelPosition::UpperRight)
    } else if low > 0.3 * top {
        (top, SeriesLabelPosition::LowerRight)
    } else {
        ((high / 0.72).max(top), SeriesLabelPosition::UpperRight)
    }
}

/// The stretches of a curve where it has a value; what is above the axis is cut at its top.
fn unbroken(series: &Series, column: &str, top: f64) -> Vec<Vec<(f64, f64)>> {
    let mut runs = vec![Vec::new()];
    for (time_s, value) in series.of(column) {
        match value.filter(|v| v.is_finite()) {
            Some(v) => runs.last_mut().expect("never empty").push((time_s, v.min(top))),
            None => runs.push(Vec::new()),
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// Whether a run is set beside what was published of its mission.
#[derive(Debug, Clone, Copy)]
struct Beside(bool);

impl Beside {
    fn published(self, curve: &Curve) -> Option<Published> {
        curve.published.filter(|_| self.0).map(|published| published())
    }
}
