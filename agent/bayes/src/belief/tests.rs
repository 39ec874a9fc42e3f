use csat_proto::camera::Pose;
use csat_proto::model::Ground;

use super::*;
use crate::likelihood::Sensor;
use crate::likelihood::tests::sensor;

const GROUND: Ground = Ground { size_m: [1000.0, 1000.0] };

fn frame(
    sensor: &Sensor,
    p: [f64; 2],
    yaw_rad: f64,
    sighting: Option<[f64; 2]>,
) -> Arc<Likelihood> {
    let pose = Pose { p_world: [p[0], p[1], 90.0], yaw_rad, pitch_rad: -0.07, roll_rad: 0.1 };
    Arc::new(Likelihood::of_frame(sensor, &pose, sighting))
}

/// Frames along a line, and detections of a target near (103, 57) at the end.
fn frames(sensor: &Sensor) -> Vec<Arc<Likelihood>> {
    let search = (0..40).map(|i| frame(sensor, [-400.0 + 12.0 * f64::from(i), 30.0], 0.1, None));
    let seen = (0..6).map(|i| {
        let x = 80.0 + 6.0 * f64::from(i);
        let pose = Pose { p_world: [x, 50.0, 90.0], yaw_rad: 0.4, pitch_rad: -0.07, roll_rad: 0.1 };
        let target = nalgebra::Vector3::new(103.0, 57.0, 0.0);
        let z = sensor.camera.at(&pose).project(&target).unwrap();
        frame(sensor, [x + 3.0, 50.0 - f64::from(i)], 0.4, Some(z))
    });
    search.chain(seen).collect()
}

fn adaptive() -> AdaptiveBelief {
    AdaptiveBelief::new(Grid::covering(&GROUND, 12.5), 0.5)
}

/// Law (1): the belief is the product of the factors, in any order.
#[test]
fn a_belief_is_the_product_of_its_factors_in_any_order() {
    let sensor = sensor();
    let frames = frames(&sensor);
    let mut grid = GridBelief::new(Grid::covering(&GROUND, 12.5));
    frames.iter().for_each(|frame| grid.update(std::slice::from_ref(frame)));
    let mut turned = GridBelief::new(Grid::covering(&GROUND, 12.5));
    frames.chunks(7).rev().for_each(|some| turned.update(some));
    let mut cells = adaptive();
    frames.iter().rev().for_each(|frame| cells.update(std::slice::from_ref(frame)));
    for i in 0..50 {
        for j in 0..50 {
            let p = [20.0 * f64::from(i) - 490.0, 20.0 * f64::from(j) - 490.0];
            for (centre, ln) in [grid.at(p), turned.at(p), cells.at(p)].into_iter().flatten() {
                let product: f64 = frames.iter().map(|frame| frame.ln_ratio(centre)).sum();
                assert!((ln - product).abs() <= 1e-9 * product.abs().max(1.0), "{ln} {product}");
            }
        }
    }
}

/// The cells that split find the same mean, deviation and region as a grid of small cells.
#[test]
fn splitting_cells_know_what_a_fine_grid_knows() {
    let sensor = sensor();
    let frames = frames(&sensor);
    let mut fine = GridBelief::new(Grid::covering(&GROUND, 1.0));
    let mut cells = adaptive();
    let mut coarse = GridBelief::new(Grid::covering(&GROUND, 12.5));
    for some in frames.chunks(2) {
        fine.update(some);
        cells.update(some);
        coarse.update(some);
    }
    let (a, b) = (fine.gaussian(), cells.gaussian());
    assert!((a.mean[0] - b.mean[0]).hypot(a.mean[1] - b.mean[1]) < 0.1, "{a:?} {b:?}");
    assert!((a.sigma_m() / b.sigma_m() - 1.0).abs() < 0.02, "{a:?} {b:?}");
    assert!((b.mean[0] - 103.0).hypot(b.mean[1] - 57.0) < 3.0 * b.sigma_m());
    let areas = [fine.highest_density(0.95).area_m2(), cells.highest_density(0.95).area_m2()];
    assert!((areas[0] / areas[1] - 1.0).abs() < 0.1, "{areas:?}");
    assert!(cells.count() < 12_000, "{}", cells.count());
    assert!(coarse.gaussian().sigma_m() < 30.0);
    assert!(cells.highest_density(0.95).contains([103.0, 57.0]));
}

/// A belief of no factors is uniform, and can be asked.
#[test]
fn without_news_a_belief_is_uniform() {
    let cells = adaptive();
    let places = [[-499.0, 499.0], [3.0, -7.0]];
    assert!(places.iter().all(|p| cells.at(*p).is_some_and(|(_, ln)| ln == 0.0)));
    assert!((cells.highest_density(0.95).area_m2() / 950_000.0 - 1.0).abs() < 1e-3);
}

/// Regions hold the share they are said to hold, ties included.
#[test]
fn regions_hold_their_share() {
    let sensor = sensor();
    let frames = frames(&sensor);
    for count in [0, 1, 20, 41, 46] {
        let mut grid = GridBelief::new(Grid::covering(&GROUND, 5.0));
        let mut cells = adaptive();
        frames[..count].chunks(3).for_each(|some| {
            grid.update(some);
            cells.update(some);
        });
        for (squares, region) in [
            (grid.squares(), grid.highest_density(0.95)),
            (cells.squares(), cells.highest_density(0.95)),
        ] {
            let inside = |s: &&square::Square| region.contains(s.centre);
            let total: f64 = squares.iter().map(|s| s.mass).sum();
            let held = squares.iter().filter(inside).map(|s| s.mass).sum::<f64>() / total;
            let most = squares.iter().map(|s| s.mass).fold(0.0, f64::max) / total;
            assert!(held >= 0.95 - 1e-9 && held <= 0.95 + most + 1e-9, "{count}: {held} {most}");
        }
    }
}

