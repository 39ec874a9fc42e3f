//! The metrics of thesis §5.4.2, equations (5.36)-(5.45).

use std::collections::BTreeSet;

use csat_mission::measures::{Measures, Values};
use csat_proto::camera::CameraModel;
use csat_proto::ids::TargetId;
use csat_proto::model::Ground;
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::{Region, is_inside};

use super::merged::Merged;
use super::report::{Report, percent_of};

/// Side of the cells that coverage is counted in, metres.
const COVERAGE_CELL_M: f64 = 1.0;

/// Measures a run of the mission.
#[derive(Debug, Clone)]
pub struct SetMeasures {
    ground: Ground,
    camera: CameraModel,
    coverage: Coverage,
    merged: Merged,
}

impl SetMeasures {
    /// Before the first step of a mission of steps of `period_s`, seconds.
    pub fn new(ground: Ground, camera: CameraModel, period_s: f64) -> Self {
        let coverage = Coverage::new(ground, COVERAGE_CELL_M);
        Self { ground, camera, coverage, merged: Merged::new(period_s) }
    }
}

impl Measures<Report> for SetMeasures {
    fn fleet(&mut self, uavs: &[&Report], targets: &[[f64; 2]]) -> Values {
        let identified: BTreeSet<TargetId> =
            uavs.iter().flat_map(|report| report.targets.iter().map(|(j, _)| *j)).collect();
        let detected: BTreeSet<TargetId> =
            uavs.iter().flat_map(|report| report.detected.iter().copied()).collect();
        let mut footprints = Vec::new();
        for report in uavs {
            let footprint = footprint(&self.camera, report);
            if let Some(clear_ground) = &report.clear_ground {
                self.coverage.add(&footprint, clear_ground);
            }
            footprints.push(footprint);
        }
        let coverage = self.coverage.finish_step();
        let merged_m2 = self.merged.unexplored_m2(uavs);
        vec![
            ("fleet_unexplored_pct", merged_m2.map(|area_m2| percent_of(&self.ground, area_m2))),
            ("identified_union", Some(identified.len() as f64)),
            ("targets_detected", Some(detected.len() as f64)),
            ("targets_in_fov", Some(f64::from(targets_in_fov(&footprints, targets)))),
            ("footprint_pct", Some(coverage.footprint_pct)),
            ("ground_seen_pct", Some(coverage.ground_seen_pct)),
            ("explored_pct", Some(coverage.explored_pct)),
        ]
    }

    fn agent(&self, report: &Report, targets: &[[f64; 2]]) -> Values {
        let sets = report.targets.iter().map(|(j, set)| (*j, set));
        let localization = localization(sets, targets);
        let mut values = stats(&self.ground, report);
        values.extend([
            ("localization_error_m", localization.map(|l| l.error_m)),
            ("target_area_m2", localization.map(|l| l.area_m2)),
            ("target_radius_m", localization.map(|l| l.radius_m)),
        ]);
        values
    }
}

/// What an agent can tell of itself without the truth.
pub fn stats(ground: &Ground, report: &Report) -> Values {
    vec![
        ("identified", Some(report.targets.len() as f64)),
        ("unexplored_pct", Some(percent_of(ground, report.unexplored.area_m2()))),
        ("hidden_pct", Some(report.hidden_pct)),
        ("oem_iou_pct", report.oem_iou_pct),
        ("news_age_s", report.news_age_s),
        ("pose_error_m", report.pose_error_m),
        ("liars_named", Some(report.liars.len() as f64)),
        ("vertices", Some(f64::from(report.vertices()))),
    ]
}

/// F ∩ {z = 0} of the agent's last frame; empty without one.
pub fn footprint(camera: &CameraModel, report: &Report) -> Vec<[f64; 2]> {
    let has_seen = report.clear_ground.is_some();
    if has_seen { camera.at(&report.pose).footprint() } else { Vec::new() }
}

/// How well an agent knows its identified targets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Localization {
    /// Mean distance from the barycentre of the set to the target (5.36), metres.
    pub error_m: f64,
    /// Mean area of the sets (5.37), square metres.
    pub area_m2: f64,
    /// Mean radius of discs of those areas (5.38)-(5.39), metres.
    pub radius_m: f64,
}

/// (5.36)-(5.38): `sets` are the X_ij of all j in L_i, `locations` the true x^g_j by index. Sets
/// without area and indexes without a target do not count.
pub fn localization<'a>(
    sets: impl IntoIterator<Item = (TargetId, &'a Region)>,
    locations: &[[f64; 2]],
) -> Option<Localization> {
    let (mut count, mut sum) = (0.0, Localization { error_m: 0.0, area_m2: 0.0, radius_m: 0.0 });
    for (target, set) in sets {
        let (Some(centre), Some(truth)) = (set.barycentre(), locations.get(usize::from(target.0)))
        else {
            continue;
        };
        count += 1.0;
        sum.error_m += (centre[0] - truth[0]).hypot(centre[1] - truth[1]);
        sum.area_m2 += set.area_m2();
        sum.radius_m += equivalent_radius_m(set.area_m2());
    }
    (count > 0.0).then(|| Localization {
        error_m: sum.error_m / count,
        area_m2: sum.area_m2 / count,
        radius_m: sum.radius_m / count,
    })
}

/// φ^eq (5.39): the radius of a disc of this area, metres.
pub fn equivalent_radius_m(area_m2: f64) -> f64 {
    (area_m2 / std::f64::consts::PI).sqrt()
}

