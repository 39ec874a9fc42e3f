//! Random regions, ordinary and degenerate ones.

use std::f64::consts::TAU;

use csat_proto::region::{GridPoint, Region, Ring, UNITS_PER_M, grid_point};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The generator of a case.
pub type Rng = ChaCha8Rng;

/// Runs `case` for the seeds 0..count, or for the seed in `CASE` only.
pub fn cases(test: &'static str, count: u64, case: impl Fn(&mut Rng)) {
    let only = std::env::var("CASE").ok().map(|seed| seed.parse().expect("CASE is a seed"));
    for seed in only.map_or(0..count, |seed: u64| seed..seed + 1) {
        let _replay = Replay { test, seed };
        case(&mut Rng::seed_from_u64(seed));
    }
}

struct Replay {
    test: &'static str,
    seed: u64,
}

impl Drop for Replay {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let Self { test, seed } = self;
            eprintln!("replay: CASE={seed} cargo test -p csat-agent --test region {test}");
        }
    }
}

/// A region that is not ∅, of any family and of any size from a few grid units to some hundred
/// metres, anywhere within ±1000 m.
pub fn any_region(rng: &mut Rng) -> Region {
    let scales_m = [5.0 / UNITS_PER_M, 40.0 / UNITS_PER_M, 0.002, 0.05, 1.0, 8.0, 40.0, 300.0];
    let scale_m = scales_m[rng.random_range(0..scales_m.len())] * rng.random_range(0.5..1.5);
    let room_m = 1000.0 - 1.5 * scale_m;
    loop {
        let at = [rng.random_range(-room_m..room_m), rng.random_range(-room_m..room_m)];
        let region = region_at(rng, at, scale_m);
        if !region.is_empty() {
            return region;
        }
    }
}

/// A region of any family within `1.5 * scale_m` of `at`; may be ∅ at scales of a few grid units.
pub fn region_at(rng: &mut Rng, at: [f64; 2], scale_m: f64) -> Region {
    match rng.random_range(0..8) {
        0 => solid(&[star(rng, at, scale_m)]),
        1 => solid(&[comb(rng, at, scale_m)]),
        2 => solid(&[needle(rng, at, scale_m)]),
        3 => solid(&[staircase(rng, at, scale_m)]),
        4 => solid(&[nearly_straight(rng, at, scale_m)]),
        5 => with_holes(rng, at, scale_m),
        6 => {
            let part = |rng: &mut Rng| {
                let side = rng.random_range(0.1..0.6) * scale_m;
                let (dx, dy) = (rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5));
                let at = [at[0] + dx * scale_m, at[1] + dy * scale_m];
                if rng.random() { star(rng, at, side) } else { staircase(rng, at, side) }
            };
            let count = rng.random_range(2..7);
            let parts: Vec<Ring> = (0..count).map(|_| part(rng)).collect();
            solid(&parts)
        }
        _ => {
            // A ring with many crossings and pinch points.
            let count = rng.random_range(4..14);
            let mut point = || rng.random_range(-1.0..1.0) * scale_m;
            let ring: Ring =
                (0..count).map(|_| grid_point([at[0] + point(), at[1] + point()])).collect();
            resolved(&[ring], FillRule::EvenOdd)
        }
    }
}

/// The region of the points that at least one ring encloses.
pub fn solid(rings: &[Ring]) -> Region {
    resolved(rings, FillRule::NonZero)
}

/// The region of rings, by the default settings of the library.
pub fn resolved(rings: &[Ring], fill: FillRule) -> Region {
    Region::from_shapes(Overlay::from_subj(rings).overlay(OverlayRule::Subject, fill))
}

/// A star-shaped ring with spikes and notches.
pub fn star(rng: &mut Rng, at: [f64; 2], scale_m: f64) -> Ring {
    let count = rng.random_range(3..24);
    let least = rng.random_range(0.05..0.9);
    let mut angles: Vec<f64> = (0..count).map(|_| rng.random_range(0.0..TAU)).collect();
    angles.sort_by(f64::total_cmp);
    let corner = |angle: f64| {
        let radius = rng.random_range(least..1.0) * scale_m;
        grid_point([at[0] + radius * angle.cos(), at[1] + radius * angle.sin()])
    };
    angles.into_iter().map(corner).collect()
}

