//! What a mission will cost at least, told before it flies: images and looks ahead. What sets cost is bounded
//! by `estimator.max_vertices`.

use csat_agent::config::{Criterion, Schedule, planning_camera};

use super::{Check, Scenario};
use crate::scenario::mistake::Mistake;

/// Rendering a pixel and sensing it, seconds; as docs/performance.md has it for the default image.
const PIXEL_S: f64 = 2e-8;
/// A look of a planner on the default raster, seconds; likewise.
const LOOK_S: f64 = 4e-5;
/// The cells of that raster.
const LOOK_CELLS: f64 = 62_500.0;
/// The cores that have to keep up with real time.
const CORES: f64 = 2.0;
/// The most cells that guidance looks ahead: rays take memory with their square.
const MAX_REACH_CELLS: f64 = 2048.0;

/// Refuses rasters too fine for how far guidance looks, and warns of what is surely slower than real time.
pub(super) fn judge(check: &mut Check, scenario: &Scenario, period_s: Option<f64>) {
    let agents = f64::from(scenario.agents.count);
    let cell_m = scenario.estimator.raster_cell_m;
    let camera = planning_camera(scenario.camera, &scenario.ground(), &scenario.agents);
    let reach_m = camera.d_max_m;
    // A cell that is no number is refused elsewhere.
    let is_too_fine = reach_m / cell_m > MAX_REACH_CELLS;
    check.that(
        !is_too_fine,
        &["estimator.raster_cell_m", "camera.d_max_m", "map.size_m"],
        &cell_m.to_string(),
        &format!(
            "at least {:.3} m: guidance looks {reach_m:.0} m far, at most {MAX_REACH_CELLS} cells",
            reach_m / MAX_REACH_CELLS
        ),
    );
    let Some(period_s) = period_s else { return };
    let frame_s = PIXEL_S * scenario.camera.pixels() as f64;
    warn(
        check,
        agents * frame_s / period_s,
        &["camera.columns", "camera.rows", "agents.count", "run.period_s"],
        &format!(
            "images of {} x {} pixels take {} agents about {frame_s:.3} s each every {period_s} s",
            scenario.camera.columns, scenario.camera.rows, scenario.agents.count
        ),
    );
    let looks = looks(scenario);
    let [east, north] = scenario.map.size_m;
    let cells = (east / cell_m) * (north / cell_m);
    let decision_s = looks * LOOK_S * (cells / LOOK_CELLS).max(1.0);
    warn(
        check,
        agents * decision_s / scenario.guidance.period_s,
        &["guidance.n_mpc", "guidance.increments_deg", "estimator.raster_cell_m", "agents.count"],
        &format!(
            "{looks:.0} looks ahead on {cells:.0} cells take {} agents about {decision_s:.3} s each \
             every {} s",
            scenario.agents.count, scenario.guidance.period_s
        ),
    );
}

/// How often a planner looks from a pose in a decision, by all passes.
fn looks(scenario: &Scenario) -> f64 {
    let guidance = &scenario.guidance;
    let increments = guidance.increments_deg.len().max(1) as f64;
    match guidance.criterion {
        Criterion::Circles | Criterion::Lawnmower => 0.0,
        // Looks are remembered; most candidates come by the same places.
        far if far.is_far_sighted() => f64::from(guidance.str4.beam),
        _ => {
            let passes = if guidance.schedule == Schedule::SequentialLoopback { 2.0 } else { 1.0 };
            let blocks = 1..=i32::from(guidance.n_mpc);
            passes * blocks.map(|block| increments.powi(block)).sum::<f64>()
        }
    }
}

/// Warns of a cost of so many seconds of computing per second if real time has no room for it.
fn warn(check: &mut Check, cost: f64, keys: &[&'static str], what: &str) {
    if cost > CORES {
        let text = format!("{what}: slower than real time");
        let help = format!(
            "{cost:.1} s of computing for each second flown, so about {:.2} times real time on \
             {CORES:.0} cores",
            CORES / cost
        );
        check.warn(keys, Mistake::new(text).help(help));
    }
}
