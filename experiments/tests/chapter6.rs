//! What the thesis says of its chapter 6, as laws that our looks have to keep.

use csat_experiments::published::reference;
use csat_experiments::reproduce::chapter4::look::Seen as Look;
use csat_experiments::reproduce::chapter6::settings::{POSITION_M, RADII_M};
use csat_experiments::reproduce::chapter6::{Chapter6, Seen};
use csat_experiments::scenario::Scenario;

fn seen() -> Chapter6 {
    Chapter6::look(&Scenario::default(), &[1, 2, 3, 4, 5, 6])
}

fn mean(one: &Seen, car: usize, value: fn(&Look) -> f64) -> f64 {
    one.looks.stats(car, value).expect("identified").mean
}

#[test]
fn a_box_costs_no_more_than_the_thesis_says() {
    let seen = seen();
    let published = reference().chapter6;
    let shares = published.footprint_guaranteed_pct;
    let shares = [shares.u1, shares.u2, shares.u3, shares.u4];
    for (one, published_pct) in seen.seen[1..].iter().zip(shares) {
        assert!(
            seen.footprint_pct(one) >= published_pct,
            "{}: {}",
            one.uncertainty.name,
            seen.footprint_pct(one)
        );
    }
    let [exact, u1, .., u4] = &seen.seen[..] else { panic!("five boxes") };
    let set_m = mean(u1, 0, |look| look.set_radius_m);
    assert!(set_m <= published.target_60m_radius_m.u1[0], "{set_m} m");
    for car in 0..5 {
        // A larger box, larger sets.
        for value in [|look: &Look| look.measured_radius_m, |look: &Look| look.set_radius_m] {
            let radii = [exact, u1, u4].map(|one| mean(one, car, value));
            assert!(radii.is_sorted(), "car {car}: {radii:?}");
        }
        // Figure 6.8: exclusion hardly helps any more, and never more than before.
        let covered = [exact, u1].map(|one| mean(one, car, |look| look.covered_pct[3]));
        assert!(covered[1] <= covered[0], "car {car}: {covered:?}");
    }
    let clear: Vec<f64> = seen.seen.iter().map(|one| one.clear_ground.area_m2()).collect();
    assert!(clear[0] > clear[1] && clear[1] > clear[2] && clear[2] > clear[4], "{clear:?}");
}

/// Figure 6.9: errors of the position take the margins of small distances first.
#[test]
fn margins_shrink_with_the_error_of_the_position() {
    let seen = seen();
    let area = |position: usize, radius: usize| seen.margins[position][radius].area_m2();
    for radius in 0..RADII_M.len() {
        assert!(area(0, radius) > area(1, radius) || area(0, radius) == 0.0);
        assert!(area(1, radius) >= area(2, radius));
    }
    assert!(area(0, 0) > 50.0, "{}", area(0, 0));
    assert_eq!((area(2, 0), POSITION_M[2], RADII_M[0]), (0.0, 2.0, 2.5));
    assert!(area(2, RADII_M.len() - 1) > 50.0);
}

#[test]
fn the_page_shows_every_figure_and_stands_alone() {
    let seen = seen();
    let page = seen.html(&seen.tables(), "csat reproduce chapter6");
    for part in [
        "Figure 6.3",
        "Figure 6.4",
        "Figure 6.5",
        "figure 6.6",
        "figure 6.7",
        "figure 6.8",
        "figure 6.9",
        "A.10",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("NaN") && !page.contains("<script"));
}
