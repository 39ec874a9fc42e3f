//! The same recorded frames through each representation of the belief: speed and error, for `bench/stonesoup.sh`.
//!
//! ```text
//! cargo run --release -p csat-bayes --example replay -- fly 1 400 flight.csv
//! cargo run --release -p csat-bayes --example replay -- filter flight.csv
//! cargo run --release -p csat-bayes --example replay -- filter flight.csv particles-6400 adaptive
//! ```
//!
//! - `fly SEED FRAMES FILE`: an aircraft flies over a standing target again and again. A line per frame: the reported
//!   pose, the image point of the sighting (empty if there is none), the target, and whether it was detected.
//! - `filter FILE [NAME]...`: a line of JSON per representation. An update is what a frame costs: prediction,
//!   likelihood and correction. Updates are those of a second of processor time, mean of all runs in at least that
//!   time; one more run measures errors.
//! - `likelihood FILE`: a line per frame, ln of its likelihood at 25 points around the target, to check other programs.
//! - `repeat FILE NAME`: one run over all frames without a clock, for a profiler.

use std::io::Write as _;

use csat_bayes::config::{AgentConfig, BeliefConfig, BeliefKind, ExchangeConfig, GuidanceConfig};
use csat_bayes::factor::{Factor, FactorId, ReportedPose};
use csat_bayes::filter::Filter;
use csat_bayes::likelihood::{Likelihood, Sensor};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::detector::DetectorModel;
use csat_proto::fixed_wing::FixedWing;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::{FleetModel, Ground, VehicleKind};
use csat_proto::time::Step;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Seconds between frames.
const PERIOD_S: f64 = 0.25;
const SPEED_M_S: f64 = 20.0;
const HEIGHT_M: f64 = 90.0;
/// Runs over all frames go on until they took this much processor time, seconds.
const LONG_S: f64 = 1.0;
const HEADER: &str =
    "step,x_m,y_m,z_m,yaw_rad,pitch_rad,roll_rad,c_px,r_px,target_x_m,target_y_m,detected";

/// A frame of a recording.
struct Line {
    factor: Factor,
    target: [f64; 2],
    is_detection: bool,
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args[..] {
        ["fly", seed, frames, file] => {
            fly(seed.parse().expect("a seed"), frames.parse().expect("a number of frames"), file);
        }
        ["filter", file] => filter(file, &["grid-12.5", "grid-0.67", "adaptive", "particles-6400"]),
        ["filter", file, ref names @ ..] => filter(file, names),
        ["likelihood", file] => likelihoods(file),
        ["repeat", file, name] => {
            let filter = run(&config(name), &read(file));
            println!("{:?}", filter.belief().gaussian());
        }
        _ => panic!(
            "fly SEED FRAMES FILE, filter FILE [NAME]..., likelihood FILE or repeat FILE NAME"
        ),
    }
}

