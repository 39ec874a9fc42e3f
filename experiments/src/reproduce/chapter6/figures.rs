//! Figures 6.3 to 6.9 and A.10.

use csat_proto::region::{Region, metres};

use super::settings::{POSITION_M, RADII_M};
use super::sivia::{Cell, Paving};
use super::{Chapter6, PAVED_M, Seen};
use crate::report::curves::Curves;
use crate::report::page;
use crate::reproduce::chapter4::figures::{Covered, Value, curve, x_axis};
use crate::reproduce::chapter4::look::SEPARATIONS_M;
use crate::reproduce::chapter4::scene::{self, CARS_M, distance_m};
use crate::reproduce::map::{Map, Mark, Stroke};

/// The side of the window about a car, metres.
const WINDOW_M: f64 = 32.0;

/// All figures, as markup.
pub fn all(seen: &Chapter6) -> String {
    let parts = [
        ("Ground that is seen for certain", vec![paved(seen), footprints(seen)]),
        ("The car at 60 m", vec![car(seen, 0, &[0, 4], "Figure 6.5: exact and u4")]),
        (
            "Five cars, exact and u1 (figure 6.6)",
            (0..CARS_M.len()).map(|i| car(seen, i, &[0, 1], "")).collect(),
        ),
        ("Sizes (figure 6.7)", vec![sizes(&seen.seen[0]), sizes(&seen.seen[1])]),
        ("Exclusion over shadow (figure 6.8)", vec![exclusion(seen)]),
        (
            "Obstacle margins (figure 6.9)",
            POSITION_M.iter().zip(&seen.margins).map(|(m, r)| margins(*m, r)).collect(),
        ),
        ("Set inversion (figure A.10)", vec![ring(&seen.rings[3])]),
    ];
    parts.into_iter().fold("<h2>Figures</h2>\n".to_owned(), |markup, (title, figures)| {
        markup + &format!("<h3>{title}</h3>\n") + &page::figures(figures.into_iter())
    })
}

/// The rings of a region, metres.
fn rings(region: &Region) -> impl Iterator<Item = Vec<[f64; 2]>> {
    region.rings().map(|ring| ring.iter().map(|&p| metres(p)).collect())
}

/// A set in the colour of a series, named once.
fn marks(region: &Region, series: usize, name: &str) -> Vec<Mark> {
    let closed = |ring: Vec<[f64; 2]>| {
        let ends = ring.first().copied();
        ring.into_iter().chain(ends).collect::<Vec<_>>()
    };
    let paths = rings(region).map(|ring| Mark::Path(closed(ring), series, Stroke::Bold));
    paths.chain([Mark::Key(series, name.to_owned())]).collect()
}

fn figure(
    title: String,
    (origin_m, side_m): ([f64; 2], f64),
    marks: Vec<Mark>,
    note: &str,
) -> String {
    page::figure(&Map { title, origin_m, side_m, marks }.svg(), note)
}

fn boxes(cells: &[Cell], series: usize, name: &str) -> Vec<Mark> {
    let ring = |[x, y]: &Cell| {
        vec![[x.low, y.low], [x.high, y.low], [x.high, y.high], [x.low, y.high], [x.low, y.low]]
    };
    let paths = cells.iter().map(|cell| Mark::Path(ring(cell), series, Stroke::Thin));
    paths.chain([Mark::Key(series, name.to_owned())]).collect()
}

fn paving(paving: &Paving) -> Vec<Mark> {
    let mut marks = boxes(&paving.inside, 0, "seen from all poses");
    marks.extend(boxes(&paving.penumbra, 1, "seen from some"));
    marks.extend(boxes(&paving.border, 2, "not decided"));
    marks
}

fn paved(seen: &Chapter6) -> String {
    let mut all = paving(&seen.paving);
    all.extend(marks(&seen.seen[2].footprint, 3, "ours, from all poses"));
    figure(
        "Figure 6.3: u2 by Thick SIVIA".to_owned(),
        PAVED_M,
        all,
        "Boxes down to 2 m, and the set of csat.",
    )
}

