//! A laboratory for guidance: aircraft search for a standing target, without engine, radios and processes.
//!
//! ```text
//! cargo run --release -p csat-bayes --example search_lab -- first seeds=1-50
//! cargo run --release -p csat-bayes --example search_lab -- cover seeds=1001-1004 criterion=information beam=30
//! ```
//!
//! - `first`: the time of the first true detection of a target somewhere in the region, under `lawnmower` and
//!   `information`: quartiles and the ratio of the medians.
//! - `cover`: no target and no false alarms; when the probability that a target somewhere in the region would have
//!   been detected reaches 25, 50, 75, 90 %; `curve=file.csv` for all of it.
//! - `localise`: the standard deviation and the error 10, 20, 30 and 60 s after the first detection.
//! - `time`: the durations of decisions.
//!
//! Links are perfect, or with `silent=true` there are none.

use std::io::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};

use csat_bayes::config::{AgentConfig, BeliefConfig, Criterion, ExchangeConfig, GuidanceConfig};
use csat_bayes::guidance::{GuidanceInput, Guide, NeighbourPlan};
use csat_bayes::likelihood::{Likelihood, Sensor};
use csat_bayes::search_map::{CELL_M, Gaussian, SearchMap};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::command::Command;
use csat_proto::detector::DetectorModel;
use csat_proto::fixed_wing::FixedWing;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::{FleetModel, Ground, StartPose, VehicleKind};
use csat_proto::raster::Grid;
use csat_proto::time::Step;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The end of a mission, seconds.
const END_S: f64 = 600.0;

#[derive(Clone)]
struct Lab {
    seeds: std::ops::RangeInclusive<u64>,
    config: AgentConfig,
    silent: bool,
    /// Cells of the belief, metres.
    cell_m: f64,
    curve: Option<String>,
}

fn main() {
    let mut args = std::env::args().skip(1);
    let mode = args.next().unwrap_or_else(|| "first".to_owned());
    let mut lab =
        Lab { seeds: 1..=50, config: config(2), silent: false, cell_m: CELL_M, curve: None };
    let mut starts = "opposite".to_owned();
    for arg in args {
        let (key, value) = arg.split_once('=').expect("key=value");
        if key == "start" {
            value.clone_into(&mut starts);
        } else {
            lab.set(key, value);
        }
    }
    lab.config.fleet.start = start(&starts, lab.config.fleet.count);
    match mode.as_str() {
        "first" => lab.first(),
        "cover" => lab.cover(),
        "localise" => lab.localise(),
        "time" => lab.time(),
        other => panic!("{other}: first, cover, localise or time"),
    }
}

/// The mission of the paper in round numbers.
fn config(count: u16) -> AgentConfig {
    AgentConfig {
        run: RunId(1),
        seed: 0,
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: 0.25,
        ground: Ground { size_m: [1000.0, 1000.0] },
        fleet: FleetModel {
            count,
            speed_m_s: 20.0,
            altitude_m: 90.0,
            altitude_step_m: 0.0,
            vehicle: VehicleKind::FixedWing,
            ..FleetModel::default()
        },
        stations: 0,
        camera: CameraModel {
            columns: 640,
            rows: 480,
            aperture_deg: 49.3,
            tilt_deg: 90.0,
            ..CameraModel::default()
        },
        detector: DetectorModel::default(),
        pose_sigma: [10.5, 5.5, 2.0, 0.01, 0.05, 0.02],
        walk_m: 0.0,
        belief: BeliefConfig::default(),
        exchange: ExchangeConfig::default(),
        guidance: GuidanceConfig::default(),
        channel: ChannelId(0),
    }
}

