//! Simplification only grows outer approximations and only shrinks inner ones.

use csat_agent::region::{Inner, Outer};
use csat_proto::region::{Region, metres};
use i_overlay::core::fill_rule::FillRule;
use rand::RngExt;

use crate::oracle::{ROUNDING_M, excess_m2, perimeter_m, samples, without_splinters};
use crate::shapes::{Rng, any_region, cases, resolved, star};

/// A tolerance from much less than the size of the set up to about its size, metres.
pub fn any_tolerance_m(rng: &mut Rng, region: &Region) -> f64 {
    let size_m = region.bounds().map_or(1.0, |b| {
        let (min, max) = (metres(b.min), metres(b.max));
        (max[0] - min[0]).max(max[1] - min[1])
    });
    size_m * 10f64.powf(rng.random_range(-5.0..0.0))
}

/// The area that moves may change in total: triangles of the height of the tolerance, a hundred times
/// as long, and rounding along every edge.
fn allowed_m2(region: &Region, tolerance_m: f64) -> f64 {
    let moves = region.vertex_count() as f64;
    50.0 * tolerance_m * tolerance_m * moves + 1e-5 * perimeter_m(region) + 1e-9
}

#[test]
fn an_outer_set_only_grows() {
    cases("an_outer_set_only_grows", 3000, |rng| {
        let region = any_region(rng);
        let tolerance_m = any_tolerance_m(rng, &region);
        let simple = Outer::containing(region.clone()).simplified(tolerance_m).into_region();
        let lost = excess_m2(&region, &simple);
        assert!(lost <= 1e-6 * perimeter_m(&region) + 1e-10, "{lost} m² lost");
        for p in samples(rng, &without_splinters(region.clone())) {
            let distance = simple.distance_m(p);
            assert!(distance <= 2.0 * ROUNDING_M, "{distance} m outside at {p:?}");
        }
        let gained = excess_m2(&simple, &region);
        assert!(gained <= allowed_m2(&region, tolerance_m), "{gained} m² gained");
    });
}

#[test]
fn an_inner_set_only_shrinks() {
    cases("an_inner_set_only_shrinks", 3000, |rng| {
        let region = any_region(rng);
        let tolerance_m = any_tolerance_m(rng, &region);
        let simple = Inner::within(region.clone()).simplified(tolerance_m).into_region();
        let gained = excess_m2(&simple, &region);
        assert!(gained <= 1e-6 * perimeter_m(&simple) + 1e-10, "{gained} m² gained");
        for p in samples(rng, &without_splinters(simple.clone())) {
            let distance = region.distance_m(p);
            assert!(distance <= 2.0 * ROUNDING_M, "{distance} m outside at {p:?}");
        }
        let lost = excess_m2(&region, &simple);
        assert!(lost <= allowed_m2(&region, tolerance_m), "{lost} m² lost");
    });
}

/// Not always: a dropped vertex may make its ring cross others, and each crossing is a vertex.
#[test]
fn vertices_become_fewer_until_nothing_changes() {
    cases("vertices_become_fewer_until_nothing_changes", 2000, |rng| {
        let region = any_region(rng);
        let tolerance_m = any_tolerance_m(rng, &region);
        let most = region.vertex_count() * 5 / 4 + 4;
        let mut outer = Outer::containing(region.clone());
        let mut inner = Inner::within(region);
        for _ in 0..most {
            let (o, i) =
                (outer.clone().simplified(tolerance_m), inner.clone().simplified(tolerance_m));
            assert!(o.region().vertex_count() <= most);
            assert!(i.region().vertex_count() <= most);
            if (&o, &i) == (&outer, &inner) {
                return;
            }
            (outer, inner) = (o, i);
        }
        panic!("still changing");
    });
}

/// The triangles of dropped vertices hold other shapes, holes and their islands.
#[test]
fn rings_within_dropped_triangles_are_respected() {
    cases("rings_within_dropped_triangles_are_respected", 1000, |rng| {
        let mut rings = vec![star(rng, [0.0, 0.0], 50.0)];
        for _ in 0..rng.random_range(5..40) {
            let at = [rng.random_range(-50.0..50.0), rng.random_range(-50.0..50.0)];
            let scale_m = rng.random_range(0.3..6.0);
            rings.push(star(rng, at, scale_m));
        }
        let region = resolved(&rings, FillRule::EvenOdd);
        let tolerance_m = 10f64.powf(rng.random_range(-2.0..1.5));
        let allowed = 1e-6 * perimeter_m(&region);
        let outer = Outer::containing(region.clone()).simplified(tolerance_m).into_region();
        assert!(excess_m2(&region, &outer) <= allowed);
        let inner = Inner::within(region.clone()).simplified(tolerance_m).into_region();
        assert!(excess_m2(&inner, &region) <= allowed);
    });
}
