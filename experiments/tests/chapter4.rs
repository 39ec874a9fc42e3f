//! What the thesis says of its chapter 4, as laws that our looks have to keep.

use csat_experiments::published::reference;
use csat_experiments::reproduce::chapter4::Chapter4;
use csat_experiments::reproduce::chapter4::look::{Looks, SEPARATIONS_M, Seen};
use csat_experiments::reproduce::chapter4::scene::{self, CARS_M};
use csat_experiments::scenario::Scenario;

fn seen() -> Chapter4 {
    Chapter4::look(&Scenario::default(), &[1, 2, 3, 4, 5, 6, 7, 8])
}

#[test]
fn one_look_is_as_good_as_the_thesis_says() {
    let seen = seen();
    let published = reference().chapter4;
    let mean = |looks: &Looks, car: usize, value: fn(&Seen) -> f64| {
        looks.stats(car, value).expect("identified").mean
    };
    for (car, published_m) in published.distance_m.into_iter().enumerate() {
        assert!((scene::distance_m(car) - published_m).abs() < 1.0);
        let looks = seen.plain();
        assert_eq!(looks.cars[car].len(), 8, "car {car} is identified in every look");
        // Theirs is below 2 m; ours has the Unknown pixels in the shadow of far cars, too.
        let allowed_m = published.point_error_below_m + if car > 2 { 0.5 } else { 0.0 };
        let error_m = mean(looks, car, |s| s.error_m);
        assert!(error_m < allowed_m, "car {car}: {error_m} m");
        let [measured_m, set_m] =
            [mean(looks, car, |s| s.measured_radius_m), mean(looks, car, |s| s.set_radius_m)];
        // Never smaller than the car's own ground, and the clear ground takes something away.
        assert!(set_m > (4.6f64 * 1.8 / std::f64::consts::PI).sqrt() && set_m < measured_m);
        // Figure 4.11: the farther, the larger.
        let nearer = car.checked_sub(1).map_or(0.0, |car| mean(looks, car, |s| s.set_radius_m));
        assert!(set_m > nearer, "car {car}: {set_m} m");
    }
    let nearest_m = mean(seen.plain(), 0, |s| s.set_radius_m);
    let published_m = reference().chapter6.target_60m_radius_m.exact;
    assert!((nearest_m - published_m).abs() < 0.15, "{nearest_m} m");
    let iou = &seen.oem_iou_pct;
    assert!(iou.iter().all(|iou| (75.0..=100.0).contains(iou)), "{iou:?}");
}

#[test]
fn what_differs_has_the_effect_that_the_thesis_says() {
    let seen = seen();
    let mean = |family: usize, setting: usize, car: usize, value: fn(&Seen) -> f64| {
        seen.families[family].1[setting].stats(car, value).expect("identified").mean
    };
    for car in 0..CARS_M.len() {
        // Figure 4.13: r^t shifts X^{t,m} by about its own difference.
        let shift = |s| mean(1, s, car, |s| s.measured_radius_m);
        assert!((shift(2) - shift(0) - 1.5).abs() < 0.4, "{}", shift(2) - shift(0));
        // Figure 4.14: noise makes X^{t,m} larger, but hardly the set estimate of near cars.
        assert!(
            mean(2, 2, car, |s| s.measured_radius_m) > mean(2, 0, car, |s| s.measured_radius_m)
        );
        let noisy = |s| mean(2, s, car, |s| s.set_radius_m);
        assert!(car > 2 || noisy(2) - noisy(0) < 0.2, "{} {}", noisy(2), noisy(0));
        // Figure 4.17: a finer image helps while the whole shadow is in X^{t,m}.
        let fine_m = mean(3, 1, car, |s| s.set_radius_m);
        assert!(car > 2 || fine_m < mean(3, 0, car, |s| s.set_radius_m));
        // Figure A.3: X^{t,m} is smaller with Assumption 6, and X^t much the same.
        assert!(
            mean(4, 2, car, |s| s.measured_radius_m) < mean(4, 1, car, |s| s.measured_radius_m)
        );
        let [four, six] =
            [mean(4, 0, car, |s| s.set_radius_m), mean(4, 2, car, |s| s.set_radius_m)];
        assert!((four - six).abs() < 0.5, "{four} {six}");
    }
    // Figure 4.19: the farther apart cars stay, the more of the shadow is clear.
    for look in seen.plain().cars.iter().flatten() {
        assert!(look.covered_pct.windows(2).all(|w| w[0] <= w[1] + 1e-9), "{look:?}");
        assert!(look.covered_pct[3] < look.covered_by_set_pct[3], "{look:?}");
    }
    for look in seen.plain().cars[..3].iter().flatten() {
        assert!(look.covered_by_set_pct[3] > 99.9, "{look:?}");
    }
    assert_eq!(SEPARATIONS_M[3], reference().chapter4.exclusion_covers_shadow.r_s_tt_m);
}

#[test]
fn looks_are_the_same_again_and_their_page_stands_alone() {
    let (one, two) = (seen(), seen());
    let page = one.html(&one.tables(), "csat reproduce chapter4");
    assert_eq!(page, two.html(&two.tables(), "csat reproduce chapter4"));
    assert!(page.contains("figure 4.19") && page.contains("Assumption 6"));
    assert!(!page.contains("NaN") && !page.contains("<script"));
}
