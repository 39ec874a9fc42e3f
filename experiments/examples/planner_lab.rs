//! Missions of rasters alone, for comparing planners: the real planner, dynamics and towns, but
//! sets of cells for sets, no cars, links that lose nothing and obstacles known from the start. Some
//! ten times as fast as `csat run`, and some points lower: compare within the lab only.
//!
//! Usage: `planner_lab SCENARIO SEEDS RESTARTS [--frames] [KEY=VALUE]...`, say
//! `planner_lab city 8 1 guidance.criterion=str4 guidance.str4.beam=25`. With more than one restart
//! each town is flown as often, the beam wider by one each time; the best of them in hindsight is
//! what `str4` might have reached, which the best possible flight can only beat.
//!
//! With `--frames`, cameras look at the town with its cars, and what is seen, X° and the map are what
//! sensors make of their frames: then little but the sets' being polygons is missing of a mission.

use csat_agent::config::{AgentConfig, Criterion};
use csat_agent::estimate::oem::Oem;
use csat_agent::guidance::{Planner, PlannerInput};
use csat_agent::sense::Sensor;
use csat_experiments::scenario::{self, Loaded, Request};
use csat_experiments::set_membership::SetMembership;
use csat_mission::mission::Mission;
use csat_proto::camera::Pose;
use csat_proto::command::Command;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::oem::{OemCell, OemDelta};
use csat_proto::raster::{Grid, Raster};
use csat_world::camera::Renderer;
use csat_world::obstacle::Walls;
use csat_world::world::World;

/// Cells of the truth, metres.
const FINE_M: f64 = 1.0;
/// Cells of the obstacles that hide ground, metres.
const TOWER_M: f64 = 2.0;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [name, seeds, restarts, sets @ ..] = args.as_slice() else {
        panic!("usage: planner_lab SCENARIO SEEDS RESTARTS [--frames] [KEY=VALUE]...")
    };
    let seeds: u64 = seeds.parse().expect("a number of seeds");
    let restarts: u16 = restarts.parse().expect("a number of restarts");
    let (frames, sets) = match sets {
        [first, rest @ ..] if first == "--frames" => (true, rest),
        _ => (false, sets),
    };
    let (mut first, mut best) = (0.0, 0.0);
    for seed in 1..=seeds {
        let lab = |extra| {
            let lab = Lab::new(name, sets, seed, extra);
            if frames { lab.with_frames(seed) } else { lab }
        };
        let flown: Vec<f64> = (0..restarts.max(1)).map(|extra| lab(extra).fly()).collect();
        let least = flown.iter().copied().fold(f64::INFINITY, f64::min);
        println!("seed {seed}: {:.2} %, best of {} {least:.2} %", flown[0], flown.len());
        first += flown[0] / seeds as f64;
        best += least / seeds as f64;
    }
    println!("mean: {first:.2} %, best in hindsight {best:.2} %");
}

struct Lab {
    world: World,
    /// What hides ground.
    truth: Oem,
    /// What the planners know of it.
    oem: Oem,
    /// X°, as known.
    margin: Raster,
    /// Cameras and sensors, if there are any.
    cameras: Option<Cameras>,
    /// Looks at the truth.
    eye: Planner,
    configs: Vec<AgentConfig>,
    planners: Vec<Planner>,
    /// Commanded yaws, radians.
    yaws: Vec<f64>,
    plans: Vec<Vec<Pose>>,
    /// X̄.
    unexplored: Raster,
    /// What was hidden at each of the last steps.
    hidden: Vec<Raster>,
    steps: u32,
    steps_per_block: u32,
    growth_m: f64,
}

