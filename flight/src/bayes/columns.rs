//! What is measured of the Bayesian search (Tisdale et al. 2008).

use csat_mission::measures::{Column, Curve, Level, Milestone, Panel, Plot};

const PAPER: &str = "Tisdale et al. (8), figure 3";

/// The columns, in the order of `metrics.csv`.
pub const COLUMNS: &[Column] = &[
    Column::of_agent("localization_error_m", "localisation error", "m")
        .defined("from the mean of its belief to the true location", "Tisdale et al. figure 6")
        .last_as("localization_error_m")
        .of_stations()
        .plotted(Plot::less("Localisation error at the end", "localisation error, m", "m").note("")),
    Column::of_agent("sigma_m", "sigma", "m")
        .defined("square root of the trace of the covariance of its belief", "Tisdale et al. figure 7")
        .last_as("sigma_m")
        .of_stations()
        .plotted(Plot::less("Deviation of the belief at the end", "sigma, m", "m").note("")),
    Column::of_agent("cumulative_detection", "P(D)", "")
        .defined(
            "probability that the frames whose factors it holds had detected the target, wherever it is; false \
             alarms do not count",
            PAPER,
        )
        .last_as("cumulative_detection")
        .of_stations()
        .plotted(
            Plot::more("Cumulative probability of detection at the end", "P(D)", "")
                .up_to(1.0)
                .note(""),
        ),
    Column::of_agent("in_95_region", "truth in the 95 % region", "")
        .defined(
            "whether the target is in the densest part of the region that holds 95 % of its belief; of the fleet, \
             the first UAV's",
            "",
        )
        .flag()
        .last_as("in_95_region")
        .of_stations()
        .plotted(
            Plot::more("Truth in the 95 % region at the end", "in the 95 % region", "share of runs")
                .up_to(1.0)
                .note("0.95 is calibrated; less is too sure."),
        ),
    Column::of_agent("factors_held_pct", "factors held", "%")
        .defined("share of all factors that UAVs stated which it holds", "")
        .last_as("factors_held_pct")
        .of_stations()
        .plotted(
            Plot::more("Factors held at the end", "factors held, %", "% of those stated")
                .up_to(100.0)
                .note(""),
        ),
    Column::of_agent("region_m2", "95 % region", "m²")
        .defined("area of that part", "")
        .last_as("region_m2"),
    Column::of_agent("left_out", "too late", "factors")
        .defined("factors that were too late to be filtered, for a target that moves", "")
        .count(),
    Column::of_fleet("true_detections", "detections", "frames")
        .defined(
            "frames of this step whose sighting is the target, and no false alarm",
            "Tisdale et al. figure 5",
        )
        .count(),
    Column::of_fleet("detections", "target detected in", "frames")
        .defined("sum of the true detections up to this step", "")
        .count()
        .last_as("detections"),
];

/// When the target is detected first.
pub const MILESTONES: &[Milestone] = &[Milestone {
    key: "first_detection_s",
    restricted: "first_detection_restricted_s",
    fleet: "detections",
    station: None,
    level: Level::Value(1.0),
    name: "first",
    meaning: "when a UAV detected the target for the first time; null if never",
    source: "Tisdale et al. figure 5",
    plot: Plot::less("Time until the target is detected", "first detection, s", "s").note(
        "Hollow triangles: runs that never detected it; they count with the mission's length, so that \
         means are lower bounds where there are any.",
    ),
}];

const BLUE: &str = "#0072b2";
const ORANGE: &str = "#d55e00";

/// The panels of `metrics.svg`, two to a row, and of the live page.
pub const PANELS: &[Panel] = &[
    Panel {
        title: "Cumulative probability of detection P(D) (fig. 3)",
        live: Some("P(D)"),
        unit: "",
        axis: [1.0, 1.0],
        curves: &[Curve::new("cumulative_detection", "", BLUE)],
        of_stations: Some("cumulative_detection"),
    },
    Panel {
        title: "Deviation of the belief (fig. 7)",
        live: Some("Sigma"),
        unit: "m",
        axis: [10.0, 450.0],
        curves: &[Curve::new("sigma_m", "", BLUE)],
        of_stations: Some("sigma_m"),
    },
    Panel {
        title: "Localisation error",
        live: Some("Error"),
        unit: "m",
        axis: [10.0, 700.0],
        curves: &[
            Curve::new("localization_error_m", "error", ORANGE).wide(),
            Curve::new("sigma_m", "sigma", BLUE),
        ],
        of_stations: Some("localization_error_m"),
    },
    Panel {
        title: "Factors held, of all that were stated",
        live: Some("Factors held"),
        unit: "%",
        axis: [100.0, 100.0],
        curves: &[Curve::new("factors_held_pct", "", BLUE)],
        of_stations: Some("factors_held_pct"),
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use csat_mission::measures::index_of;

    #[test]
    fn panels_and_milestones_name_columns_that_exist() {
        let curves = PANELS.iter().flat_map(|panel| panel.curves);
        let stations = PANELS.iter().filter_map(|panel| panel.of_stations);
        let milestones = MILESTONES.iter().map(|m| m.fleet);
        for key in curves.map(|curve| curve.column).chain(stations).chain(milestones) {
            assert!(index_of(COLUMNS, key).is_some(), "{key}");
        }
    }
}