fn footprints(seen: &Chapter6) -> String {
    let all = seen.seen.iter().enumerate();
    let mut all: Vec<Mark> =
        all.flat_map(|(i, one)| marks(&one.footprint, i, &one.uncertainty.name)).collect();
    all.extend((0..CARS_M.len()).map(|car| Mark::Star(scene::location(car))));
    figure("Figure 6.4: four boxes of poses".to_owned(), PAVED_M, all, "Stars: the cars.")
}

fn car(seen: &Chapter6, car: usize, which: &[usize], title: &str) -> String {
    let [x, y] = scene::location(car);
    let window = ([x - WINDOW_M / 2.0, y - WINDOW_M / 2.0], WINDOW_M);
    let mut all = Vec::new();
    for (i, one) in which.iter().map(|i| &seen.seen[*i]).enumerate() {
        let name = &one.uncertainty.name;
        all.extend(
            one.measured
                .get(car)
                .map(|set| marks(set, 2 * i, &format!("measured, {name}")))
                .unwrap_or_default(),
        );
        all.extend(
            one.sets
                .get(car)
                .map(|set| marks(set, 2 * i + 1, &format!("set, {name}")))
                .unwrap_or_default(),
        );
    }
    all.push(Mark::Star([x, y]));
    let title = if title.is_empty() {
        format!("The car {:.0} m away", distance_m(car))
    } else {
        title.to_owned()
    };
    figure(title, window, all, "")
}

fn sizes(one: &Seen) -> String {
    let (span, x) = x_axis();
    let values: [(&str, Value); 3] = [
        ("measured set", |seen| seen.measured_radius_m),
        ("set estimate", |seen| seen.set_radius_m),
        ("point error", |seen| seen.error_m),
    ];
    let lines = values.map(|(name, value)| curve(name, &one.looks, value)).to_vec();
    let title = format!("Radius of equal area, {}", one.uncertainty.name);
    let curves = Curves { title: &title, unit: "m", x: &x, span, top: f64::INFINITY, lines };
    page::figure(&curves.svg(), "Mean and one standard deviation over the looks.")
}

fn exclusion(seen: &Chapter6) -> String {
    let (span, x) = x_axis();
    let widest = SEPARATIONS_M.len() - 1;
    let ways: [(&str, Covered); 2] = [
        ("measured set", |seen| seen.covered_pct),
        ("set estimate", |seen| seen.covered_by_set_pct),
    ];
    let lines = seen.seen[..2].iter().flat_map(|one| {
        ways.map(|(way, covered)| {
            let name = format!("round the {way}, {}", one.uncertainty.name);
            curve(&name, &one.looks, |look| covered(look)[widest])
        })
    });
    let title = "Share of the ground behind a car without another car";
    let curves = Curves { title, unit: "%", x: &x, span, top: 100.0, lines: lines.collect() };
    page::figure(&curves.svg(), "Cars are 8 m apart.")
}

fn margins(half_m: f64, regions: &[Region]) -> String {
    let mut all = Vec::new();
    for (i, (radius_m, region)) in RADII_M.iter().zip(regions).enumerate().rev() {
        all.extend(marks(region, i, &format!("r_s^to = {radius_m} m")));
    }
    figure(format!("Errors of x and y of ±{half_m} m"), ([80.0, -80.0], 140.0), all, "")
}

fn ring(paved: &Paving) -> String {
    let names = ["inside for all p", "for some p", "not decided"];
    let all = [&paved.inside, &paved.penumbra, &paved.border].into_iter().zip(names).enumerate();
    let all = all.flat_map(|(i, (cells, name))| boxes(cells, i, name)).collect();
    figure("(A.21) by Thick SIVIA, p in [-0.5, 0.5]²".to_owned(), ([-5.0; 2], 10.0), all, "")
}
