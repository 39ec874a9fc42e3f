//! Checks of measured sets and knowledge against the scene.

use csat_agent::estimate::state::Knowledge;
use csat_agent::sense::Measured;
use csat_experiments::set_membership::judge::TOLERANCE_M;
use csat_proto::oem::OemCell;
use csat_world::target::TargetTruth;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::geometry::{is_inside, points_in};
use crate::scenes::Case;

/// Rounding of a measured outer set to the grid, metres.
pub const ROUNDING_M: f64 = 2e-5;

/// The targets whose location the knowledge excludes, against the guarantee, with their distance from
/// its set, metres.
pub fn broken(knowledge: &Knowledge, targets: &[TargetTruth]) -> Vec<(TargetTruth, f64)> {
    let distance = |t: &TargetTruth| knowledge.set_of(t.id).region().distance_m(t.location);
    let all = targets.iter().map(|t| (*t, distance(t)));
    all.filter(|(_, distance)| *distance > TOLERANCE_M).collect()
}

/// Counts of what frames proved: a test whose frames prove nothing is worthless.
#[derive(Debug, Clone, Copy, Default)]
pub struct Said {
    /// Frames with clear ground.
    pub clear: u32,
    /// Frames with an obstacle margin.
    pub margins: u32,
    /// Points of margins that were checked.
    pub margin_points: u32,
    /// Detections.
    pub detections: u32,
    /// Detections with an exclusion.
    pub exclusions: u32,
    /// Targets outside an exclusion or margin and within a metre of it.
    pub close_calls: u32,
    /// Cells of the OEM called Empty.
    pub empty_cells: u32,
}

impl Said {
    /// Adds the counts of another frame.
    pub fn add(&mut self, other: &Said) {
        self.clear += other.clear;
        self.margins += other.margins;
        self.margin_points += other.margin_points;
        self.detections += other.detections;
        self.exclusions += other.exclusions;
        self.close_calls += other.close_calls;
        self.empty_cells += other.empty_cells;
    }
}

/// Checks all that a frame proved against the scene.
///
/// # Panics
/// When a set is wrong.
pub fn check_frame(case: &Case, measured: &Measured) -> Said {
    let mut said = Said {
        clear: u32::from(!measured.clear_ground.is_empty()),
        margins: u32::from(!measured.obstacle_margin.is_empty()),
        ..Said::default()
    };
    for target in &case.targets {
        let clear = measured.clear_ground.region().contains(target.location);
        assert!(!clear, "{target:?} stands on clear ground\n{case:?}");
        let margin = measured.obstacle_margin.region();
        assert!(!margin.contains(target.location), "{target:?} stands in S°\n{case:?}");
        said.close_calls += u32::from(margin.distance_m(target.location) < 1.0);
    }
    check_targets(case, measured, &mut said);
    check_margin(case, measured, &mut said);
    check_rasters(case, measured, &mut said);
    said
}

fn check_targets(case: &Case, measured: &Measured, said: &mut Said) {
    for seen in &measured.targets {
        said.detections += 1;
        said.exclusions += u32::from(!seen.exclusion.is_empty());
        for target in &case.targets {
            let p = target.location;
            if target.id == seen.target {
                let error_m = seen.location.region().distance_m(p);
                assert!(error_m <= ROUNDING_M, "{target:?} is {error_m} m out of X^tm\n{case:?}");
            } else {
                let excluded = seen.exclusion.region().contains(p);
                assert!(!excluded, "{target:?} is excluded by {}\n{case:?}", seen.target);
                said.close_calls += u32::from(seen.exclusion.region().distance_m(p) < 1.0);
            }
        }
    }
}

fn check_margin(case: &Case, measured: &Measured, said: &mut Said) {
    let mut rng = ChaCha8Rng::seed_from_u64(case.seed);
    let reach_m = case.config.targets.obstacle_distance_m;
    for p in points_in(measured.obstacle_margin.region(), 200, &mut rng) {
        let distance_m = case.distance_to_obstacles_m(p);
        assert!(
            distance_m <= reach_m,
            "{p:?} is in S° but {distance_m} m from the nearest obstacle, r_s^to = {reach_m} m\n\
             {case:?}"
        );
        said.margin_points += 1;
    }
}

fn check_rasters(case: &Case, measured: &Measured, said: &mut Said) {
    let (hidden, seen) = (&measured.hidden, &measured.seen);
    assert_eq!(hidden.count_common(seen), 0, "ground both hidden and seen\n{case:?}");
    for (column, row) in seen.iter() {
        let p = seen.grid().centre(column, row);
        let under = case.scene.prisms.iter().find(|prism| is_inside(&prism.rings, p));
        assert!(under.is_none(), "{p:?} was seen under {under:?}\n{case:?}");
    }
    let grid = case.config.oem_grid();
    for delta in &measured.oem {
        let (column, row) = (delta.cell % grid.columns, delta.cell / grid.columns);
        let p = grid.centre(column, row);
        match delta.state {
            OemCell::Empty => {
                said.empty_cells += 1;
                let under = case.obstacles().find(|rings| is_inside(rings, p));
                assert!(under.is_none(), "OEM cell at {p:?} is Empty under {under:?}\n{case:?}");
            }
            OemCell::Occupied { height_dm } => assert!(height_dm > 0, "{p:?}\n{case:?}"),
            OemCell::Unexplored => panic!("a frame cannot unexplore {p:?}\n{case:?}"),
        }
    }
}
