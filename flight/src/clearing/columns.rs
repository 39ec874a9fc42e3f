//! What is measured of road clearing (Gagliardi et al. 2014).

use csat_mission::measures::{Column, Curve, Level, Milestone, Panel, Plot};

const PAPER: &str = "Gagliardi et al. figure 10a";
const ELLIS: &str = "Ellis, Sudborough, Turner 1994";
const KIROUSIS: &str = "Kirousis, Papadimitriou 1986";

/// The columns, in the order of `metrics.csv`.
pub const COLUMNS: &[Column] = &[
    Column::of_agent("duty", "duty", "")
        .defined("0 cleaner, 1 wing, 2 tail, 3 helper", "Gagliardi et al. V")
        .count(),
    Column::of_agent("frontier_m", "frontier", "m")
        .defined("length of the frontier that it holds: pixels of the image times their side", "Gagliardi et al. (8), (9)"),
    Column::of_agent("cleared_by_uav_pct", "cleared by it", "% of R_S")
        .defined("area of R_S that it was the first to clear", PAPER)
        .last_as("cleared_by_uav_pct")
        .plotted(Plot::more("Cleared by each UAV at the end", "cleared by a UAV, %", "% of R_S").note("")),
    Column::of_agent("path_m", "path", "m")
        .defined("length of the path that it has flown, in truth", "Gagliardi et al. figure 10b")
        .last_as("path_m")
        .plotted(Plot::less("Path of each UAV at the end", "path, m", "m").note("")),
    Column::of_agent("hbsr_bytes", "short range", "bytes")
        .defined("bytes said on `clearing.hbsr` in this step", "")
        .count(),
    Column::of_agent("lblr_bytes", "long range", "bytes")
        .defined("bytes said on `clearing.lblr` in this step", "")
        .count(),
    Column::of_fleet("cleared_pct", "cleared", "% of R_S")
        .defined("area of R_S that the fleet says is cleared", PAPER)
        .last_as("cleared_pct")
        .plotted(Plot::more("Cleared at the end", "cleared, %", "% of R_S").up_to(100.0).note("")),
    Column::of_fleet("contaminated_pct", "contaminated", "% of R_S")
        .defined("area of R_S where an evader may be that nobody saw, of any speed", "Gagliardi et al. (2)")
        .last_as("contaminated_pct"),
    Column::of_fleet("is_cleared", "all cleared", "")
        .defined("whether no such evader is left in R_S", "Gagliardi et al. proposition 1")
        .flag(),
    Column::of_fleet("cleaners", "cleaners", "UAVs").defined("UAVs whose images clear", "").count(),
    Column::of_fleet("cleaners_max", "most cleaners", "UAVs")
        .defined("the most cleaners so far", "")
        .count()
        .last_as("cleaners_max")
        .plotted(Plot::less("The most cleaners at a time", "cleaners", "UAVs").note("")),
    Column::of_fleet("edge_search_at_least", "edge search number, at least", "searchers")
        .defined("the fewest searchers, seeing a point each and flying along the centre lines of R_S, that clear them: \
                  a lower bound", ELLIS)
        .count()
        .last_as("edge_search_at_least"),
    Column::of_fleet("edge_search_at_most", "edge search number, at most", "searchers")
        .defined("the same: an upper bound, equal to the lower one where the number is known", ELLIS)
        .count()
        .last_as("edge_search_at_most"),
    Column::of_fleet("node_search_at_least", "node search number, at least", "searchers")
        .defined("the same of searchers that guard junctions and dead ends only, and fly from any to any: a lower bound",
                 KIROUSIS)
        .count()
        .last_as("node_search_at_least"),
    Column::of_fleet("node_search_at_most", "node search number, at most", "searchers")
        .defined("the same: an upper bound", KIROUSIS)
        .count()
        .last_as("node_search_at_most"),
    Column::of_fleet("splits", "splits", "")
        .defined("sub-frontiers that a wing took over so far", "Gagliardi et al. III-B")
        .count()
        .last_as("splits"),
    Column::of_fleet("encounters", "encounters", "")
        .defined("times that a cleaner's frontier shrank because another one had cleared the road beyond", "Gagliardi et al. III-B")
        .count()
        .last_as("encounters"),
    Column::of_fleet("merges", "merges", "")
        .defined("helpers that joined a formation so far", "Gagliardi et al. V")
        .count()
        .last_as("merges"),
    Column::of_fleet("stalled", "stalled", "")
        .defined("whether a cleaner says that it can neither move nor split its frontier", "")
        .flag()
        .last_as("stalled"),
    Column::of_fleet("lost", "lost", "")
        .defined("whether a UAV says that a cleaner, and so its frontier, is lost: the fleet claims nothing then", "")
        .flag()
        .last_as("lost"),
];

/// When the network is cleared.
pub const MILESTONES: &[Milestone] = &[Milestone {
    key: "cleared_s",
    restricted: "cleared_restricted_s",
    fleet: "is_cleared",
    station: None,
    level: Level::Value(1.0),
    name: "cleared",
    meaning: "when no undetected evader was left in R_S; null if never",
    source: "Gagliardi et al. proposition 1",
    plot: Plot::less("Time until the network is cleared", "cleared, s", "s").note(
        "Hollow triangles: runs that never cleared it; they count with the mission's length, so that means are lower \
         bounds where there are any.",
    ),
}];

const GREEN: &str = "#1b7837";
const RED: &str = "#b2182b";
const BLUE: &str = "#0072b2";
const ORANGE: &str = "#d55e00";

/// The panels of `metrics.svg`, two to a row, and of the live page.
pub const PANELS: &[Panel] = &[
    Panel {
        title: "Cleared share of the roads (fig. 10a)",
        live: Some("Cleared"),
        unit: "%",
        axis: [100.0, 100.0],
        curves: &[
            Curve::new("cleared_pct", "cleared", GREEN).wide(),
            Curve::new("contaminated_pct", "contaminated", RED),
        ],
        of_stations: None,
    },
    Panel {
        title: "Cleaners",
        live: Some("Cleaners"),
        unit: "UAVs",
        axis: [4.0, 64.0],
        curves: &[Curve::new("cleaners", "", BLUE)],
        of_stations: None,
    },
    Panel {
        title: "Path, mean of the UAVs (fig. 10b)",
        live: Some("Path"),
        unit: "m",
        axis: [100.0, 1e6],
        curves: &[Curve::new("path_m", "", ORANGE)],
        of_stations: None,
    },
    Panel {
        title: "Frontier, mean of the UAVs",
        live: Some("Frontier"),
        unit: "m",
        axis: [5.0, 1e4],
        curves: &[Curve::new("frontier_m", "", BLUE)],
        of_stations: None,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use csat_mission::measures::index_of;

    #[test]
    fn panels_and_milestones_name_columns_that_exist() {
        let curves = PANELS.iter().flat_map(|panel| panel.curves).map(|curve| curve.column);
        for key in curves.chain(MILESTONES.iter().map(|milestone| milestone.fleet)) {
            assert!(index_of(COLUMNS, key).is_some(), "{key}");
        }
    }
}
