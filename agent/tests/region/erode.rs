//! `Inner::eroded` is the Minkowski difference, and dual to `Outer::dilated`.

use csat_agent::region::{Disc, Inner, Outer};
use csat_proto::region::metres;
use rand::RngExt;

use crate::dilate::{any_disc, everywhere};
use crate::oracle::{
    ROUNDING_M, assert_same, disc_offsets, excess_m2, minkowski_difference, perimeter_m, samples,
    without_splinters,
};
use crate::shapes::{any_region, cases};

#[test]
fn every_disc_about_an_eroded_point_lies_in_the_set() {
    cases("every_disc_about_an_eroded_point_lies_in_the_set", 1000, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let radius_m = radius_m * rng.random_range(0.0..0.5);
        let disc = Disc::circumscribed(radius_m, vertices);
        let eroded = without_splinters(Inner::within(region.clone()).eroded(&disc).into_region());
        let offsets = disc_offsets(rng, radius_m, 16);
        for p in samples(rng, &eroded) {
            for o in &offsets {
                let q = [p[0] + o[0], p[1] + o[1]];
                let distance = region.distance_m(q);
                assert!(distance <= ROUNDING_M, "{distance} m outside at {q:?}, r = {radius_m}");
            }
        }
    });
}

#[test]
fn eroded_is_what_the_complements_sum_leaves() {
    cases("eroded_is_what_the_complements_sum_leaves", 1500, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let disc = Disc::circumscribed(radius_m * rng.random_range(0.0..0.5), vertices);
        let eroded = Inner::within(region.clone()).eroded(&disc);
        assert_same(eroded.region(), &minkowski_difference(&region, disc.corners()));
    });
}

#[test]
fn a_set_narrower_than_the_disc_erodes_to_nothing() {
    cases("a_set_narrower_than_the_disc_erodes_to_nothing", 1000, |rng| {
        let region = any_region(rng);
        let Some(bounds) = region.bounds() else { return };
        let (min, max) = (metres(bounds.min), metres(bounds.max));
        let width = (max[0] - min[0]).min(max[1] - min[1]);
        let disc = Disc::circumscribed(width / 2.0 + rng.random_range(0.0..5.0), 16);
        let left = Inner::within(region).eroded(&disc).into_region();
        // Rounding may leave splinters a grid unit wide.
        let splinters = 1e-5 * perimeter_m(&left);
        assert!(left.area_m2() <= splinters, "{} m² left", left.area_m2());
    });
}

#[test]
fn dilating_and_eroding_gives_the_set_back_and_more() {
    cases("dilating_and_eroding_gives_the_set_back_and_more", 600, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let vertices = vertices.next_multiple_of(2);
        let disc = Disc::circumscribed(radius_m, vertices);
        let dilated = Outer::containing(region.clone()).dilated(&disc, &everywhere());
        let closed = Inner::within(without_splinters(dilated.into_region())).eroded(&disc);
        let missing = excess_m2(&region, closed.region());
        assert!(missing <= 2.0 * ROUNDING_M * perimeter_m(&region) + 1e-9, "{missing} m² lost");
        for p in samples(rng, &region) {
            let distance = closed.region().distance_m(p);
            assert!(distance <= 5.0 * ROUNDING_M, "{distance} m outside at {p:?}");
        }
    });
}

#[test]
fn eroding_and_dilating_gives_a_part_of_the_set() {
    cases("eroding_and_dilating_gives_a_part_of_the_set", 600, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let vertices = vertices.next_multiple_of(2);
        let disc = Disc::circumscribed(radius_m * rng.random_range(0.0..0.5), vertices);
        let eroded = without_splinters(Inner::within(region.clone()).eroded(&disc).into_region());
        let opened = Outer::containing(eroded).dilated(&disc, &everywhere());
        let extra = excess_m2(opened.region(), &region);
        assert!(extra <= ROUNDING_M * perimeter_m(opened.region()) + 1e-9, "{extra} m² gained");
        for p in samples(rng, opened.region()) {
            let distance = region.distance_m(p);
            assert!(distance <= ROUNDING_M, "{distance} m outside at {p:?}");
        }
    });
}
