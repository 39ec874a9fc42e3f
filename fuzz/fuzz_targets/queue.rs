#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| csat_tests::fuzz::wire::queue(bytes));
