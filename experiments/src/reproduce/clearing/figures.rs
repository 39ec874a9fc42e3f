//! Figures 8 to 10.

use csat_mission::mission::Mission;
use csat_mission::picture::{Cells, Content, Layer, Ring};
use csat_mission::style::Colour;
use csat_proto::ids::AgentId;

use super::phases::Phase;
use super::uavs::{Duty, Instant, Uav};
use super::{Clearings, Shown};
use crate::clearing::Clearing;
use crate::clearing::report::{Report, Role};
use crate::report::axis::{XAxis, step};
use crate::report::curves::{Curve, Curves, Moment};
use crate::report::page;
use crate::reproduce::map::{Map, Mark, Stroke};

/// The side of the pictures of figure 9, metres.
const WINDOW_M: f64 = 260.0;
/// How long curves go on after the network is cleared, as a share of the time until then.
const AFTER_SHARE: f64 = 0.05;
/// The most ticks of the time axis.
const TICKS: f64 = 6.0;
/// Every so many steps the means over missions are drawn.
const DRAWN_STEPS: usize = 16;

/// All figures.
pub(super) fn all(seen: &Clearings<'_>) -> String {
    let (Some(shown), Some(uavs), Some(run)) = (&seen.shown, seen.uavs.first(), seen.runs.first())
    else {
        return String::new();
    };
    let end_s = run.summary.numbers.get("cleared_s").unwrap_or(run.summary.sim_s);
    let span = [0.0, (end_s * (1.0 + AFTER_SHARE)).min(run.summary.sim_s).max(1.0)];
    let seed = run.summary.seed;
    let mut markup =
        format!("<h2>Figures</h2>\n<h3>What was cleared, seed {seed} (figure 8)</h3>\n");
    markup += &page::figures([cleared(shown, uavs)].into_iter());
    markup += &format!("<h3>Salient phases, seed {seed} (figure 9)</h3>\n");
    markup += &page::figures(shown.phases.iter().map(|phase| picture(shown, phase)));
    markup += &format!("<h3>Shares and distances, seed {seed} (figure 10)</h3>\n");
    markup += &page::figures([shares(uavs, span), distances(uavs, span)].into_iter());
    markup += "<h3>All networks</h3>\n";
    markup + &page::figures([totals(seen)].into_iter())
}

fn name(uav: usize) -> String {
    format!("UAV {uav}")
}

fn roads(shown: &Shown) -> impl Iterator<Item = Mark> {
    shown.roads.iter().map(|(road, width_m)| Mark::Road(road.clone(), *width_m))
}

/// The cells of a layer.
fn cells_of<'a>(layers: &'a [Layer], key: &str) -> Option<&'a Cells> {
    layers.iter().find(|layer| layer.key == key).and_then(|layer| match &layer.content {
        Content::Cells(cells) => Some(cells),
        _ => None,
    })
}

/// Figure 8: what each UAV has cleared, and its path as a cleaner and as a helper.
fn cleared(shown: &Shown, uavs: &[Uav]) -> String {
    let view = &shown.view;
    let side_m = view.size_m[0].max(view.size_m[1]);
    let mut marks: Vec<Mark> = roads(shown).collect();
    for (index, layers) in view.agents.iter().enumerate().take(uavs.len()) {
        let cells = cells_of(layers, "cleared").cloned();
        marks.extend(cells.map(|cells| Mark::Cells(cells, index)));
    }
    for (index, (uav, track)) in uavs.iter().zip(&view.uavs).enumerate() {
        for part in uav.instants.chunk_by(|a, b| a.duty == b.duty) {
            let stroke = match part[0].duty {
                Duty::Cleaner => Stroke::Bold,
                Duty::Helper => Stroke::Dashed,
                Duty::Follower => continue,
            };
            let places = part.iter().filter_map(|at| track.path.get(at.step as usize));
            marks.push(Mark::Path(places.copied().collect(), index, stroke));
        }
        let never = if uav.was_cleaner { "" } else { ", never cleaner" };
        marks.push(Mark::Key(index, name(index) + never));
    }
    let title = "What each UAV has cleared, and its path (figure 8)".to_owned();
    let map = Map { title, origin_m: [-side_m / 2.0; 2], side_m, marks };
    let note = "Lines: as a cleaner; dashed: as a helper, on the way to a formation; no line: in a formation. Grey: the \
                roads. The paper shows the images of the cleaners as squares instead of the roads that they cleared.";
    page::figure(&map.svg(), note)
}

