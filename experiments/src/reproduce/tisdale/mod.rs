//! Tisdale et al. 2008, §IV: two aircraft fly given lanes, and the same frames are filtered by every representation
//! of the belief.
//!
//! The flight data of the paper were never published. So the flight is `csat`'s own, by the paper's models; table II
//! follows from the published parameters alone.
//!
//! | module | what it does |
//! |---|---|
//! | [`flight`] | flies, and keeps the factors of all frames |
//! | [`filters`] | what each representation makes of them |
//! | [`figures`] | figures 2 to 7 |
//! | [`tables`] | ours beside theirs |

pub mod figures;
pub mod filters;
pub mod flight;
pub mod tables;

use rayon::prelude::*;

use super::table::{Table, banner_of};
use crate::report::page;
use crate::scenario::{Loaded, Mistakes, Request, load};
use filters::{Curves, KINDS, Last};
use flight::Flight;

/// What a reproduction flies besides the scenario `tisdale`.
pub const SETS: [&str; 1] = ["guidance.criterion=\"lawnmower\""];

/// When the paper's aircraft detected the target, seconds (figure 5).
pub const DETECTED_S: f64 = 120.0;

/// Everything that was flown and filtered.
pub struct Tisdale {
    /// The flights, by seed.
    flights: Vec<Flight>,
    /// What each representation of [`KINDS`] knew at the end of each flight.
    ends: Vec<Vec<Last>>,
    /// The flight that the figures show.
    shown: usize,
    /// Its curves, by representation.
    curves: Vec<Curves>,
}

/// The scenario of a seed.
///
/// # Errors
/// Mistakes in the sets.
pub fn scenario(sets: &[String], seed: u64) -> Result<Loaded, Mistakes> {
    let all: Vec<String> = SETS.iter().map(|set| (*set).to_owned()).chain(sets.to_vec()).collect();
    load(Request { scenario: Some("tisdale"), sets: &all, seed: Some(seed) })
}

impl Tisdale {
    /// Flies once per scenario and filters the frames. `done` is called after each flight.
    pub fn fly(scenarios: Vec<Loaded>, done: impl Fn() + Sync) -> Self {
        let each: Vec<(Flight, Vec<Last>)> = scenarios
            .into_par_iter()
            .map(|loaded| {
                let flight = Flight::fly(loaded);
                let ends = KINDS.iter().map(|kind| filters::last(&flight, kind)).collect();
                done();
                (flight, ends)
            })
            .collect();
        let (flights, ends): (Vec<Flight>, Vec<Vec<Last>>) = each.into_iter().unzip();
        // The flight that is most like the paper's.
        let late_s = |flight: &Flight| (flight.detected_s().unwrap_or(1e9) - DETECTED_S).abs();
        let by_likeness = |a: &usize, b: &usize| {
            late_s(&flights[*a]).total_cmp(&late_s(&flights[*b])).then(a.cmp(b))
        };
        let shown = (0..flights.len()).min_by(by_likeness).unwrap_or_default();
        let curves = KINDS.par_iter().map(|kind| filters::curves(&flights[shown], kind)).collect();
        Self { flights, ends, shown, curves }
    }

    /// How many flights there are.
    pub fn count(&self) -> usize {
        self.flights.len()
    }

    fn shown(&self) -> &Flight {
        &self.flights[self.shown]
    }

    /// The tables.
    pub fn tables(&self) -> Vec<Table> {
        tables::tables(self)
    }

    /// The page with these tables; `again` is the command that makes it again.
    pub fn html(&self, tables: &[Table], again: &str) -> String {
        let detected = match self.shown().detected_s() {
            Some(time_s) => format!("{time_s} s"),
            None => "never".to_owned(),
        };
        let about = page::definitions(&[
            ("flights", format!("{}, perfect links, lanes of the lawnmower", self.count())),
            (
                "figures",
                format!(
                    "seed {}, the flight whose first detection ({detected}) is nearest to the paper's, about \
                     {DETECTED_S} s",
                    self.shown().seed
                ),
            ),
            (
                "data",
                "the paper's flight data were not published: the models are compared, \
                      not the flights"
                    .to_owned(),
            ),
            ("again", format!("<code>{}</code>", crate::report::shapes::escaped(again))),
        ]);
        let banner = banner_of(tables);
        let tables: String = tables.iter().map(Table::html).collect();
        page::document(
            "Tisdale et al. 2008, ours beside theirs",
            &(banner + &about + &tables + &figures::all(self)),
        )
    }
}
