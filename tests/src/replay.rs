//! Tests over many seeds. A failing seed prints how to run it alone.

use std::fmt::Debug;
use std::fs;
use std::io::Write;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::SystemTime;

use rayon::prelude::*;

/// The environment variable that selects one seed.
const VARIABLE: &str = "CSAT_SEED";

/// Runs `check` for every seed of a range, or only for the one in `CSAT_SEED`. `test` is the file and
/// the name of the calling test, for `cargo test`.
pub fn for_seeds(test: [&'static str; 2], seeds: Range<u64>, mut check: impl FnMut(u64)) {
    let seeds = picked().map_or(seeds, |seed| seed..seed + 1);
    for seed in seeds {
        let _announce = Announce { test, seed };
        check(seed);
    }
}

/// What a mission comes to; a panic of an agent is an error as well.
///
/// # Errors
/// Those of the mission, and the text of a panic.
pub fn caught<T>(fly: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(fly)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|t| (*t).to_owned()));
        Err(format!("panicked: {}", text.unwrap_or_default()))
    })
}

/// Whether a single seed is replayed, so that counts over all seeds have no meaning.
pub fn is_replay() -> bool {
    picked().is_some()
}

/// The seed in `CSAT_SEED`, if there is one.
fn picked() -> Option<u64> {
    let seed = std::env::var_os(VARIABLE)?;
    let number = seed.to_str().and_then(|seed| seed.parse().ok());
    Some(number.unwrap_or_else(|| panic!("{VARIABLE}={seed:?}: expected a seed, such as 17")))
}

/// The seeds of a swarm.
#[derive(Debug, Clone, Copy)]
pub struct Seeds {
    /// How many are flown every time, from 0 on.
    pub fixed: u64,
    /// How many new ones are flown, which no earlier run has flown.
    pub fresh: u64,
    /// The file of the seeds that failed once; failing ones are added.
    pub regressions: &'static str,
}

impl Seeds {
    /// The seeds of `CSAT_SEED`, of `CSAT_SEEDS`, or else all.
    #[expect(clippy::disallowed_methods, reason = "fresh seeds are to be new ones")]
    pub fn all(&self) -> Vec<u64> {
        if let Some(seed) = picked() {
            return vec![seed];
        }
        if let Some(range) = asked_range() {
            return range.collect();
        }
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let fresh = since_1970.map_or(0, |time| time.as_secs()) << 8;
        let mut seeds = self.known();
        seeds.extend((0..self.fixed).chain(fresh..fresh + self.fresh));
        seeds
    }

    /// Flies all seeds at once, and adds up `with` what they exercised. Gives it if they are at least as many as
    /// are flown every time: of fewer, it says little. `test` is the file of the calling test.
    ///
    /// # Panics
    /// When seeds fail, with how to replay them; they are kept.
    pub fn fly<E: Default + Debug + Send>(
        &self,
        test: &str,
        fly: fn(u64) -> Result<E, String>,
        with: fn(E, E) -> E,
    ) -> Option<E> {
        let seeds = self.all();
        let flown: Vec<_> = seeds.par_iter().map(|&seed| (seed, fly(seed))).collect();
        let (mut failures, mut exercise) = (Vec::new(), E::default());
        for (seed, result) in flown {
            match result {
                Ok(more) => exercise = with(exercise, more),
                Err(law) => {
                    self.keep(seed, &law);
                    failures.push(format!("seed {seed}: {law}\n    {}", replay(test, seed)));
                }
            }
        }
        println!("{exercise:#?}");
        let (failed, all) = (failures.len(), seeds.len());
        assert!(failures.is_empty(), "{failed} of {all}:\n{}", failures.join("\n"));
        (all as u64 >= self.fixed).then_some(exercise)
    }

    /// Adds a seed to the regressions.
    fn keep(&self, seed: u64, law: &str) {
        if !Path::new(self.regressions).exists() || self.known().contains(&seed) {
            return;
        }
        if let Ok(mut file) = fs::OpenOptions::new().append(true).open(self.regressions) {
            let _ = writeln!(file, "{seed}  # {}", law.lines().next().unwrap_or_default());
        }
    }

    /// The seeds that failed once.
    fn known(&self) -> Vec<u64> {
        let text = fs::read_to_string(self.regressions).unwrap_or_default();
        let numbers = text.lines().filter_map(|line| line.split_whitespace().next());
        numbers.filter_map(|number| number.parse().ok()).collect()
    }
}

/// The seeds of `CSAT_SEEDS`, if it is set: how many, or from..to.
///
/// # Panics
/// When there is something else in it.
pub fn asked_range() -> Option<Range<u64>> {
    let text = std::env::var_os("CSAT_SEEDS")?;
    let seeds = text.to_str().and_then(range_of).filter(|seeds| !seeds.is_empty());
    Some(seeds.unwrap_or_else(|| {
        panic!("CSAT_SEEDS={text:?}: expected how many seeds, such as 1000, or a range that is not empty, such as 500..700")
    }))
}

fn range_of(text: &str) -> Option<Range<u64>> {
    let (from, to) = text.split_once("..").unwrap_or(("0", text));
    Some(from.parse().ok()?..to.parse().ok()?)
}

/// How to fly a seed of a test alone.
fn replay(test: &str, seed: u64) -> String {
    format!(
        "replay it with {VARIABLE}={seed} cargo test -p csat-tests --test {test} -- --nocapture"
    )
}

struct Announce {
    test: [&'static str; 2],
    seed: u64,
}

impl Drop for Announce {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let ([file, name], seed) = (self.test, self.seed);
            eprintln!(
                "seed {seed} failed; replay it with\n    {VARIABLE}={seed} cargo test -p csat-tests \
                 --test {file} {name} -- --nocapture"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_a_number_or_a_range() {
        assert_eq!(range_of("7"), Some(0..7));
        assert_eq!(range_of("5..7"), Some(5..7));
        assert!(range_of("7..5").unwrap().is_empty());
        assert_eq!(["", "x", "..7", "5..", "-1", "1..x"].map(range_of), [const { None }; 6]);
    }
}
