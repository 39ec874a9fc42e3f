use super::*;
use crate::obstacle::Walls;
use crate::road::RoadRules;
use csat_proto::model::Ground;
use proptest::prelude::*;

fn roads(lines: &[&[Point]]) -> RoadGraph {
    let lines: Vec<Vec<Point>> = lines.iter().map(|l| l.to_vec()).collect();
    let rules = RoadRules { inset_m: 3.0, clearance_m: 2.55, min_network_m: 10.0 };
    RoadGraph::build(&Ground { size_m: [200.0; 2] }, &lines, &Walls::default(), &rules)
}

fn model(count: u16) -> TargetsModel {
    TargetsModel { count, ..TargetsModel::default() }
}

#[test]
fn a_car_turns_round_at_a_dead_end_and_its_body_turns_slowly() {
    let roads = roads(&[&[[0.0, 0.0], [12.0, 0.0]]]);
    let mut traffic = Traffic::place(&roads, 1, &model(1), 1).unwrap();
    traffic.truths[0].speed_m_s = 1.0;
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut before = traffic.truths()[0];
    for _ in 0..100 {
        traffic.advance(&roads, 0.5);
        let now = traffic.truths()[0];
        (least, most) = (least.min(now.location[0]), most.max(now.location[0]));
        assert!((0.0..=12.0).contains(&now.location[0]) && now.location[1] == 0.0);
        assert!(distance_m(now.location, before.location) <= 0.5 + 1e-12);
        let turn = (now.heading_rad - before.heading_rad).abs();
        assert!(turn.min(TAU - turn) <= 0.5 + 1e-12);
        before = now;
    }
    // To the very end and back, both sides.
    assert!(least < 0.5 && most > 11.5, "{least} {most}");
}

#[test]
fn junctions_are_turned_at_but_not_back() {
    let roads = roads(&[&[[-90.0, 0.0], [90.0, 0.0]], &[[0.0, -90.0], [0.0, 90.0]]]);
    let mut ways = [0; 4];
    for seed in 0..40 {
        let mut traffic = Traffic::place(&roads, 2, &model(1), seed).unwrap();
        let node = roads.nodes().iter().position(|n| *n == [0.0, 0.0]).unwrap();
        let back = roads.arms(node)[1];
        traffic.cars[0].enter(&roads, node, back);
        let arm = traffic.cars[0].place.arm;
        assert_ne!(arm, back);
        ways[roads.arms(node).iter().position(|a| *a == arm).unwrap()] += 1;
    }
    assert_eq!(ways[1], 0);
    assert!([0, 2, 3].iter().all(|&w| ways[w] > 3), "{ways:?}");
}

#[test]
fn a_blocked_car_waits_then_turns_round() {
    let roads = roads(&[&[[-50.0, 0.0], [50.0, 0.0]]]);
    let mut traffic = Traffic::place(&roads, 1, &model(2), 1).unwrap();
    for (index, (along_m, speed)) in [(50.0, 1.0), (58.2, 0.0)].into_iter().enumerate() {
        traffic.cars[index].place = RoadPlace { arm: Arm { edge: 0, forward: true }, along_m };
        traffic.truths[index].location = traffic.cars[index].place.point(&roads);
        traffic.truths[index].speed_m_s = speed;
    }
    let patience = traffic.cars[0].patience;
    let start = traffic.truths()[0].location;
    for _ in 0..patience {
        traffic.advance(&roads, 0.5);
        assert_eq!(traffic.truths()[0].location, start);
    }
    traffic.advance(&roads, 0.5);
    assert!((distance_m(traffic.truths()[0].location, start) - 0.5).abs() < 1e-9);
    assert!(traffic.truths()[0].location[0] < start[0]);
}

#[test]
fn too_many_cars_are_counted() {
    let roads = roads(&[&[[0.0, 0.0], [40.0, 0.0]]]);
    let error = Traffic::place(&roads, 7, &model(20), 1).unwrap_err();
    assert!((3..=5).contains(&error.placed) && error.count == 20, "{error}");
    assert_eq!((error.road_m, error.roads_mapped), (40.0, 7));
    assert!(error.to_string().contains("targets.count"), "{error}");
    let error = Traffic::place(&RoadGraph::default(), 0, &model(1), 1).unwrap_err();
    assert_eq!((error.placed, error.road_m), (0, 0.0));
    assert!(Traffic::place(&RoadGraph::default(), 0, &model(0), 1).is_ok());
}

#[test]
fn bodies_are_counter_clockwise_boxes_about_the_location() {
    let truth = TargetTruth {
        id: TargetId(3),
        location: [10.0, 20.0],
        heading_rad: std::f64::consts::FRAC_PI_2,
        speed_m_s: 1.0,
    };
    let prism = truth.prism([4.6, 1.8, 1.5]);
    assert_eq!((prism.entity, prism.height_m), (Entity::Target(TargetId(3)), 1.5));
    let expected = [[10.9, 17.7], [10.9, 22.3], [9.1, 22.3], [9.1, 17.7]];
    for (got, expected) in prism.rings[0].iter().zip(expected) {
        assert!(distance_m(*got, expected) < 1e-12, "{got:?}");
    }
}

proptest! {
    #[test]
    fn headings_turn_the_short_way(from in -20.0..20.0f64, to in -20.0..20.0f64) {
        let close = |a: f64, b: f64| (a - b).cos() > 1.0 - 1e-9;
        prop_assert!(close(turned(from, to, 10.0), to));
        let partly = turned(from, to, 0.1);
        prop_assert!((partly - from).cos() >= 0.1f64.cos() - 1e-12);
        prop_assert!((partly - to).cos() >= (from - to).cos() - 1e-12);
    }

    /// On crowded roads too, cars keep their separation, their speed and the roads.
    #[test]
    fn crowds_keep_apart(seed: u64, count in 2..20u16) {
        let roads = roads(&[
            &[[-60.0, 0.0], [60.0, 0.0]],
            &[[0.0, -60.0], [0.0, 60.0]],
            &[[-30.0, -30.0], [30.0, -30.0], [30.0, 30.0], [-30.0, 30.0], [-30.0, -30.0]],
        ]);
        let mut traffic = Traffic::place(&roads, 3, &model(count), seed).unwrap();
        for _ in 0..200 {
            let before = traffic.truths().to_vec();
            traffic.advance(&roads, 0.5);
            for (i, now) in traffic.truths().iter().enumerate() {
                prop_assert!(distance_m(now.location, before[i].location) <= 0.5 + 1e-9);
                for other in &traffic.truths()[..i] {
                    prop_assert!(distance_m(now.location, other.location) > 8.0);
                }
            }
        }
    }
}