impl Lab {
    fn new(name: &str, sets: &[String], seed: u64, wider: u16) -> Self {
        let request = Request { scenario: Some(name), sets, seed: Some(seed) };
        let Loaded { mut scenario, world, .. } = scenario::load(request).expect("a scenario");
        scenario.guidance.str4.beam += wider;
        let mission = SetMembership::new(&scenario);
        let configs: Vec<AgentConfig> = (0..scenario.agents.count)
            .map(|id| mission.agent(AgentId(id), Incarnation(0)).config().clone())
            .collect();
        let mut eye = configs[0].clone();
        eye.estimator.raster_cell_m = FINE_M;
        eye.guidance.criterion = Criterion::Str3;
        let fine = eye.raster_grid();
        let (walls, reach_m) =
            (Walls::new(world.obstacles()), configs[0].targets.obstacle_distance_m);
        let mut margin = Raster::empty(fine);
        for (column, row) in (0..fine.rows).flat_map(|r| (0..fine.columns).map(move |c| (c, r))) {
            if walls.nearest_within(fine.centre(column, row), reach_m).is_some() {
                margin.set(column, row);
            }
        }
        let mut unexplored = Raster::empty(fine);
        (0..fine.rows).for_each(|row| unexplored.set_run(row, 0..fine.columns));
        Self {
            truth: boxes(&world, Grid::covering(&world.ground(), TOWER_M), 2),
            oem: boxes(&world, configs[0].oem_grid(), 1),
            margin,
            cameras: None,
            eye: Planner::new(&eye),
            planners: configs.iter().map(Planner::new).collect(),
            yaws: vec![0.0; configs.len()],
            plans: vec![Vec::new(); configs.len()],
            unexplored,
            hidden: Vec::new(),
            steps: scenario.steps(),
            steps_per_block: (scenario.guidance.period_s / scenario.run.period_s).round() as u32,
            growth_m: scenario.targets.v_max_m_s * scenario.run.period_s,
            world,
            configs,
        }
    }

    /// The same, with nothing known of the town and cameras to learn it by.
    fn with_frames(mut self, seed: u64) -> Self {
        self.margin = Raster::empty(*self.margin.grid());
        self.oem = Oem::unexplored(*self.oem.grid());
        self.cameras = Some(Cameras {
            sensors: self.configs.iter().map(Sensor::new).collect(),
            renderers: self.configs.iter().map(|config| Renderer::new(config.camera)).collect(),
            seed,
        });
        self
    }

    /// φ(X̄), mean over the second half of the mission, per cent of the region.
    fn fly(mut self) -> f64 {
        let (mut sum, half, mut owed_m, mut diagonal) = (0.0, self.steps / 2, 0.0, false);
        for step in 0..self.steps {
            if step > 0 {
                self.world.advance();
                owed_m += self.growth_m;
            }
            // A cell in all directions and a cell along the axes by turns: nearly a disc.
            while owed_m >= FINE_M {
                diagonal = !diagonal;
                let radius = if diagonal { FINE_M } else { 0.5 * FINE_M };
                self.unexplored = self.unexplored.dilated_disc(radius);
                owed_m -= FINE_M;
            }
            self.look();
            if step >= half {
                sum += self.unexplored.area_m2();
            }
            if step % self.steps_per_block == 0 {
                self.decide();
            }
        }
        100.0 * sum / f64::from(self.steps - half) / self.world.ground().area_m2()
    }

    fn look(&mut self) {
        let mut all_hidden = Raster::empty(*self.unexplored.grid());
        for (pose, id) in self.world.poses().into_iter().zip(0..) {
            let hidden = self.eye.predicted_hidden(&self.truth, None, &pose);
            all_hidden.union_with(&hidden);
            let seen = self.photographed(AgentId(id)).unwrap_or_else(|| {
                let mut seen = self.eye.footprint(&pose);
                seen.subtract(&hidden);
                seen
            });
            self.unexplored.subtract(&seen);
        }
        self.unexplored.subtract(&self.margin);
        self.hidden.push(coarse(&all_hidden, self.configs[0].raster_grid(), 1));
        if self.hidden.len() > 12 {
            self.hidden.remove(0);
        }
    }

    /// Where a camera's frame proves that there is no car, not counting X°, which it adds to, as it
    /// does to the map; `None` without cameras.
    fn photographed(&mut self, id: AgentId) -> Option<Raster> {
        let Cameras { sensors, renderers, seed } = self.cameras.as_mut()?;
        let (index, step) = (usize::from(id.0), self.world.step());
        let pose = self.world.poses()[index];
        let frame = renderers[index].frame(&self.world.scene(), &pose, step, *seed, id);
        let measured = sensors[index].measure(&frame);
        for delta in measured.oem {
            self.oem.join(delta);
        }
        self.margin.fill_region(measured.obstacle_margin.region());
        let mut seen = Raster::of_region(*self.margin.grid(), measured.clear_ground.region());
        for target in &measured.targets {
            seen.fill_region(target.exclusion.region());
        }
        Some(seen)
    }

