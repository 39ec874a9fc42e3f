use std::f64::consts::FRAC_PI_2;

use geo::polygon;
use proptest::prelude::*;

use super::*;

const GROUND: Ground = Ground { size_m: [200.0, 100.0] };

/// Rows of (target, time, x, y), one to a line after a header.
fn rows(rows: &[(u16, f64, f64, f64)]) -> Vec<Row> {
    let row = |(line, &(target, time_s, x, y))| {
        (TargetId(target), Waypoint { line, time_s, location: [x, y] })
    };
    (2..).zip(rows).map(row).collect()
}

fn tracks(given: &[(u16, f64, f64, f64)]) -> Tracks {
    Tracks::new(&rows(given)).unwrap()
}

fn wall() -> Obstacle {
    Obstacle {
        footprint: polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)],
        height_m: 6.0,
        name: "way/7".into(),
    }
}

/// The faults among a wall from (0, 0) to (10, 10), each with its line.
fn faults(given: &[(u16, f64, f64, f64)]) -> Vec<(usize, TrackFault)> {
    let errors = tracks(given).faults(&TargetsModel::default(), &GROUND, &[wall()]);
    errors.into_iter().map(|error| (error.line, error.fault)).collect()
}

#[test]
fn rows_that_make_no_tracks_are_all_named() {
    let given = [
        (0, 0.0, 1.0, 1.0),
        (0, 0.0, 2.0, 1.0),
        (0, f64::NAN, 2.0, 1.0),
        (2, -1.0, 2.0, 1.0),
        (2, 1.0, f64::INFINITY, 1.0),
    ];
    let errors = Tracks::new(&rows(&given)).unwrap_err();
    let lines: Vec<usize> = errors.iter().map(|error| error.line).collect();
    assert_eq!(lines, [3, 4, 5, 6, 6], "{errors:?}");
    assert_eq!(
        errors[0].to_string(),
        "line 3: car 0 is here at 0 s, after a row at 0 s, expected the rows of a car by increasing \
         time"
    );
    assert!(errors[4].to_string().contains("a car 2, and none with the number 1"), "{}", errors[4]);
    assert_eq!(Tracks::new(&[]).unwrap().count(), 0);
}

#[test]
fn tracks_that_keep_to_the_model_have_no_faults() {
    // At exactly v_max = 1 m/s; round the wall with 3 m to spare; 13 m behind each other.
    let both = [
        (0, 0.0, -13.0, -3.0),
        (0, 26.0, 13.0, -3.0),
        (0, 42.0, 13.0, 13.0),
        (1, 0.0, -26.0, -3.0),
        (1, 26.0, 0.0, -3.0),
        (1, 39.0, 13.0, -3.0),
        (1, 46.0, 13.0, 4.0),
    ];
    assert_eq!(faults(&both), []);
    assert_eq!(faults(&[(0, 5.0, -50.0, 20.0)]), [], "a parked car");
}

#[test]
fn speeds_and_the_region_are_judged_by_row() {
    let fast = faults(&[(0, 0.0, -50.0, 0.0), (0, 10.0, -39.0, 0.0), (0, 20.0, -30.0, 0.0)]);
    let speed = TrackFault::Speed { target: TargetId(0), speed_m_s: 1.1, limit_m_s: 1.0 };
    assert_eq!(fast, [(3, speed)]);
    // Half of 200 m, less the radius of 2.5 m.
    let limit_m = [97.5, 47.5];
    let outside = faults(&[(0, 0.0, -50.0, 47.0), (0, 9.0, -50.0, 48.0), (0, 18.0, -50.0, 47.5)]);
    let fault = TrackFault::Outside { target: TargetId(0), location: [-50.0, 48.0], limit_m };
    assert_eq!(outside, [(3, fault)]);
}

#[test]
fn walls_are_kept_clear_of_between_the_rows_too() {
    // Both ends are 20 m away; the way leads through, by, or just not by the wall.
    for (y, nearest_m) in [(5.0, Some(0.0)), (12.0, Some(2.0)), (12.5, Some(2.5)), (12.6, None)] {
        let found = faults(&[(0, 0.0, -20.0, y), (0, 60.0, 30.0, y)]);
        let fault = |distance_m| TrackFault::Obstacle {
            target: TargetId(0),
            name: "way/7".into(),
            distance_m,
            limit_m: 2.5,
        };
        let expected: Vec<_> = nearest_m.into_iter().map(|d| (3, fault(d))).collect();
        assert_eq!(found, expected, "y = {y}");
    }
    let parked_inside = faults(&[(0, 0.0, 5.0, 5.0)]);
    assert!(matches!(parked_inside[..], [(2, TrackFault::Obstacle { distance_m: 0.0, .. })]));
}