/// The mission of `tisdale` for one aircraft. A name is a kind and, after `-`, metres or particles.
fn config(name: &str) -> AgentConfig {
    let (kind, size) = name.split_once('-').map_or((name, None), |(kind, size)| {
        (kind, Some(size.parse::<f64>().expect("a number after the kind")))
    });
    let standard = BeliefConfig::default();
    let belief = match kind {
        "grid" => BeliefConfig {
            kind: BeliefKind::Grid,
            cell_m: size.unwrap_or(standard.cell_m),
            ..standard
        },
        "particles" => BeliefConfig {
            kind: BeliefKind::Particles,
            particles: size.map_or(standard.particles, |count| count as u32),
            ..standard
        },
        "adaptive" => BeliefConfig { kind: BeliefKind::Adaptive, ..standard },
        other => panic!("{other}: grid, adaptive or particles"),
    };
    AgentConfig {
        run: RunId(1),
        seed: 1,
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: PERIOD_S,
        ground: Ground { size_m: [1000.0, 1000.0] },
        fleet: FleetModel {
            count: 1,
            speed_m_s: SPEED_M_S,
            altitude_m: HEIGHT_M,
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
        // Table II of the paper, and `[pose]` of the scenario.
        pose_sigma: [10.5, 5.5, 5.5, 0.01, 0.05, 0.02],
        walk_m: 0.0,
        belief,
        exchange: ExchangeConfig::default(),
        guidance: GuidanceConfig::default(),
        channel: ChannelId(0),
    }
}

/// Writes a recording.
fn fly(seed: u64, frames: u32, file: &str) {
    let config = config("adaptive");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let target: [f64; 2] = std::array::from_fn(|_| rng.random_range(-300.0..300.0));
    let bearing: f64 = rng.random_range(-3.1..3.1);
    let start = [target[0] - 250.0 * bearing.cos(), target[1] - 250.0 * bearing.sin(), HEIGHT_M];
    let mut aircraft = FixedWing::level(config.fleet.fixed_wing, start, bearing + 0.1, SPEED_M_S);
    let mut aim = near(target, &mut rng);
    let mut was_near = false;
    let mut out = std::io::BufWriter::new(std::fs::File::create(file).expect("a file"));
    writeln!(out, "{HEADER}").expect("written");
    for step in 1..=frames {
        aircraft.advance(PERIOD_S);
        let pose = aircraft.pose();
        let (seen, is_detection) = sighting(&config, &pose, target, &mut rng);
        let ReportedPose { p_world: [x, y, z], angles_rad: [yaw, pitch, roll] } =
            ReportedPose::from(&reported(&config, &pose, &mut rng));
        let seen = seen.map_or(",".to_owned(), |z| {
            let [c, r] = z.map(|z| z as f32);
            format!("{c},{r}")
        });
        let [tx, ty] = target;
        let detected = u8::from(is_detection);
        writeln!(out, "{step},{x},{y},{z},{yaw},{pitch},{roll},{seen},{tx},{ty},{detected}")
            .expect("written");
        // Towards a point near the target, 130 m past it, and back to another point.
        let (dx, dy) = (aim[0] - pose.p_world[0], aim[1] - pose.p_world[1]);
        let distance = dx.hypot(dy);
        was_near |= distance < 40.0;
        if was_near && distance > 130.0 {
            (was_near, aim) = (false, near(target, &mut rng));
        }
        if !was_near {
            let turn = (dy.atan2(dx) - pose.yaw_rad + std::f64::consts::PI)
                .rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
            aircraft.command(pose.yaw_rad + turn);
        } else {
            aircraft.command(pose.yaw_rad);
        }
    }
}

/// A point over which to fly: the target is rarely in the middle of the image.
fn near(target: [f64; 2], rng: &mut ChaCha8Rng) -> [f64; 2] {
    target.map(|x| x + 15.0 * normal(rng))
}

/// What the detector reports, and whether that is the target: as `world::sensor` decides it.
fn sighting(
    config: &AgentConfig,
    pose: &Pose,
    [x, y]: [f64; 2],
    rng: &mut ChaCha8Rng,
) -> (Option<[f64; 2]>, bool) {
    let view = config.camera.at(pose);
    let size = [config.camera.columns, config.camera.rows].map(f64::from);
    let u: f64 = rng.random();
    let anywhere = size.map(|side| side * rng.random::<f64>());
    let is_inside = |z: &[f64; 2]| (0..2).all(|axis| (0.0..=size[axis]).contains(&z[axis]));
    let image = view.project(&Vector3::new(x, y, 0.0)).filter(is_inside);
    let p = image.map_or(0.0, |[c, r]| config.detector.p_detected(view.resolution_px_m2(c, r)));
    if u < p {
        return (image, true);
    }
    ((u < p + config.detector.p_false).then_some(anywhere), false)
}

/// What navigation reports, as `world::navigation` does with white noise.
fn reported(config: &AgentConfig, pose: &Pose, rng: &mut ChaCha8Rng) -> Pose {
    let [along, across, up, yaw, pitch, roll] = config.pose_sigma.map(|s| s * normal(rng));
    let (sin, cos) = pose.yaw_rad.sin_cos();
    let [x, y, z] = pose.p_world;
    Pose {
        p_world: [x + along * cos - across * sin, y + along * sin + across * cos, z + up],
        yaw_rad: pose.yaw_rad + yaw,
        pitch_rad: pose.pitch_rad + pitch,
        roll_rad: pose.roll_rad + roll,
    }
}

fn read(file: &str) -> Vec<Line> {
    let text = std::fs::read_to_string(file).expect("a recording");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEADER), "{file}: not a recording");
    lines.map(line).collect()
}

