//! The panels of `metrics.svg` and their curves.

use plotters::style::RGBColor;

use crate::published::{Published, Row, reference};
use crate::series::Point;

const BLUE: RGBColor = RGBColor(0, 114, 178);
const ORANGE: RGBColor = RGBColor(213, 94, 0);
/// Curves of stations: as many as the legends name.
pub const STATIONS: [RGBColor; 4] =
    [RGBColor(93, 58, 155), RGBColor(140, 81, 10), RGBColor(204, 121, 167), RGBColor(86, 180, 233)];
/// Curves of what is merely there.
pub const GREY: RGBColor = RGBColor(90, 90, 90);
/// Words.
pub const TEXT: RGBColor = RGBColor(34, 34, 34);

/// One curve of a panel.
pub struct Curve {
    /// Its name in the legend; empty in a panel of one curve.
    pub name: &'static str,
    /// Its colour.
    pub colour: RGBColor,
    /// Its value at a step, if it has one.
    pub value: fn(&Point) -> Option<f64>,
    /// The thesis's mean.
    pub published: Option<Published>,
    /// How thick it is, pixels.
    pub width_px: u32,
}

/// One panel.
pub struct Panel {
    /// What it shows, and where the thesis shows it.
    pub title: &'static str,
    /// Unit of its axis.
    pub unit: &'static str,
    /// The top of the axis is at least and at most this.
    pub axis: [f64; 2],
    /// What is drawn.
    pub curves: Vec<Curve>,
    /// What is drawn of each station, if anything.
    pub of_station: Option<fn(&Point) -> Option<f64>>,
}

/// What a mission's curves are set beside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// The thesis's means.
    Thesis,
    /// Nothing: the mission is another than the thesis's.
    Nothing,
}

/// All panels, two to a row.
pub fn panels(beside: Beside) -> Vec<Panel> {
    let mut panels = with_thesis();
    if beside == Beside::Nothing {
        panels.iter_mut().flat_map(|panel| &mut panel.curves).for_each(|c| c.published = None);
    }
    panels
}

fn with_thesis() -> Vec<Panel> {
    let thesis = reference().chapter5.str3_kappa1;
    let [identified, in_view] = target_panels();
    let [unexplored, ground_in_view] = ground_panels(&thesis);
    vec![
        identified,
        in_view,
        Panel::single("Localisation error (fig. 5.10)", "m", [2.0, 15.0], |p| {
            p.means.localization_error_m
        })
        .with_stations()
        .beside(thesis.localization_error_m),
        Panel::single("Target set, radius of equal area (fig. 5.10)", "m", [20.0, 100.0], |p| {
            p.means.target_radius_m
        })
        .with_stations()
        .beside(thesis.target_radius_m),
        unexplored,
        ground_in_view,
        Panel::single("Explored ground (fig. 5.13)", "%", [100.0, 100.0], |p| {
            Some(p.means.explored_pct)
        })
        .beside(thesis.explored_pct),
        Panel::single(
            "OEM against hidden ground, intersection over union (fig. 5.14)",
            "%",
            [100.0, 100.0],
            |p| p.means.oem_iou_pct,
        )
        .beside(thesis.oem_iou_pct),
    ]
}

fn target_panels() -> [Panel; 2] {
    let fleet = |p: &Point| Some(f64::from(p.identified_union));
    let located = |p: &Point| Some(f64::from(p.targets_in_fov));
    let detected = |p: &Point| Some(f64::from(p.targets_detected));
    let axis = [1.0, f64::INFINITY];
    let panel = |title, curves| Panel { title, unit: "targets", axis, curves, of_station: None };
    [
        Panel {
            of_station: Some(|p| Some(p.identified)),
            ..panel(
                "Identified targets (fig. 5.9 left)",
                vec![
                    // Where they agree, the wider one shows on both sides of the other.
                    Curve::new("by the fleet", ORANGE, fleet).wide(),
                    Curve::new("by a UAV, mean", BLUE, |p| Some(p.identified)),
                ],
            )
        },
        panel(
            "Targets in view (fig. 5.9 right)",
            vec![
                Curve::new("located in a footprint", GREY, located),
                Curve::new("identified in a frame", ORANGE, detected),
            ],
        ),
    ]
}

fn ground_panels(thesis: &Row) -> [Panel; 2] {
    let axis = [10.0, 100.0];
    let panel = |title, curves| Panel { title, unit: "%", axis, curves, of_station: None };
    [
        panel(
            "Unexplored ground (fig. 5.11)",
            vec![
                Curve::new("unexplored", BLUE, |p| Some(p.means.unexplored_pct))
                    .beside(thesis.unexplored_pct),
                Curve::new("its hidden part", ORANGE, |p| Some(p.means.hidden_pct))
                    .beside(thesis.hidden_pct),
            ],
        )
        .with_stations(),
        panel(
            "Ground in view (fig. 5.12)",
            vec![
                Curve::new("footprint", BLUE, |p| Some(p.means.footprint_pct))
                    .beside(thesis.footprint_pct),
                Curve::new("seen as ground", ORANGE, |p| Some(p.means.ground_seen_pct))
                    .beside(thesis.ground_seen_pct),
            ],
        ),
    ]
}

impl Curve {
    fn new(name: &'static str, colour: RGBColor, value: fn(&Point) -> Option<f64>) -> Self {
        Self { name, colour, value, published: None, width_px: 2 }
    }

    /// To be seen under another one.
    fn wide(self) -> Self {
        Self { width_px: 5, ..self }
    }

    /// With the thesis's mean.
    fn beside(self, published: impl Into<Option<Published>>) -> Self {
        Self { published: published.into(), ..self }
    }
}

impl Panel {
    /// A panel of one curve without a name.
    fn single(
        title: &'static str,
        unit: &'static str,
        axis: [f64; 2],
        value: fn(&Point) -> Option<f64>,
    ) -> Self {
        let curves = vec![Curve::new("", BLUE, value)];
        Self { title, unit, axis, curves, of_station: None }
    }

    /// With the first curve of each station, too.
    fn with_stations(self) -> Self {
        Self { of_station: self.curves.first().map(|curve| curve.value), ..self }
    }

    /// With the thesis's mean.
    fn beside(mut self, published: impl Into<Option<Published>>) -> Self {
        let published = published.into();
        self.curves = self.curves.into_iter().map(|c| c.beside(published)).collect();
        self
    }
}
