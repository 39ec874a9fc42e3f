//! `dilated_far` and `eroded_far` differ little from the exact operations, and keep the guarantee.

use csat_agent::region::{Disc, Inner, Outer, Reach};
use csat_proto::region::{Region, grid_point, metres};
use rand::RngExt;

use crate::dilate::everywhere;
use crate::oracle::{ROUNDING_M, excess_m2, perimeter_m};
use crate::shapes::{any_region, cases};

#[test]
fn a_far_dilation_contains_the_exact_one_and_little_more() {
    cases("a_far_dilation_contains_the_exact_one_and_little_more", 400, |rng| {
        let region = any_region(rng);
        let radius_m = rng.random_range(0.0..40.0);
        let vertices = rng.random_range(4..=24);
        let set = Outer::containing(region.clone());
        let exact = set.dilated(&Disc::circumscribed(radius_m, vertices), &everywhere());
        let far = set.dilated_far(&Reach::new(radius_m, vertices), &everywhere()).into_region();
        let missing_m2 = excess_m2(exact.region(), &far);
        let allowed_m2 = ROUNDING_M * perimeter_m(exact.region()) + 1e-9;
        assert!(missing_m2 <= allowed_m2, "{missing_m2} m² missing of a reach of {radius_m} m");
        for p in far.rings().flatten() {
            let beyond_m = exact.region().distance_m(metres(*p));
            assert!(beyond_m <= 0.75 * radius_m + 0.005, "{beyond_m} m too far for {radius_m} m");
        }
    });
}

#[test]
fn a_far_erosion_is_contained_in_the_exact_one_and_little_less() {
    cases("a_far_erosion_is_contained_in_the_exact_one_and_little_less", 400, |rng| {
        let region = any_region(rng);
        let radius_m = rng.random_range(0.0..20.0);
        let vertices = rng.random_range(4..=24);
        let set = Inner::within(region.clone());
        let exact = set.eroded(&Disc::circumscribed(radius_m, vertices)).into_region();
        let far = set.eroded_far(&Reach::new(radius_m, vertices)).into_region();
        let extra_m2 = excess_m2(&far, &exact);
        assert!(extra_m2 <= ROUNDING_M * perimeter_m(&far) + 1e-9, "{extra_m2} m² too much");
        let farther = Disc::circumscribed(radius_m * 1.25 + 0.01, vertices);
        let surely = set.eroded(&farther).into_region();
        let missing_m2 = excess_m2(&surely, &far);
        let allowed_m2 = ROUNDING_M * perimeter_m(&surely) + 1e-9;
        assert!(missing_m2 <= allowed_m2, "{missing_m2} m² missing after a reach of {radius_m} m");
    });
}

/// A comb of 20 000 corners with the reach of a minute; in one stage this takes gigabytes.
#[test]
fn details_are_gone_before_they_are_swept_far() {
    let tooth = |i: u32| {
        let x = f64::from(i) * 0.05;
        [[x, 0.0], [x + 0.02, 60.0 + f64::from(i % 7)], [x + 0.03, 5.0]]
    };
    let mut ring: Vec<_> = (0..6000).flat_map(tooth).collect();
    ring.extend([[301.0, 0.0], [301.0, -5.0], [0.0, -5.0]]);
    ring.reverse();
    let ring = ring.iter().map(|p| grid_point([p[0] - 150.0, p[1] - 30.0])).collect();
    let comb = Outer::containing(Region::from_shapes(vec![vec![ring]]));
    let dilated = comb.dilated_far(&Reach::new(60.0, 16), &Region::rectangle([2000.0; 2]));
    assert!(dilated.region().vertex_count() < 200, "{}", dilated.region().vertex_count());
    assert!(dilated.region().area_m2() > 301.0 * 120.0);
}
