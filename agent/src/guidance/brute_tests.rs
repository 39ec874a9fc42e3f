//! The search against brute force, against mirrored scenes, and repeated.

use csat_proto::oem::OemDelta;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::shadow::hides_point;
use super::tests::{CRITERIA, Scene, default_config, fill};
use super::*;
use crate::config::Criterion;

/// A random scene on a region small enough for brute force.
fn random_scene(config: &AgentConfig, rng: &mut ChaCha8Rng) -> Scene {
    let mut scene = Scene::new(config);
    let half = 0.5 * config.ground.size_m[0];
    let mut blobs = |raster: &mut Raster, count: usize| {
        for _ in 0..count {
            let (x, y) = (rng.random_range(-half..half), rng.random_range(-half..half));
            let (w, h) = (rng.random_range(5.0..60.0), rng.random_range(5.0..60.0));
            let mut blob = Raster::empty(*raster.grid());
            fill(&mut blob, [x, x + w], [y, y + h]);
            raster.union_with(&blob);
        }
    };
    blobs(&mut scene.wanted, 14);
    blobs(&mut scene.margin, 4);
    blobs(&mut scene.hidden_now, 6);
    blobs(&mut scene.hidden_recent, 5);
    let cells = config.oem_grid().columns;
    for _ in 0..cells {
        let (column, row) = (rng.random_range(0..cells), rng.random_range(0..cells));
        let height_dm = rng.random_range(30..420);
        scene.occupy(column, row, height_dm);
    }
    scene
}

fn random_pose(config: &AgentConfig, rng: &mut ChaCha8Rng) -> Pose {
    let half = 0.7 * config.ground.size_m[0];
    let [x, y] = [rng.random_range(-half..half), rng.random_range(-half..half)];
    Pose::level([x, y, rng.random_range(50.0..62.0)], rng.random_range(-7.0..7.0))
}

/// What a pose sees by a criterion, computed from the definitions.
struct BruteVisibility<'a> {
    planner: Planner,
    config: &'a AgentConfig,
    scene: &'a Scene,
}

impl BruteVisibility<'_> {
    fn seen(&mut self, pose: &Pose, own: bool) -> Raster {
        let mut seen = self.planner.footprint(pose);
        match self.config.guidance.criterion {
            Criterion::Str2 if own => seen.subtract(&self.scene.hidden_now),
            Criterion::Str3 => {
                seen.subtract(&self.planner.predicted_hidden(&self.scene.oem, None, pose));
            }
            _ => {}
        }
        seen
    }

    /// Whether a cell outside the footprint is hidden from a pose.
    fn is_hidden(&self, pose: &Pose, column: u32, row: u32) -> bool {
        let centre = self.scene.wanted.grid().centre(column, row);
        match self.config.guidance.criterion {
            Criterion::Str1
            | Criterion::Str2NoHidden
            | Criterion::Circles
            | Criterion::Lawnmower => false,
            Criterion::Str2 => self.scene.hidden_now.get(column, row),
            Criterion::Str3 | Criterion::Str4 | Criterion::Str5 => {
                hides_point(&self.scene.oem, pose.p_world, centre)
            }
        }
    }

    /// (5.16), (5.21), (5.27), (5.32), term by term.
    fn cost(&mut self, poses: &[Pose], neighbour: &[Pose]) -> f64 {
        let guidance = &self.config.guidance;
        let mut remaining = self.scene.wanted.clone();
        for (own, other) in poses.iter().zip(neighbour) {
            remaining = remaining.dilated_disc(3.0);
            if guidance.criterion != Criterion::Str1 {
                remaining.subtract(&self.scene.margin);
            }
            remaining.subtract(&self.seen(own, true));
            remaining.subtract(&self.seen(other, false));
        }
        let kappa = if guidance.criterion == Criterion::Str3 { guidance.kappa } else { 0.0 };
        let mut recent = remaining.clone();
        recent.intersect_with(&self.scene.hidden_recent);
        let last = &poses[poses.len() - 1];
        let grid = *remaining.grid();
        let footprint = self.planner.footprint(last);
        assert!(footprint.count() > 0, "the test's footprints meet the region");
        let mean = |axis: usize| {
            let sum: f64 = footprint.iter().map(|(c, r)| grid.centre(c, r)[axis]).sum();
            sum / f64::from(footprint.count())
        };
        let from = [mean(0), mean(1)];
        let distance = |&(column, row): &(u32, u32)| {
            let centre = grid.centre(column, row);
            (centre[0] - from[0]).hypot(centre[1] - from[1])
        };
        let mut cells: Vec<(u32, u32)> = remaining.iter().collect();
        cells.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        // X^Δ that remains in the footprint is not seen from the pose.
        let open = |&&(c, r): &&(u32, u32)| !footprint.get(c, r) && !self.is_hidden(last, c, r);
        let distance = cells.iter().find(open).or(cells.first()).map_or(0.0, distance);
        remaining.area_m2() + kappa * recent.area_m2() + guidance.lambda * distance
    }
}