/// A bar with teeth, the slits between them down to one grid unit wide.
fn comb(rng: &mut Rng, at: [f64; 2], scale_m: f64) -> Ring {
    let teeth = rng.random_range(2..8);
    let pitch = 2.0 * scale_m / f64::from(teeth);
    let slit = if rng.random() { pitch * 0.3 } else { (1.0 / UNITS_PER_M).min(pitch * 0.5) };
    let angle: f64 = if rng.random() { 0.0 } else { rng.random_range(0.0..TAU) };
    let place = |x: f64, y: f64| {
        let (sin, cos) = angle.sin_cos();
        grid_point([at[0] + x * cos - y * sin, at[1] + x * sin + y * cos])
    };
    let mut ring = vec![place(-scale_m, -scale_m), place(scale_m, -scale_m)];
    for tooth in (0..teeth).rev() {
        let west = -scale_m + f64::from(tooth) * pitch;
        let top = rng.random_range(0.2..1.0) * scale_m;
        let root = rng.random_range(-0.9..0.1) * scale_m;
        ring.extend([place(west + pitch, top), place(west + slit, top)]);
        if tooth > 0 {
            ring.extend([place(west + slit, root), place(west, root)]);
        }
    }
    ring
}

/// A long triangle a few grid units wide.
fn needle(rng: &mut Rng, at: [f64; 2], scale_m: f64) -> Ring {
    let angle = rng.random_range(0.0..TAU);
    let tip = grid_point([at[0] + scale_m * angle.cos(), at[1] + scale_m * angle.sin()]);
    let base = grid_point(at);
    let (dx, dy) = (rng.random_range(-3..=3), rng.random_range(-3..=3));
    vec![base, tip, GridPoint::new(base.x + dx, base.y + dy)]
}

/// Axis-parallel steps up and down again, as the outline of pixels has them.
fn staircase(rng: &mut Rng, at: [f64; 2], scale_m: f64) -> Ring {
    let steps = rng.random_range(2..14);
    let width = 2.0 * scale_m / f64::from(steps);
    let mut ring = vec![[at[0] + scale_m, at[1] - scale_m], [at[0] - scale_m, at[1] - scale_m]];
    let mut top = 0.0;
    for step in 0..steps {
        top = f64::clamp(top + rng.random_range(-0.3..0.3), -0.8, 1.0);
        let west = at[0] - scale_m + f64::from(step) * width;
        ring.push([west, at[1] + top * scale_m]);
        ring.push([west + width, at[1] + top * scale_m]);
    }
    ring.iter().rev().map(|&p| grid_point(p)).collect()
}

/// A turned square whose sides are bent by a unit here and there.
fn nearly_straight(rng: &mut Rng, at: [f64; 2], scale_m: f64) -> Ring {
    let angle: f64 = rng.random_range(0.0..TAU);
    let mut ring = Ring::new();
    for side in 0..4 {
        let (sin, cos) = (angle + f64::from(side) * TAU / 4.0).sin_cos();
        let count = rng.random_range(1..9);
        for i in 0..count {
            let along = 1.0 - 2.0 * f64::from(i) / f64::from(count);
            let p = grid_point([
                at[0] + scale_m * (cos - sin * -along),
                at[1] + scale_m * (sin + cos * -along),
            ]);
            let bend = |rng: &mut Rng| rng.random_range(-1..=1);
            ring.push(GridPoint::new(p.x + bend(rng), p.y + bend(rng)));
        }
    }
    ring
}

/// A set with holes from very narrow to most of it, and islands in them.
fn with_holes(rng: &mut Rng, at: [f64; 2], scale_m: f64) -> Region {
    let mut rings = vec![nearly_straight(rng, at, scale_m)];
    for _ in 0..rng.random_range(1..6) {
        let size = scale_m * 10f64.powf(rng.random_range(-2.5..-0.1));
        let (dx, dy) = (rng.random_range(-0.7..0.7), rng.random_range(-0.7..0.7));
        rings.push(star(rng, [at[0] + dx * scale_m, at[1] + dy * scale_m], size));
    }
    resolved(&rings, FillRule::EvenOdd)
}