#[test]
fn particles_gather_where_the_target_is() {
    let sensor = sensor();
    let before = Particles::new(GROUND, 6400, [7; 32]).gaussian();
    assert!((before.sigma_m() - 408.0).abs() < 10.0, "{before:?}");
    let mut fine = GridBelief::new(Grid::covering(&GROUND, 2.0));
    fine.update(&frames(&sensor));
    let exact = fine.gaussian();
    // Few particles are near at the first detection, so filters differ.
    let filtered = |key: u8| {
        let mut particles = Particles::new(GROUND, 6400, [key; 32]);
        for (step, some) in (1..).zip(frames(&sensor).chunks(1)) {
            particles.walk(Step(step), 1.0);
            particles.update(some);
        }
        particles
    };
    let mut all: Vec<Particles> = (0..9).map(filtered).collect();
    all.sort_by(|a, b| a.gaussian().sigma_m().total_cmp(&b.gaussian().sigma_m()));
    let mut particles = all.swap_remove(4);
    let found = particles.gaussian();
    let apart_m = (found.mean[0] - exact.mean[0]).hypot(found.mean[1] - exact.mean[1]);
    assert!(apart_m < 4.0 * exact.sigma_m(), "{found:?} {exact:?}");
    assert!(found.sigma_m() < 1.5 * exact.sigma_m(), "{found:?} {exact:?}");
    let region = particles.highest_density(0.95);
    let inside = particles.points().filter(|p| region.contains(*p)).count();
    assert!((6080..6200).contains(&inside), "{inside}");
    // Without news the process noise makes it wider.
    (100..200).for_each(|step| particles.walk(Step(step), 1.0));
    let later = particles.gaussian().covariance[0] - found.covariance[0];
    assert!((later - 100.0).abs() < 20.0, "{later}");
    let mut again = Particles::new(GROUND, 6400, [7; 32]);
    again.walk(Step(1), 1.0);
    let mut other = Particles::new(GROUND, 6400, [8; 32]);
    other.walk(Step(1), 1.0);
    assert!(again.points().ne(other.points()));
}

/// A target that moves: variances grow by σ² a step, whatever the cells are.
#[test]
fn a_moving_target_spreads() {
    let sensor = sensor();
    let frames = frames(&sensor);
    let mut coarse = GridBelief::new(Grid::covering(&GROUND, 12.5));
    let mut fine = GridBelief::new(Grid::covering(&GROUND, 2.0));
    let mut cells = adaptive();
    coarse.update(&frames);
    fine.update(&frames);
    cells.update(&frames);
    let before = [coarse.gaussian(), fine.gaussian(), cells.gaussian()];
    for _ in 0..50 {
        coarse.diffuse(1.0);
        fine.diffuse(1.0);
        cells.diffuse(1.0);
    }
    let after = [coarse.gaussian(), fine.gaussian(), cells.gaussian()];
    for (before, after) in before.into_iter().zip(after) {
        for axis in [0, 2] {
            let grown = after.covariance[axis] - before.covariance[axis];
            assert!((grown - 50.0).abs() < 5.0, "{before:?} {after:?}");
        }
        assert!((after.mean[0] - before.mean[0]).abs() < 0.5, "{before:?} {after:?}");
    }
}

/// Tiles say what the belief is, and fusing the same belief again changes nothing.
#[test]
fn tiles_carry_a_belief() {
    let sensor = sensor();
    let frames = frames(&sensor);
    let mut cells = adaptive();
    let mut grid = GridBelief::new(Grid::covering(&GROUND, 2.0));
    cells.update(&frames);
    grid.update(&frames);
    let coarse = Grid::covering(&GROUND, CELL_M);
    let mut fused = Vec::new();
    for squares in [cells.squares(), grid.squares()] {
        let tiles = Arc::new(square::tiles(&coarse, &squares));
        assert!(tiles.is_cover(&coarse));
        let mut receiver = adaptive();
        receiver.pool(0.0, 1.0, &coarse, &tiles);
        let (sent, got) = (cells.gaussian(), receiver.gaussian());
        assert!((sent.mean[0] - got.mean[0]).hypot(sent.mean[1] - got.mean[1]) < 1.0);
        assert!((sent.sigma_m() / got.sigma_m() - 1.0).abs() < 0.1, "{sent:?} {got:?}");
        let once = receiver.gaussian();
        receiver.pool(0.5, 0.5, &coarse, &tiles);
        let twice = receiver.gaussian();
        assert!((once.sigma_m() / twice.sigma_m() - 1.0).abs() < 0.02, "{once:?} {twice:?}");
        receiver.pool(1.0, 1.0, &coarse, &tiles);
        fused.push(receiver.gaussian().sigma_m() / once.sigma_m());
    }
    assert!(fused.iter().all(|ratio| *ratio < 0.85), "the product is too sure: {fused:?}");
}
