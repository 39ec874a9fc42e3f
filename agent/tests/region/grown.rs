//! `Grown` gives the same sets as simplification, dilation and difference one after the other.

use std::sync::Arc;

use csat_agent::region::{Disc, Grown, Inner, Outer, Reach};
use csat_proto::region::{Region, metres};
use i_overlay::core::overlay_rule::OverlayRule;
use rand::RngExt;

use crate::dilate::any_disc;
use crate::oracle::{ROUNDING_M, assert_same, excess_m2, minkowski_sum, overlay, perimeter_m};
use crate::shapes::{Rng, any_region, cases, region_at};
use crate::simplify::any_tolerance_m;

/// Bounds that many sets exceed.
fn bounds() -> Region {
    Region::rectangle([900.0, 700.0])
}

fn parts_about(rng: &mut Rng, region: &Region) -> Vec<Inner> {
    let [x, y] = region.barycentre().unwrap_or_default();
    let scale_m = (2.0 * region.area_m2().sqrt()).clamp(1e-3, 300.0);
    let part = |rng: &mut Rng| {
        let mut near = |at: f64| at + scale_m * rng.random_range(-1.0..1.0);
        let at = [near(x), near(y)];
        Inner::within(region_at(rng, at, scale_m * 0.5))
    };
    (0..rng.random_range(0..5)).map(|_| part(rng)).collect()
}

/// The raw path of a simplified ring is not resolved before it is dilated.
#[test]
fn growing_is_simplifying_and_dilating() {
    cases("growing_is_simplifying_and_dilating", 2000, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let disc = Disc::circumscribed(radius_m, vertices);
        let tolerance_m = any_tolerance_m(rng, &region);
        let set = Outer::containing(region);
        let grown = Grown::new(
            &set,
            tolerance_m,
            &Reach::at_once(disc.clone()),
            &bounds(),
            &Arc::default(),
        )
        .resolved();
        let simple = set.clone().simplified(tolerance_m);
        let expected = minkowski_sum(simple.region(), disc.corners());
        assert_same(grown.region(), &overlay(&expected, &bounds(), OverlayRule::Intersect));
    });
}

#[test]
fn growing_and_cutting_at_once_changes_nothing() {
    cases("growing_and_cutting_at_once_changes_nothing", 1000, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = any_disc(rng, &region);
        let disc = Disc::circumscribed(radius_m, vertices);
        let tolerance_m = any_tolerance_m(rng, &region);
        let parts = parts_about(rng, &region);
        let set = Outer::containing(region);
        for grown in [
            Grown::new(
                &set,
                tolerance_m,
                &Reach::at_once(disc.clone()),
                &bounds(),
                &Arc::default(),
            ),
            Grown::still(&set, &bounds(), &Arc::default()),
        ] {
            let whole = grown.resolved();
            let at_once = grown.minus(&parts).into_region();
            let plain = parts.iter().fold(whole.region().clone(), |left, part| {
                overlay(&left, part.region(), OverlayRule::Difference)
            });
            assert_same(&at_once, &plain);
            let outside = excess_m2(&at_once, &bounds());
            assert!(outside <= ROUNDING_M * perimeter_m(&at_once) + 1e-9);
        }
    });
}

/// A long reach is swept in stages; the result exceeds the exact set by no more than that of a far
/// dilation.
#[test]
fn growing_far_contains_the_exact_set_and_little_more() {
    cases("growing_far_contains_the_exact_set_and_little_more", 400, |rng| {
        let region = any_region(rng);
        let (radius_m, vertices) = (rng.random_range(1.0..40.0), 2 * rng.random_range(2..=12));
        let set = Outer::containing(region);
        let grown =
            Grown::new(&set, 1e-3, &Reach::new(radius_m, vertices), &bounds(), &Arc::default())
                .resolved();
        let exact = set.dilated(&Disc::circumscribed(radius_m, vertices), &bounds());
        let missing_m2 = excess_m2(exact.region(), grown.region());
        let allowed_m2 = ROUNDING_M * perimeter_m(exact.region()) + 1e-9;
        assert!(missing_m2 <= allowed_m2, "{missing_m2} m² missing of {radius_m} m");
        for p in grown.region().rings().flatten() {
            let beyond_m = exact.region().distance_m(metres(*p));
            assert!(beyond_m <= 0.75 * radius_m + 0.01, "{beyond_m} m too far for {radius_m} m");
        }
    });
}
