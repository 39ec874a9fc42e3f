//! `Outer::dilated` is the Minkowski sum with the disc's polygon.

use std::f64::consts::PI;

use csat_agent::region::{Disc, NUMERIC_MARGIN_M, Outer};
use csat_proto::region::{Region, metres};
use rand::RngExt;

use crate::oracle::{ROUNDING_M, assert_same, disc_offsets, edges, minkowski_sum, samples};
use crate::shapes::{Rng, any_region, cases};

/// A region larger than all others of these tests.
pub fn everywhere() -> Region {
    Region::rectangle([3000.0, 3000.0])
}

/// A radius and a number of corners to dilate or erode `region` with.
pub fn any_disc(rng: &mut Rng, region: &Region) -> (f64, u16) {
    let size_m = region.bounds().map_or(1.0, |b| {
        let (min, max) = (metres(b.min), metres(b.max));
        (max[0] - min[0]).max(max[1] - min[1])
    });
    let radius_m = match rng.random_range(0..4) {
        0 => 0.5,
        1 => 0.0,
        2 => (size_m * rng.random_range(0.0..0.1)).min(60.0),
        _ => (size_m * rng.random_range(0.0..1.5)).min(60.0),
    };
    let vertices = [4, 5, 7, 8, 16, 16, 24, 32];
    (radius_m, vertices[rng.random_range(0..vertices.len())])
}

#[test]
fn dilated_contains_every_disc_about_every_point() {
    cases("dilated_contains_every_disc_about_every_point", 600, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let disc = Disc::circumscribed(radius_m, vertices);
        let dilated = Outer::containing(region.clone()).dilated(&disc, &everywhere());
        let offsets = disc_offsets(rng, radius_m, 16);
        for p in samples(rng, &region) {
            for o in &offsets {
                let q = [p[0] + o[0], p[1] + o[1]];
                let distance = dilated.region().distance_m(q);
                assert!(distance <= ROUNDING_M, "{distance} m outside at {q:?}, r = {radius_m}");
            }
        }
    });
}

#[test]
fn dilated_stays_within_the_polygons_reach() {
    cases("dilated_stays_within_the_polygons_reach", 600, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let disc = Disc::circumscribed(radius_m, vertices);
        let dilated = Outer::containing(region.clone()).dilated(&disc, &everywhere());
        let reach = (radius_m + NUMERIC_MARGIN_M) / (PI / f64::from(vertices)).cos() + 4e-5;
        for [a, b] in edges(dilated.region()) {
            for q in [a, [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]] {
                let distance = region.distance_m(q);
                assert!(distance <= reach, "{distance} m away at {q:?}, reach {reach}");
            }
        }
    });
}

#[test]
fn dilated_is_the_union_of_the_edges_sums() {
    cases("dilated_is_the_union_of_the_edges_sums", 1500, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let disc = Disc::circumscribed(radius_m, vertices);
        let dilated = Outer::containing(region.clone()).dilated(&disc, &everywhere());
        assert_same(dilated.region(), &minkowski_sum(&region, disc.corners()));
    });
}

#[test]
fn dilated_is_clipped_to_the_bounds() {
    cases("dilated_is_clipped_to_the_bounds", 300, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let disc = Disc::circumscribed(radius_m, vertices);
        let bounds = Region::rectangle([900.0, 700.0]);
        let outer = Outer::containing(region);
        let clipped = outer.dilated(&disc, &bounds);
        let whole = outer.dilated(&disc, &everywhere());
        assert_same(
            clipped.region(),
            whole.intersection(&Outer::containing(bounds.clone())).region(),
        );
        for [a, _] in edges(clipped.region()) {
            assert!(bounds.distance_m(a) == 0.0 || bounds.distance_m(a) < ROUNDING_M);
        }
    });
}
