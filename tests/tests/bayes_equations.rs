//! What agents believe in a scripted mission is what the equations of the paper say, computed another way.

use csat_tests::bayes::{equations, liar};

#[test]
fn beliefs_are_the_posterior_of_the_equations() {
    let apart = equations::check_posterior().unwrap();
    println!("at most {apart:.4?} of the probability is elsewhere after each part");
}

#[test]
fn detections_are_worth_what_the_equations_say() {
    let apart = equations::check_sightings().unwrap();
    println!("at most {apart:.4} of the probability is elsewhere");
}

#[test]
fn a_target_that_walks_gets_lost() {
    equations::check_walk().unwrap();
}

#[test]
fn what_is_late_changes_nothing() {
    equations::check_late().unwrap();
}

#[test]
fn the_probability_of_detection_is_that_of_the_equations() {
    equations::check_detection().unwrap();
}

#[test]
fn the_first_factor_of_an_identity_stays() {
    liar::check().unwrap();
}