/// Start poses by name.
fn start(name: &str, count: u16) -> Vec<StartPose> {
    let at = |x_m: f64, y_m: f64, yaw_deg: f64| StartPose { x_m, y_m, yaw_deg };
    let strip = 1000.0 / f64::from(count);
    let index = |i: u16| f64::from(i);
    match name {
        // At the western border, side by side.
        "west" => (0..count)
            .map(|i| at(-500.0, (index(i) + 0.5 - f64::from(count) / 2.0) * 80.0, 0.0))
            .collect(),
        // At the southern border, each in the corner of its strip.
        "south" => (0..count).map(|i| at(-472.0 + index(i) * strip, -500.0, 90.0)).collect(),
        // At the corners of strips, every second one in the north.
        "opposite" => (0..count)
            .map(|i| match i % 2 {
                0 => at(-472.0 + index(i) * strip, -500.0, 90.0),
                _ => at(472.0 - index(count - 1 - i) * strip, 500.0, -90.0),
            })
            .collect(),
        // As in the scenario `tisdale`: south of the border, in the outer corners.
        "tisdale" => {
            (0..count).map(|i| at(if i % 2 == 0 { -480.0 } else { 480.0 }, -520.0, 90.0)).collect()
        }
        other => panic!("start {other}: west, south, opposite or tisdale"),
    }
}

impl Lab {
    fn set(&mut self, key: &str, value: &str) {
        let number = || value.parse::<f64>().expect("a number");
        let guidance = &mut self.config.guidance;
        match key {
            "seeds" => {
                let (first, last) = value.split_once('-').expect("first-last");
                self.seeds = first.parse().expect("seed")..=last.parse().expect("seed");
            }
            "agents" => self.config.fleet.count = number() as u16,
            "silent" => self.silent = value == "true",
            "cell" => self.cell_m = number(),
            "curve" => self.curve = Some(value.to_owned()),
            "criterion" => {
                guidance.criterion = match value {
                    "lawnmower" => Criterion::Lawnmower,
                    _ => Criterion::Information,
                }
            }
            "lane" => guidance.lane_m = number(),
            "period" => guidance.period_s = number(),
            "horizon" => guidance.horizon_s = number(),
            "beam" => guidance.beam = number() as u16,
            "attraction_m" => guidance.attraction_m = number(),
            "attraction" => guidance.attraction = number(),
            "discount" => guidance.discount_s = number(),
            "edge" => guidance.edge_worth = number(),
            "wind" => self.config.fleet.fixed_wing.wind_m_s = [number(), 0.0],
            other => panic!("unknown key {other}"),
        }
    }