#[test]
fn cars_that_meet_between_their_rows_are_too_near() {
    // They pass each other on parallel lines 6 m apart, at 50 s; then on lines 8.5 m apart.
    let given = |apart: f64| {
        [
            (0, 0.0, -60.0, 20.0),
            (1, 0.0, 40.0, 20.0 + apart),
            (0, 100.0, 40.0, 20.0),
            (1, 100.0, -60.0, 20.0 + apart),
        ]
    };
    let [(line, TrackFault::Separation { target, other, time_s, distance_m, limit_m })] =
        &faults(&given(6.0))[..]
    else {
        panic!("{:?}", faults(&given(6.0)))
    };
    assert_eq!((*line, *target, *other), (5, TargetId(1), TargetId(0)));
    assert!((time_s - 50.0).abs() < 1e-9 && (distance_m - 6.0).abs() < 1e-9);
    assert_eq!(*limit_m, 8.0);
    assert_eq!(faults(&given(8.5)), []);
    // One has arrived and stands; the other drives up to it later.
    let late = [(0, 0.0, -50.0, 20.0), (1, 0.0, -20.0, 20.0), (0, 60.0, -25.0, 20.0)];
    assert!(
        matches!(faults(&late)[..], [(4, TrackFault::Separation { .. })]),
        "{:?}",
        faults(&late)
    );
}

#[test]
fn cars_stand_still_before_and_after_their_tracks() {
    let mut cars =
        Scripted::new(tracks(&[(0, 2.0, 0.0, 40.0), (0, 4.0, 0.0, 38.0), (1, 9.0, 50.0, 0.0)]));
    // Towards the south from the beginning.
    assert_eq!(cars.truths()[0].heading_rad, -FRAC_PI_2);
    let mut seen = Vec::new();
    for k in 1..=12 {
        cars.advance_to(f64::from(k) * 0.5, 0.5);
        seen.push((cars.truths()[0].location[1], cars.truths()[0].speed_m_s));
        assert_eq!(cars.truths()[1].location, [50.0, 0.0]);
    }
    let expected = [40.0, 40.0, 40.0, 40.0, 39.5, 39.0, 38.5, 38.0, 38.0, 38.0, 38.0, 38.0];
    assert_eq!(seen.iter().map(|s| s.0).collect::<Vec<_>>(), expected);
    assert_eq!(seen.iter().filter(|s| s.1 == 1.0).count(), 4);
}

#[test]
fn bodies_turn_no_faster_than_others() {
    let corner = [(0, 0.0, 0.0, 20.0), (0, 10.0, 10.0, 20.0), (0, 20.0, 10.0, 30.0)];
    let mut cars = Scripted::new(tracks(&corner));
    let mut before = cars.truths()[0].heading_rad;
    for k in 1..=40 {
        cars.advance_to(f64::from(k) * 0.5, 0.5);
        let now = cars.truths()[0].heading_rad;
        assert!((now - before).abs() <= 0.5 + 1e-12);
        before = now;
    }
    assert!((before - FRAC_PI_2).abs() < 1e-9);
}

proptest! {
    /// Whatever tracks have no faults keep to the model at every step; a monitor agrees.
    #[test]
    fn what_has_no_faults_has_no_violations(
        steps in prop::collection::vec((0..3u16, 0.5..9.0f64, -1.5..1.5f64, -1.5..1.5f64), 3..24),
        starts in prop::collection::vec((-60.0..60.0f64, -30.0..30.0f64), 3),
    ) {
        let mut given: Vec<(u16, f64, f64, f64)> =
            (0..).zip(&starts).map(|(i, s)| (i, 0.0, s.0, s.1)).collect();
        for (target, taken_s, vx, vy) in steps {
            let last = *given.iter().rfind(|row| row.0 == target).unwrap();
            given.push((target, last.1 + taken_s, last.2 + vx * taken_s, last.3 + vy * taken_s));
        }
        let model = TargetsModel::default();
        let tracks = tracks(&given);
        let is_right = tracks.faults(&model, &GROUND, &[wall()]).is_empty();
        let mut cars = Scripted::new(tracks);
        let period_s = 0.25;
        let mut monitor = crate::truth::Monitor::new(GROUND, model, period_s, &[wall()]);
        let mut violations = monitor.check(csat_proto::time::Step(0), cars.truths()).len();
        for k in 1..=240u32 {
            cars.advance_to(f64::from(k) * period_s, period_s);
            violations += monitor.check(csat_proto::time::Step(k), cars.truths()).len();
        }
        prop_assert!(!is_right || violations == 0, "{violations}");
    }
}
