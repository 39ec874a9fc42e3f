//! Which of many factors are worth most to be sent, without rating all of them at each step.

use std::collections::BTreeMap;

use csat_proto::time::Step;

use crate::factor::{Factor, FactorId};

/// The most factors that are rated for the first time, or again after a long time, for a message.
const NEW: usize = 64;
/// The most factors that are rated again for a message because they were worth most.
const BEST: usize = 64;

/// What factors were worth when they were last rated.
#[derive(Debug, Clone)]
pub struct Ratings {
    rated: BTreeMap<FactorId, (f64, Step)>,
    /// After so many steps a factor is rated again.
    validity: u32,
}

impl Ratings {
    /// No ratings; they are good for `validity` steps.
    pub fn new(validity: u32) -> Self {
        Self { rated: BTreeMap::new(), validity }
    }

    /// The factors by what they are worth, the greatest first and equal ones by id, each with its worth (0 or
    /// more). If there are many, those are left out that were never rated and have to wait for it.
    pub fn rank(
        &mut self,
        now: Step,
        mut factors: Vec<Factor>,
        worth: &mut dyn FnMut(&Factor) -> f64,
    ) -> Vec<(f64, Factor)> {
        let last = |rated: &BTreeMap<FactorId, (f64, Step)>, factor: &Factor| {
            rated.get(&factor.id).copied()
        };
        let is_new = |factor: &Factor| {
            last(&self.rated, factor).is_none_or(|(_, step)| step.after(self.validity) < now)
        };
        // Sightings first, then the newest.
        let order = |factor: &Factor| {
            (factor.sighting.is_none(), std::cmp::Reverse(factor.step), factor.id)
        };
        factors.sort_unstable_by_key(order);
        let new = factors.iter().filter(|factor| is_new(factor)).take(NEW);
        let mut known: Vec<(f64, FactorId, &Factor)> = factors
            .iter()
            .filter(|factor| !is_new(factor))
            .filter_map(|factor| Some((last(&self.rated, factor)?.0, factor.id, factor)))
            .collect();
        known.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let best = known.iter().take(BEST).map(|(_, _, factor)| *factor);
        let to_rate: Vec<Factor> = new.chain(best).copied().collect();
        for factor in to_rate {
            let worth = worth(&factor);
            let worth = if worth.is_nan() { 0.0 } else { worth.max(0.0) };
            self.rated.insert(factor.id, (worth, now));
        }
        let mut ranked: Vec<(f64, Factor)> = factors
            .into_iter()
            .filter_map(|factor| Some((last(&self.rated, &factor)?.0, factor)))
            .collect();
        ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.id.cmp(&b.1.id)));
        ranked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::fixture::factor;

    #[test]
    fn few_are_all_rated_and_of_many_each_one_in_its_turn() {
        let mut ratings = Ratings::new(20);
        let few: Vec<Factor> = (0..5).map(|number| factor(0, 0, number)).collect();
        let mut worth = |factor: &Factor| match factor.id.number {
            1 => f64::NAN,
            2 => -7.0,
            number => f64::from(number % 2),
        };
        let ranked = ratings.rank(Step(9), few, &mut worth);
        let numbers: Vec<u32> = ranked.iter().map(|(_, factor)| factor.id.number).collect();
        assert_eq!(numbers, [3, 0, 1, 2, 4]);
        assert_eq!(ranked[2].0, 0.0);

        let mut ratings = Ratings::new(20);
        let many: Vec<Factor> = (0..500).map(|number| factor(0, 0, number)).collect();
        for now in (500..520).map(Step) {
            let mut rated = 0;
            let mut worth = |factor: &Factor| {
                rated += 1;
                f64::from(u8::from(factor.id.number == 123))
            };
            let ranked = ratings.rank(now, many.clone(), &mut worth);
            assert!(rated <= NEW + BEST);
            assert_eq!(ranked[0].1.id.number == 123, now >= Step(505), "at {now}");
        }
    }
}
