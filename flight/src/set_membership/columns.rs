//! What is measured of the set-membership mission: thesis §5.4.2 and figures 5.9-5.14.

use csat_mission::measures::{Column, Curve, Level, Milestone, Panel, Plot};

use crate::published::{Row, reference};

const PCT: &str = "% of the region";
const OVER_IDENTIFIED: &str = "agent, mean over its identified targets";

/// The columns, in the order of `metrics.csv`.
pub const COLUMNS: &[Column] = &[
    Column::of_agent("identified", "identified", "targets")
        .defined("card(L_i), the targets it knows of", "thesis figure 5.9")
        .count()
        .of_stations(),
    Column::of_agent("localization_error_m", "localisation error", "m")
        .defined(
            "e^t_i, from the barycentre of X_ij to the true location; nothing while L_i is empty",
            "thesis (5.36)",
        )
        .over(OVER_IDENTIFIED)
        .in_summary()
        .of_stations()
        .plotted(Plot::less("Localisation error", "localisation error, m", "m")),
    Column::of_agent("target_area_m2", "target area", "m²")
        .defined("Φ^t_i, area of X_ij; nothing while L_i is empty", "thesis (5.37)")
        .over(OVER_IDENTIFIED),
    Column::of_agent("target_radius_m", "target radius", "m")
        .defined(
            "Φ^{t,eq}_i, radius of a disc of the area of X_ij; nothing while L_i is empty",
            "thesis (5.38), (5.39)",
        )
        .over(OVER_IDENTIFIED)
        .in_summary()
        .of_stations()
        .plotted(Plot::less("Target set, radius of equal area", "target radius, m", "m")),
    Column::of_agent("unexplored_pct", "unexplored", "%")
        .defined("φ(X̄_i), ground where targets not identified may be", "thesis figure 5.11")
        .in_summary()
        .of_stations()
        .plotted(Plot::less("Unexplored ground", "unexplored, %", PCT).up_to(100.0)),
    Column::of_agent("hidden_pct", "hidden", "%")
        .defined(
            "φ(X̄_i ∩ X^h_i), the part of it that obstacles hid and that was not seen since",
            "thesis (5.43), (5.44)",
        )
        .in_summary()
        .of_stations()
        .plotted(
            Plot::less("Hidden part of the unexplored ground", "hidden, %", PCT).up_to(100.0),
        ),
    Column::of_agent("oem_iou_pct", "OEM agreement", "%")
        .defined(
            "hidden ground, as its frame shows it and as its occupancy-elevation map predicts it: \
             intersection over union, % of the union; nothing where both are empty",
            "thesis (5.45), one UAV's term",
        )
        .in_summary(),
    Column::of_agent("news_age_s", "age of news", "s")
        .defined(
            "how old the newest frame of a UAV is that it heard of from that UAV; nothing without others",
            "",
        )
        .over("agent, mean over the other UAVs")
        .of_stations(),
    Column::of_agent("pose_error_m", "error of the position", "m")
        .defined(
            "greater half-width of the box of its position over the ground; nothing where poses are exact",
            "thesis (6.1)-(6.3)",
        )
        .in_summary(),
    Column::of_agent("liars_named", "agents named as liars", "agents")
        .defined("agents that it has proven to have said something false ([liars.md](liars.md))", "")
        .count(),
    Column::of_agent("vertices", "vertices of sets", "corners")
        .defined("of all its sets together", "")
        .count(),
    Column::of_fleet("identified_union", "identified", "targets")
        .defined("card(∪ L_i)", "thesis figure 5.9")
        .count()
        .last_as("identified"),
    Column::of_fleet("fleet_unexplored_pct", "unexplored by the fleet", "%")
        .defined(
            "φ(∩ X̄_i), ground where targets that no UAV has identified may be: what a UAV would have left unexplored \
             that knew all that the UAVs know; measured once a second, and never above the least of their \
             `unexplored_pct`",
            "",
        )
        .in_summary()
        .plotted(
            Plot::less("Ground that the UAVs together leave unexplored", "unexplored by the fleet, %", PCT)
                .up_to(100.0),
        ),
    Column::of_fleet("false_agents", "agents with false frames", "agents")
        .defined(
            "whose cameras have shown something false so far: liars, and those that took a target for another one; the \
             guarantee is not demanded of them",
            "",
        )
        .count()
        .last_as("false_agents"),
    Column::of_fleet("targets_in_fov", "targets in a footprint", "targets")
        .defined(
            "whose true location lies in the footprint of at least one UAV",
            "thesis figure 5.9",
        )
        .count(),
    Column::of_fleet("targets_detected", "targets in a frame", "targets")
        .defined(
            "card(∪ D_i), identified in at least one frame of this step",
            "thesis figure 5.9",
        )
        .count(),
    Column::of_fleet("footprint_pct", "footprint", "%")
        .defined("Φ^FoV, within the footprint of at least one UAV", "thesis (5.40)")
        .in_summary(),
    Column::of_fleet("ground_seen_pct", "ground seen", "%")
        .defined("Φ^g, seen as ground by at least one UAV", "thesis (5.41)")
        .in_summary(),
    Column::of_fleet("explored_pct", "explored", "%")
        .defined("Φ^{g,cum}, seen as ground at this step or before", "thesis (5.42)")
        .in_summary()
        .plotted(Plot::more("Explored ground", "explored, %", PCT).up_to(100.0)),
];

