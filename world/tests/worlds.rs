//! Whole worlds, generated and real: the assumptions of the theory hold at every step.

use std::path::PathBuf;

use csat_proto::model::Driving;
use csat_world::map::{MapConfig, MapKind};
use csat_world::obstacle::Obstacle;
use csat_world::target::TargetTruth;
use csat_world::world::{World, WorldConfig};
use geo::{
    Area, BooleanOps, BoundingRect, Distance, Euclidean, Intersects, Point, Polygon, Validation,
};

fn helsinki(density: &str) -> WorldConfig {
    let file =
        format!("{}/../experiments/maps/helsinki-{density}.geojson", env!("CARGO_MANIFEST_DIR"));
    let map = MapConfig {
        kind: MapKind::GeoJson,
        file: Some(PathBuf::from(file)),
        ..MapConfig::default()
    };
    WorldConfig { map, ..WorldConfig::default() }
}

fn worlds() -> [(&'static str, WorldConfig); 3] {
    [
        ("city", WorldConfig::default()),
        ("helsinki-05", helsinki("05")),
        ("helsinki-17", helsinki("17")),
    ]
}

/// Drives for `steps` under the monitor; `drove` gets the world and each car before and after a
/// period, with the way between.
fn drive(
    name: &str,
    world: &mut World,
    steps: u32,
    mut drove: impl FnMut(&World, &TargetTruth, &TargetTruth, f64),
) {
    let mut monitor = world.monitor();
    for _ in 0..steps {
        let before = world.targets().to_vec();
        let violations = monitor.check(world.step(), world.targets());
        assert_eq!(violations, [], "{name}");
        world.advance();
        for (now, before) in world.targets().iter().zip(&before) {
            let d = [0, 1].map(|i| now.location[i] - before.location[i]);
            drove(world, before, now, d[0].hypot(d[1]));
        }
    }
}

#[test]
fn separations_hold_for_300_seconds() {
    for (name, config) in worlds() {
        let limit_m = config.targets.v_max_m_s * config.period_s;
        for seed in 0..10 {
            let mut world = World::new(&config, seed).unwrap();
            let start = world.targets().to_vec();
            let what = format!("{name}, seed {seed}");
            drive(&what, &mut world, 600, |_, before, now, way_m| {
                assert!(way_m <= limit_m + 1e-9, "{what}");
                // The speed is drawn once.
                assert_eq!(now.speed_m_s, before.speed_m_s);
            });
            let moved =
                world.targets().iter().zip(&start).filter(|(a, b)| a.location != b.location);
            assert!(moved.count() >= 6, "{what}: cars stand still");
        }
    }
}

#[test]
fn cars_that_evade_use_all_that_the_model_allows_and_no_more() {
    for (name, mut config) in worlds() {
        config.targets.driving = Driving::Evasive;
        let limit_m = config.targets.v_max_m_s * config.period_s;
        for seed in 0..3 {
            let mut world = World::new(&config, seed).unwrap();
            let (mut moves, mut at_v_max, mut off_road) = (0, 0, 0);
            let what = format!("{name}, seed {seed}");
            drive(&what, &mut world, 300, |world, _, now, way_m| {
                moves += 1;
                assert!(way_m <= limit_m + 1e-9, "{what}");
                at_v_max += u32::from(way_m > limit_m - 1e-9);
                let road = world.roads().edges().iter().map(|edge| {
                    let line = geo::LineString::from(edge.line.clone());
                    Euclidean.distance(&Point::from(now.location), &line)
                });
                off_road += u32::from(road.fold(f64::INFINITY, f64::min) > 1.0);
            });
            assert!(at_v_max * 10 > moves * 9, "{what}: {at_v_max} of {moves}");
            assert!(off_road * 2 > moves, "{what}: {off_road} of {moves}");
        }
    }
}

/// The distances of the monitor against those of `geo`, which the world does not use for them.
#[test]
fn no_location_is_near_a_wall_by_an_independent_measure() {
    for (name, config) in worlds() {
        let mut world = World::new(&config, 3).unwrap();
        for _ in 0..100 {
            world.advance();
            for target in world.targets() {
                let [x, y] = target.location;
                for obstacle in world.obstacles() {
                    let distance = Euclidean.distance(&Point::new(x, y), &obstacle.footprint);
                    assert!(distance > config.targets.obstacle_distance_m, "{name} {target:?}");
                }
            }
        }
    }
}

/// The real shares were computed independently of this code, by clipping each outline on its own
/// (Sutherland-Hodgman) after an equirectangular projection: 4.635 % and 17.55 %.
#[test]
fn the_built_share_is_what_the_maps_say() {
    for ((name, config), (expected, tolerance)) in
        worlds().iter().zip([(0.05, 1e-9), (0.04635, 1e-4), (0.1755, 1e-4)])
    {
        let world = World::new(config, 1).unwrap();
        let share = world.map().built_share();
        assert!((share - expected).abs() <= tolerance, "{name}: {share}, expected {expected}");
    }
}

/// Bodies, not just locations: a scene's solids never overlap.
#[test]
fn bodies_overlap_neither_walls_nor_each_other() {
    for (name, config) in worlds() {
        let mut world = World::new(&config, 2).unwrap();
        for _ in 0..60 {
            (0..10).for_each(|_| world.advance());
            let scene = world.scene();
            let (walls, bodies) = scene.prisms.split_at(world.obstacles().len());
            assert_eq!(walls.len(), world.obstacles().len());
            let bodies: Vec<Polygon> = bodies
                .iter()
                .map(|b| Polygon::new(b.rings[0].iter().copied().collect(), Vec::new()))
                .collect();
            for (i, body) in bodies.iter().enumerate() {
                let clear = |o: &Obstacle| !o.footprint.intersects(body);
                assert!(world.obstacles().iter().all(clear), "{name}: {body:?}");
                assert!(bodies[..i].iter().all(|other| !other.intersects(body)), "{name}");
            }
        }
    }
}

#[test]
fn obstacles_are_valid_disjoint_and_inside() {
    for (name, config) in worlds() {
        let world = World::new(&config, 1).unwrap();
        let half = world.ground().size_m.map(|s| s / 2.0 + 1e-6);
        for (i, a) in world.obstacles().iter().enumerate() {
            assert_eq!(a.footprint.validation_errors(), [], "{name}: {}", a.name);
            assert!(a.footprint.signed_area() > 0.0, "{name}: {} runs clockwise", a.name);
            assert!(a.height_m > 0.0 && a.height_m <= 50.0, "{name}: {}", a.name);
            let bounds = a.footprint.bounding_rect().unwrap();
            assert!(bounds.max().x <= half[0] && bounds.min().x >= -half[0], "{name}: {}", a.name);
            assert!(bounds.max().y <= half[1] && bounds.min().y >= -half[1], "{name}: {}", a.name);
            for b in &world.obstacles()[..i] {
                if b.footprint.bounding_rect().unwrap().intersects(&bounds) {
                    let shared = a.footprint.intersection(&b.footprint).unsigned_area();
                    assert!(shared < 1e-3, "{name}: {} and {} share {shared} m²", a.name, b.name);
                }
            }
        }
    }
}

#[test]
fn the_seed_is_the_world() {
    for (name, config) in worlds() {
        let run = |seed| {
            let mut world = World::new(&config, seed).unwrap();
            (0..50).for_each(|_| world.advance());
            (world.targets().to_vec(), world.scene())
        };
        assert_eq!(run(5), run(5), "{name}");
        assert_ne!(run(5).0, run(6).0, "{name}");
    }
}

#[test]
fn real_maps_keep_their_attribution_and_their_roads() {
    for (density, at_least_m) in [("05", 500.0), ("17", 500.0)] {
        let world = World::new(&helsinki(density), 1).unwrap();
        let attribution = world.map().attribution.as_deref();
        assert_eq!(attribution, Some("© OpenStreetMap contributors, ODbL 1.0"));
        assert!(world.roads().length_m() > at_least_m, "{}", world.roads().length_m());
    }
}

#[test]
fn small_and_large_worlds_work() {
    for (size, cars) in [(60.0, 1), (120.0, 3), (2000.0, 64)] {
        let mut config = WorldConfig::default();
        config.map.size_m = [size, size];
        config.targets.count = cars;
        let mut world = World::new(&config, 1).unwrap();
        let mut monitor = world.monitor();
        for _ in 0..50 {
            world.advance();
            assert_eq!(monitor.check(world.step(), world.targets()), []);
        }
    }
}
