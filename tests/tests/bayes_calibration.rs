//! The target is in the region that holds 95 % of the belief in 95 % of all missions, whatever the links do and
//! whether it was found or not; and where that is not to be expected, it is not so.
//!
//! `CSAT_SEEDS=1000` flies that many with factors instead of 200, `CSAT_SEEDS=500..700` those. The other tests always
//! fly the same.

use std::ops::Range;

use csat_bayes::config::Fusion;
use csat_tests::bayes::calibration::{Coverage, Look, Setting, fly};
use csat_tests::replay;
use csat_world::navigation::Noise;

/// Enough to tell 0.88 from 0.95.
const MISSIONS: Range<u64> = 0..200;

/// The missions with factors to fly.
fn missions() -> Range<u64> {
    replay::asked_range().unwrap_or(MISSIONS)
}

/// How often the target was where it was believed to be, at each look.
fn coverages(what: &str, setting: &Setting, missions: Range<u64>) -> Vec<Coverage> {
    let looks = fly(setting, missions);
    let coverage = |(at_s, looks): (&f64, &Vec<Look>)| {
        let coverage = Coverage::of(looks);
        let found = looks.iter().filter(|look| look.sigma_m < 50.0);
        let missed = looks.iter().filter(|look| look.sigma_m < 50.0 && !look.is_in);
        let mut errors: Vec<f64> = looks.iter().map(|look| look.error_m).collect();
        errors.sort_unstable_by(f64::total_cmp);
        println!(
            "{what} at {at_s} s: in the region {} of {}, {:.3}; {} were sure to 50 m, {} of them wrong; median \
             error {:.1} m",
            coverage.hits,
            coverage.missions,
            coverage.share(),
            found.count(),
            missed.count(),
            errors[errors.len() / 2]
        );
        coverage
    };
    setting.looks_s.iter().zip(&looks).map(coverage).collect()
}

#[test]
fn with_perfect_links_the_belief_is_calibrated() {
    let coverages = coverages("perfect links", &Setting::default(), missions());
    assert!(!coverages.iter().any(|c| c.is_too_low() || c.is_too_high()), "{coverages:?}");
}

#[test]
fn lossy_links_cost_information_and_no_truth() {
    let setting = Setting { is_lossy: true, ..Setting::default() };
    let coverages = coverages("lossy links", &setting, missions());
    assert!(!coverages.iter().any(|c| c.is_too_low() || c.is_too_high()), "{coverages:?}");
}

#[test]
fn fused_beliefs_are_careful_and_their_product_is_not() {
    let chernoff = coverages("Chernoff", &Setting::of_beliefs(Fusion::Chernoff), MISSIONS);
    assert!(!chernoff.iter().any(|c| c.is_too_low()), "{chernoff:?}");
    let product = coverages("product", &Setting::of_beliefs(Fusion::Product), 0..40);
    assert!(product.last().is_some_and(|c| c.is_too_low()), "{product:?}");
}

#[test]
fn errors_that_last_make_the_belief_too_sure() {
    let setting = Setting { noise: Noise::GaussMarkov, ..Setting::default() };
    let coverages = coverages("Gauss-Markov errors", &setting, 0..60);
    assert!(coverages.last().is_some_and(|c| c.share() < 0.9), "{coverages:?}");
}
