use csat_proto::region::grid_point;
use geo::{Contains, Coord, LineString, MultiPolygon, Point, Polygon, Validation};

use super::*;
use crate::scenario::{Request, load};
use crate::set_membership::SetMembership;
use csat_mission::engine::Engine;

const GROUND: Ground = Ground { size_m: [100.0, 100.0] };

/// For checks by another library.
fn foreign(shapes: &Shapes) -> MultiPolygon {
    let line =
        |ring: &Ring| LineString::from_iter(ring.iter().map(|[x, y]| Coord { x: *x, y: *y }));
    let polygon = |shape: &Vec<Ring>| {
        let holes = shape[1..].iter().map(line).collect();
        Polygon::new(line(&shape[0]), holes)
    };
    MultiPolygon(shapes.iter().map(polygon).collect())
}

#[track_caller]
fn assert_valid(shapes: &Shapes) {
    if let Err(error) = foreign(shapes).check_validation() {
        panic!("{error}\n{shapes:?}");
    }
}

fn region(rings: &[&[[f64; 2]]]) -> Region {
    let ring = |ring: &&[[f64; 2]]| ring.iter().map(|p| grid_point(*p)).collect();
    Region::from_shapes(vec![rings.iter().map(ring).collect()])
}

/// What is shown, as a set of the estimator's.
fn shown(shapes: &Shapes) -> Region {
    let ring = |ring: &Ring| ring.iter().map(|p| grid_point(*p)).collect();
    Region::from_shapes(shapes.iter().map(|s| s.iter().map(ring).collect()).collect())
}

/// Whether `inside` lies in `outside`, both taken as they are.
fn is_within(inside: &Region, outside: &Region) -> bool {
    let outside = Inner::within(outside.clone());
    Outer::containing(inside.clone()).minus([&outside]).is_empty()
}

/// The sides of the spike come closer to each other than a millimetre, those of the slit, too.
fn spiky() -> Region {
    region(&[
        &[
            [0.0, 0.0],
            [10.0, 0.0],
            [10.0, 4.9997],
            [20.0, 5.0001],
            [10.0, 5.0003],
            [10.0, 10.0],
            [0.0, 10.0],
        ],
        &[[2.0, 2.0], [2.0, 5.0004], [8.0, 5.0001], [2.0, 5.0001], [2.0003, 8.0], [8.0, 8.0]],
    ])
}

#[test]
fn nearest_millimetres() {
    let shapes = shapes(&Region::rectangle([4.0, 2.0004]));
    assert_eq!(shapes, [[[[-2.0, 1.0], [-2.0, -1.0], [2.0, -1.0], [2.0, 1.0]]]]);
}

#[test]
fn what_rounding_breaks_is_mended() {
    let spiky = spiky();
    let naive: Shapes = spiky
        .shapes()
        .iter()
        .map(|s| s.iter().map(|r| r.iter().map(|p| metres(*p)).collect()).collect())
        .map(|s: Vec<Ring>| {
            s.iter()
                .map(|r| r.iter().map(|p| p.map(csat_mission::picture::to_millimetre)).collect())
                .collect()
        })
        .collect();
    assert!(!foreign(&naive).is_valid(), "rounding alone must break it, or nothing is tested");
    for shapes in [shapes(&spiky), outer(&spiky, &GROUND), inner(&spiky)] {
        assert_valid(&shapes);
        assert!((shown(&shapes).area_m2() - spiky.area_m2()).abs() < 0.5, "{shapes:?}");
    }
}

#[test]
fn outer_stays_outer_and_inner_stays_inner() {
    let spiky = spiky();
    assert!(is_within(&spiky, &shown(&outer(&spiky, &GROUND))));
    assert!(is_within(&shown(&inner(&spiky)), &spiky));
    assert!(!is_within(&spiky, &shown(&shapes(&spiky))), "without the margin it does not hold");
    // The ground is not outgrown, and not cut short where it is no whole number of millimetres.
    let ground = Ground { size_m: [100.000_3, 100.0] };
    let all = Region::rectangle(ground.size_m);
    let [ring] = &outer(&all, &ground)[0][..] else { panic!("one ring") };
    let farthest = |i: usize| ring.iter().map(|p| p[i]).fold(0.0, f64::max);
    assert_eq!([farthest(0), farthest(1)], [50.001, 50.0]);
    assert!(outer(&Region::EMPTY, &GROUND).is_empty() && inner(&Region::EMPTY).is_empty());
}

/// Polygons that touch in points stay apart, and a ring that touches itself becomes two.
#[test]
fn touching_rings_are_taken_apart() {
    let two = region(&[&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]]]);
    let shapes = shapes(&two);
    assert_eq!(shapes.len(), 2, "{shapes:?}");
    assert_valid(&shapes);
    let hole = [vec![[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]], vec![[1.0, 1.0], [1.0, 2.0], [7.0, 2.0]]];
    let shapes = polygons(&[hole.to_vec()], PER_METRE);
    assert_valid(&shapes);
    assert!(!foreign(&shapes).contains(&Point::new(1.5, 1.8)), "{shapes:?}");
}

/// Every set that a mission shows, whichever way cars drive.
#[test]
fn sets_of_missions_keep_what_they_promise() {
    for (v_max, seed) in [("1", 1), ("5", 1), ("5", 2)] {
        let sets = [format!("targets.v_max_m_s={v_max}"), "run.duration_s=30".to_owned()];
        let request = Request { sets: &sets, seed: Some(seed), ..Request::default() };
        let loaded = load(request).unwrap();
        let ground = loaded.scenario.ground();
        let mission = SetMembership::new(&loaded.scenario);
        let mut engine = Engine::new(mission, loaded.world, &loaded.scenario.netem, seed);
        for step in 0..=loaded.scenario.run.duration_s as usize * 2 {
            let trace = engine.step();
            // With perfect links the other agents know the same.
            let report = trace.flown[0].report.as_ref().unwrap();
            let outer_sets = report.targets.iter().map(|(_, set)| set).chain([&report.unexplored]);
            for set in outer_sets {
                let shapes = outer(set, &ground);
                assert_valid(&shapes);
                assert!(is_within(set, &shown(&shapes)), "outer, v_max {v_max}, step {step}");
            }
            let shapes = inner(&report.obstacle_margin);
            assert_valid(&shapes);
            assert!(is_within(&shown(&shapes), &report.obstacle_margin), "inner, step {step}");
        }
    }
}
