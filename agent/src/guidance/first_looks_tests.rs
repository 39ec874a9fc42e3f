//! First looks against the camera, point by point, and against earlier looks.

use csat_proto::model::Ground;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::shadow::tests::random_oem;
use super::super::tests::{default_config, fill};
use super::super::viewshed::RayCaster;
use super::*;

const GROUND: Ground = Ground { size_m: [500.0, 420.0] };

fn grid() -> Grid {
    Grid::covering(&GROUND, 4.0)
}

fn everything() -> Raster {
    let mut all = Raster::empty(grid());
    fill(&mut all, [-250.0, 250.0], [-210.0, 210.0]);
    all
}

/// A caster of a map with buildings.
fn town(seed: u64) -> RayCaster {
    let mut caster = RayCaster::new(grid(), 300.0);
    caster.load(&random_oem(&mut ChaCha8Rng::seed_from_u64(seed), 60.0));
    caster
}

fn seen(first_looks: &mut FirstLooks, pose: &Pose) -> Raster {
    let mut seen = Raster::empty(grid());
    first_looks.look(RoundedPose::of(pose, &grid())).add_to(&mut seen);
    seen
}

/// The middle of a cell, where the camera looks at the region.
fn middle() -> Pose {
    let [x, y] = grid().centre(60, 51);
    Pose::level([x, y, 52.0], 0.0)
}

/// A pose from which the camera looks elsewhere.
fn aside() -> Pose {
    Pose { yaw_rad: 3.0, ..middle() }
}

#[test]
fn roofs_come_into_view_where_the_camera_sees_them() {
    let (mut rng, config) = (ChaCha8Rng::seed_from_u64(31), default_config());
    let (mut high, mut low) = (0, 0);
    for round in 0..40 {
        let caster = town(round);
        let height_map = caster.height_map();
        let mut margin = Raster::empty(grid());
        fill(&mut margin, [-40.0, 60.0], [-90.0, 90.0]);
        let mut first_looks = FirstLooks::new(grid(), &config);
        first_looks.load(&everything(), &margin, height_map, &aside());
        let [x, y] = grid().centre(3 * rng.random_range(0..40), 3 * rng.random_range(0..35));
        let heading = f64::from(rng.random_range(0..1440)) * 0.25;
        let pose = Pose::level([x, y, 53.0], heading.to_radians());
        let (seen, camera) = (seen(&mut first_looks, &pose), config.camera.at(&pose));
        for (column, row) in everything().iter() {
            let p = grid().centre(column, row);
            // The cells whose squares are within 12 m.
            let gap_m = |cells: i32| (f64::from(cells.abs()) - 0.5).max(0.0) * 4.0;
            let beside = (-4..=4).flat_map(|x| (-4..=4).map(move |y| [x, y]));
            let beside = beside.filter(|[x, y]| gap_m(*x).hypot(gap_m(*y)) <= 12.0);
            let storeys =
                beside.map(|[x, y]| height_map.storeys([column as i32 + x, row as i32 + y])).max();
            let height_m = f64::from(storeys.unwrap().next_multiple_of(5));
            let roof = Vector3::new(p[0], p[1], height_m);
            let in_image = camera
                .project(&roof)
                .is_some_and(|[c, r]| (0.0..480.0).contains(&c) && (0.0..360.0).contains(&r));
            // At this distance a depth error of 1 % is half the obstacle distance.
            let is_near = (roof - camera.centre_world()).norm() <= 125.0;
            let is_there = (1.0..53.0).contains(&height_m) && !margin.get(column, row);
            let is_expected = in_image && is_near && is_there;
            assert_eq!(seen.get(column, row), is_expected, "{column} {row} {height_m}");
            high += u32::from(is_expected && height_m > 25.0);
            low += u32::from(is_expected && height_m <= 25.0);
        }
    }
    assert!(high > 100 && low > 100, "{high} {low}");
}

#[test]
fn what_was_free_once_is_never_looked_at_for_the_first_time() {
    let (caster, nothing) = (town(1), Raster::empty(grid()));
    let mut first_looks = FirstLooks::new(grid(), &default_config());
    let mut wanted = everything();
    let mut free = Raster::empty(grid());
    fill(&mut free, [40.0, 80.0], [-10.0, 40.0]);
    wanted.subtract(&free);
    first_looks.load(&wanted, &nothing, caster.height_map(), &aside());
    let before = seen(&mut first_looks, &middle());
    first_looks.load(&everything(), &nothing, caster.height_map(), &aside());
    assert_eq!(seen(&mut first_looks, &middle()), before);
    assert!(before.count() > 50 && before.count_common(&free) == 0);
}

#[test]
fn what_was_looked_at_twice_in_vain_is_given_up() {
    let (caster, nothing) = (town(1), Raster::empty(grid()));
    let mut first_looks = FirstLooks::new(grid(), &default_config());
    let mut counts = Vec::new();
    for pose in [middle(), aside(), middle(), aside()] {
        first_looks.load(&everything(), &nothing, caster.height_map(), &pose);
        counts.push(seen(&mut first_looks, &middle()).count());
    }
    assert!(counts[0] > 50, "{counts:?}");
    // The second look is the last one with a bonus.
    assert_eq!(counts, [counts[0], counts[0], counts[0], 0]);
}

/// Without noise the range of the camera is the only limit.
#[test]
fn exact_cameras_see_farther() {
    let (caster, nothing) = (town(1), Raster::empty(grid()));
    let mut config = default_config();
    let counts = [[-0.01, 0.01], [-0.005, 0.0], [0.0, 0.0]].map(|depth_noise| {
        config.camera.depth_noise = depth_noise;
        let mut first_looks = FirstLooks::new(grid(), &config);
        first_looks.load(&everything(), &nothing, caster.height_map(), &aside());
        seen(&mut first_looks, &middle()).count()
    });
    assert!(counts.is_sorted() && 4 * counts[0] < 3 * counts[1], "{counts:?}");
}
