#![no_main]

use csat_tests::fuzz::clearing;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

fuzz_target!(|body: &[u8]| clearing::clearing(body));

// Half of the changes are lies with a shape, the rest of bytes.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let lie = (seed % 2 == 0).then(|| clearing::talk(&data[..size], u64::from(seed))).flatten();
    match lie.filter(|lie| lie.len() <= max_size) {
        Some(lie) => {
            data[..lie.len()].copy_from_slice(&lie);
            lie.len()
        }
        None => fuzzer_mutate(data, size, max_size),
    }
});
