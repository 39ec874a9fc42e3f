//! Figures 2 to 7.

use csat_bayes::belief::Belief;
use csat_bayes::likelihood::{Likelihood, Sensor};
use csat_bayes::search_map::{Gaussian, SearchMap};
use csat_mission::picture::Heat;
use csat_proto::camera::Pose;
use csat_proto::time::Step;

use super::Tisdale;
use super::filters::{KINDS, beliefs_at};
use super::tables::NOMINAL;
use crate::report::axis::XAxis;
use crate::report::curves::{Curve, Curves, Moment};
use crate::report::page;
use crate::reproduce::map::{Map, Mark, Stroke};

/// Places of the paper's three representations and ours in [`KINDS`].
const FINE: usize = 0;
const COARSE: usize = 1;
const PARTICLES: usize = 2;

/// When figure 5 shows the search, seconds.
const SEARCH_S: [f64; 2] = [70.0, 105.0];
/// How long after the first detection it shows what was found, seconds.
const AFTER_S: f64 = 4.0;
/// The longest time after the first detection that figure 7 shows, seconds.
const SPAN_S: f64 = 60.0;
/// On maps of the whole region, all that is denser than so many times a uniform density is as dark.
const MOST_UNIFORM: f64 = 4.0;
/// Corners of an ellipse.
const CORNERS: u32 = 64;

/// All figures, as markup.
pub fn all(seen: &Tisdale) -> String {
    let mut markup = "<h2>Figures</h2>\n".to_owned();
    markup += &page::figures([no_detection(seen), cumulative(seen)].into_iter());
    markup += "<h3>The fine grid at the first four detections (figure 4)</h3>\n";
    markup += &page::figures(observations(seen).into_iter());
    markup += "<h3>The search on the coarse grid and with particles (figure 5)</h3>\n";
    markup += &page::figures(search(seen).into_iter());
    markup += "<h3>What was found (figures 6 and 7)</h3>\n";
    markup + &page::figures([ellipses(seen), deviations(seen)].into_iter())
}

/// Figure 2: the likelihood of a frame without a detection, at the pose of table II.
fn no_detection(seen: &Tisdale) -> String {
    let sensor = Sensor::new(&seen.shown().config);
    let [_, _, h, yaw_rad, pitch_rad, roll_rad] = NOMINAL;
    let pose = Pose { p_world: [0.0, 0.0, h], yaw_rad, pitch_rad, roll_rad };
    let likelihood = Likelihood::of_frame(&sensor, &pose, None);
    let (cells, cell_m, origin_m) = (110, 2.0, [-110.0, -110.0]);
    let p_false = sensor.detector.p_false;
    let values =
        raster(cells, cell_m, origin_m, |x| (1.0 - p_false) * likelihood.ln_ratio(x).exp());
    let heat = Heat { cell_m, origin_m, columns: cells, maximum: 1.0, values };
    let map = Map {
        title: "Likelihood of no detection (figure 2)".to_owned(),
        origin_m,
        side_m: f64::from(cells) * cell_m,
        marks: vec![Mark::Heat(heat), Mark::Cross([0.0, 0.0], 0)],
    };
    let note = "Dark is near 1, light near 0, as in the paper. The aircraft (cross) flies east with the nose down \
                and the right wing down (table II), so it looks to its left rear; the far side of the image has \
                less resolution.";
    page::figure(&map.svg(), note)
}

/// Figure 3.
fn cumulative(seen: &Tisdale) -> String {
    let flight = seen.shown();
    let points = seen.curves[FINE].cumulative_detection.iter().enumerate().step_by(4);
    let points =
        points.map(|(step, p)| Moment { x: flight.time_s(Step(step as u32)), mean: *p, sd: 0.0 });
    let span = [0.0, flight.time_s(Step(flight.steps))];
    let x = XAxis::between("time [s]", span, &ticks(span));
    let line = Curve { name: String::new(), points: points.collect(), published: None };
    let curves = Curves {
        title: "Cumulative probability of detection (figure 3)",
        unit: "P(D)",
        x: &x,
        span,
        top: 1.0,
        lines: vec![line],
    };
    page::figure(
        &curves.svg(),
        "Equation (8) of all frames so far. The paper's rises in the same way.",
    )
}

/// Figure 4.
fn observations(seen: &Tisdale) -> Vec<String> {
    let flight = seen.shown();
    let steps: Vec<Step> = (1..=4).filter_map(|n| flight.nth_detection(n)).collect();
    let beliefs = beliefs_at(flight, &KINDS[FINE], &steps);
    let side_m = 100.0;
    let origin_m = flight.target.map(|x| x - side_m / 2.0);
    let picture = |(index, (belief, step)): (usize, (&Belief, &Step))| {
        let map = Map {
            title: format!("Detection {}, {} s", index + 1, flight.time_s(*step)),
            origin_m,
            side_m,
            marks: vec![
                Mark::Heat(window(belief, origin_m, side_m)),
                Mark::Cross(belief.gaussian().mean, 1),
                Mark::Star(flight.target),
            ],
        };
        page::figure(&map.svg(), "Density, mean (cross) and target (star).")
    };
    beliefs.iter().zip(&steps).enumerate().map(picture).collect()
}

