//! Frames of a mission for `bench/literal.py`, with what this sensor makes of them and how long it
//! takes: the thesis's literal method, pixel by pixel, is timed on the same frames.
//!
//! Usage: `literal DIR [SECONDS]...`: the moments of the mission to record, multiples of T_MPC (60
//! 150).

#[path = "../benches/recorded/mod.rs"]
#[expect(dead_code, reason = "the other stages are for other measurements")]
mod recorded;

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

use csat_agent::sense::{Measured, Sensor};
use csat_experiments::rounding;
use csat_proto::frame::Frame;
use recorded::Moment;
use serde_json::{Value, json};

/// Runs of which the median counts.
const RUNS: usize = 101;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("expected a folder to write to")?);
    let times_s = arguments.map(|s| s.parse()).collect::<Result<Vec<f64>, _>>()?;
    let times_s = if times_s.is_empty() { vec![60.0, 150.0] } else { times_s };
    fs::create_dir_all(&folder)?;
    for (time_s, moment) in times_s.iter().zip(recorded::moments(&times_s)) {
        write(&folder, &format!("city-{time_s}s"), &moment)?;
    }
    Ok(())
}

/// One frame: labels and depths as they are, everything else as JSON.
fn write(folder: &Path, name: &str, moment: &Moment) -> Result<(), Box<dyn Error>> {
    let Moment { config, frame, sensor, .. } = moment;
    let view = config.camera.at(&frame.pose);
    let labels: Vec<u8> = frame.labels.iter().map(|label| *label as u8).collect();
    let depth: Vec<u8> = frame.depth.iter().flat_map(|depth| depth.to_le_bytes()).collect();
    fs::write(folder.join(format!("{name}.labels")), labels)?;
    fs::write(folder.join(format!("{name}.depth")), depth)?;
    // On its first frame a sensor measures everything; later it leaves out what it has measured.
    let (first_ms, measured) = timed(&Sensor::new(config), frame);
    let (flying_ms, _) = timed(sensor, frame);
    let rays: Vec<Vec<f64>> =
        view.ray_matrix().row_iter().map(|row| row.iter().copied().collect()).collect();
    let camera = config.camera;
    let document = json!({
        "name": name,
        "columns": camera.columns,
        "rows": camera.rows,
        "centre_world": view.centre_world().as_slice(),
        "ray_matrix": rays,
        "d_max_m": camera.d_max_m,
        "depth_step_m": camera.depth_step_m(),
        "depth_noise": camera.depth_noise,
        "ground_m": config.ground.size_m,
        "obstacle_distance_m": config.targets.obstacle_distance_m,
        "target_radius_m": config.targets.radius_m,
        "detections": frame.detections.iter().map(|d| d.pixels).collect::<Vec<_>>(),
        "ours": ours(&measured, first_ms, flying_ms),
    });
    fs::write(folder.join(format!("{name}.json")), serde_json::to_vec(&document)?)?;
    Ok(())
}

fn ours(measured: &Measured, first_ms: f64, flying_ms: f64) -> Value {
    let targets = measured.targets.iter().map(|t| rounding::shapes(t.location.region()));
    json!({
        "first_frame_ms": first_ms,
        "in_flight_ms": flying_ms,
        "clear_ground": rounding::shapes(measured.clear_ground.region()),
        "obstacle_margin": rounding::shapes(measured.obstacle_margin.region()),
        "targets": targets.collect::<Vec<_>>(),
    })
}

/// The median time of measuring a frame with a sensor like this one, milliseconds, and the result.
#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
fn timed(sensor: &Sensor, frame: &Frame) -> (f64, Measured) {
    let run = || {
        let mut sensor = sensor.clone();
        let start = Instant::now();
        let measured = recorded::stage_sense(&mut sensor, black_box(frame));
        (1e3 * start.elapsed().as_secs_f64(), measured)
    };
    let mut runs: Vec<(f64, Measured)> = (0..RUNS).map(|_| run()).collect();
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    runs.swap_remove(RUNS / 2)
}
