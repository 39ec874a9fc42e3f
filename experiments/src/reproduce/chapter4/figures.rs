//! Figures 4.11-4.19 and A.3: numbers against distance.

use super::Chapter4;
use super::look::{Looks, SEPARATIONS_M, Seen};
use super::scene::{CARS_M, distance_m};
use crate::report::axis::XAxis;
use crate::report::curves::{Curve, Curves, Moment};
use crate::report::page;
use crate::report::shapes::escaped;

/// A number of a car in a frame.
pub type Value = fn(&Seen) -> f64;
/// How much of a car's shadow is covered, by the distance between cars.
pub type Covered = fn(&Seen) -> [f64; SEPARATIONS_M.len()];

/// What all figures but 4.19 show.
const SIZES: [(&str, Value); 3] = [
    ("Measured set, radius of equal area", |seen| seen.measured_radius_m),
    ("Set estimate, radius of equal area", |seen| seen.set_radius_m),
    ("Point error of the set estimate", |seen| seen.error_m),
];
const NOTE: &str = "Mean and one standard deviation over the looks.";

/// All figures, as markup.
pub fn all(seen: &Chapter4) -> String {
    let (span, x) = x_axis();
    let chart = |title: &str, unit: &str, top: f64, lines: Vec<Curve>| {
        page::figure(&Curves { title, unit, x: &x, span, top, lines }.svg(), NOTE)
    };
    let sizes = SIZES.iter().map(|(name, value)| curve(name, seen.plain(), *value)).collect();
    let covered = |covered: Covered| -> Vec<Curve> {
        let lines = SEPARATIONS_M.iter().enumerate().map(|(i, separation_m)| {
            curve(&format!("cars {separation_m} m apart"), seen.plain(), |seen| covered(seen)[i])
        });
        lines.collect()
    };
    let plain = [
        chart("One look (thesis figure 4.11)", "m", f64::INFINITY, sizes),
        chart(
            "Exclusion over shadow (thesis figure 4.19)",
            "%",
            100.0,
            covered(|seen| seen.covered_pct),
        ),
        chart(
            "The same by the exclusion round the set estimate",
            "%",
            100.0,
            covered(|seen| seen.covered_by_set_pct),
        ),
    ];
    let mut markup = "<h2>Figures</h2>\n".to_owned() + &page::figures(plain.into_iter());
    for (family, looks) in &seen.families {
        markup += &format!("<h3>{} ({})</h3>\n", escaped(family.title), escaped(family.figure));
        markup += &page::figures(SIZES.iter().map(|(title, value)| {
            let lines = family.settings.iter().zip(looks);
            let lines = lines.map(|(setting, looks)| curve(&setting.name, looks, *value)).collect();
            chart(title, "m", f64::INFINITY, lines)
        }));
    }
    markup
}

/// The distances of the cars: what is at the ends, and the axis.
pub fn x_axis() -> ([f64; 2], XAxis) {
    let span = [distance_m(0), distance_m(CARS_M.len() - 1)];
    let ticks: Vec<f64> = (0..CARS_M.len()).map(|car| distance_m(car).round()).collect();
    (span, XAxis::between("distance from the UAV [m]", span, &ticks))
}

/// A number against the distance of the cars: mean and spread over the looks.
pub fn curve(name: &str, looks: &Looks, value: impl Fn(&Seen) -> f64) -> Curve {
    let points =
        (0..CARS_M.len()).filter_map(|car| Moment::of(distance_m(car), &looks.values(car, &value)));
    Curve { name: name.to_owned(), points: points.collect(), published: None }
}
