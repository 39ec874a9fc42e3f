#![no_main]

mod lies;

use csat_tests::fuzz::factors::{self, lie};
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_target!(init: { factors::Moment::all(); }, |bytes: &[u8]| factors::factors(bytes));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    lies::mutate(data, size, max_size, seed, lie::talk)
});
