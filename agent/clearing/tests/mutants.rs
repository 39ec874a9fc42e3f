//! Every known mistake is noticed: by contamination of what was claimed, by road that is overlooked, by a frontier at
//! the edge of an image, or by a frontier that is no boundary.

#[allow(dead_code)]
mod sim;

use std::panic::{AssertUnwindSafe, catch_unwind};

use csat_clearing::bitmap::Rect;
use csat_clearing::masks::{Masks, Sight};
use csat_clearing::mutant::{Mutant, switch};
use sim::links::LinkModel;
use sim::town::Town;
use sim::{Outcome, Setup, fly};

/// The frontier is what has unknown road within reach.
fn boundary() -> Option<String> {
    let sight = Sight::new(&Setup::new(Town::straight(), 0).config(0));
    let mut road = sight.nothing();
    // Steps of one pixel, in the middle of M and across its border.
    for index in 0..80 {
        let [row, column] = [100 + index, 200 + index / 2];
        road.fill(&Rect { rows: [row; 2], columns: [column; 2] });
    }
    let mut seeds = sight.nothing();
    seeds.set(100, 200);
    let mut masks = Masks::new(&sight, road);
    masks.begin(&sight, &seeds);
    let near = masks.unknown().dilated(sight.radii.reach).and(masks.mine());
    (near != *masks.frontier()).then(|| "a frontier that is no boundary".to_owned())
}

fn setups() -> Vec<Setup> {
    let delayed = LinkModel { max_delay_s: 2.0, ..LinkModel::default() };
    let town = |index: usize| match index {
        0 => Town::hooks(),
        1 => Town::cross(),
        2 => Town::ring(),
        3 => Town::ladder(60.0, &[-120.0]),
        4 => Town::desert(0, 110.0),
        _ => Town::desert(3, 110.0),
    };
    (0..6)
        .map(|index| {
            let seed = index as u64;
            let mut setup = Setup { max_s: 450.0, ..Setup::new(town(index), seed) };
            setup.uavs = if index < 4 { 4 } else { 8 };
            if index % 2 == 1 {
                setup.links = delayed;
            }
            setup
        })
        .collect()
}

/// What of a mission is not as it should be.
fn broken(index: usize, setup: &Setup) -> Option<String> {
    let broken = |outcome: Outcome| outcome.first_violation.or(outcome.overlooked);
    let result = catch_unwind(AssertUnwindSafe(|| broken(fly(setup))));
    let law = result.unwrap_or_else(|_| Some("an assertion".to_owned()))?;
    Some(format!("setup {index}: {law}"))
}

/// What is noticed first.
fn noticed() -> Option<String> {
    let setups = setups();
    boundary().or_else(|| setups.iter().enumerate().find_map(|(index, s)| broken(index, s)))
}

/// The same where nothing should be: then all missions are flown, at once.
fn noticed_at_all() -> Option<String> {
    let setups = setups();
    let flown: Vec<Option<String>> = std::thread::scope(|scope| {
        let flights =
            setups.iter().enumerate().map(|(index, s)| scope.spawn(move || broken(index, s)));
        let flights: Vec<_> = flights.collect();
        flights.into_iter().map(|flight| flight.join().expect("panics are caught")).collect()
    });
    boundary().or_else(|| flown.into_iter().flatten().next())
}

#[test]
fn every_known_mistake_is_noticed() {
    assert_eq!(noticed_at_all(), None, "this is no mistake");
    std::panic::set_hook(Box::new(|_| {}));
    let mut alive = Vec::new();
    for mutant in Mutant::ALL {
        switch(Some(mutant));
        match noticed() {
            Some(law) => println!("{mutant:?}: {law}"),
            None => alive.push(mutant),
        }
    }
    switch(None);
    let _ = std::panic::take_hook();
    assert_eq!(alive, [], "not noticed");
}
