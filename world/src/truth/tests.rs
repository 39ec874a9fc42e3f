use super::*;
use geo::polygon;

fn monitor() -> Monitor {
    let wall = Obstacle {
        footprint: polygon![
            (x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)
        ],
        height_m: 9.0,
        name: String::new(),
    };
    Monitor::new(Ground { size_m: [100.0; 2] }, TargetsModel::default(), 0.5, &[wall])
}

fn at(id: u16, x: f64, y: f64) -> TargetTruth {
    TargetTruth { id: TargetId(id), location: [x, y], heading_rad: 0.0, speed_m_s: 0.5 }
}

fn faults(monitor: &mut Monitor, step: u32, targets: &[TargetTruth]) -> Vec<Fault> {
    monitor.check(Step(step), targets).into_iter().map(|v| v.fault).collect()
}

#[test]
fn what_is_right_is_silent() {
    let mut monitor = monitor();
    for step in 0..3 {
        let x = -20.0 + 0.5 * f64::from(step);
        let targets = [at(0, x, -2.6), at(1, 40.0, 40.0)];
        assert_eq!(monitor.check(Step(step), &targets), []);
    }
    assert_eq!(monitor.counts().total().violations, 0);
}

#[test]
fn separations_are_strict() {
    let mut monitor = monitor();
    assert_eq!(faults(&mut monitor, 0, &[at(0, -2.500_001, 5.0)]), []);
    let exact = faults(&mut monitor, 9, &[at(0, -2.5, 5.0)]);
    assert!(matches!(exact[..], [Fault::ObstacleDistance { obstacle: 0, distance_m: 2.5, .. }]));
    let pair = [at(0, -20.0, 0.0), at(1, -28.0, 0.0)];
    let exact = faults(&mut monitor, 99, &pair);
    assert!(matches!(exact[..], [Fault::TargetDistance { distance_m: 8.0, .. }]), "{exact:?}");
}

#[test]
fn speed_and_region_are_checked() {
    let mut monitor = monitor();
    assert_eq!(faults(&mut monitor, 3, &[at(0, -40.0, 0.0)]), []);
    assert_eq!(faults(&mut monitor, 5, &[at(0, -41.0, 0.0)]), []);
    let fast = faults(&mut monitor, 6, &[at(0, -41.51, 0.0)]);
    assert!(matches!(fast[..], [Fault::Speed { limit_m: 0.5, .. }]), "{fast:?}");
    let out = faults(&mut monitor, 60, &[at(0, -50.1, 0.0)]);
    assert!(matches!(out[..], [Fault::OutsideRegion { .. }]), "{out:?}");
}

#[test]
fn what_is_not_a_number_violates() {
    let mut monitor = monitor();
    faults(&mut monitor, 0, &[at(0, -40.0, 0.0), at(1, 40.0, 40.0)]);
    let nan = faults(&mut monitor, 1, &[at(0, f64::NAN, 0.0), at(1, 40.0, 40.0)]);
    assert_eq!(nan.len(), 3, "region, pair, speed: {nan:?}");
}

#[test]
fn messages_are_conserved() {
    let mut monitor = monitor();
    let counts = MessageCounts { sent: 10, duplicated: 2, delivered: 7, dropped: 4, in_flight: 1 };
    assert_eq!(monitor.check_messages(Step(0), counts), None);
    let leak = MessageCounts { in_flight: 0, ..counts };
    let violation = monitor.check_messages(Step(1), leak).unwrap();
    assert_eq!(violation.fault, Fault::MessageConservation { counts: leak });
    assert_eq!(
        monitor.counts().of(Promise::MessageConservation.key()),
        Checked { checks: 2, violations: 1 }
    );
    let json = serde_json::to_value(&violation).unwrap();
    assert_eq!(json["fault"]["kind"], "message-conservation");
    assert_eq!(json["fault"]["counts"]["sent"], 10);
}

/// Flights over a roof, beside it and through it, also between two checks.
#[test]
fn uavs_keep_their_clearance_from_buildings() {
    let at = |x: f64, y: f64, z: f64| Pose::level([x, y, z], 0.0);
    for (pose, distance_m) in [
        (at(5.0, 5.0, 11.0), None),
        (at(5.0, 5.0, 10.999), Some(0.0)),
        (at(12.0, 5.0, 3.0), None),
        (at(11.999, 5.0, 3.0), Some(1.999)),
        (at(11.999, 5.0, 11.1), None),
        (at(13.0, 11.5, 60.0), None),
    ] {
        let mut monitor = monitor();
        let found = monitor.check_flights(Step(4), &[at(-40.0, 0.0, 3.0), pose]);
        let faults: Vec<Fault> = found.into_iter().map(|violation| violation.fault).collect();
        match (distance_m, &faults[..]) {
            (None, []) => {}
            (
                Some(expected),
                [Fault::BuildingDistance { agent, obstacle, distance_m, limit_m }],
            ) => {
                assert_eq!((*agent, *obstacle, *limit_m), (AgentId(1), 0, 2.0));
                assert!((distance_m - expected).abs() < 1e-9, "{distance_m}");
            }
            other => panic!("{pose:?}: {other:?}"),
        }
        let counted = Checked { checks: 2, violations: faults.len() as u64 };
        assert_eq!(monitor.counts().of(Promise::BuildingDistance.key()), counted);
        assert_eq!(monitor.counts().total(), counted);
    }
    let mut monitor = monitor();
    assert_eq!(monitor.check_flights(Step(0), &[at(-10.0, 5.0, 3.0)]), []);
    let through = monitor.check_flights(Step(1), &[at(20.0, 5.0, 3.0)]);
    assert_eq!(through.len(), 1, "it flew through the block");
    assert_eq!(monitor.check_flights(Step(2), &[at(21.0, 5.0, 3.0)]), []);
}

#[test]
fn every_check_is_counted() {
    let mut monitor = monitor();
    let targets = [at(0, -20.0, 0.0), at(1, 30.0, 30.0), at(2, -30.0, -20.0)];
    for step in 0..4 {
        monitor.check(Step(step), &targets);
        monitor.check_messages(Step(step), MessageCounts::default());
    }
    let expected = [
        (Promise::ObstacleDistance, 4 * 3),
        (Promise::TargetDistance, 4 * 3),
        (Promise::OutsideRegion, 4 * 3),
        (Promise::Speed, 3 * 3),
        (Promise::MessageConservation, 4),
    ];
    for (promise, checks) in expected {
        assert_eq!(monitor.counts().of(promise.key()).checks, checks, "{promise:?}");
    }
    assert_eq!(monitor.counts().total(), Checked { checks: 49, violations: 0 });
}
