#![no_main]

mod lies;

use csat_tests::fuzz::{self, spoil};
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_target!(init: { csat_tests::fuzz::Moment::shared(); }, |bytes: &[u8]| fuzz::snapshot(bytes));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    lies::mutate(data, size, max_size, seed, spoil::snapshot)
});