    /// Calls `each` for every seed, on all processors; results by seed.
    fn for_seeds<R: Send>(&self, each: impl Fn(u64) -> R + Sync) -> Vec<R> {
        let next = AtomicU64::new(*self.seeds.start());
        let work = || {
            let mut results = Vec::new();
            loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed > *self.seeds.end() {
                    return results;
                }
                results.push((seed, each(seed)));
            }
        };
        let mut results: Vec<(u64, R)> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..2).map(|_| scope.spawn(work)).collect();
            workers.into_iter().flat_map(|worker| worker.join().expect("a worker")).collect()
        });
        results.sort_by_key(|result| result.0);
        results.into_iter().map(|result| result.1).collect()
    }

    fn with(&self, criterion: Criterion) -> Self {
        let mut lab = self.clone();
        lab.config.guidance.criterion = criterion;
        lab
    }

    fn first(&self) {
        let medians = [Criterion::Lawnmower, Criterion::Information].map(|criterion| {
            let lab = self.with(criterion);
            let mut times = lab.for_seeds(|seed| {
                let mut flight = Flight::new(&lab, seed, true);
                flight.until_detected().unwrap_or(f64::INFINITY)
            });
            times.sort_by(f64::total_cmp);
            let quartiles = [0.25, 0.5, 0.75].map(|q| quantile(&times, q));
            println!("{criterion:?}: first detection, quartiles {quartiles:.1?} s");
            quartiles[1]
        });
        println!("ratio of the medians: {:.3}", medians[1] / medians[0]);
    }

    fn cover(&self) {
        let curves = self.for_seeds(|seed| Flight::new(self, seed, false).coverage());
        let seconds = curves.iter().map(Vec::len).min().unwrap_or(0);
        let mean =
            |k: usize| curves.iter().map(|curve| curve[k]).sum::<f64>() / curves.len() as f64;
        let mean: Vec<f64> = (0..seconds).map(mean).collect();
        let times = [0.25, 0.5, 0.75, 0.9, 0.95]
            .map(|p| mean.iter().position(|x| *x >= p).map_or(f64::INFINITY, |k| k as f64));
        let criterion = self.config.guidance.criterion;
        println!(
            "{criterion:?}: 25, 50, 75, 90, 95 % at {times:?} s; mean {:.1} s; {:.3} at the end",
            mean.iter().map(|covered| 1.0 - covered).sum::<f64>(),
            mean[seconds - 1]
        );
        if let Some(path) = &self.curve {
            let mut file = std::fs::File::create(path).expect("a file");
            writeln!(file, "t_s,covered").expect("written");
            for (second, covered) in mean.iter().enumerate() {
                writeln!(file, "{second},{covered:.4}").expect("written");
            }
        }
    }

    fn localise(&self) {
        let after = [10.0, 20.0, 30.0, 60.0];
        let results = self.for_seeds(|seed| Flight::new(self, seed, true).localised(&after));
        for (index, seconds) in after.iter().enumerate() {
            let of = |part: usize| {
                let mut all: Vec<f64> = results.iter().flatten().map(|r| r[index][part]).collect();
                all.sort_by(f64::total_cmp);
                quantile(&all, 0.5)
            };
            println!(
                "{seconds} s: median sigma {:.2} m, error {:.2} m, detections {}",
                of(0),
                of(1),
                of(2)
            );
        }
    }

    #[allow(clippy::disallowed_methods)]
    fn time(&self) {
        let lab = self.with(Criterion::Information);
        let mut flight = Flight::new(&lab, *self.seeds.start(), false);
        let (mut total, mut worst, mut count) = (0.0, 0.0f64, 0u32);
        for _ in 0..800 {
            flight.advance();
            for index in 0..flight.guides.len() {
                let start = std::time::Instant::now();
                flight.guide(index);
                let ms = start.elapsed().as_secs_f64() * 1e3;
                if flight.guides[index].planned_at() == flight.step {
                    (total, worst, count) = (total + ms, worst.max(ms), count + 1);
                }
            }
        }
        println!(
            "{count} decisions: mean {:.2} ms, greatest {worst:.2} ms",
            total / f64::from(count)
        );
    }
}

fn quantile(sorted: &[f64], q: f64) -> f64 {
    if sorted.is_empty() {
        return f64::NAN;
    }
    let at = q * (sorted.len() - 1) as f64;
    let (low, share) = (at as usize, at.fract());
    let high = (low + 1).min(sorted.len() - 1);
    if share == 0.0 { sorted[low] } else { sorted[low] * (1.0 - share) + sorted[high] * share }
}

/// ln p(x | z) on a grid, but for a constant.
#[derive(Clone)]
struct Belief {
    grid: Grid,
    ln: Vec<f64>,
}

impl Belief {
    fn apply(&mut self, likelihood: &Likelihood) {
        let Some(bounds) = likelihood.bounds() else { return };
        let ([west, south], [east, north]) = (bounds.min, bounds.max);
        for row in self.grid.rows_between(south, north) {
            for column in self.grid.columns_between(west, east) {
                let index = (row * self.grid.columns + column) as usize;
                self.ln[index] += likelihood.ln_within(self.grid.centre(column, row));
            }
        }
    }

    fn mass(&self) -> Vec<f64> {
        let most = self.ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut mass: Vec<f64> = self.ln.iter().map(|ln| (ln - most).exp()).collect();
        let sum: f64 = mass.iter().sum();
        mass.iter_mut().for_each(|m| *m /= sum);
        mass
    }

    fn map(&self, ground: &Ground) -> SearchMap {
        let grid = Grid::covering(ground, CELL_M);
        let mut mass = vec![0.0; (grid.columns * grid.rows) as usize];
        for (index, m) in self.mass().into_iter().enumerate() {
            let (column, row) =
                (index as u32 % self.grid.columns, index as u32 / self.grid.columns);
            if let Some((column, row)) = grid.cell_of(self.grid.centre(column, row)) {
                mass[(row * grid.columns + column) as usize] += m;
            }
        }
        SearchMap { grid, mass }
    }

