//! What is compared: the curves of thesis figures 5.9-5.14, whose means are its tables 5.3-5.6.

use crate::published::{Published, Row};

/// One curve.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// What people call it.
    pub title: &'static str,
    /// How a table calls it.
    pub short: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Where the thesis draws it.
    pub figure: &'static str,
    /// The most it can be.
    pub top: f64,
    /// The column whose mean over the agents it is.
    pub column: &'static str,
    /// The thesis's mean and deviation for a criterion.
    pub published: fn(&Row) -> Option<Published>,
}

impl Quantity {
    /// A value of the column, if it means anything: an agreement of maps is 0 only for a fleet that keeps none.
    pub fn defined(&self, value: Option<f64>) -> Option<f64> {
        value.filter(|value| self.column != OEM_IOU.column || *value > 0.0)
    }
}

const PCT: &str = "% of the region";

/// card(L).
pub const IDENTIFIED: Quantity = Quantity {
    title: "Identified targets",
    short: "identified",
    unit: "targets",
    figure: "figure 5.9, left",
    top: f64::INFINITY,
    column: "identified",
    published: |_| None,
};
/// Targets in some footprint.
pub const IN_FOOTPRINT: Quantity = Quantity {
    title: "Targets located in a footprint",
    short: "in a footprint",
    figure: "figure 5.9, right, black",
    column: "targets_in_fov",
    ..IDENTIFIED
};
/// card(∪ D_i).
pub const DETECTED: Quantity = Quantity {
    title: "Targets identified in a frame",
    short: "in a frame",
    figure: "figure 5.9, right, green",
    column: "targets_detected",
    ..IDENTIFIED
};
/// (5.36).
pub const ERROR: Quantity = Quantity {
    title: "Localisation error",
    short: "localisation error",
    unit: "m",
    figure: "figure 5.10, left",
    column: "localization_error_m",
    published: |row| Some(row.localization_error_m),
    ..IDENTIFIED
};
/// (5.38).
pub const RADIUS: Quantity = Quantity {
    title: "Target set, radius of equal area",
    short: "target radius",
    figure: "figure 5.10, bottom right",
    column: "target_radius_m",
    published: |row| Some(row.target_radius_m),
    ..ERROR
};
/// φ(X̄).
pub const UNEXPLORED: Quantity = Quantity {
    title: "Unexplored ground",
    short: "unexplored",
    unit: PCT,
    figure: "figure 5.11, solid",
    top: 100.0,
    column: "unexplored_pct",
    published: |row| Some(row.unexplored_pct),
};
/// φ(X̄ ∩ X^h).
pub const HIDDEN: Quantity = Quantity {
    title: "Hidden part of the unexplored ground",
    short: "hidden",
    figure: "figure 5.11, dashed",
    column: "hidden_pct",
    published: |row| Some(row.hidden_pct),
    ..UNEXPLORED
};
/// (5.40).
pub const FOOTPRINT: Quantity = Quantity {
    title: "Footprint of the fleet",
    short: "footprint",
    figure: "figure 5.12, black",
    column: "footprint_pct",
    published: |row| Some(row.footprint_pct),
    ..UNEXPLORED
};
/// (5.41).
pub const SEEN: Quantity = Quantity {
    title: "Ground seen",
    short: "ground seen",
    figure: "figure 5.12, green",
    column: "ground_seen_pct",
    published: |row| Some(row.ground_seen_pct),
    ..UNEXPLORED
};
/// (5.42).
pub const EXPLORED: Quantity = Quantity {
    title: "Explored ground",
    short: "explored",
    figure: "figure 5.13",
    column: "explored_pct",
    published: |row| Some(row.explored_pct),
    ..UNEXPLORED
};
/// (5.45). It is 0 only for a fleet that keeps no map, where it means nothing.
pub const OEM_IOU: Quantity = Quantity {
    title: "Occupancy-elevation map against hidden ground (IoU)",
    short: "OEM IoU",
    unit: "%",
    figure: "figure 5.14",
    column: "oem_iou_pct",
    published: |row| row.oem_iou_pct,
    ..UNEXPLORED
};
