//! Intersection, difference and union, against membership of points and areas.

use csat_agent::region::{Inner, Outer};
use csat_proto::region::{GridPoint, Region, Ring, metres};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use rand::RngExt;

use crate::oracle::{ROUNDING_M, around, assert_same, boundary_distance_m, overlay, perimeter_m};
use crate::shapes::{Rng, any_region, cases, region_at, resolved, solid, star};

/// Two regions, mostly overlapping, of similar or very different sizes.
fn any_pair(rng: &mut Rng) -> (Region, Region) {
    let a = any_region(rng);
    let Some(bounds) = a.bounds() else { return (a.clone(), a) };
    let (min, max) = (metres(bounds.min), metres(bounds.max));
    let size = (max[0] - min[0]).max(max[1] - min[1]).max(1e-3);
    let scale = (size * 10f64.powf(rng.random_range(-1.5..0.5))).min(500.0);
    let mut pick = |low: f64, high: f64| rng.random_range(low - size * 0.2..high + size * 0.2);
    let at = [pick(min[0], max[0]), pick(min[1], max[1])];
    let b = region_at(rng, at, scale);
    (a, b)
}

#[test]
fn operations_agree_with_membership_of_points() {
    cases("operations_agree_with_membership_of_points", 1500, |rng| {
        let (a, b) = any_pair(rng);
        let both = Outer::containing(a.clone()).intersection(&Outer::containing(b.clone()));
        let rest = Outer::containing(a.clone()).minus([&Inner::within(b.clone())]);
        let any = Inner::union([&Inner::within(a.clone()), &Inner::within(b.clone())]);
        let mut points = around(rng, &a, 60);
        points.extend(around(rng, &b, 60));
        for p in points {
            if boundary_distance_m(&a, p).min(boundary_distance_m(&b, p)) < 1e-4 {
                continue;
            }
            let (in_a, in_b) = (a.contains(p), b.contains(p));
            assert_eq!(both.region().contains(p), in_a && in_b, "∩ at {p:?}");
            assert_eq!(rest.region().contains(p), in_a && !in_b, "\\ at {p:?}");
            assert_eq!(any.region().contains(p), in_a || in_b, "∪ at {p:?}");
        }
    });
}

#[test]
fn areas_add_up() {
    cases("areas_add_up", 2000, |rng| {
        let (a, b) = any_pair(rng);
        let both = Outer::containing(a.clone()).intersection(&Outer::containing(b.clone()));
        let rest = Outer::containing(a.clone()).minus([&Inner::within(b.clone())]);
        let any = Inner::union([&Inner::within(a.clone()), &Inner::within(b.clone())]);
        let [both, rest, any] = [both.region(), rest.region(), any.region()].map(Region::area_m2);
        let allowed = ROUNDING_M * (perimeter_m(&a) + perimeter_m(&b)) + 1e-9;
        assert!((a.area_m2() - both - rest).abs() <= allowed);
        assert!((a.area_m2() + b.area_m2() - both - any).abs() <= allowed);
    });
}

#[test]
fn shortcuts_change_nothing() {
    cases("shortcuts_change_nothing", 1000, |rng| {
        let near = |rng: &mut Rng| {
            let at = [rng.random_range(-40.0..40.0), rng.random_range(-40.0..40.0)];
            let scale = rng.random_range(1.0..25.0);
            region_at(rng, at, scale)
        };
        let scattered = (0..rng.random_range(1..5))
            .fold(Region::EMPTY, |sum, _| overlay(&sum, &near(rng), OverlayRule::Union));
        let parts: Vec<Inner> =
            (0..rng.random_range(0..5)).map(|_| Inner::within(near(rng))).collect();
        let plain = parts.iter().fold(scattered.clone(), |left, part| {
            overlay(&left, part.region(), OverlayRule::Difference)
        });
        let whole = Outer::containing(scattered.clone());
        assert_same(whole.minus(&parts).region(), &plain);
        let sum = parts
            .iter()
            .fold(Region::EMPTY, |sum, part| overlay(&sum, part.region(), OverlayRule::Union));
        assert_same(Inner::union(&parts).region(), &sum);
    });
}

/// The same set on several agents: edges that nearly coincide. (With a constant snapping radius
/// case 13 took minutes, ten copies in one overlay took ten seconds and gave 65 000 vertices.)
#[test]
fn copies_moved_by_a_unit_neither_hang_nor_explode() {
    cases("copies_moved_by_a_unit_neither_hang_nor_explode", 200, |rng| {
        let scale_m = rng.random_range(1.0..300.0);
        let set = solid(&[star(rng, [10.0, -20.0], scale_m)]);
        let copies: Vec<Region> = (0..10).map(|_| moved_by_a_unit(rng, &set)).collect();
        let others: Vec<Inner> = copies.iter().cloned().map(Inner::within).collect();
        let rest = Outer::containing(set.clone()).minus(&others).into_region();
        let any = Inner::union(&others).into_region();
        let both = copies.iter().fold(Outer::containing(set.clone()), |both, copy| {
            both.intersection(&Outer::containing(copy.clone()))
        });
        let most = 30 * set.vertex_count() + 100;
        for result in [&rest, &any, both.region()] {
            assert!(result.vertex_count() <= most, "{} vertices", result.vertex_count());
        }
        let allowed = 5.0 * ROUNDING_M * perimeter_m(&set) + 1e-9;
        assert!(rest.area_m2() <= allowed);
        assert!((any.area_m2() - set.area_m2()).abs() <= allowed);
        assert!((both.region().area_m2() - set.area_m2()).abs() <= allowed);
    });
}

fn moved_by_a_unit(rng: &mut Rng, region: &Region) -> Region {
    let mut moved = |p: &GridPoint| {
        GridPoint::new(p.x + rng.random_range(-1..=1), p.y + rng.random_range(-1..=1))
    };
    let rings: Vec<Ring> =
        region.rings().map(|ring| ring.iter().map(&mut moved).collect()).collect();
    resolved(&rings, FillRule::Positive)
}

#[test]
fn the_empty_set_behaves() {
    let (none, square) = (Region::EMPTY, Region::rectangle([2.0, 2.0]));
    let outer = |region: &Region| Outer::containing(region.clone());
    let inner = |region: &Region| Inner::within(region.clone());
    assert!(outer(&none).intersection(&outer(&square)).is_empty());
    assert!(outer(&none).minus([&inner(&square)]).is_empty());
    assert!(outer(&square).minus([&inner(&square)]).is_empty());
    assert_eq!(outer(&square).minus([&inner(&none)]), outer(&square));
    assert_eq!(outer(&square).minus([]), outer(&square));
    assert!(Inner::union([]).is_empty());
    assert_eq!(Inner::union([&inner(&none), &inner(&square)]), inner(&square));
    assert!(outer(&none).simplified(0.05).is_empty());
    assert!(inner(&none).simplified(0.05).is_empty());
}