#[test]
fn the_search_finds_what_brute_force_finds() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for round in 0..12 {
        let mut config = default_config();
        config.ground.size_m = [300.0, 300.0];
        config.guidance.criterion = CRITERIA[round % 4];
        config.guidance.lambda = if round < 8 { 1e-5 } else { 3.0 };
        let scene = random_scene(&config, &mut rng);
        let start =
            Pose::level([-80.0, rng.random_range(-40.0..40.0), 53.0], rng.random_range(-0.7..0.7));
        let motion = Motion::new(&config);
        let other = random_pose(&config, &mut rng);
        let plan = vec![motion.advance(&other, 0.5)];
        let decision =
            Planner::new(&config).plan(&scene.input(), &start, std::slice::from_ref(&plan));
        let neighbour = motion.forecast(&plan, 0, 2);
        let mut brute =
            BruteVisibility { planner: Planner::new(&config), config: &config, scene: &scene };
        let order = [0.0, -30.0, 30.0, -60.0, 60.0].map(f64::to_radians);
        let mut best = (f64::INFINITY, vec![]);
        for (first, second) in order.iter().flat_map(|&a| order.iter().map(move |&b| (a, b))) {
            let one = motion.advance(&start, first);
            let poses = [one, motion.advance(&one, second)];
            let cost = brute.cost(&poses, &neighbour);
            if cost < best.0 - 1e-9 {
                best = (cost, vec![first, second]);
            }
        }
        assert_eq!(decision.nodes, 30);
        assert!((decision.cost - best.0).abs() < 1e-6, "{round}: {} {}", decision.cost, best.0);
        assert_eq!(decision.increments_rad, best.1, "round {round}");
    }
}

fn mirrored(raster: &Raster) -> Raster {
    let mut mirror = Raster::empty(*raster.grid());
    let last = raster.grid().rows - 1;
    raster.iter().for_each(|(column, row)| mirror.set(column, last - row));
    mirror
}

#[test]
fn a_mirrored_world_is_flown_mirrored() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    for round in 0..12 {
        let mut config = default_config();
        config.guidance.criterion = CRITERIA[round % 4];
        let scene = random_scene(&config, &mut rng);
        let mut mirror = Scene::new(&config);
        mirror.wanted = mirrored(&scene.wanted);
        mirror.margin = mirrored(&scene.margin);
        mirror.hidden_now = mirrored(&scene.hidden_now);
        mirror.hidden_recent = mirrored(&scene.hidden_recent);
        for OemDelta { cell, state } in scene.oem.known() {
            let (column, row) = (cell % 100, cell / 100);
            mirror.oem.join(OemDelta { cell: (99 - row) * 100 + column, state });
        }
        let pose =
            Pose::level([-120.0, rng.random_range(-90.0..90.0), 53.0], rng.random_range(-0.5..0.5));
        let [x, y, z] = pose.p_world;
        let turned = Pose::level([x, -y, z], -pose.yaw_rad);
        let mut planner = Planner::new(&config);
        let one = planner.plan(&scene.input(), &pose, &[]);
        let two = planner.plan(&mirror.input(), &turned, &[]);
        let back: Vec<f64> = two.increments_rad.iter().map(|u| -u).collect();
        assert_eq!(one.increments_rad, back, "round {round}");
        assert!((one.cost - two.cost).abs() < 1e-6, "round {round}: {} {}", one.cost, two.cost);
    }
}

/// Scratch memory has no effect, and a longer horizon has more nodes.
#[test]
fn a_plan_is_a_function_of_its_arguments() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let mut config = default_config();
    config.guidance.n_mpc = 4;
    let mut used = Planner::new(&config);
    for _ in 0..3 {
        let scene = random_scene(&config, &mut rng);
        let (pose, other) = (random_pose(&config, &mut rng), random_pose(&config, &mut rng));
        let fresh = Planner::new(&config).plan(&scene.input(), &pose, &[vec![other]]);
        assert_eq!(used.plan(&scene.input(), &pose, &[vec![other]]), fresh);
        assert_eq!((fresh.nodes, fresh.poses.len()), (5 + 25 + 125 + 625, 4));
    }
}
