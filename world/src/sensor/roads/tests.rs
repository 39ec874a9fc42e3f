use csat_proto::camera::Assumption;
use csat_proto::ids::AgentId;
use csat_proto::model::Ground;
use csat_proto::time::Step;
use nalgebra::Vector3;
use proptest::prelude::*;

use super::*;
use crate::map::Map;
use crate::road_area::CELL_M;
use crate::scene::Scene;
use crate::sensor::{Sensor, SensorModel, Sight};

fn camera() -> CameraModel {
    CameraModel {
        columns: 256,
        rows: 256,
        aperture_deg: 80.0,
        tilt_deg: 90.0,
        d_max_m: 1000.0,
        depth_noise: [0.0, 0.0],
        min_pixels: 1,
        box_error_px: 0,
        assumption: Assumption::EveryRay,
        misidentify: 0.0,
    }
}

/// A pose as a multirotor has it.
fn pose([x, y]: [f64; 2]) -> Pose {
    Pose::level([x, y, 70.0], -std::f64::consts::FRAC_PI_2)
}

fn area(roads: &[[[f64; 2]; 2]]) -> RoadArea {
    let roads = roads.iter().map(|road| road.to_vec()).collect();
    RoadArea::new(&Map { roads, ..Map::open(Ground { size_m: [200.0, 160.0] }) }, CELL_M)
}

fn crossing() -> RoadArea {
    area(&[[[-120.0, -20.0], [120.0, 35.0]], [[10.0, -120.0], [10.0, 120.0]]])
}

fn stream(step: u32) -> Stream {
    Stream { seed: 7, agent: AgentId(2), step: Step(step) }
}

#[test]
fn pixels_are_where_the_pinhole_camera_has_them() {
    let (roads, pose) = (crossing(), pose([40.3, 30.1]));
    let view = camera().at(&pose);
    let labels = labels(&camera(), &RoadSensor::EXACT, &pose, Some(&roads), stream(0));
    let mut seen = [0; 2];
    for (index, label) in labels.iter().enumerate() {
        let (row, column) = (index / 256, index % 256);
        let [x, y] = view.ground_point(column as f64 + 0.5, row as f64 + 0.5).unwrap();
        let is_road = roads.is_road([x, y]);
        // A point between two cells belongs to either.
        let is_between = [x, y].iter().any(|x| ((x / CELL_M) - (x / CELL_M).round()).abs() < 1e-6);
        assert!(is_between || is_road == (*label == Label::Road), "{x} {y} {label:?}");
        assert!(matches!(label, Label::Road | Label::Ground));
        seen[usize::from(is_road)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 1000), "{seen:?}");
    // A point in the north-west of the image.
    let [c, r] = view.project(&Vector3::new(40.3 - 50.0, 30.1 + 40.0, 0.0)).unwrap();
    assert!(c < 30.0 && r < 50.0, "{c} {r}");
}

/// E and the labelled pixels of a frame.
fn seen(sensor: &RoadSensor, roads: &RoadArea, at: [f64; 2], step: u32) -> [Bits; 2] {
    let exact = exact(&camera(), &pose(at), roads);
    let mut got = Bits::empty(256, 256);
    let labels = labels(&camera(), sensor, &pose(at), Some(roads), stream(step));
    for (index, _) in labels.iter().enumerate().filter(|(_, label)| **label == Label::Road) {
        got.insert(index % 256, index / 256);
    }
    [exact, got]
}

fn point() -> impl Strategy<Value = [f64; 2]> {
    [-110.0..110.0f64, -90.0..90.0f64]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn every_road_pixel_has_a_labelled_one_nearby(
        ends in prop::collection::vec((point(), point()), 1..5), at in point(), step: u32,
        gap_px in 0..4u16, shares in [0.0..=1.0f64, 0.0..=1.0f64, 0.0..=0.01f64],
    ) {
        let roads = area(&ends.iter().map(|(a, b)| [*a, *b]).collect::<Vec<_>>());
        let [gap_share, edge_share, speckle_share] = shares;
        let sensor = RoadSensor { gap_px, gap_share, edge_share, speckle_share };
        let [exact, got] = seen(&sensor, &roads, at, step);
        let near = got.dilated(usize::from(gap_px));
        prop_assert_eq!(exact.without(&near).count(), 0);
    }
}

/// A share of the kind of error that a sensor makes, within four standard deviations.
fn rate(wrong: &Bits, of: &Bits, expected: f64) -> bool {
    let (n, wrong) = (of.count() as f64, wrong.count_common(of) as f64);
    (wrong / n - expected).abs() < 4.0 * (expected * (1.0 - expected) / n).sqrt()
}

