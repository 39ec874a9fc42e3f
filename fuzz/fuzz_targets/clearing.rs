#![no_main]

mod lies;

use csat_tests::fuzz::clearing;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_target!(|body: &[u8]| clearing::clearing(body));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    lies::mutate(data, size, max_size, seed, clearing::talk)
});