    /// Both passes of the loopback, or the one of `str4`, and the commands.
    fn decide(&mut self) {
        let grid = self.configs[0].raster_grid();
        let margin = coarse(&self.margin, grid, 4);
        let (wanted, nothing) = (coarse(&self.unexplored, grid, 1), Raster::empty(grid));
        let mut hidden_recent = nothing.clone();
        self.hidden.iter().for_each(|hidden| hidden_recent.union_with(hidden));
        let input = PlannerInput {
            wanted: &wanted,
            margin: &margin,
            hidden_now: &nothing,
            neighbours: &[],
            plan_ages: &[],
            silent: &[],
            neighbours_hidden_now: &[],
            hidden_recent: &hidden_recent,
            oem: &self.oem,
            view_cache: None,
            pose_error: self.configs[0].pose_error,
            ways: None,
        };
        let poses = self.world.poses();
        let mut turns = vec![0.0; poses.len()];
        let far_sighted = self.configs[0].guidance.criterion.is_far_sighted();
        for plan in self.plans.iter_mut().filter(|plan| !plan.is_empty()) {
            plan.remove(0);
        }
        for pass in 0..if far_sighted { 1 } else { 2 } {
            for (i, planner) in self.planners.iter_mut().enumerate() {
                let known = |&j: &usize| j != i && (far_sighted || pass > 0 || j < i);
                let others: Vec<Vec<Pose>> =
                    (0..poses.len()).filter(known).map(|j| self.plans[j].clone()).collect();
                let pose = Pose { yaw_rad: self.yaws[i], ..poses[i] };
                let neighbours: Vec<AgentId> =
                    (0..poses.len()).filter(known).map(|j| AgentId(j as u16)).collect();
                let plan_ages: Vec<u32> =
                    neighbours.iter().map(|j| u32::from(usize::from(j.0) > i)).collect();
                let input =
                    PlannerInput { neighbours: &neighbours, plan_ages: &plan_ages, ..input };
                let decision = planner.plan(&input, &pose, &others);
                turns[i] = decision.increments_rad[0];
                self.plans[i] = decision.poses;
            }
        }
        for ((yaw_rad, turn), id) in self.yaws.iter_mut().zip(turns).zip(0..) {
            *yaw_rad += turn;
            let command = Command::Yaw { yaw_rad: *yaw_rad };
            self.world.command(AgentId(id), command).expect("a UAV of the fleet");
        }
    }
}

/// What takes pictures and measures them, by UAV.
struct Cameras {
    sensors: Vec<Sensor>,
    renderers: Vec<Renderer>,
    seed: u64,
}

/// The obstacles as boxes on the cells that hold at least `least` cells of the truth.
fn boxes(world: &World, grid: Grid, least: u32) -> Oem {
    let mut oem = Oem::unexplored(grid);
    for obstacle in world.obstacles() {
        let mut footprint = Raster::empty(Grid::covering(&world.ground(), FINE_M));
        footprint.fill_rings(&obstacle.rings().collect::<Vec<_>>());
        let state = OemCell::Occupied { height_dm: (obstacle.height_m * 10.0) as u16 };
        for (column, row) in coarse(&footprint, grid, least).iter() {
            oem.join(OemDelta { cell: grid.index(column, row) as u32, state });
        }
    }
    oem
}

/// The cells of a coarser grid that hold at least `least` cells of `fine`.
fn coarse(fine: &Raster, grid: Grid, least: u32) -> Raster {
    let mut counts = vec![0; grid.cells()];
    let mut out = Raster::empty(grid);
    for (column, row) in fine.iter() {
        if let Some((column, row)) = grid.cell_of(fine.grid().centre(column, row)) {
            let count = &mut counts[grid.index(column, row)];
            *count += 1;
            if *count == least {
                out.set(column, row);
            }
        }
    }
    out
}