fn line(line: &str) -> Line {
    let fields: Vec<&str> = line.split(',').collect();
    let f = |index: usize| fields[index].parse::<f32>().expect("a number");
    let pose = ReportedPose { p_world: [f(1), f(2), f(3)], angles_rad: [f(4), f(5), f(6)] };
    let step: u32 = fields[0].parse().expect("a step");
    let id = FactorId { source: AgentId(0), incarnation: Incarnation(0), number: step };
    let sighting = (!fields[7].is_empty()).then(|| [f(7), f(8)]);
    Line {
        factor: Factor { id, step: Step(step), pose, sighting },
        target: [9, 10].map(|index| fields[index].parse().expect("a coordinate")),
        is_detection: fields[11] == "1",
    }
}

fn likelihoods(file: &str) {
    let sensor = Sensor::new(&config("adaptive"));
    for Line { factor, target: [x, y], .. } in read(file) {
        let likelihood = Likelihood::new(&sensor, &factor);
        let at = |index: u32| {
            let [i, j] = [index % 5, index / 5].map(|i| 20.0 * f64::from(i) - 40.0);
            likelihood.ln_ratio([x + i, y + j]).to_string()
        };
        println!("{}", (0..25).map(at).collect::<Vec<_>>().join(","));
    }
}

/// All frames through a filter.
fn run(config: &AgentConfig, lines: &[Line]) -> Filter {
    let mut filter = Filter::new(config);
    lines.iter().for_each(|line| stage_update(&mut filter, line.factor));
    filter
}

/// An update, by a name that `bench/callgrind-bayes.sh` finds.
#[inline(never)]
fn stage_update(filter: &mut Filter, factor: Factor) {
    filter.advance(factor.step);
    filter.apply(vec![factor]);
}

fn filter(file: &str, names: &[&str]) {
    let lines = read(file);
    for name in names {
        let config = config(name);
        let begin = processor_s();
        let (mut runs, mut seconds) = (0.0, 0.0);
        while seconds < LONG_S {
            std::hint::black_box(run(&config, &lines));
            runs += 1.0;
            seconds = processor_s() - begin;
        }
        let updates_per_s = runs * lines.len() as f64 / seconds;
        let detections = lines.iter().filter(|line| line.is_detection).count();
        let [error_m, sigma_m, rmse_m] = errors(&config, &lines);
        println!(
            "{{\"filter\":\"{name}\",\"frames\":{},\"detections\":{detections},\
             \"updates_per_s\":{updates_per_s:.1},\"error_m\":{error_m:.3},\"sigma_m\":{sigma_m:.3},\
             \"rmse_m\":{rmse_m:.3}}}",
            lines.len()
        );
    }
}

/// The processor time of this process, seconds, which other processes do not use up.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    // After the name in brackets: user and system time are the 12th and 13th field, 1/100 s.
    let fields = stat.rsplit(')').next().expect("fields").split_whitespace();
    fields.skip(11).take(2).map(|field| field.parse::<f64>().expect("a time") / 100.0).sum()
}

/// The error and the deviation after the last frame, and the root of the mean square error over the frames from the
/// first detection on.
fn errors(config: &AgentConfig, lines: &[Line]) -> [f64; 3] {
    let mut filter = Filter::new(config);
    let (mut error, mut sigma, mut squares) = (0.0, 0.0, Vec::new());
    for Line { factor, target, is_detection } in lines {
        stage_update(&mut filter, *factor);
        let estimate = filter.belief().gaussian();
        error = (target[0] - estimate.mean[0]).hypot(target[1] - estimate.mean[1]);
        sigma = estimate.sigma_m();
        if *is_detection || !squares.is_empty() {
            squares.push(error * error);
        }
    }
    [error, sigma, (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()]
}

/// A standard normal number (Box and Muller 1958).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (a, b): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}