#[test]
fn each_kind_of_error_comes_at_its_rate() {
    let roads = crossing();
    let none = RoadSensor { gap_px: 1, ..RoadSensor::EXACT };
    let [exact, got] = seen(&none, &roads, [0.0; 2], 1);
    assert_eq!(exact, got);
    let everything = Bits::full(256, 256);

    let speckle = RoadSensor { speckle_share: 0.01, ..none };
    let [_, got] = seen(&speckle, &roads, [0.0; 2], 1);
    let off_road = everything.without(&exact);
    assert_eq!(exact.clone().without(&got).count(), 0);
    assert!(rate(&got, &off_road, 0.01));

    let ragged = RoadSensor { edge_share: 0.2, ..none };
    let [_, got] = seen(&ragged, &roads, [0.0; 2], 1);
    let outside = exact.dilated(1).without(&exact);
    let missed = exact.clone().without(&got);
    assert!(rate(&got, &outside, 0.2));
    assert_eq!(got.without(&exact.dilated(1)).count(), 0);
    let inside = exact.clone().without(&exact.eroded());
    assert_eq!(missed.clone().without(&inside).count(), 0);
    // Nearly all that are drawn are lost: their neighbours inwards are there.
    assert!(missed.count() as f64 > 0.15 * inside.count() as f64, "{}", missed.count());

    let holes = RoadSensor { gap_share: 0.04, ..none };
    let [_, got] = seen(&holes, &roads, [0.0; 2], 1);
    assert_eq!(got.clone().without(&exact).count(), 0);
    let share = exact.clone().without(&got).count() as f64 / exact.count() as f64;
    assert!((0.025..0.04).contains(&share), "{share}");
}

#[test]
fn frames_are_functions_of_seed_agent_and_step() {
    let (roads, sensor) = (crossing(), RoadSensor::default());
    let at = |stream| labels(&camera(), &sensor, &pose([0.0; 2]), Some(&roads), stream);
    assert_eq!(at(stream(1)), at(stream(1)));
    let others =
        [stream(2), Stream { seed: 8, ..stream(1) }, Stream { agent: AgentId(3), ..stream(1) }];
    assert!(others.into_iter().all(|other| at(other) != at(stream(1))));
}

#[test]
fn roads_end_at_the_border_and_nothing_is_seen_without_an_area() {
    let (roads, at) = (crossing(), [99.0, 79.0]);
    let [exact, _] = seen(&RoadSensor::EXACT, &roads, at, 0);
    let half = exact.cells().filter(|[column, row]| *column < 130 && *row > 125).count();
    assert_eq!((exact.count(), half > 500), (half, true));
    let labels = labels(&camera(), &RoadSensor::EXACT, &pose(at), None, stream(0));
    assert!(labels.len() == 65536 && labels.iter().all(|label| *label == Label::Ground));
}

#[test]
fn a_frame_has_labels_and_nothing_else() {
    let (roads, scene) = (crossing(), Scene::default());
    let mut sensor = Sensor::new(SensorModel::Roads(camera(), RoadSensor::default()));
    let sight = Sight { step: Step(2), seed: 7, scene: &scene, targets: &[], roads: Some(&roads) };
    let reported = Pose { p_world: [1.0, 2.0, 70.0], ..pose([0.0; 2]) };
    let frame = sensor.frame(&sight, AgentId(2), &pose([0.0; 2]), &reported.into());
    let expected =
        labels(&camera(), &RoadSensor::default(), &pose([0.0; 2]), Some(&roads), stream(2));
    assert_eq!((frame.pose, frame.labels), (reported, expected));
    assert!(frame.depth.is_empty() && frame.detections.is_empty() && frame.sighting.is_none());
}

#[test]
fn impossible_values_are_named() {
    let keys = |camera: CameraModel, sensor: RoadSensor, heights_m| {
        let all = mistakes(&camera, &sensor, heights_m, CELL_M);
        all.into_iter().map(|(key, ..)| key).collect::<Vec<_>>()
    };
    let (good, heights_m) = (RoadSensor::default(), [70.0, 72.0]);
    assert!(keys(camera(), good, heights_m).is_empty());
    assert_eq!(keys(camera(), good, [70.0, 80.0]), ["agents.altitude_m"]);
    let wrong = CameraModel { tilt_deg: 30.0, rows: 200, ..camera() };
    assert_eq!(keys(wrong, good, heights_m), ["camera.tilt_deg", "camera.rows"]);
    let wrong = RoadSensor { gap_px: 0, gap_share: 0.5, edge_share: -0.1, speckle_share: f64::NAN };
    let expected = ["segmentation.edge_share", "segmentation.speckle_share", "segmentation.gap_px"];
    assert_eq!(keys(camera(), wrong, heights_m), expected);
    let wrong = RoadSensor { gap_px: 65, ..good };
    assert_eq!(keys(camera(), wrong, heights_m), ["segmentation.gap_px"]);
    assert!(serde_json::from_str::<RoadSensor>(r#"{"gaps": 1}"#).is_err());
    let read: RoadSensor = serde_json::from_str(r#"{"gap_px": 2}"#).unwrap();
    assert_eq!(read, RoadSensor { gap_px: 2, ..good });
}
