//! The target is in the region that holds 95 % of the belief in 95 % of all missions, whatever the links do; and
//! where it is not to be expected, it is not.

use csat_bayes::config::Fusion;
use csat_tests::bayes::calibration::{Coverage, Setting, fly};
use csat_world::navigation::Noise;

const MISSIONS: u64 = 200;

fn coverage(what: &str, setting: &Setting, missions: u64) -> Coverage {
    let ends = fly(setting, 0..missions);
    let coverage = Coverage::of(&ends);
    let sure = ends.iter().filter(|end| end.sigma_m < 50.0).count();
    let mut errors: Vec<f64> = ends.iter().map(|end| end.error_m).collect();
    errors.sort_unstable_by(f64::total_cmp);
    println!(
        "{what}: in the region {} of {}, {:.3}; {sure} were sure to 50 m; median error {:.1} m",
        coverage.hits,
        coverage.missions,
        coverage.share(),
        errors[errors.len() / 2]
    );
    let misses: Vec<_> = ends.iter().filter(|end| !end.is_in).collect();
    println!("{misses:#?}");
    coverage
}

#[test]
fn with_perfect_links_the_belief_is_calibrated() {
    let coverage = coverage("perfect links", &Setting::default(), MISSIONS);
    assert!(!coverage.is_too_low() && !coverage.is_too_high(), "{coverage:?}");
}

#[test]
fn lossy_links_cost_information_and_no_truth() {
    let setting = Setting { is_lossy: true, ..Setting::default() };
    let coverage = coverage("lossy links", &setting, MISSIONS);
    assert!(!coverage.is_too_low() && !coverage.is_too_high(), "{coverage:?}");
}

#[test]
fn fused_beliefs_are_careful_and_their_product_is_not() {
    let chernoff = coverage("Chernoff", &Setting::of_beliefs(Fusion::Chernoff), MISSIONS);
    assert!(!chernoff.is_too_low(), "{chernoff:?}");
    let product = coverage("product", &Setting::of_beliefs(Fusion::Product), MISSIONS);
    assert!(product.is_too_low(), "{product:?}");
}

#[test]
fn errors_that_last_make_the_belief_too_sure() {
    let setting = Setting { noise: Noise::GaussMarkov, ..Setting::default() };
    let coverage = coverage("Gauss-Markov errors", &setting, 60);
    assert!(coverage.share() < 0.9, "{coverage:?}");
}