/// Figure 5.
fn search(seen: &Tisdale) -> Vec<String> {
    let flight = seen.shown();
    let found_s = flight.detected_s().map(|time_s| time_s + AFTER_S);
    let steps: Vec<Step> =
        SEARCH_S.into_iter().chain(found_s).map(|time_s| flight.step_at(time_s)).collect();
    let mut pictures = Vec::new();
    for kind in [COARSE, PARTICLES] {
        for (belief, step) in beliefs_at(flight, &KINDS[kind], &steps).iter().zip(&steps) {
            let side_m = flight.config.ground.size_m[0].max(flight.config.ground.size_m[1]);
            let mut marks = match &belief.particles()[..] {
                [] => vec![Mark::Heat(heat(&belief.map()))],
                particles => vec![Mark::Dots(particles.to_vec())],
            };
            let until = step.0 as usize;
            marks.extend(flight.paths.iter().enumerate().map(|(index, path)| {
                Mark::Path(path[..=until.min(path.len() - 1)].to_vec(), index, Stroke::Thin)
            }));
            marks.push(Mark::Star(flight.target));
            let title = format!("{}, {} s", KINDS[kind].name, flight.time_s(*step));
            let map = Map { title, origin_m: [-side_m / 2.0; 2], side_m, marks };
            pictures.push(page::figure(&map.svg(), "Density, paths and target (star)."));
        }
    }
    pictures
}

/// Figure 6: means and one-sigma ellipses at the end; of the particles when they were surest.
fn ellipses(seen: &Tisdale) -> String {
    let flight = seen.shown();
    let surest = |estimates: &[Gaussian]| {
        let least = |a: &&Gaussian, b: &&Gaussian| a.sigma_m().total_cmp(&b.sigma_m());
        estimates.iter().min_by(least).copied()
    };
    let mut marks = Vec::new();
    for (series, (kind, curves)) in KINDS.iter().zip(&seen.curves).enumerate() {
        let estimate = match series {
            PARTICLES => surest(&curves.estimates),
            _ => curves.estimates.last().copied(),
        };
        if let Some(estimate) = estimate {
            marks.push(Mark::Ring(estimate.ellipse(1.0, CORNERS), series, kind.name.to_owned()));
            marks.push(Mark::Cross(estimate.mean, series));
        }
    }
    marks.push(Mark::Star(flight.target));
    let side_m = 40.0;
    let origin_m = flight.target.map(|x| x - side_m / 2.0);
    let title = "Means and one-sigma ellipses (figure 6)".to_owned();
    let note = "At the end of the flight; of the particles when their deviation was least, as in the paper. The \
                star is the target.";
    page::figure(&Map { title, origin_m, side_m, marks }.svg(), note)
}

/// Figure 7.
fn deviations(seen: &Tisdale) -> String {
    let flight = seen.shown();
    let start_s = flight.detected_s().unwrap_or_default();
    let span = [start_s, (start_s + SPAN_S).min(flight.time_s(Step(flight.steps)))];
    let [first, last] = span.map(|time_s| flight.step_at(time_s).0 as usize);
    let line = |(kind, curves): (&super::filters::Kind, &super::filters::Curves)| {
        let estimates = curves.estimates.iter().enumerate().take(last + 1).skip(first);
        let points = estimates.map(|(step, estimate)| Moment {
            x: flight.time_s(Step(step as u32)),
            mean: estimate.sigma_m().min(40.0),
            sd: 0.0,
        });
        Curve { name: kind.name.to_owned(), points: points.collect(), published: None }
    };
    let x = XAxis::between("time [s]", span, &ticks(span));
    let curves = Curves {
        title: "Deviation of the belief after the first detection (figure 7)",
        unit: "square root of the trace, m",
        x: &x,
        span,
        top: 40.0,
        lines: KINDS.iter().zip(&seen.curves).map(line).collect(),
    };
    let note = "From the first detection on; values above 40 m are drawn at 40 m. The particles are surest at once and then \
                lose it to their process noise; the coarse grid ends at the size of a cell.";
    page::figure(&curves.svg(), note)
}

/// A density relative to its greatest, in a window.
fn window(belief: &Belief, origin_m: [f64; 2], side_m: f64) -> Heat {
    let cell_m = 0.67;
    let cells = (side_m / cell_m).floor() as u32;
    let ln = |x: [f64; 2]| belief.at(x).map_or(f64::NEG_INFINITY, |(_, ln)| ln);
    let lns = raster(cells, cell_m, origin_m, ln);
    let peak = lns.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let values = lns.into_iter().map(|ln| (ln - peak).exp()).collect();
    Heat { cell_m, origin_m, columns: cells, maximum: 1.0, values }
}

fn heat(SearchMap { grid, mass }: &SearchMap) -> Heat {
    // What is not searched yet shows beside what was found.
    let uniform = 1.0 / mass.len() as f64;
    let maximum = mass.iter().copied().fold(0.0, f64::max).min(MOST_UNIFORM * uniform);
    let (cell_m, origin_m) = (grid.cell_m, grid.origin());
    Heat { cell_m, origin_m, columns: grid.columns, maximum, values: mass.clone() }
}

/// The values of a function at the centres of the cells of a square.
fn raster(cells: u32, cell_m: f64, origin_m: [f64; 2], of: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
    let centre = |axis: usize, index: u32| origin_m[axis] + (f64::from(index) + 0.5) * cell_m;
    let places = (0..cells).flat_map(|row| (0..cells).map(move |column| (column, row)));
    places.map(|(column, row)| of([centre(0, column), centre(1, row)])).collect()
}

/// Five places from end to end.
fn ticks([from, to]: [f64; 2]) -> Vec<f64> {
    (0..=4).map(|i| from + (to - from) * f64::from(i) / 4.0).collect()
}
