//! Simplification only goes the safe way.

use csat_agent::region::{Inner, Outer};
use csat_proto::region::{Region, metres};
use rand::RngExt;

use crate::oracle::{ROUNDING_M, excess_m2, perimeter_m, samples};
use crate::shapes::{Rng, any_region, cases};

/// A tolerance from much less than the set's area to more than it.
fn any_tolerance_m2(rng: &mut Rng, region: &Region) -> f64 {
    let size_m2 = region.bounds().map_or(1.0, |b| {
        let (min, max) = (metres(b.min), metres(b.max));
        (max[0] - min[0]) * (max[1] - min[1])
    });
    size_m2 * 10f64.powf(rng.random_range(-5.0..0.5))
}

#[test]
fn an_outer_set_only_grows() {
    cases("an_outer_set_only_grows", 3000, |rng| {
        let region = any_region(rng);
        let tolerance_m2 = any_tolerance_m2(rng, &region);
        let simple = Outer::containing(region.clone()).simplified(tolerance_m2).into_region();
        let lost = excess_m2(&region, &simple);
        assert!(lost <= 1e-6 * perimeter_m(&region) + 1e-10, "{lost} m² lost");
        for p in samples(rng, &region) {
            let distance = simple.distance_m(p);
            assert!(distance <= ROUNDING_M, "{distance} m outside at {p:?}");
        }
        let moves = region.vertex_count() as f64;
        let gained = excess_m2(&simple, &region);
        assert!(gained <= tolerance_m2 * moves + 1e-6 * perimeter_m(&region) + 1e-10);
    });
}

#[test]
fn an_inner_set_only_shrinks() {
    cases("an_inner_set_only_shrinks", 3000, |rng| {
        let region = any_region(rng);
        let tolerance_m2 = any_tolerance_m2(rng, &region);
        let simple = Inner::within(region.clone()).simplified(tolerance_m2).into_region();
        let gained = excess_m2(&simple, &region);
        assert!(gained <= 1e-6 * perimeter_m(&simple) + 1e-10, "{gained} m² gained");
        for p in samples(rng, &simple) {
            let distance = region.distance_m(p);
            assert!(distance <= ROUNDING_M, "{distance} m outside at {p:?}");
        }
        let moves = region.vertex_count() as f64;
        let lost = excess_m2(&region, &simple);
        assert!(lost <= tolerance_m2 * moves + 1e-6 * perimeter_m(&region) + 1e-10);
    });
}

#[test]
fn vertices_become_fewer_until_nothing_changes() {
    cases("vertices_become_fewer_until_nothing_changes", 2000, |rng| {
        let region = any_region(rng);
        let tolerance_m2 = any_tolerance_m2(rng, &region);
        let mut outer = Outer::containing(region.clone());
        let mut inner = Inner::within(region.clone());
        for _ in 0..region.vertex_count() {
            let (o, i) =
                (outer.clone().simplified(tolerance_m2), inner.clone().simplified(tolerance_m2));
            assert!(o.region().vertex_count() <= outer.region().vertex_count());
            assert!(i.region().vertex_count() <= inner.region().vertex_count());
            if (&o, &i) == (&outer, &inner) {
                return;
            }
            (outer, inner) = (o, i);
        }
        panic!("still changing");
    });
}
