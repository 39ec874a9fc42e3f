//! What is measured of the census.

use std::collections::BTreeSet;

use csat_mission::measures::{Column, Curve, Level, Measures, Milestone, Panel, Plot, Values};
use csat_proto::camera::CameraModel;
use csat_proto::ids::TargetId;
use csat_proto::model::Ground;
use csat_proto::raster::{Grid, Raster};

use crate::agent::Count;

/// Side of the cells in which the ground is counted, metres.
const CELL_M: f64 = 2.0;

/// The columns, in the order of `metrics.csv`.
pub const COLUMNS: &[Column] = &[
    Column::of_agent("counted", "counted", "targets")
        .defined("cars that the agent has counted or been told of", "")
        .count()
        .in_summary()
        .of_stations()
        .plotted(Plot::more("Cars that an agent knows of", "counted", "cars")),
    Column::of_agent("own", "by itself", "targets")
        .defined("of those, cars that its own camera saw first", "")
        .count(),
    Column::of_agent("error_m", "error", "m")
        .defined("from the place of a sighting to where the car is now", "")
        .over("agent, mean over the cars it has counted")
        .in_summary()
        .of_stations()
        .plotted(Plot::less("Distance to where the cars are now", "error, m", "m")),
    Column::of_fleet("counted_union", "counted", "targets")
        .defined("cars that at least one UAV has counted", "")
        .count()
        .last_as("counted_at_end"),
    Column::of_fleet("looked_at_pct", "looked at", "%")
        .defined("ground that was in the footprint of a UAV at least once", "")
        .in_summary()
        .plotted(
            Plot::more("Ground that was looked at", "looked at, %", "% of the region").up_to(100.0),
        ),
];

/// When all cars are counted.
pub const MILESTONES: &[Milestone] = &[Milestone {
    key: "all_counted_s",
    restricted: "all_counted_restricted_s",
    fleet: "counted_union",
    station: Some("counted"),
    level: Level::Targets,
    name: "all",
    meaning: "when all cars were counted; null if never",
    source: "",
    plot: Plot::less("Time until all cars are counted", "all counted, s", "s").note(
        "Hollow triangles: runs that never counted all; they count with the mission's length.",
    ),
}];

const BLUE: &str = "#0072b2";
const ORANGE: &str = "#d55e00";

/// What is drawn over time.
pub const PANELS: &[Panel] = &[
    Panel {
        title: "Cars counted",
        live: Some("Counted"),
        unit: "targets",
        axis: [1.0, f64::INFINITY],
        curves: &[
            Curve::new("counted_union", "by the fleet", ORANGE).wide(),
            Curve::new("counted", "by a UAV, mean", BLUE),
        ],
        of_stations: Some("counted"),
    },
    Panel {
        title: "Ground looked at",
        live: Some("Looked at"),
        unit: "%",
        axis: [100.0, 100.0],
        curves: &[Curve::new("looked_at_pct", "", BLUE)],
        of_stations: None,
    },
];

/// Measures a run.
pub struct Tallies {
    ground: Ground,
    camera: CameraModel,
    looked_at: Raster,
}

impl Tallies {
    /// Before the first step.
    pub fn new(ground: Ground, camera: CameraModel) -> Self {
        let looked_at = Raster::empty(Grid::covering(&ground, CELL_M));
        Self { ground, camera, looked_at }
    }
}

impl Measures<Count> for Tallies {
    fn fleet(&mut self, uavs: &[&Count], _: &[[f64; 2]]) -> Values {
        for report in uavs.iter().filter(|report| report.has_looked) {
            self.looked_at.fill_rings(&[self.camera.at(&report.pose).footprint()]);
        }
        let counted: BTreeSet<TargetId> =
            uavs.iter().flat_map(|report| report.sightings.keys().copied()).collect();
        let looked_at_pct = 100.0 * self.looked_at.area_m2() / self.ground.area_m2();
        vec![
            ("counted_union", Some(counted.len() as f64)),
            ("looked_at_pct", Some(looked_at_pct.min(100.0))),
        ]
    }

    fn agent(&self, report: &Count, targets: &[[f64; 2]]) -> Values {
        let errors_m = report.sightings.iter().filter_map(|(target, sighting)| {
            let [x, y] = targets.get(usize::from(target.0))?;
            Some((x - sighting.location[0]).hypot(y - sighting.location[1]))
        });
        let (count, sum_m) = errors_m.fold((0.0, 0.0), |(n, sum), error| (n + 1.0, sum + error));
        let mut values = stats(report);
        values.push(("error_m", (count > 0.0).then(|| sum_m / count)));
        values
    }
}

/// What an agent can tell of itself without the truth.
pub fn stats(report: &Count) -> Values {
    let own = report.sightings.values().filter(|sighting| sighting.by == report.agent).count();
    vec![("counted", Some(report.sightings.len() as f64)), ("own", Some(own as f64))]
}
