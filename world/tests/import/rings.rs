//! Rings as people and programs draw them.

use csat_world::map::{LeftOut, MapWarning};
use serde_json::json;

use super::{SQUARE, area_m2, building, feature, left_out, positions, with_road};

#[test]
fn a_clean_map_has_no_warnings() {
    let map = with_road(vec![building(&[&SQUARE])]);
    assert_eq!(map.warnings, []);
    assert!((area_m2(&map) - 100.0).abs() < 0.01, "{}", area_m2(&map));
    assert_eq!(map.obstacles[0].name, "way/7");
    assert_eq!(map.roads.len(), 1);
    assert_eq!((map.count.features, map.count.buildings, map.count.roads), (2, 1, 1));
    assert_eq!(map.count.left_out(), 0);
}

#[test]
fn open_rings_are_closed_and_repeats_dropped() {
    let map = with_road(vec![building(&[&SQUARE[..4]])]);
    assert!(
        matches!(&map.warnings[..], [MapWarning::RingClosed { ring, .. }] if ring == "outer ring")
    );
    assert!((area_m2(&map) - 100.0).abs() < 0.01);
    let mut repeated = SQUARE.to_vec();
    repeated.splice(1..1, [SQUARE[0], SQUARE[0]]);
    let map = with_road(vec![building(&[&repeated])]);
    assert!(matches!(map.warnings[..], [MapWarning::RepeatedPositions { count: 2, .. }]));
    assert!((area_m2(&map) - 100.0).abs() < 0.01);
}

#[test]
fn crossing_rings_are_rebuilt() {
    let tie = [[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0], [0.0, 0.0]];
    let map = with_road(vec![building(&[&tie])]);
    assert!(matches!(map.warnings[..], [MapWarning::SelfCrossing { parts: 2, .. }]));
    assert!((area_m2(&map) - 50.0).abs() < 0.01);
    assert_eq!(map.obstacles.len(), 2);
}

#[test]
fn rings_of_nothing_are_left_out() {
    let map = with_road(vec![building(&[&SQUARE[..2]])]);
    assert!(matches!(
        map.warnings[..],
        [MapWarning::ShortRing { got: 2, .. }, MapWarning::NoBuildings]
    ));
    assert_eq!(left_out(&map), [(LeftOut::NoArea, 1)]);
    let line = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [0.0, 0.0]];
    let map = with_road(vec![building(&[&line])]);
    assert!(matches!(map.warnings[..], [MapWarning::ZeroArea { .. }, MapWarning::NoBuildings]));
    // A hole without area leaves the building whole.
    let map = with_road(vec![building(&[&SQUARE, &line])]);
    assert!(matches!(&map.warnings[..], [MapWarning::ZeroArea { ring, .. }] if ring == "hole 1"));
    assert!((area_m2(&map) - 100.0).abs() < 0.01);
}

#[test]
fn holes_are_courtyards_and_stray_ones_are_trimmed() {
    let hole = |x: f64| [[x, 4.0], [x, 6.0], [x + 2.0, 6.0], [x + 2.0, 4.0], [x, 4.0]];
    let map = with_road(vec![building(&[&SQUARE, &hole(4.0)])]);
    assert_eq!(map.warnings, []);
    assert_eq!(map.obstacles[0].footprint.interiors().len(), 1);
    let map = with_road(vec![building(&[&SQUARE, &hole(9.0)])]);
    assert!(matches!(map.warnings[..], [MapWarning::HoleOutside { .. }]));
    assert!((area_m2(&map) - 98.0).abs() < 0.01);
}

#[test]
fn sheds_are_kept() {
    let shed = [[0.0, 0.0], [1.5, 0.0], [1.5, 1.5], [0.0, 1.5], [0.0, 0.0]];
    let map = with_road(vec![building(&[&shed])]);
    assert!((area_m2(&map) - 2.25).abs() < 1e-3);
    assert_eq!(map.warnings, []);
}

#[test]
fn multipolygons_are_one_feature() {
    let far: Vec<[f64; 2]> = SQUARE.iter().map(|p| [p[0] + 20.0, p[1]]).collect();
    let near: Vec<[f64; 2]> = SQUARE.iter().map(|p| [p[0] + 5.0, p[1]]).collect();
    let rings = [&SQUARE[..], &far, &near].map(|ring| json!([positions(ring)]));
    let geometry = json!({ "type": "MultiPolygon", "coordinates": rings });
    let map = with_road(vec![feature(json!({ "building": true }), geometry)]);
    assert_eq!(map.obstacles.len(), 2);
    assert!((area_m2(&map) - 250.0).abs() < 0.03);
}