/// A part of figure 9.
fn picture(shown: &Shown, phase: &Phase) -> String {
    let of_it = phase.reports.iter().find(|report| report.agent == phase.agent);
    let place = |report: &Report| [report.pose.p_world[0], report.pose.p_world[1]];
    let origin_m = of_it.map(place).unwrap_or_default().map(|x| x - WINDOW_M / 2.0);
    let is_near = |report: &Report| {
        let [x, y] = place(report);
        (0.0..=WINDOW_M).contains(&(x - origin_m[0]))
            && (0.0..=WINDOW_M).contains(&(y - origin_m[1]))
    };
    let layers: Vec<(usize, &Report, Vec<Layer>)> = phase
        .reports
        .iter()
        .map(|report| (usize::from(report.agent.0), report, shown.mission.picture(report)))
        .collect();
    let mut marks: Vec<Mark> = roads(shown).collect();
    for (index, _, layers) in &layers {
        let cells = cells_of(layers, "cleared").cloned();
        marks.extend(cells.map(|cells| Mark::Cells(cells, *index)));
    }
    for key in ["unknown", "frontier"] {
        let of_cleaners = layers.iter().filter(|(_, report, _)| report.role == Role::Cleaner);
        let cells = of_cleaners.filter_map(|(_, _, layers)| cells_of(layers, key).cloned());
        marks.extend(cells.map(|cells| Mark::Painted(cells, colour(key))));
    }
    for (index, report, _) in layers.iter().filter(|(_, report, _)| is_near(report)) {
        let words = format!("{}: {}", name(*index), report.role.name());
        if report.role == Role::Cleaner {
            let ring: Ring = shown.mission.footprint(report);
            marks.push(Mark::Ring(ring, *index, words));
        } else {
            marks.push(Mark::Key(*index, words));
        }
        marks.push(Mark::Cross(place(report), *index));
    }
    let AgentId(agent) = phase.agent;
    let title = format!("The first {}, {} s (figure 9)", phase.name, phase.time_s);
    let map = Map { title, origin_m, side_m: WINDOW_M, marks };
    let note = format!(
        "UAV {agent} {}. Squares: images of cleaners; crosses: UAVs; filled: what each has cleared so far; red: road in \
         the image of a cleaner that it does not know to be cleared; yellow: its frontier.",
        phase.meaning
    );
    page::figure(&map.svg(), &note)
}

/// The colour of a layer of the mission.
fn colour(key: &str) -> String {
    let style = Clearing::LAYERS.iter().find(|style| style.key == key);
    style.map_or_else(String::new, |style| match &style.colour {
        Colour::Fixed(colour) | Colour::By(colour) => colour.to_string(),
    })
}

/// Figure 10a, without the sum.
fn shares(uavs: &[Uav], span: [f64; 2]) -> String {
    let title = "Cleared by each UAV (figure 10a)";
    let svg = curves(title, "% of R_S", 100.0, uavs, span, |instant| instant.cleared_pct);
    let note = "A curve is steep where a UAV becomes a cleaner: all road in its first image counts. It is level while the \
                UAV is no cleaner.";
    page::figure(&svg, note)
}

/// Figure 10b.
fn distances(uavs: &[Uav], span: [f64; 2]) -> String {
    let title = "Distance flown by each UAV (figure 10b)";
    let svg = curves(title, "m", f64::INFINITY, uavs, span, |instant| instant.path_m);
    let note = "Steep where a helper flies to a formation, level where a UAV waits; the paper's UAVs do not stop on \
                average.";
    page::figure(&svg, note)
}

fn curves(
    title: &str,
    unit: &str,
    top: f64,
    uavs: &[Uav],
    span: [f64; 2],
    value: impl Fn(&Instant) -> f64,
) -> String {
    let line = |(index, uav): (usize, &Uav)| {
        let instants = uav.instants.iter().filter(|instant| instant.time_s <= span[1]);
        let points = instants.map(|at| Moment { x: at.time_s, mean: value(at), sd: 0.0 });
        Curve { name: name(index), points: points.collect(), published: None }
    };
    let lines = uavs.iter().enumerate().map(line).collect();
    Curves { title, unit, x: &time(span), span, top, lines }.svg()
}

/// The sum of figure 10a, over all missions.
fn totals(seen: &Clearings<'_>) -> String {
    let series: Vec<Vec<(f64, Option<f64>)>> =
        seen.runs.iter().map(|run| run.series.of("cleared_pct").collect()).collect();
    let steps = series.iter().map(Vec::len).min().unwrap_or(0);
    let moment = |at: usize| {
        let values: Vec<f64> = series.iter().filter_map(|run| run[at].1).collect();
        Moment::of(series[0][at].0, &values)
    };
    let points: Vec<Moment> = (0..steps).step_by(DRAWN_STEPS).filter_map(moment).collect();
    let span = [0.0, points.last().map_or(1.0, |point| point.x).max(1.0)];
    let line = Curve { name: String::new(), points, published: None };
    let curves = Curves {
        title: "Cleared by all UAVs (figure 10a, black)",
        unit: "% of R_S",
        x: &time(span),
        span,
        top: 100.0,
        lines: vec![line],
    };
    let note = format!(
        "Mean and one standard deviation over {} missions, each in another network.",
        seen.runs.len()
    );
    page::figure(&curves.svg(), &note)
}

fn time(span: [f64; 2]) -> XAxis {
    let step_s = step(span[1] / TICKS);
    let ticks: Vec<f64> =
        (0..).map(|k| f64::from(k) * step_s).take_while(|t| *t <= span[1]).collect();
    XAxis::between("time [s]", span, &ticks)
}
