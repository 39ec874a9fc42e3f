//! Tests over many seeds. A failing seed prints how to run it alone.

use std::ops::Range;

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
