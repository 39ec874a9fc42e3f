//! The numbers of a run that reports and comparisons show first.

use super::results;

/// What is drawn of a run.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// Its key in `sweep.csv`.
    pub key: &'static str,
    /// What people call it.
    pub title: &'static str,
    /// Unit of its axis.
    pub unit: &'static str,
    /// How it is called in a table.
    pub short: &'static str,
    /// The most it can be.
    pub top: f64,
    /// What there is to say under its plot.
    pub note: &'static str,
    /// Whether less of it is better; else more is.
    pub less_is_better: bool,
}

const NO_TOP: f64 = f64::INFINITY;
const SECOND_HALF: &str = "Mean over the second half of the mission and over the agents.";

/// Everything that is drawn, if the sweep has it.
pub const METRICS: [Metric; 9] = [
    Metric {
        key: "unexplored_pct",
        title: "Unexplored ground",
        unit: "% of the region",
        short: "unexplored, %",
        top: 100.0,
        note: SECOND_HALF,
        less_is_better: true,
    },
    Metric {
        key: "hidden_pct",
        title: "Hidden part of the unexplored ground",
        unit: "% of the region",
        short: "hidden, %",
        top: 100.0,
        note: SECOND_HALF,
        less_is_better: true,
    },
    Metric {
        key: "explored_pct",
        title: "Explored ground",
        unit: "% of the region",
        short: "explored, %",
        top: 100.0,
        note: SECOND_HALF,
        less_is_better: false,
    },
    Metric {
        key: results::RESTRICTED,
        title: "Time until the fleet has identified all targets",
        unit: "s",
        short: "all identified, s",
        top: NO_TOP,
        note: "Hollow triangles: runs that never identified all; they count with the mission's \
               length, so that means are lower bounds where there are any.",
        less_is_better: true,
    },
    Metric {
        key: "localization_error_m",
        title: "Localisation error",
        unit: "m",
        short: "localisation error, m",
        top: NO_TOP,
        note: SECOND_HALF,
        less_is_better: true,
    },
    Metric {
        key: "target_radius_m",
        title: "Target set, radius of equal area",
        unit: "m",
        short: "target radius, m",
        top: NO_TOP,
        note: SECOND_HALF,
        less_is_better: true,
    },
    Metric {
        key: "bytes_sent",
        title: "Bytes sent by all agents",
        unit: "bytes",
        short: "bytes sent",
        top: NO_TOP,
        note: "Each message once, however many hear it.",
        less_is_better: true,
    },
    Metric {
        key: results::DELIVERED,
        title: "Messages that arrived",
        unit: "% of those sent",
        short: "delivered, %",
        top: 100.0,
        note: "Per receiver.",
        less_is_better: false,
    },
    Metric {
        key: "violations",
        title: "Violations of what is guaranteed",
        unit: "count",
        short: "violations",
        top: NO_TOP,
        note: "Any other value than 0 is a fault of the program.",
        less_is_better: true,
    },
];