    fn gaussian(&self) -> Gaussian {
        let mut sums = [0.0; 5];
        for (index, m) in self.mass().into_iter().enumerate() {
            let (column, row) =
                (index as u32 % self.grid.columns, index as u32 / self.grid.columns);
            let [x, y] = self.grid.centre(column, row);
            for (sum, value) in sums.iter_mut().zip([x, y, x * x, x * y, y * y]) {
                *sum += m * value;
            }
        }
        let [x, y, xx, xy, yy] = sums;
        let within = self.grid.cell_m.powi(2) / 12.0;
        Gaussian {
            mean: [x, y],
            covariance: [xx - x * x + within, xy - x * y, yy - y * y + within],
        }
    }
}

/// A flight of the fleet.
struct Flight<'a> {
    lab: &'a Lab,
    sensor: Sensor,
    rng: ChaCha8Rng,
    step: Step,
    aircraft: Vec<FixedWing>,
    reported: Vec<Pose>,
    guides: Vec<Guide>,
    /// One, or one for each aircraft.
    beliefs: Vec<Belief>,
    target: Option<[f64; 2]>,
    /// True detections so far.
    detections: u32,
}

impl<'a> Flight<'a> {
    fn new(lab: &'a Lab, seed: u64, with_target: bool) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let half = lab.config.ground.size_m.map(|size| size / 2.0);
        let target = half.map(|h| rng.random_range(-h..h));
        let fleet = &lab.config.fleet;
        let aircraft = |index: u16| {
            let start = fleet.start_of(index, &lab.config.ground);
            let p_world = [start.x_m, start.y_m, fleet.altitude_of(index)];
            FixedWing::level(fleet.fixed_wing, p_world, start.yaw_deg.to_radians(), fleet.speed_m_s)
        };
        let guide = |index| Guide::new(&AgentConfig { id: AgentId(index), ..lab.config.clone() });
        let grid = Grid::covering(&lab.config.ground, lab.cell_m);
        let belief = Belief { grid, ln: vec![0.0; (grid.columns * grid.rows) as usize] };
        let beliefs = if lab.silent { fleet.count } else { 1 };
        let aircraft: Vec<FixedWing> = (0..fleet.count).map(aircraft).collect();
        Self {
            lab,
            sensor: Sensor::new(&lab.config),
            rng,
            step: Step(0),
            reported: aircraft.iter().map(FixedWing::pose).collect(),
            aircraft,
            guides: (0..fleet.count).map(guide).collect(),
            beliefs: vec![belief; usize::from(beliefs)],
            target: with_target.then_some(target),
            detections: 0,
        }
    }

    fn seconds(&self) -> f64 {
        f64::from(self.step.0) * self.lab.config.period_s
    }

    /// Moves the fleet, takes the frames and updates the beliefs.
    fn advance(&mut self) {
        self.step = self.step.after(1);
        for index in 0..self.aircraft.len() {
            self.aircraft[index].advance(self.lab.config.period_s);
            let pose = self.aircraft[index].pose();
            let sighting = self.sighting(&pose);
            self.reported[index] = self.report(&pose);
            let likelihood = Likelihood::of_frame(&self.sensor, &self.reported[index], sighting);
            let belief = index.min(self.beliefs.len() - 1);
            self.beliefs[belief].apply(&likelihood);
        }
    }

    fn sighting(&mut self, pose: &Pose) -> Option<[f64; 2]> {
        let [x, y] = self.target?;
        let view = self.lab.config.camera.at(pose);
        let size = [self.lab.config.camera.columns, self.lab.config.camera.rows].map(f64::from);
        let (detect, false_alarm) = (self.rng.random::<f64>(), self.rng.random::<f64>());
        let anywhere = size.map(|s| self.rng.random_range(0.0..s));
        if let Some([c, r]) = view.project(&nalgebra::Vector3::new(x, y, 0.0))
            && (0.0..size[0]).contains(&c)
            && (0.0..size[1]).contains(&r)
            && detect < self.lab.config.detector.p_detected(view.resolution_px_m2(c, r))
        {
            self.detections += 1;
            return Some([c, r]);
        }
        (false_alarm < self.lab.config.detector.p_false).then_some(anywhere)
    }

