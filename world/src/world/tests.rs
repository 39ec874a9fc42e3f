use super::*;
use crate::scene::Entity;
use csat_proto::ids::TargetId;

#[test]
fn the_scene_holds_obstacles_then_targets() {
    let world = World::new(&WorldConfig::default(), 1).unwrap();
    let scene = world.scene();
    let obstacles = world.obstacles().len();
    assert_eq!(scene.prisms.len(), obstacles + 8);
    for (i, prism) in scene.prisms[..obstacles].iter().enumerate() {
        assert_eq!(prism.entity, Entity::Obstacle(i as u32));
        assert_eq!(prism.height_m, world.obstacles()[i].height_m);
    }
    for (j, prism) in scene.prisms[obstacles..].iter().enumerate() {
        assert_eq!(prism.entity, Entity::Target(TargetId(j as u16)));
    }
}

#[test]
fn commands_steer_and_wrong_ones_change_nothing() {
    let mut world = World::new(&WorldConfig::default(), 1).unwrap();
    assert!(world.command(AgentId(1), Command::Yaw { yaw_rad: 1.0 }).is_ok());
    assert!(world.command(AgentId(2), Command::Yaw { yaw_rad: f64::NAN }).is_err());
    let error = world.command(AgentId(4), Command::Yaw { yaw_rad: 1.0 }).unwrap_err();
    assert_eq!((error.agent, error.count), (AgentId(4), 4));
    for _ in 0..20 {
        world.advance();
    }
    let yaws: Vec<f64> = world.poses().iter().map(|p| p.yaw_rad).collect();
    assert!((yaws[1] - 1.0).abs() < 1e-3);
    assert_eq!([yaws[0], yaws[2], yaws[3]], [0.0; 3]);
    assert_eq!(world.step(), Step(20));
    let altitudes: Vec<f64> = world.poses().iter().map(|p| p.p_world[2]).collect();
    assert_eq!(altitudes, [52.0, 55.0, 58.0, 61.0]);
}

#[test]
fn every_mistake_is_reported_at_once() {
    let mut config = WorldConfig { period_s: 0.0, ..WorldConfig::default() };
    config.map.built_share = -1.0;
    config.targets.v_max_m_s = f64::NAN;
    config.targets.radius_m = 2.0;
    config.fleet.yaw_settling_s = -1.0;
    let errors = World::new(&config, 1).unwrap_err();
    let text = errors.to_string();
    let keys = [
        "targets.v_max_m_s",
        "run.period_s",
        "agents.yaw_settling_s",
        "targets.radius_m",
        "map.built_share",
    ];
    assert_eq!(text.lines().count(), keys.len(), "{text}");
    assert!(keys.iter().zip(text.lines()).all(|(key, line)| line.starts_with(key)), "{text}");
}

#[test]
fn a_town_from_elsewhere_makes_the_same_world() {
    let config = WorldConfig::default();
    let usual = World::new(&config, 3).unwrap();
    let given = World::from_map(&config, usual.map().clone(), 3).unwrap();
    assert_eq!((given.map(), given.targets()), (usual.map(), usual.targets()));
    let wrong = WorldConfig { period_s: 0.0, ..config };
    let errors = World::from_map(&wrong, usual.map().clone(), 3).unwrap_err();
    assert_eq!(errors.errors.len(), 1, "{errors}");
}

#[test]
fn the_mistakes_of_a_text_and_of_the_rest_are_reported_at_once() {
    let mut config = WorldConfig { period_s: 0.0, ..WorldConfig::default() };
    config.map.kind = map::MapKind::GeoJson;
    config.map.file = Some("named, not read".into());
    let errors = World::from_geojson(&config, "[", 1).unwrap_err();
    let all = &errors.errors[..];
    assert!(
        matches!(all, [WorldError::Config { .. }, WorldError::Map(MapError::NotJson { .. })]),
        "{errors}"
    );
}

#[test]
fn no_room_is_an_error_that_says_what_to_change() {
    let mut config = WorldConfig::default();
    config.map.size_m = [60.0, 60.0];
    config.targets.count = 500;
    let errors = World::new(&config, 1).unwrap_err();
    assert!(matches!(errors.errors[..], [WorldError::Placement(_)]), "{errors}");
}

/// Off: all buildings are below the flights. On: they have the heights of the map, except at the
/// launch site.
#[test]
fn buildings_are_as_high_as_they_are_where_uavs_fly_around_them() {
    let heights =
        |world: &World| -> Vec<f64> { world.obstacles().iter().map(|o| o.height_m).collect() };
    let mut config = WorldConfig::default();
    config.map.max_height_m = 120.0;
    config.map.min_height_m = 60.0;
    let low = World::new(&config, 2).unwrap();
    assert!(heights(&low).iter().all(|h| *h <= 50.0));
    config.fleet.avoid_buildings = true;
    let high = World::new(&config, 2).unwrap();
    let launch_m = config.fleet.launch_radius_m();
    assert_eq!(launch_m, 50.0);
    let start = [-260.0, 0.0];
    let mut lowered = 0;
    for (index, obstacle) in high.obstacles().iter().enumerate() {
        let walls = Walls::new(std::slice::from_ref(obstacle));
        let is_near = walls.nearest_within(start, launch_m).is_some();
        lowered += usize::from(is_near);
        assert_eq!(obstacle.height_m >= 60.0, !is_near, "{index}");
        assert!(!is_near || obstacle.height_m == 50.0);
    }
    let told = |w: &&MapWarning| matches!(w, MapWarning::LaunchSite { max_m: 50.0, .. });
    assert_eq!(high.warnings().iter().filter(told).count(), lowered);
    config.map.size_m = [150.0; 2];
    config.map.built_share = 0.2;
    let narrow = World::new(&config, 4).unwrap();
    assert!(narrow.warnings().iter().any(|w| told(&w)), "{:?}", narrow.warnings());
    config.map.max_height_m = 1001.0;
    config.fleet.altitude_m = 3.0;
    let error = World::new(&config, 2).unwrap_err().to_string();
    assert!(error.contains("max_height_m <= 1000 m"), "{error}");
    assert!(error.contains("more than 3 m for the lowest UAV"), "{error}");
}