/// The number of targets in at least one footprint.
pub fn targets_in_fov(footprints: &[Vec<[f64; 2]>], locations: &[[f64; 2]]) -> u16 {
    let edges = |ring: &Vec<[f64; 2]>| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| [*a, *b]).collect::<Vec<_>>()
    };
    let footprints: Vec<Vec<[[f64; 2]; 2]>> = footprints.iter().map(edges).collect();
    let seen = |p: &&[f64; 2]| footprints.iter().any(|edges| is_inside(edges, **p));
    locations.iter().filter(seen).count() as u16
}

/// What the fleet watches and has watched, (5.40)-(5.42), on a raster.
#[derive(Debug, Clone)]
pub struct Coverage {
    ground: Ground,
    footprint: Raster,
    seen: Raster,
    explored: Raster,
}

/// (5.40)-(5.42) at one step, in per cent of the ground.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CoveragePct {
    /// Φ^FoV (5.40).
    pub footprint_pct: f64,
    /// Φ^g (5.41).
    pub ground_seen_pct: f64,
    /// Φ^{g,cum} (5.42).
    pub explored_pct: f64,
}

impl Coverage {
    /// Nothing watched yet. Areas are counted in cells of `cell_m`: 1 m makes an error below 0.1 %
    /// of the region.
    pub fn new(ground: Ground, cell_m: f64) -> Self {
        let empty = Raster::empty(Grid::covering(&ground, cell_m));
        Self { ground, footprint: empty.clone(), seen: empty.clone(), explored: empty }
    }

    /// Adds one UAV's footprint F and clear ground C of the current step.
    pub fn add(&mut self, footprint: &[[f64; 2]], clear_ground: &Region) {
        // Each ring on its own raster pass: two footprints that overlap must not cancel out.
        self.footprint.fill_rings(&[footprint]);
        self.seen.fill_region(clear_ground);
    }

    /// Ends the step.
    pub fn finish_step(&mut self) -> CoveragePct {
        self.explored.union_with(&self.seen);
        let percent = |raster: &Raster| percent_of(&self.ground, raster.area_m2()).min(100.0);
        let result = CoveragePct {
            footprint_pct: percent(&self.footprint),
            ground_seen_pct: percent(&self.seen),
            explored_pct: percent(&self.explored),
        };
        let empty = Raster::empty(*self.seen.grid());
        (self.footprint, self.seen) = (empty.clone(), empty);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::super::report::oem_iou_pct;
    use super::*;

    const GROUND: Ground = Ground { size_m: [100.0, 100.0] };

    fn square(x: f64, y: f64, side: f64) -> Region {
        let ring = [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
        Region::from_shapes(vec![vec![
            ring.iter().map(|&p| csat_proto::region::grid_point(p)).collect(),
        ]])
    }

    #[test]
    fn localization_by_hand() {
        let (a, b) = (square(0.0, 0.0, 2.0), square(10.0, 10.0, 4.0));
        let locations = [[1.0, 1.0], [0.0, 0.0], [12.0, 17.0]];
        let found = localization([(TargetId(0), &a), (TargetId(2), &b)], &locations).unwrap();
        assert!((found.error_m - 2.5).abs() < 1e-9);
        assert!((found.area_m2 - 10.0).abs() < 1e-9);
        let radius =
            ((4.0 / std::f64::consts::PI).sqrt() + (16.0 / std::f64::consts::PI).sqrt()) / 2.0;
        assert!((found.radius_m - radius).abs() < 1e-9);
        assert_eq!(localization([], &locations), None);
        assert_eq!(
            localization([(TargetId(9), &a), (TargetId(0), &Region::EMPTY)], &locations),
            None
        );
    }

    #[test]
    fn iou_by_hand() {
        let grid = Grid::covering(&GROUND, 1.0);
        let a = Raster::of_region(grid, &square(0.0, 0.0, 10.0));
        let b = Raster::of_region(grid, &square(5.0, 0.0, 10.0));
        assert!((oem_iou_pct(&a, &b).unwrap() - 100.0 / 3.0).abs() < 1e-9);
        assert_eq!(oem_iou_pct(&Raster::empty(grid), &Raster::empty(grid)), None);
    }

    #[test]
    fn coverage_is_a_union_and_cumulates() {
        let mut coverage = Coverage::new(GROUND, 1.0);
        let footprint = [[-60.0, 0.0], [0.0, 0.0], [0.0, 50.0], [-60.0, 50.0]];
        coverage.add(&footprint, &square(-50.0, 0.0, 10.0));
        coverage.add(&footprint, &square(-45.0, 0.0, 10.0));
        let first = coverage.finish_step();
        assert_eq!(
            first,
            CoveragePct { footprint_pct: 25.0, ground_seen_pct: 1.5, explored_pct: 1.5 }
        );
        coverage.add(&[], &square(0.0, 0.0, 10.0));
        let second = coverage.finish_step();
        assert_eq!(
            second,
            CoveragePct { footprint_pct: 0.0, ground_seen_pct: 1.0, explored_pct: 2.5 }
        );
    }

    #[test]
    fn targets_count_once_however_many_see_them() {
        let footprint = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let locations = [[5.0, 5.0], [50.0, 5.0], [1.0, 9.0]];
        assert_eq!(targets_in_fov(&[footprint.clone(), footprint], &locations), 2);
    }
}