    fn report(&mut self, pose: &Pose) -> Pose {
        let sigma = self.lab.config.pose_sigma;
        let [along, across, up, yaw, pitch, roll] = sigma.map(|s| s * normal(&mut self.rng));
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let [x, y, z] = pose.p_world;
        Pose {
            p_world: [x + along * cos - across * sin, y + along * sin + across * cos, z + up],
            yaw_rad: pose.yaw_rad + yaw,
            pitch_rad: pose.pitch_rad + pitch,
            roll_rad: pose.roll_rad + roll,
        }
    }

    fn guide(&mut self, index: usize) {
        let plan = |(other, guide): (usize, &Guide)| NeighbourPlan {
            id: AgentId(other as u16),
            step: guide.planned_at(),
            poses: guide.planned().to_vec(),
        };
        let others = self.guides.iter().enumerate().filter(|other| other.0 != index);
        let neighbours: Vec<_> =
            if self.lab.silent { Vec::new() } else { others.map(plan).collect() };
        let belief = &self.beliefs[index.min(self.beliefs.len() - 1)];
        let ground = &self.lab.config.ground;
        let input = GuidanceInput {
            step: self.step,
            pose: &self.reported[index],
            map: &|| belief.map(ground),
            target: Some(belief.gaussian()).filter(|gaussian| gaussian.sigma_m() < 50.0),
            neighbours: &neighbours,
        };
        if let Some(command) = self.guides[index].step(&input) {
            let Command::Yaw { yaw_rad } = command else { unreachable!("aircraft turn") };
            self.aircraft[index].command(yaw_rad);
        }
    }

    fn next(&mut self) {
        self.advance();
        (0..self.guides.len()).for_each(|index| self.guide(index));
    }

    fn until_detected(&mut self) -> Option<f64> {
        while self.seconds() < END_S {
            self.next();
            if self.detections > 0 {
                return Some(self.seconds());
            }
        }
        None
    }

    /// By second: the probability that a target somewhere in the region would have been detected.
    fn coverage(&mut self) -> Vec<f64> {
        let grid = Grid::covering(&self.lab.config.ground, 10.0);
        let mut missed = vec![1.0f64; (grid.columns * grid.rows) as usize];
        let mut curve = vec![0.0];
        while self.seconds() < END_S {
            self.next();
            for aircraft in &self.aircraft {
                let view = self.lab.config.camera.at(&aircraft.pose());
                let [x, y, _] = aircraft.pose().p_world;
                for row in grid.rows_between(y - 150.0, y + 150.0) {
                    for column in grid.columns_between(x - 150.0, x + 150.0) {
                        let [px, py] = grid.centre(column, row);
                        let image = view.project(&nalgebra::Vector3::new(px, py, 0.0));
                        let Some([c, r]) = image else { continue };
                        if (0.0..640.0).contains(&c) && (0.0..480.0).contains(&r) {
                            let p =
                                self.lab.config.detector.p_detected(view.resolution_px_m2(c, r));
                            missed[(row * grid.columns + column) as usize] *= 1.0 - p;
                        }
                    }
                }
            }
            if self.step.0.is_multiple_of(4) {
                curve.push(1.0 - missed.iter().sum::<f64>() / missed.len() as f64);
            }
        }
        curve
    }

    /// Standard deviation, error and detections some times after the first detection.
    fn localised(&mut self, after: &[f64]) -> Option<Vec<[f64; 3]>> {
        let first = self.until_detected()?;
        let target = self.target?;
        let mut results = Vec::new();
        for seconds in after {
            while self.seconds() < first + seconds {
                self.next();
            }
            let gaussian = self.beliefs[0].gaussian();
            let [dx, dy] = [0, 1].map(|axis| gaussian.mean[axis] - target[axis]);
            results.push([gaussian.sigma_m(), dx.hypot(dy), f64::from(self.detections)]);
        }
        Some(results)
    }
}

/// A standard normal number (Box and Muller 1958).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (a, b): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}