/// When all targets are identified.
pub const MILESTONES: &[Milestone] = &[Milestone {
    key: "all_identified_s",
    restricted: "all_identified_restricted_s",
    fleet: "identified_union",
    station: Some("identified"),
    level: Level::Targets,
    name: "all",
    meaning: "when all targets were identified; null if never",
    source: "thesis §5.4.3",
    plot: Plot::less("Time until the fleet has identified all targets", "all identified, s", "s")
        .note(
            "Hollow triangles: runs that never identified all; they count with the mission's \
             length, so that means are lower bounds where there are any.",
        ),
}];

const BLUE: &str = "#0072b2";
const ORANGE: &str = "#d55e00";
const GREY: &str = "#5a5a5a";

/// The panels of `metrics.svg`, two to a row, and of the live page.
pub const PANELS: &[Panel] = &[
    Panel {
        title: "Identified targets (fig. 5.9 left)",
        live: Some("Identified"),
        unit: "targets",
        axis: [1.0, f64::INFINITY],
        curves: &[
            // Where they agree, the wider one shows on both sides of the other.
            Curve::new("identified_union", "by the fleet", ORANGE).wide(),
            Curve::new("identified", "by a UAV, mean", BLUE),
        ],
        of_stations: Some("identified"),
    },
    Panel {
        title: "Targets in view (fig. 5.9 right)",
        live: None,
        unit: "targets",
        axis: [1.0, f64::INFINITY],
        curves: &[
            Curve::new("targets_in_fov", "located in a footprint", GREY),
            Curve::new("targets_detected", "identified in a frame", ORANGE),
        ],
        of_stations: None,
    },
    Panel {
        title: "Localisation error (fig. 5.10)",
        live: Some("Localisation"),
        unit: "m",
        axis: [2.0, 15.0],
        curves: &[
            Curve::new("localization_error_m", "", BLUE).beside(|| thesis().localization_error_m)
        ],
        of_stations: Some("localization_error_m"),
    },
    Panel {
        title: "Target set, radius of equal area (fig. 5.10)",
        live: None,
        unit: "m",
        axis: [20.0, 100.0],
        curves: &[Curve::new("target_radius_m", "", BLUE).beside(|| thesis().target_radius_m)],
        of_stations: Some("target_radius_m"),
    },
    Panel {
        title: "Unexplored ground (fig. 5.11)",
        live: Some("Unexplored"),
        unit: "%",
        axis: [10.0, 100.0],
        curves: &[
            Curve::new("unexplored_pct", "unexplored", BLUE)
                .beside(|| thesis().unexplored_pct)
                .wide(),
            Curve::new("hidden_pct", "its hidden part", ORANGE).beside(|| thesis().hidden_pct),
            Curve::new("fleet_unexplored_pct", "by the fleet together", GREY),
        ],
        of_stations: Some("unexplored_pct"),
    },
    Panel {
        title: "Ground in view (fig. 5.12)",
        live: None,
        unit: "%",
        axis: [10.0, 100.0],
        curves: &[
            Curve::new("footprint_pct", "footprint", BLUE).beside(|| thesis().footprint_pct),
            Curve::new("ground_seen_pct", "seen as ground", ORANGE)
                .beside(|| thesis().ground_seen_pct),
        ],
        of_stations: None,
    },
    Panel {
        title: "Explored ground (fig. 5.13)",
        live: Some("Explored"),
        unit: "%",
        axis: [100.0, 100.0],
        curves: &[Curve::new("explored_pct", "", BLUE).beside(|| thesis().explored_pct)],
        of_stations: None,
    },
    Panel {
        title: "OEM against hidden ground, intersection over union (fig. 5.14)",
        live: None,
        unit: "%",
        axis: [100.0, 100.0],
        curves: &[Curve::new("oem_iou_pct", "", BLUE)
            .beside(|| thesis().oem_iou_pct.expect("the embedded table has it"))],
        of_stations: None,
    },
];

/// What the thesis's best criterion came to.
fn thesis() -> Row {
    reference().chapter5.str3_kappa1
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_mission::measures::index_of;

    #[test]
    fn panels_and_milestones_name_columns_that_exist() {
        let curves = PANELS.iter().flat_map(|panel| panel.curves);
        let stations = PANELS.iter().filter_map(|panel| panel.of_stations);
        let milestones = MILESTONES.iter().flat_map(|m| [Some(m.fleet), m.station]).flatten();
        for key in curves.map(|curve| curve.column).chain(stations).chain(milestones) {
            assert!(index_of(COLUMNS, key).is_some(), "{key}");
        }
        for published in PANELS.iter().flat_map(|p| p.curves).filter_map(|c| c.published) {
            assert!(published()[0] > 0.0);
        }
    }
}
